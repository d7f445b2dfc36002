// Lines that cross too much: how many pieces and vertices a query may make of a surface.
#include <doctest/doctest.h>

#include <cstdint>
#include <string>

#include "proto/wire/query_limits.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/test_seed.h"
#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using fixtures::RandomMesh;
using fixtures::test_seed;

namespace {

constexpr std::uint32_t kRows = 1500;
constexpr std::uint32_t kFaces = 2 * (kRows - 1);  // of a strip, each way through it crosses all

// To and fro between the first face of the strip and the last.
json to_and_fro(std::size_t points, RandomMesh& random) {
  json line = json::array();
  for (std::size_t i = 0; i < points; ++i) {
    const double a = 0.1 + random.unit();
    const double b = 0.1 + random.unit();
    const double sum = a + b + 0.1;
    line.push_back(
        {{"face", i % 2 == 0 ? 0 : kFaces - 1}, {"bary", {a / sum, b / sum, 0.1 / sum}}});
  }
  return line;
}

void check_limit(const HttpResponse& response, std::string_view parameter, std::uint64_t limit) {
  check_problem(response, 413, "too_large", parameter);
  const json problem = body_of(response);
  CHECK(problem["limit"] == limit);
  CHECK(problem["actual"] > limit);
}

}  // namespace

TEST_CASE("LinesThatCrossTooMuchAreRefused") {
  RandomMesh random(test_seed());
  PlaneService plane;
  const std::string base = plane.add(shapes::plane(2, kRows));
  const auto ask = [&](const std::string& query, const json& body) {
    return plane.service.ask("POST", base + query, body.dump());
  };
  const std::size_t legs = proto::kMaxCurvePieces / kFaces;
  check_limit(
      ask("/distance", {{"from", {{{"curve", {{"points", to_and_fro(legs + 4, random)}}}}}}}),
      "from[0]", proto::kMaxCurvePieces);
  const std::size_t cuts = proto::kMaxLineVertices / kFaces;
  check_limit(
      ask("/distance", {{"from", "v:0"}, {"walls", {{{"points", to_and_fro(cuts + 4, random)}}}}}),
      "walls", proto::kMaxLineVertices);
  check_limit(
      ask("/distance",
          {{"signed", true},
           {"from", {{{"curve", {{"points", to_and_fro(cuts + 4, random)}, {"closed", true}}}}}}}),
      "signed", proto::kMaxLineVertices);
  // What is refused leaves nothing behind that others would wait for.
  CHECK(ask("/distance", {{"from", "v:0"}, {"walls", {{{"points", to_and_fro(2, random)}}}}})
            .status == 200);
}

TEST_CASE("MoreRangesOfFacesThanAllowedAreRefusedAsSources") {
  PlaneService plane;
  json faces = json::array();
  for (std::size_t i = 0; i <= proto::kMaxFaceRanges; ++i) faces.push_back(i % 2);
  check_limit(plane.service.ask("POST", plane.base + "/distance",
                                json{{"from", {{{"faces", faces}}}}}.dump()),
              "from[0]", proto::kMaxFaceRanges);
}
