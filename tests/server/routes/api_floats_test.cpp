// Fields of `method=auto`, which are floats: what the cache holds of them, and what replies
// say of them in each format, computed or kept.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

// No reply is kept, so that the second one comes from a kept field.
Config without_replies() {
  Config config;
  config.reply_cache_bytes = 0;
  return config;
}

struct FloatService : PlaneService {
  explicit FloatService(const Config& config = without_replies()) : PlaneService(config) {}
  HttpResponse distance(const std::string& query) {
    const HttpResponse response = service.get(mesh + "/distance?from=v:3" + query);
    REQUIRE(response.status == 200);
    return response;
  }
  std::string mesh = add(shapes::terrain(40, 6, 3));
};

}  // namespace

TEST_CASE("TwiceAsManyFieldsOfFloatsAreKept") {
  const auto kept = [](const std::string& method, std::uint64_t budget) {
    Config config = without_replies();
    config.field_cache_bytes = budget;
    FloatService floats(config);
    for (int i = 0; i < 24; ++i) {
      floats.service.get(floats.mesh + "/distance?from=v:" + std::to_string(i) + "&" + method);
    }
    const CacheStats stats = floats.service.queries.field_cache();
    CHECK(stats.bytes <= budget);
    return stats;
  };
  constexpr std::uint64_t kDoubles = 8 * 1600;
  for (const std::string method : {"method=auto", "method=auto&bound=upper"}) {
    CAPTURE(method);
    const CacheStats floats = kept(method, 10 * kDoubles);
    const CacheStats doubles = kept("method=auto&tolerance=0.01", 10 * kDoubles);
    CHECK(doubles.entries == 9);  // each has its sources, too
    CHECK(floats.entries >= 18);
    CHECK(floats.bytes < floats.entries * (4 * 1600 + 400));
  }
}

TEST_CASE("AKeptFieldOfFloatsIsToldInTheSameBytes") {
  for (const std::string format : {"json", "f32", "f64", "u16", "npy", "frame"}) {
    for (const std::string bound : {"none", "upper"}) {
      CAPTURE(format);
      CAPTURE(bound);
      FloatService floats;
      const std::string query = "&method=auto&bound=" + bound + "&format=" + format;
      const HttpResponse computed = floats.distance(query);
      const HttpResponse kept = floats.distance(query);
      CHECK(header_of(computed, "Geo-Cache") == "miss");
      CHECK(header_of(kept, "Geo-Cache") == "hit");
      CHECK(*computed.body == *kept.body);
      CHECK(header_of(computed, "ETag") == header_of(kept, "ETag"));
      CHECK(header_of(computed, "Geo-Max") == header_of(kept, "Geo-Max"));
      // Of some vertices, from no field, from one that stops there, and from the whole.
      const std::string some = "&at=v:77&at=v:1000&at=v:1599&method=auto&bound=" + bound;
      FloatService other;
      CHECK(*other.distance(some).body == *floats.distance(some).body);
    }
  }
}

TEST_CASE("EveryFormatHasTheSameFloats") {
  FloatService floats;
  const std::string by = "&method=auto";
  const HttpResponse as_json = floats.distance(by);
  const json reply = body_of(as_json);
  const auto narrow = numbers_of<float>(floats.distance(by + "&format=f32"));
  const HttpResponse f64 = floats.distance(by + "&format=f64");
  const auto wide = numbers_of<double>(f64);
  const json in_full = body_of(floats.distance(by + "&precision=17"));
  REQUIRE(narrow.size() == 1600);
  bool differ = false;
  for (std::size_t v = 0; v < narrow.size(); ++v) {
    CHECK(wide[v] == static_cast<double>(narrow[v]));
    CHECK(static_cast<float>(reply["distances"][v].get<double>()) == narrow[v]);
    CHECK(in_full["distances"][v].get<double>() == wide[v]);
    differ = differ || reply["distances"][v].get<double>() != wide[v];
  }
  CHECK(differ);
  const double max = *std::max_element(wide.begin(), wide.end());
  CHECK(std::stod(header_of(f64, "Geo-Max")) == max);
  CHECK(wide[reply["farthest"].get<std::size_t>()] == max);
  CHECK(reply["max"] == reply["distances"][reply["farthest"].get<std::size_t>()]);
  // With half of the digits.
  const auto size_of = [&](const std::string& query) {
    return floats.distance(query + "&from=v:9").body->size();
  };
  CHECK(size_of(by) < 0.65 * static_cast<double>(size_of("&method=exact")));
}

TEST_CASE("ADecimalIsNotBelowItsUpperBound") {
  FloatService floats;
  const std::string by = "&method=auto&bound=upper";
  const json reply = body_of(floats.distance(by));
  const auto wide = numbers_of<double>(floats.distance(by + "&format=f64"));
  CHECK(reply["distances"].get<std::vector<double>>() == wide);
}

TEST_CASE("WhatASingleQuestionSaysIsWhatTheFieldSays") {
  FloatService floats;
  for (const std::string bound : {"none", "upper"}) {
    const std::string by = "&method=auto&bound=" + bound;
    const json field = body_of(floats.distance(by))["distances"];
    for (const int v : {0, 3, 500, 1599}) {
      const std::string at = std::to_string(v);
      CHECK(body_of(floats.distance("&at=v:" + at + by))["distances"][0] == field[v]);
      const HttpResponse table =
          floats.service.get(floats.mesh + "/table?from=v:3&to=v:7&to=v:" + at + by);
      CHECK(body_of(table)["distances"][0][1] == field[v]);
      // Up to as far as that: it and all that is nearer, whether or not the field is there.
      const std::string max = "&max=" + field[v].dump() + by;
      CHECK(body_of(floats.distance("&at=v:" + at + max))["distances"][0] == field[v]);
      const json within = body_of(floats.distance(max));
      CHECK(within["distances"][v] == field[v]);
      CHECK(within["max"] == field[v]);
      CHECK(body_of(floats.distance("&at=v:" + at + max))["distances"][0] == field[v]);
    }
  }
}

TEST_CASE("AFramesGreatestIsThatOfItsArray") {
  FloatService floats;
  const std::string frame = *floats.distance("&method=auto&format=frame").body;
  const std::string f64 = *floats.distance("&method=auto&format=f64").body;
  CHECK(frame.find(f64) != std::string::npos);
  const std::string max = header_of(floats.distance("&method=auto&format=f64"), "Geo-Max");
  CHECK(frame.find("\"max\":" + max) != std::string::npos);
}

TEST_CASE("LinesAndSamplesAndPathsGoByTheFloats") {
  FloatService floats;
  const std::string by = "from=v:3&method=auto";
  const auto field = numbers_of<double>(floats.distance("&method=auto&format=f64"));
  const double max = *std::max_element(field.begin(), field.end());
  const json lines = body_of(floats.service.get(floats.mesh + "/isolines?count=4&" + by));
  CHECK(lines["max"].get<double>() == max);
  CHECK_FALSE(lines["isolines"].empty());
  const json samples = body_of(floats.service.get(floats.mesh + "/samples?count=1&" + by));
  CHECK(samples["samples"][0]["radius"].get<double>() == max);
  for (const int v : {40, 700, 1599}) {
    const json path =
        body_of(floats.service.get(floats.mesh + "/path?to=v:" + std::to_string(v) + "&" + by));
    CHECK(path["length"].get<double>() ==
          doctest::Approx(field[static_cast<std::size_t>(v)]).epsilon(0.01));
  }
}
