#include "server/gzip.h"

#include <doctest/doctest.h>
#include <zlib.h>

#include <string>

using namespace geodesic;

namespace {

std::string gunzip(const std::string& bytes, std::size_t size) {
  z_stream stream{};
  REQUIRE(inflateInit2(&stream, 15 + 16) == Z_OK);
  std::string out(size + 1, '\0');
  std::string in = bytes;
  stream.next_in = reinterpret_cast<Bytef*>(in.data());
  stream.avail_in = static_cast<uInt>(in.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  CHECK(inflate(&stream, Z_FINISH) == Z_STREAM_END);
  out.resize(stream.total_out);
  inflateEnd(&stream);
  return out;
}

}  // namespace

TEST_CASE("GzipComesBack") {
  for (const std::size_t size : {0, 1, 1000, 3'000'000}) {
    std::string text;
    for (std::size_t i = 0; text.size() < size; ++i) text += std::to_string(i * 0.37) + ",";
    text.resize(size);
    const std::string packed = server::gzip(text);
    CHECK(gunzip(packed, size) == text);
    if (size > 1000) CHECK(packed.size() < text.size() / 2);
  }
}

TEST_CASE("GzipIsSentOnlyToThoseWhoTakeIt") {
  for (const char* yes : {"gzip", "GZip", "x-gzip", "deflate, gzip;q=0.5", "*", "br;q=1.0, *;q=0.1",
                          "gzip;q=0.001", "identity;q=0, gzip"}) {
    CAPTURE(yes);
    CHECK(server::admits_gzip(yes));
  }
  for (const char* no : {"", "br", "gzip;q=0", "gzip; q=0.000", "*;q=0", "identity", "*, gzip;q=0",
                         "gzip;q=0, *", "notgzip", "gzip2"}) {
    CAPTURE(no);
    CHECK_FALSE(server::admits_gzip(no));
  }
}
