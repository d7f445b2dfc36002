#include "server/http/gzip.h"

#include <doctest/doctest.h>

#include <string>

#include "tests/server/http/gunzipped.h"

using namespace geodesic;

TEST_CASE("GzipComesBack") {
  for (const std::size_t size : {0, 1, 1000, 3'000'000}) {
    std::string text;
    for (std::size_t i = 0; text.size() < size; ++i) text += std::to_string(i * 0.37) + ",";
    text.resize(size);
    const std::string packed = server::gzip(text);
    CHECK(server::test::gunzipped(packed) == text);
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
