// Tables of which most entries are estimated, by the fields of some of their columns.
#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "core/mesh/shapes.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/test_seed.h"
#include "tests/fixtures/wait_until.h"
#include "tests/server/routes/streamed_table.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using geodesic::fixtures::test_seed;
using geodesic::fixtures::wait_until;

namespace {

// Two surfaces beside each other, the second one smaller.
TriangleSoup two_terrains(std::mt19937& random) {
  TriangleSoup soup = shapes::terrain(40, 3, random());
  const auto offset = static_cast<std::uint32_t>(soup.positions.size());
  const TriangleSoup other = shapes::terrain(12, 1, random());
  for (Vec3 p : other.positions) {
    p.x += 1000;
    soup.positions.push_back(p);
  }
  for (const Triangle& t : other.faces) {
    soup.faces.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  }
  return soup;
}

json some_points(std::size_t count, const TriangleSoup& soup, std::mt19937& random) {
  json points = json::array();
  for (std::size_t i = 0; i < count; ++i) {
    if (random() % 4 == 0) {
      const double along = static_cast<double>(random() % 1000) / 2001;
      points.push_back("f:" + std::to_string(random() % soup.faces.size()) + "," +
                       std::to_string(along) + ",0.25");
    } else {
      points.push_back("v:" + std::to_string(random() % soup.positions.size()));
    }
  }
  return points;
}

json in_numbers(json asked) {
  asked["stream"] = true;
  asked["format"] = "f64";
  return asked;
}

std::vector<std::uint32_t> some_vertices(std::size_t count, const TriangleSoup& soup,
                                         std::mt19937& random) {
  std::vector<std::uint32_t> vertices(count);
  for (std::uint32_t& v : vertices) {
    v = static_cast<std::uint32_t>(random() % soup.positions.size());
  }
  return vertices;
}

// Whole, without what is kept, and in pieces.
void check_that_rows_are_their_own(TableService& plane, const std::string& base, json asked,
                                   std::mt19937& random) {
  const std::size_t rows = asked["from"].size();
  const std::string whole = whole_stream(plane.post(base, "table", in_numbers(asked)));
  plane.service.queries.set_cache_budget(0);
  CHECK(whole_stream(plane.post(base, "table", in_numbers(asked))) == whole);
  std::string joined;
  for (std::size_t row = 0; row < rows;) {
    const std::size_t end = std::min<std::size_t>(rows, row + 1 + random() % 30);
    asked["rows"] = std::to_string(row) + "-" + std::to_string(end - 1);
    joined += whole_stream(plane.post(base, "table", in_numbers(asked)));
    row = end;
  }
  CHECK(joined == whole);
}

}  // namespace

TEST_CASE("EstimatedTablesAreNearTheTrueOnesAndSayHowNear") {
  std::mt19937 random(test_seed());
  TableService plane;
  for (int round = 0; round < geodesic::fixtures::all_or(4, 1); ++round) {
    CAPTURE(round);
    const TriangleSoup soup = two_terrains(random);
    const std::string base = plane.add(soup);
    json asked{{"from", some_points(150, soup, random)}};
    if (random() % 2 == 0) asked["to"] = some_points(400, soup, random);
    if (random() % 2 == 0) asked["method"] = random() % 2 == 0 ? "wavefront" : "exact";
    const std::size_t columns = asked.contains("to") ? asked["to"].size() : asked["from"].size();
    const auto whole =
        numbers_in<double>(whole_stream(plane.post(base, "table", in_numbers(asked))));
    json estimated = in_numbers(asked);
    estimated["landmarks"] = 60;
    const HttpResponse response = plane.post(base, "table", estimated);
    const auto found = numbers_in<double>(whole_stream(response));
    REQUIRE(found.size() == whole.size());
    const json said = json::parse(header_of(response, "Geo-Estimated"));
    CHECK(said["landmarks"] == 60);
    CHECK(said["entries"].get<std::size_t>() <= 8 * columns);
    CHECK(said["mean"].get<double>() <= said["percentile_99"].get<double>());
    CHECK(said["percentile_99"].get<double>() <= said["max"].get<double>());
    double sum = 0;
    std::size_t compared = 0;
    std::size_t same = 0;
    for (std::size_t i = 0; i < whole.size(); ++i) {
      REQUIRE((found[i] == kUnreached) == (whole[i] == kUnreached));
      if (whole[i] == kUnreached || whole[i] == 0) continue;
      sum += std::abs(found[i] / whole[i] - 1);
      ++compared;
      if (found[i] == whole[i]) ++same;
    }
    REQUIRE(compared > 0);
    const double mean = sum / static_cast<double>(compared);
    CHECK(mean < 0.03);
    // Eight columns are a small sample.
    CHECK(mean < 4 * said["mean"].get<double>() + 0.002);
    // What is near is computed, but most is not.
    CHECK(same > compared / 100);
    CHECK(same < compared);

    // As lines, it says the same before its rows.
    estimated["format"] = "ndjson";
    const auto lines = lines_in(whole_stream(plane.post(base, "table", estimated)));
    CHECK(lines[0]["estimated"] == said);
  }
}

// By `exact` and columns at vertices alone, rows inside faces would make other bits of those that
// are not.
TEST_CASE("EstimatesDependNeitherOnTheRowsAskedForNorOnWhatIsKept") {
  std::mt19937 random(test_seed() + 1);
  TableService plane;
  const TriangleSoup soup = two_terrains(random);
  const std::string base = plane.add(soup);
  for (const std::string method : {"auto", "exact"}) {
    CAPTURE(method);
    json asked{{"from", some_points(fixtures::all_or(60, 12), soup, random)},
               {"to", points_at(some_vertices(fixtures::all_or(200, 60), soup, random))},
               {"landmarks", fixtures::all_or(40, 12)},
               {"method", method}};
    check_that_rows_are_their_own(plane, base, asked, random);
  }
}

TEST_CASE("TablesThatAreNotEstimated") {
  TableService plane;
  const auto refused = [&](const json& body, int status, std::string_view code) {
    CAPTURE(body.dump());
    json asked{{"from", {"v:0", "v:1"}}, {"stream", true}, {"landmarks", 8}};
    asked.update(body);
    check_problem(plane.post(plane.base, "table", asked), status, code, "landmarks");
  };
  refused({{"landmarks", 7}}, 422, "value_out_of_range");
  refused({{"landmarks", 301}}, 413, "too_large");
  refused({{"landmarks", "many"}}, 400, "bad_syntax");
  refused({{"stream", false}}, 422, "value_out_of_range");
  refused({{"sparse", true}}, 422, "value_out_of_range");
  refused({{"max", 3}}, 422, "value_out_of_range");
  refused({{"bound", "upper"}}, 422, "value_out_of_range");
  refused({{"tolerance", 0.01}}, 422, "value_out_of_range");
  refused({{"weights", {{"0-9", 2}}}, {"method", "steiner"}}, 422, "value_out_of_range");
  refused({{"from", {"boundary"}}, {"to", {"v:1"}}}, 422, "value_out_of_range");
  check_problem(plane.post(plane.base, "table",
                           {{"from", {{{"vertex", 0}, {"offset", 1}}}},
                            {"to", {"v:1"}},
                            {"stream", true},
                            {"landmarks", 8}}),
                422, "value_out_of_range", "from[0].offset");
}

// Fewer columns than landmarks, and one: nothing is left to be estimated, nor to be compared.
TEST_CASE("SmallTablesMayBeAskedForWithLandmarks") {
  TableService plane;
  json asked{{"from", {"v:0", "v:50", "v:119"}}, {"to", {"v:7", "v:7", "v:1"}}};
  const std::string whole = whole_stream(plane.post(plane.base, "table", in_numbers(asked)));
  asked["landmarks"] = 100;
  const HttpResponse response = plane.post(plane.base, "table", in_numbers(asked));
  CHECK(whole_stream(response) == whole);
  CHECK(json::parse(header_of(response, "Geo-Estimated"))["landmarks"] == 2);
}

TEST_CASE("EstimatesAreAskedOfTheMemoryForReplies") {
  Config config;
  config.reply_memory_bytes = 2'000'000;
  TableService plane(config);
  json asked{{"from", std::vector<std::string>(2'000, "v:3")}, {"stream", true}};
  asked["to"] = {"v:1"};
  asked["landmarks"] = 300;
  // One column needs no more than one landmark.
  CHECK(plane.post(plane.base, "table", asked).status == 200);
  asked["to"] = std::vector<std::string>(300, "v:1");
  check_problem(plane.post(plane.base, "table", asked), 422, "too_much_memory");
  asked.erase("landmarks");
  CHECK(plane.post(plane.base, "table", asked).status == 200);
}

TEST_CASE("EstimatesEndWhenTheirClientIsGone") {
  TableService plane;
  const std::string base = plane.add(shapes::terrain(150, 10, 7));
  HttpRequest request = table_request(
      base, {{"from", far_apart(2000)}, {"method", "exact"}, {"stream", true}, {"landmarks", 300}});
  std::atomic<int> asked{0};
  // While the landmarks' fields are computed.
  request.caller.gone = [&] { return ++asked > 500; };
  const HttpResponse response = plane.service.routes.answer(request);
  CHECK(response.status != 200);
  wait_until([&] { return plane.is_idle(); });
  // Not after the fields of all landmarks.
  CHECK(asked < 2'000);
}
