// What tags promise: a strong one that the bytes are the same, a weak one that they mean the same.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <future>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "server/routes/engine_digest.h"
#include "tests/fixtures/bumpy_plane.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/test_seed.h"
#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

// What of a number a weak tag leaves open, as openapi.yaml says.
double left_open(const std::string& question) {
  for (const char* const exact : {"exact", "chen_han", "dijkstra"}) {
    if (question.find(std::string("method=") + exact) != std::string::npos) return 1e-9;
  }
  return 1e-4;
}

// Every number of two replies, side by side; what is not a number must be equal, and so must be
// what is said of the points that were asked for. Of two paths as long either may be it.
bool mean_the_same(const json& a, const json& b, double open, const std::string& name = {}) {
  if (name == "points" || name == "farthest") return true;
  if (name == "from" || name == "to" || name == "at") return a == b;
  if (a.is_number() && b.is_number()) {
    const double x = a;
    const double y = b;
    return std::abs(x - y) <= 1e-12 + open * std::max(std::abs(x), std::abs(y));
  }
  if (a.type() != b.type() || a.size() != b.size()) return false;
  if (a.is_array()) {
    for (std::size_t i = 0; i < a.size(); ++i) {
      if (!mean_the_same(a[i], b[i], open)) return false;
    }
    return true;
  }
  if (a.is_object()) {
    for (const auto& [key, value] : a.items()) {
      if (!b.contains(key) || !mean_the_same(value, b[key], open, key)) return false;
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
                                     "fast_marching", "dijkstra", "novotni", "exact", "exact",
                                     "chen_han", "auto&bound=upper", "auto&tolerance=0.001"});
    const std::string by = "&method=" + method;
    // Ways that have fields of a tolerance are no paths.
    const bool has_paths = method.find("tolerance") == std::string::npos;
    switch (random_() % (has_paths ? 10 : 9)) {
      case 0:
        return "/distance?from=" + source() + by;
      case 1:
        return "/distance?from=" + source() + "&at=" + point() + by;
      case 2:
        return "/distance?from=" + source() + "&at=" + point() + "&at=" + point() +
               "&at=" + point() + by + pick({"", "&labels=1"});
      case 3:
        return "/trace?from=" + point() + "&length=1.5&angle=" + std::to_string(random_() % 6);
      case 4:
        return "/table?from=" + source() + "&from=" + source() + "&to=" + point() + by;
      case 5:
        return "/isolines?count=5&from=" + source() + by;
      case 6:
        return "/distance?from=" + source() + "&from=" + point() + "&labels=1" + by;
      case 7:
        return "/samples?count=3&from=" + point() + by;
      case 8:
        return "/nearest?point=" + point() + "&point=" + point() + "&point=" + point();
      default:
        return "/path?from=" + source() + "&to=" + point() + by + pick({"", "&refine=shortest"});
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
    switch (random_() % 4) {
      case 0:
        return "v:" + std::to_string(random_() % vertices_);
      case 1:
        return "f:" + std::to_string(random_() % faces_) + ",0.5,0.25";
      case 2:  // on an edge, which is two faces'
        return "f:" + std::to_string(random_() % faces_) + pick({",0.5,0.5", ",0,0.25", ",0.75,0"});
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

// The first reply to each question, which all others are compared with.
class Promises {
 public:
  void check(const std::string& question, HttpResponse reply) {
    CAPTURE(question);
    const auto [known, is_new] = first_.try_emplace(question, std::move(reply));
    if (is_new) return;
    const HttpResponse& before = known->second;
    REQUIRE(reply.status == before.status);
    if (reply.status != 200) return;
    const std::string tag = header_of(reply, "ETag");
    REQUIRE(tag == header_of(before, "ETag"));
    if (!tag.starts_with("W/")) {
      ++strong_;
      CHECK(*reply.body == *before.body);
    } else if (*reply.body != *before.body) {
      ++differ_;
      CAPTURE(*before.body);
      CAPTURE(*reply.body);
      CHECK(mean_the_same(body_of(reply), body_of(before), left_open(question)));
    }
  }
  [[nodiscard]] int strong() const { return strong_; }
  [[nodiscard]] int differ() const { return differ_; }

 private:
  std::map<std::string, HttpResponse> first_;
  int strong_ = 0;
  int differ_ = 0;  // under weak tags
};

using Replies = std::vector<std::pair<std::string, HttpResponse>>;

// All questions in an order of its own.
Replies ask_all(Service& service, const std::string& base, std::vector<std::string> questions,
                std::uint32_t seed) {
  std::shuffle(questions.begin(), questions.end(), std::mt19937(seed));
  Replies replies;
  for (const std::string& question : questions) {
    replies.emplace_back(question, service.get(base + question));
  }
  return replies;
}

}  // namespace

TEST_CASE("TagsKeepTheirPromiseColdAndWarmAndFromTwoThreads") {
  std::mt19937 random(fixtures::test_seed());
  int strong = 0;
  int differ = 0;
  // Above and below the size from which on pairs are searched, smooth and rough.
  std::vector<TriangleSoup> soups{shapes::icosphere(5), shapes::terrain(30, 3, 7),
                                  fixtures::bumpy_plane(75)};
  std::shuffle(soups.begin(), soups.end(), random);
  soups.resize(fixtures::all_or<std::size_t>(soups.size(), 1));
  for (const TriangleSoup& soup : soups) {
    const std::string glb = glb_of(soup);
    Questions questions(random, static_cast<std::uint32_t>(soup.positions.size()),
                        static_cast<std::uint32_t>(soup.faces.size()));
    std::vector<std::string> asked;
    for (int i = 0; i < fixtures::all_or(120, 24); ++i) asked.push_back(questions.draw());
    Promises promises;
    // Fields are never there; sometimes; from the second time on.
    for (const std::uint64_t field_cache :
         {std::uint64_t{0}, std::uint64_t{1} << 19, std::uint64_t{1} << 30}) {
      CAPTURE(field_cache);
      const TemporaryFolder folder;
      Service service(folder.path(), with_caches(field_cache));
      const std::string base = "/v1/meshes/" + service.upload(glb);
      auto other =
          std::async(std::launch::async, ask_all, std::ref(service), base, asked, random());
      const Replies replies = ask_all(service, base, asked, random());
      for (const auto& [question, reply] : replies) promises.check(question, reply);
      for (const auto& [question, reply] : other.get()) promises.check(question, reply);
    }
    strong += promises.strong();
    differ += promises.differ();
  }
  CHECK(strong > fixtures::all_or(100, 5));
  MESSAGE("replies that differ under a weak tag: " << differ);
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
  PlaneService plane;
  CHECK(body_of(plane.service.get("/v1/status"))["engine"] == engine_digest());
}
