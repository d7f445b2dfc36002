// Faces on one edge, or at one vertex, by the ten thousands: copies of a face, books, fans. They
// are solved like other surfaces, in memory as for those, and whoever waits may leave off.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "core/back_traced/crowded_edges.h"
#include "core/solve/pair_search.h"
#include "core/solve/scratch_parts.h"
#include "tests/core/solve/crowded_meshes.h"
#include "tests/fixtures/surface.h"

using namespace geodesic;
using namespace crowded;
using fixtures::Surface;

namespace {

struct CrowdMethod {
  std::string name;
  Method method;
  Bound bound = Bound::none;
};

const CrowdMethod kCrowdMethods[] = {
    {"auto", Method::back_traced},  {"upper", Method::back_traced, Bound::upper},
    {"dijkstra", Method::dijkstra}, {"wavefront", Method::wavefront},
    {"novotni", Method::novotni},   {"fast_marching", Method::fast_marching},
    {"steiner", Method::steiner}};

}  // namespace

TEST_CASE("CrowdsAreSolvedInStepsAndMemoryAsOtherSurfaces") {
  for (const Crowd& crowd : crowds()) {
    CAPTURE(crowd.name);
    const Surface surface(crowd.soup);
    const std::vector<SurfacePoint> points{
        surface.at(0), surface.at(2), surface.on(7, {0.2, 0.3, 0.5}), surface.on(7, {0.5, 0.5, 0})};
    for (const CrowdMethod& by : kCrowdMethods) {
      CAPTURE(by.name);
      MethodOptions options;
      options.bound = by.bound;
      for (const SurfacePoint& from : points) {
        SolveScratch scratch;
        std::size_t asked = 0;
        const Source source{from, 0};
        const auto field = solve_field(by.method, options, surface.adjacency(), {&source, 1}, {},
                                       scratch, Cancel([&] { return ++asked > 2000; }));
        // 4096 steps each: some four hundred for each face.
        REQUIRE(field.has_value());
        CHECK(scratch.parts().back_traced.cones.size() <= 3 * 10'000);
        for (const FrontDomain& domain : scratch.parts().back_traced.domains) {
          CHECK(domain.room.corners.size() <= 64 * kFaces);
        }
      }
    }
  }
}

TEST_CASE("ACrowdIsLeftWheneverItIsCancelled") {
  for (const Crowd& crowd : crowds()) {
    CAPTURE(crowd.name);
    const Surface surface(crowd.soup);
    const Source source{surface.at(2), 0};
    for (const CrowdMethod& by : kCrowdMethods) {
      CAPTURE(by.name);
      MethodOptions options;
      options.bound = by.bound;
      SolveScratch scratch;
      std::size_t whole = 0;
      REQUIRE(solve_field(by.method, options, surface.adjacency(), {&source, 1}, {}, scratch,
                          Cancel([&] { return ++whole == 0; })));
      for (std::size_t at = 1; at <= whole; at += 1 + whole / 5) {
        std::size_t asked = 0;
        const auto field = solve_field(by.method, options, surface.adjacency(), {&source, 1}, {},
                                       scratch, Cancel([&] { return ++asked == at; }));
        REQUIRE_FALSE(field);
        CHECK(asked == at);
      }
    }
  }
}

TEST_CASE("BuildingACrowdsAdjacencyAsksAllTheTime") {
  for (const Crowd& crowd : crowds()) {
    CAPTURE(crowd.name);
    auto mesh = Mesh::build(crowd.soup);
    REQUIRE(mesh);
    const auto shared = std::make_shared<const Mesh>(std::move(*mesh));
    std::size_t whole = 0;
    REQUIRE(Adjacency::build(shared, Cancel([&] { return ++whole == 0; })));
    CHECK(whole <= 1000);
    for (std::size_t at = 1; at <= whole; at += 1 + whole / 12) {
      std::size_t asked = 0;
      const auto adjacency = Adjacency::build(shared, Cancel([&] { return ++asked == at; }));
      REQUIRE_FALSE(adjacency);
      CHECK(asked == at);
    }
  }
}

TEST_CASE("AcrossABooksSpineWaysAreStraight") {
  const Surface surface(book(200, 4));
  // From a corner of a page to the other corner of every other one.
  const auto from = static_cast<std::uint32_t>(2 + 6);
  for (const Bound bound : {Bound::none, Bound::upper}) {
    MethodOptions options;
    options.bound = bound;
    const Field field =
        surface.field_by(Method::back_traced, {Source{surface.at(from), 0}}, {}, options);
    for (std::uint32_t page = 1; page < 200; ++page) {
      const double found = field.distance[surface.vertex(2 + page * 8 + 7)];
      CHECK(found == doctest::Approx(std::hypot(8, 1)).epsilon(0.01));
      if (bound == Bound::upper) CHECK(found >= std::hypot(8, 1) * (1 - 1e-9));
    }
  }
}
