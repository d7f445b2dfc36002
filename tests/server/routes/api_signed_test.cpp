// What ends a query of signed distances: memory, deadlines, and clients that are gone; and how they
// stay in a file.
#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "tests/fixtures/test_seed.h"
#include "tests/fixtures/wait_until.h"
#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using geodesic::fixtures::test_seed;

namespace {

constexpr std::uint32_t kHillsSide = 120;

TriangleSoup hills() { return shapes::terrain(kHillsSide, 6, test_seed()); }

// A closed curve along edges, far round the middle, so that it takes nothing to draw it. Its field
// goes no further than `max`: most of the work is to find what is inside.
std::string round_of(std::mt19937& random, double max) {
  const std::uint32_t first = 10 + random() % 20;
  const std::uint32_t last = 80 + random() % 20;
  std::string asked = "/distance?method=dijkstra&max=" + std::to_string(max) + "&from=curve:closed";
  const auto add = [&](std::uint32_t column, std::uint32_t row) {
    asked += ";v:" + std::to_string(row * kHillsSide + column);
  };
  for (std::uint32_t i = first; i < last; ++i) add(i, first);
  for (std::uint32_t i = first; i < last; ++i) add(last, i);
  for (std::uint32_t i = last; i > first; --i) add(i, last);
  for (std::uint32_t i = last; i > first; --i) add(first, i);
  return asked;
}

HttpRequest get_request(const std::string& target) {
  HttpRequest request;
  request.method = "GET";
  request.target = target;
  request.path = target.substr(0, target.find('?'));
  request.query = *parse_query(target.substr(target.find('?') + 1));
  request.id = "test";
  return request;
}

}  // namespace

TEST_CASE("SignedDistancesHaveTheirMemoryOrAreRefused") {
  std::mt19937 random(test_seed());
  const std::string asked = round_of(random, 1);
  CAPTURE(asked);
  PlaneService plenty;
  const json truth = body_of(plenty.service.get(plenty.add(hills()) + asked + "&signed=1"));
  REQUIRE(truth["signed"] == true);
  bool is_refused_alone = false;
  for (std::uint64_t bytes = 64 << 20; bytes >= 1 << 20; bytes -= bytes / 4) {
    CAPTURE(bytes);
    Config config;
    config.query_memory_bytes = bytes;
    PlaneService little(config);
    const std::string target = little.add(hills()) + asked;
    const HttpResponse with_sign = little.service.get(target + "&signed=1");
    if (with_sign.status == 200) {
      CHECK(body_of(with_sign)["distances"] == truth["distances"]);
    } else {
      check_problem(with_sign, 422, "too_much_memory");
      // It is for the inside that there was too little.
      is_refused_alone = is_refused_alone || little.service.get(target).status == 200;
    }
    // What it had is given back.
    CHECK(little.ask("/distance?from=v:5")["reached"] == 120);
  }
  CHECK(is_refused_alone);
}

TEST_CASE("SignedDistancesEndAtTheirDeadline") {
  PlaneService plane;
  const std::string ball = plane.add(shapes::icosphere(7));
  plane.service.ask("POST", ball + "/prepare");
  std::string round = "/distance?max=0.01&method=dijkstra&from=curve:closed;v:0;v:1000;v:90000";
  check_problem(plane.service.get(ball + round + "&signed=1&deadline_ms=1"), 504, "deadline", "");
}

TEST_CASE("SignedDistancesEndOnceTheirClientIsGone") {
  std::mt19937 random(test_seed());
  PlaneService plane;
  const std::string base = plane.add(hills());
  plane.service.ask("POST", base + "/prepare");
  // Each is another one, for a reply that was made is kept.
  const auto target = [&](std::uint64_t number) {
    return base + round_of(random, 1 + 1e-3 * static_cast<double>(number)) + "&signed=1";
  };
  std::atomic<std::uint64_t> asks{0};
  std::uint64_t most = ~std::uint64_t{0};
  const auto answer = [&](const std::string& asked) {
    HttpRequest request = get_request(asked);
    asks = 0;
    request.caller = [&] { return ++asks > most; };
    HttpResponse response = plane.service.routes.answer(request);
    fixtures::wait_until([&] { return plane.service.pool.stats().running == 0; });
    return response;
  };
  REQUIRE(answer(target(0)).status == 200);
  const std::uint64_t all = asks;
  std::uint64_t stopped = 0;
  for (std::uint64_t i = 1; i <= 25; ++i) {
    most = all * (i - 1) / 25;
    CAPTURE(most);
    const std::string asked = target(i);
    const HttpResponse response = answer(asked);
    if (response.status != 200) {
      check_problem(response, 499, "cancelled");
      ++stopped;
    }
    // Nothing is left of it, and the next client has its answer.
    CHECK(body_of(plane.service.get(asked))["signed"] == true);
  }
  MESSAGE(stopped, " of 25 stopped, within ", all, " questions");
  CHECK(stopped > 12);
}

// The values of the file's attribute, in the order of its vertices, are those of the bare array.
TEST_CASE("SignedDistancesStayInTheFile") {
  std::mt19937 random(test_seed());
  PlaneService plane;
  const std::string base = plane.add(hills());
  for (const double max : {2.0, 1e6}) {
    CAPTURE(max);
    const std::string asked = base + round_of(random, max) + "&signed=1";
    const HttpResponse bare = plane.service.get(asked + "&format=f32");
    REQUIRE(bare.status == 200);
    std::vector<float> values(bare.body->size() / sizeof(float));
    std::memcpy(values.data(), bare.body->data(), bare.body->size());
    CHECK(*std::min_element(values.begin(), values.end()) < 0);
    CHECK((std::count(values.begin(), values.end(), std::numeric_limits<float>::infinity()) > 0) ==
          (max == 2));
    for (float& value : values) value = std::min(value, std::numeric_limits<float>::max());
    const std::string wanted(reinterpret_cast<const char*>(values.data()),
                             values.size() * sizeof(float));
    const HttpResponse file = plane.service.get(asked + "&format=annotated");
    REQUIRE(file.status == 200);
    CHECK(file.body->find("_GEODESIC_SIGNED_DISTANCE") != std::string::npos);
    CHECK(file.body->find(wanted) != std::string::npos);
  }
}
