#include "proto/wire/array_formats.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

using namespace geodesic;

namespace {

template <class T>
std::vector<T> numbers(std::string_view bytes) {
  REQUIRE(bytes.size() % sizeof(T) == 0);
  std::vector<T> values(bytes.size() / sizeof(T));
  std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

template <class T>
T number_at(std::string_view bytes, std::size_t offset) {
  return numbers<T>(bytes.substr(offset, sizeof(T))).front();
}

}  // namespace

TEST_CASE("QuantisedValuesAreWithinHalfAStepAndUnreachedIsTheLast") {
  const std::vector<double> values{0, 1.25, 7.5, 10, kInfinity};
  const auto steps = numbers<std::uint16_t>(proto::u16_bytes(values, 10));
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(std::abs(steps[i] * 10.0 / 65534 - values[i]) <= 0.5 * 10 / 65534);
  }
  CHECK(steps[3] == 65534);
  CHECK(steps[4] == 65535);
  const std::vector<double> zero{0, kInfinity};
  CHECK(numbers<std::uint16_t>(proto::u16_bytes(zero, 0)) == std::vector<std::uint16_t>{0, 65535});
}

TEST_CASE("NpyHasAHeaderOfAMultipleOf64Bytes") {
  const std::vector<double> values{1, 2, 3, 4, 5, 6};
  const std::string bytes =
      proto::npy({"", proto::NumberType::f64, {2, 3}, proto::f64_bytes(values)});
  CHECK(bytes.substr(0, 8) == std::string("\x93NUMPY\x01\x00", 8));
  const std::size_t header = number_at<std::uint16_t>(bytes, 8);
  CHECK((10 + header) % 64 == 0);
  const std::string text = bytes.substr(10, header);
  CHECK(text.starts_with("{'descr': '<f8', 'fortran_order': False, 'shape': (2,3,), }"));
  CHECK(text.back() == '\n');
  CHECK(numbers<double>(bytes.substr(10 + header)) == values);
}

TEST_CASE("FrameNamesItsArraysAndAlignsThem") {
  const std::vector<double> values{0.5, -1, kInfinity};
  const std::vector<std::uint32_t> labels{7, 8, 9};
  const std::vector<proto::Array> arrays{
      {"distances", proto::NumberType::f32, {3}, proto::f32_bytes(values)},
      {"labels", proto::NumberType::u32, {3}, proto::u32_bytes(labels)},
      {"empty", proto::NumberType::f64, {0, 3}, ""}};
  // Every length of what comes before, so that every padding is seen.
  for (std::size_t length = 0; length < 40; ++length) {
    const std::string bytes = proto::frame({{"note", std::string(length, 'x')}}, arrays);
    CHECK(bytes.substr(0, 4) == "GEOD");
    CHECK(number_at<std::uint32_t>(bytes, 4) == 1);
    CHECK(number_at<std::uint32_t>(bytes, 12) == 0);
    CHECK(number_at<std::uint64_t>(bytes, 16) == bytes.size());
    const std::size_t json_length = number_at<std::uint32_t>(bytes, 8);
    CHECK((24 + json_length) % 8 == 0);
    const auto json = nlohmann::json::parse(bytes.substr(24, json_length));
    CHECK(json["note"] == std::string(length, 'x'));
    REQUIRE(json["arrays"].size() == 3);
    const auto part = [&](int i) {
      const auto& array = json["arrays"][i];
      const std::size_t offset = array["offset"];
      CHECK(offset % 8 == 0);
      CHECK(offset >= 24 + json_length);
      return bytes.substr(offset, array["nbytes"]);
    };
    CHECK(numbers<float>(part(0)) == std::vector<float>{0.5F, -1.0F, INFINITY});
    CHECK(numbers<std::uint32_t>(part(1)) == labels);
    CHECK(part(2).empty());
    CHECK(json["arrays"][2]["shape"] == nlohmann::json::array({0, 3}));
    CHECK(json["arrays"][0]["dtype"] == "<f4");
  }
}
