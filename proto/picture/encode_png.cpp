#include <png.h>

#include <csetjmp>

#include "proto/picture/picture.h"

namespace geodesic::proto {
namespace {

void append(png_structp png, png_bytep data, png_size_t size) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<char*>(data), size);
}

void flush_nothing(png_structp) {}

}  // namespace

// The simplified API of libpng writes to memory of a size known before; this one
// grows a string. With rows of the right size no error can occur but a lack of
// memory, which libpng reports by longjmp: nothing with a destructor lives between.
std::string encode_png(const Image& image, Poll* poll) {
  std::string bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  if (png == nullptr) throw std::bad_alloc();
  png_infop info = png_create_info_struct(png);
  if (info == nullptr || setjmp(png_jmpbuf(png)) != 0) {
    png_destroy_write_struct(&png, &info);
    throw std::bad_alloc();
  }
  png_set_write_fn(png, &bytes, append, flush_nothing);
  // Level 6 takes three times as long as 3 for a tenth less.
  png_set_compression_level(png, 3);
  png_set_IHDR(png, info, image.width, image.height, 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  constexpr std::uint32_t kRowsBetween = 32;  // some ms of compressing
  for (std::uint32_t row = 0; row < image.height; ++row) {
    if (poll != nullptr && row % kRowsBetween == 0 && poll->ask()) break;
    png_write_row(png, image.rgb.data() + std::size_t{3} * image.width * row);
  }
  if (poll == nullptr || !poll->stopped()) png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return bytes;
}

}  // namespace geodesic::proto
