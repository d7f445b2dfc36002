// Faces on one edge, or at one vertex, by the ten thousands: copies of a face, books, fans. They
// are solved like other surfaces, in memory as for those, and whoever waits may leave off.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "core/crowded_edges.h"
#include "core/pair_search.h"
#include "tests/fixtures/surface.h"

using namespace geodesic;
using fixtures::Surface;

namespace {

constexpr std::uint32_t kFaces = 20'000;

TriangleSoup copies(double height) {
  return {{{0, 0, 0}, {1, 0, 0}, {0.4, height, 0}}, std::vector<Triangle>(kFaces, {0, 1, 2})};
}

// Pages of `rows` rows of two faces on one edge from 0 to 1, each with its own vertices.
TriangleSoup book(std::uint32_t pages, std::uint32_t rows) {
  TriangleSoup soup{{{0, 0, 0}, {0, 1, 0}}, {}};
  for (std::uint32_t p = 0; p < pages; ++p) {
    const double angle = 2 * std::numbers::pi * p / pages;
    std::uint32_t low = 0;
    std::uint32_t high = 1;
    for (std::uint32_t r = 1; r <= rows; ++r) {
      const auto next = static_cast<std::uint32_t>(soup.positions.size());
      soup.positions.push_back({r * std::cos(angle), 0, r * std::sin(angle)});
      soup.positions.push_back({r * std::cos(angle), 1, r * std::sin(angle)});
      soup.faces.push_back({low, next, high});
      soup.faces.push_back({next, next + 1, high});
      low = next;
      high = next + 1;
    }
  }
  return soup;
}

TriangleSoup fan() {
  TriangleSoup soup{{{0, 0, 0.1}}, {}};
  for (std::uint32_t i = 0; i < kFaces; ++i) {
    const double angle = 2 * std::numbers::pi * i / kFaces;
    soup.positions.push_back({std::cos(angle), std::sin(angle), 0});
    soup.faces.push_back({0, 1 + i, 1 + (i + 1) % kFaces});
  }
  return soup;
}

struct Crowd {
  std::string name;
  TriangleSoup soup;
};

std::vector<Crowd> crowds() {
  return {{"copies of a triangle", copies(0.7)},
          {"copies of a thin one", copies(1e-9)},
          {"a book of single rows", book(kFaces / 2, 1)},
          {"a book of four rows", book(kFaces / 8, 4)},
          {"a fan", fan()}};
}

struct Named {
  std::string name;
  Method method;
  Bound bound = Bound::none;
};

const Named kMethods[] = {
    {"auto", Method::back_traced},  {"upper", Method::back_traced, Bound::upper},
    {"dijkstra", Method::dijkstra}, {"wavefront", Method::wavefront},
    {"novotni", Method::novotni},   {"fast_marching", Method::fast_marching}};

}  // namespace

TEST_CASE("CrowdsAreSolvedInStepsAndMemoryAsOtherSurfaces") {
  for (const Crowd& crowd : crowds()) {
    CAPTURE(crowd.name);
    const Surface surface(crowd.soup);
    const std::vector<SurfacePoint> points{surface.at(0), surface.at(2),
                                           surface.on(7, {0.2, 0.3, 0.5})};
    for (const Named& by : kMethods) {
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
        CHECK(scratch.back_traced.wedges.size() <= 3 * 2000);
        CHECK(scratch.back_traced.corners.size() <= 64 * kFaces);
      }
    }
  }
}

TEST_CASE("ACrowdIsLeftWheneverItIsCancelled") {
  for (const Crowd& crowd : crowds()) {
    CAPTURE(crowd.name);
    const Surface surface(crowd.soup);
    const Source source{surface.at(2), 0};
    for (const Named& by : kMethods) {
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
