// What tags promise: a strong one that the bytes are the same, a weak one that they mean the same.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "server/engine_digest.h"
#include "tests/fixtures/test_seed.h"
#include "tests/server/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

// Every number of two replies, side by side; what is not a number must be equal. Places on
// edges may be named by either face, and paths may have points more or less: only what is measured
// is compared.
bool mean_the_same(const json& a, const json& b, const std::string& name = {}) {
  if (name == "face" || name == "bary" || name == "points" || name == "xyz") return true;
  if (name == "farthest") return true;  // of two as far, either
  if (a.is_number() && b.is_number()) {
    // What a method promises at the loosest here, an estimate of the wavefront's on rough meshes.
    const double x = a;
    const double y = b;
    return std::abs(x - y) <= 1e-9 + 0.02 * std::max(std::abs(x), std::abs(y));
  }
  if (a.type() != b.type() || a.size() != b.size()) return false;
  if (a.is_array()) {
    for (std::size_t i = 0; i < a.size(); ++i) {
      if (!mean_the_same(a[i], b[i])) return false;
    }
    return true;
  }
  if (a.is_object()) {
    for (const auto& [key, value] : a.items()) {
      if (!b.contains(key) || !mean_the_same(value, b[key], key)) return false;
    }
    return true;
  }
  return a == b;
}

class Questions {
 public:
  Questions(std::mt19937& random, std::uint32_t vertices, std::uint32_t faces)
      : random_(random), vertices_(vertices), faces_(faces) {}

  std::string draw() {
    const std::string method = pick({"wavefront", "wavefront", "wavefront", "auto", "auto", "auto",
                                     "fast_marching", "dijkstra", "novotni", "exact"});
    const std::string by = "&method=" + method;
    switch (random_() % 8) {
      case 0:
        return "/distance?from=" + source() + by;
      case 1:
        return "/distance?from=" + source() + "&at=" + point() + by;
      case 2:
        return "/distance?from=" + source() + "&at=" + point() + "&at=" + point() +
               "&at=" + point() + by + pick({"", "&labels=1"});
      case 3:
        return "/path?from=" + source() + "&to=" + point() + by + pick({"", "&refine=shortest"});
      case 4:
        return "/table?from=" + source() + "&from=" + source() + "&to=" + point() + by;
      case 5:
        return "/isolines?count=5&from=" + source() + by;
      case 6:
        return "/distance?from=" + source() + "&from=" + point() + "&labels=1" + by;
      default:
        return "/nearest?point=" + point() + "&point=" + point();
    }
  }

 private:
  std::string pick(const std::vector<std::string>& choices) {
    return choices[random_() % choices.size()];
  }
  // Few of them, so that fields are asked for again.
  std::string source() {
    return random_() % 3 != 0 ? "v:" + std::to_string(7 * (random_() % 5))
                              : "f:" + std::to_string(11 * (random_() % 3)) + ",0.25,0.25";
  }
  std::string point() {
    std::uniform_real_distribution<double> place(-1.5, 1.5);
    switch (random_() % 3) {
      case 0:
        return "v:" + std::to_string(random_() % vertices_);
      case 1:
        return "f:" + std::to_string(random_() % faces_) + ",0.5,0.25";
      default:
        return "p:" + std::to_string(place(random_)) + "," + std::to_string(place(random_)) + "," +
               std::to_string(place(random_));
    }
  }

  std::mt19937& random_;
  const std::uint32_t vertices_;
  const std::uint32_t faces_;
};

Config with_caches(std::uint64_t bytes) {
  Config config;
  config.field_cache_bytes = bytes;
  config.reply_cache_bytes = 0;
  return config;
}

}  // namespace

TEST_CASE("EqualStrongTagsAreEqualBytesWhateverIsCached") {
  std::mt19937 random(fixtures::test_seed());
  // Above and below the size from which on pairs are searched.
  for (const TriangleSoup& soup : {shapes::icosphere(5), shapes::terrain(30, 3, 7)}) {
    const std::string glb = glb_of(soup);
    Questions questions(random, static_cast<std::uint32_t>(soup.positions.size()),
                        static_cast<std::uint32_t>(soup.faces.size()));
    std::vector<std::string> asked;
    for (int i = 0; i < 150; ++i) asked.push_back(questions.draw());

    std::map<std::string, HttpResponse> first;
    for (const std::uint64_t field_cache : {std::uint64_t{0}, std::uint64_t{1} << 30}) {
      const TemporaryFolder folder;
      Service service(folder.path(), with_caches(field_cache));
      const std::string base = "/v1/meshes/" + service.upload(glb);
      for (int round = 0; round < 2; ++round) {
        std::shuffle(asked.begin(), asked.end(), random);
        for (const std::string& question : asked) {
          CAPTURE(question);
          CAPTURE(field_cache);
          HttpResponse reply = service.get(base + question);
          const auto [known, is_new] = first.try_emplace(question, reply);
          if (is_new) continue;
          const HttpResponse& before = known->second;
          REQUIRE(reply.status == before.status);
          if (reply.status != 200) continue;
          const std::string tag = header_of(reply, "ETag");
          REQUIRE(tag == header_of(before, "ETag"));
          if (tag.starts_with("W/")) {
            CHECK(mean_the_same(body_of(reply), body_of(before)));
          } else {
            CHECK(*reply.body == *before.body);
          }
        }
      }
    }
  }
}

TEST_CASE("AWeakTagSavesTheComputationToo") {
  PlaneService plane;
  const std::string target = plane.base + "/path?from=v:0&to=v:77";
  const std::string tag = header_of(plane.service.get(target), "ETag");
  REQUIRE(tag.starts_with("W/\""));
  for (const std::string& known : {tag, tag.substr(2), "\"other\", " + tag}) {
    const HttpResponse again = plane.service.ask("GET", target, {}, {{"If-None-Match", known}});
    CHECK(again.status == 304);
    CHECK(header_of(again, "ETag") == tag);
  }
  CHECK(plane.service.ask("GET", target, {}, {{"If-None-Match", "W/\"other\""}}).status == 200);
}

TEST_CASE("TagsHaveTheDigestOfTheBuild") {
  CHECK(engine_digest().size() == 32);
  CHECK(engine_digest().find_first_not_of("0123456789abcdef") == std::string_view::npos);
}
