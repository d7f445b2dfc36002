#include "server/http/gzip.h"

#include <zlib.h>

#include <algorithm>
#include <limits>
#include <new>

#include "server/http/head.h"

namespace geodesic::server {
namespace {

// Whether ";q=0", with any number of zeros, is among the parameters.
bool forbidden(std::string_view parameters) {
  const std::size_t q = parameters.find("q=");
  return q != parameters.npos &&
         parameters.substr(q + 2).find_first_of("123456789") == parameters.npos;
}

}  // namespace

bool admits_gzip(std::string_view accept_encoding) {
  bool any = false;
  while (!accept_encoding.empty()) {
    const std::size_t comma = accept_encoding.find(',');
    const std::string_view entry = accept_encoding.substr(0, comma);
    accept_encoding = comma == accept_encoding.npos ? "" : accept_encoding.substr(comma + 1);
    const std::size_t semicolon = entry.find(';');
    const std::string_view name = trimmed(entry.substr(0, semicolon));
    const bool no = semicolon != entry.npos && forbidden(entry.substr(semicolon));
    if (equals_ignoring_case(name, "gzip") || equals_ignoring_case(name, "x-gzip")) return !no;
    if (name == "*") any = !no;
  }
  return any;
}

std::string gzip(std::string_view bytes, Poll* poll) {
  z_stream stream{};
  constexpr int kGzip = 15 + 16;  // the greatest window, and gzip's header
  if (deflateInit2(&stream, Z_BEST_SPEED, Z_DEFLATED, kGzip, 8, Z_DEFAULT_STRATEGY) != Z_OK) {
    throw std::bad_alloc();
  }
  std::string out(deflateBound(&stream, bytes.size()), '\0');
  constexpr std::size_t kPiece = std::size_t{1} << 20;                     // some ms
  constexpr std::size_t kMostRoom = std::numeric_limits<uInt>::max() / 2;  // zlib counts in 32 bits
  std::size_t read = 0;
  std::size_t written = 0;
  int state = Z_OK;
  while (state == Z_OK) {
    if (poll != nullptr && poll->ask()) break;
    const auto input = static_cast<uInt>(std::min(bytes.size() - read, kPiece));
    const auto room = static_cast<uInt>(std::min(out.size() - written, kMostRoom));
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data() + read));
    stream.avail_in = input;
    stream.next_out = reinterpret_cast<Bytef*>(out.data() + written);
    stream.avail_out = room;
    state = deflate(&stream, read + input == bytes.size() ? Z_FINISH : Z_NO_FLUSH);
    read += input - stream.avail_in;
    written += room - stream.avail_out;
  }
  deflateEnd(&stream);
  out.resize(written);
  out.shrink_to_fit();  // it had room for what does not shrink
  return out;
}

}  // namespace geodesic::server
