// Distances from lines on any surface, against points as dense as they please and each other.
#include "core/curves/strip_front.h"

#include <doctest/doctest.h>

#include <numbers>
#include <random>
#include <vector>

#include "tests/core/curves/curve_fixtures.h"
#include "tests/fixtures/awkward_meshes.h"
#include "tests/fixtures/faces_thrown_together.h"
#include "tests/fixtures/random_meshes.h"

using namespace geodesic;
using fixtures::ask_some_lines;
using fixtures::dense_points;
using fixtures::DensePoints;
using fixtures::LineQuestion;
using fixtures::RandomMesh;
using fixtures::some_point;
using fixtures::Surface;
using fixtures::test_seed;

TEST_CASE("LinesAreTheLimitOfDensePoints") {
  std::mt19937 random(test_seed());
  for (int round = 0; round < 12; ++round) {
    CAPTURE(round);
    RandomMesh mesh(random());
    const Surface surface(mesh.soup());
    LineQuestion question(surface);
    ask_some_lines(surface, random, question);
    const Field exact = question.field(Method::exact);
    const Field other = question.field(Method::chen_han);
    const Field ends = surface.field_by(Method::exact, question.sources());
    const DensePoints dense = dense_points(surface, question.lines(), question.sources(), 16);
    const Field limit = surface.field_by(Method::exact, dense.sources);
    const double size = norm(surface.mesh().box().max - surface.mesh().box().min);
    const double rounding = 1e-9 * size;
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      CAPTURE(v);
      if (ends.distance[v] == kUnreached) {
        // All of another component may be a source.
        CHECK((exact.distance[v] == kUnreached || exact.distance[v] == 0));
        continue;
      }
      CHECK(std::abs(exact.distance[v] - other.distance[v]) <= rounding);
      CHECK(exact.distance[v] <= ends.distance[v] + rounding);
      CHECK(exact.distance[v] <= limit.distance[v] + rounding);
      // A set has no points within.
      if (question.lines().item_of_face.empty()) {
        CHECK(exact.distance[v] >= limit.distance[v] - dense.spacing / 2 - rounding);
      }
    }
    const auto positions = surface.mesh().positions();
    for (const FaceRecord& face : surface.adjacency().faces()) {
      for (std::uint32_t c = 0; c < 3; ++c) {
        const std::uint32_t a = face.vertex[c];
        const std::uint32_t b = face.vertex[next_corner(c)];
        if (exact.distance[a] == kUnreached) continue;
        CHECK(exact.distance[a] <=
              exact.distance[b] + norm(positions[a] - positions[b]) + rounding);
      }
    }
  }
}

TEST_CASE("PointsInFacesAndPathsAgreeWithTheLimitOfDensePoints") {
  std::mt19937 random(test_seed() + 1);
  for (int round = 0; round < 8; ++round) {
    CAPTURE(round);
    RandomMesh mesh(random());
    const Surface surface(mesh.soup());
    LineQuestion question(surface);
    ask_some_lines(surface, random, question);
    const Field exact = question.field(Method::exact);
    const Field other = question.field(Method::chen_han);
    const DensePoints dense = dense_points(surface, question.lines(), question.sources(), 12);
    const Field limit = surface.field_by(Method::exact, dense.sources);
    const PointArrivals arrivals(surface.adjacency(), limit);
    const double size = norm(surface.mesh().box().max - surface.mesh().box().min);
    const double rounding = 1e-9 * size;
    for (int i = 0; i < 40; ++i) {
      const SurfacePoint point = some_point(surface, random);
      const double distance = question.at(exact, point);
      const double above = arrivals.distance_at(point);
      if (above == kUnreached) continue;
      CHECK(distance <= above + rounding);
      CHECK(std::abs(distance - question.at(other, point)) <= rounding);
      if (question.lines().item_of_face.empty()) {
        CHECK(distance >= above - dense.spacing / 2 - rounding);
      }
      const auto path = question.path(exact, point);
      REQUIRE(path);
      CHECK(std::abs(path->length - distance) <= 10 * rounding);
      const double start = question.at(exact, path->points.front().point);
      CHECK(start <= rounding);
    }
  }
}

TEST_CASE("TheRingOfACylinderIsAsFarAsItsHeight") {
  constexpr std::uint32_t kColumns = 17;
  constexpr std::uint32_t kRows = 9;
  TriangleSoup soup;
  for (std::uint32_t j = 0; j < kRows; ++j) {
    for (std::uint32_t i = 0; i < kColumns; ++i) {
      const double turn = 2 * std::numbers::pi * i / kColumns;
      soup.positions.push_back({2 * std::cos(turn), 2 * std::sin(turn), 0.7 * j});
      if (j == 0) continue;
      const std::uint32_t ahead = (i + 1) % kColumns;
      const std::uint32_t below = (j - 1) * kColumns;
      soup.faces.push_back({below + i, below + ahead, below + kColumns + ahead});
      soup.faces.push_back({below + i, below + kColumns + ahead, below + kColumns + i});
    }
  }
  const Surface surface(soup);
  const Cancel never;
  Poll poll(never);
  const auto loops = boundary_loops(surface.adjacency(), poll);
  REQUIRE(loops.size() == 2);
  CHECK(loops[0].is_closed);
  CHECK(loops[0].edges.size() == kColumns);
  CHECK(loops[0].length == doctest::Approx(loops[1].length));
  LineQuestion question(surface);
  question.loop(loops[0]);
  const double of_ring = surface.mesh().positions()[surface.adjacency().tail(loops[0].edges[0])].z;
  const Field field = question.field(Method::exact);
  for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
    const double up = std::abs(surface.mesh().positions()[v].z - of_ring);
    CHECK(std::abs(field.distance[v] - up) <= 1e-12);
  }
}

// Faces thrown together share edges as they please: strips branch at each of them.
TEST_CASE("LinesOnAwkwardMeshesAgreeByBothExactMethods") {
  std::mt19937 random(test_seed() + 2);
  std::vector<TriangleSoup> soups;
  for (auto& awkward : fixtures::awkward_meshes()) soups.push_back(std::move(awkward.soup));
  for (int i = 0; i < 10; ++i) soups.push_back(fixtures::faces_thrown_together(random, 30));
  for (std::size_t i = 0; i < soups.size(); ++i) {
    CAPTURE(i);
    const Surface surface(soups[i]);
    LineQuestion question(surface);
    ask_some_lines(surface, random, question);
    const Field exact = question.field(Method::exact);
    const Field other = question.field(Method::chen_han);
    const DensePoints dense = dense_points(surface, question.lines(), question.sources(), 12);
    const Field limit = surface.field_by(Method::exact, dense.sources);
    const double size = norm(surface.mesh().box().max - surface.mesh().box().min);
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      if (limit.distance[v] == kUnreached) continue;
      CHECK(std::abs(exact.distance[v] - other.distance[v]) <= 1e-8 * size);
      CHECK(exact.distance[v] <= limit.distance[v] + 1e-8 * size);
      if (question.lines().item_of_face.empty()) {
        CHECK(exact.distance[v] >= limit.distance[v] - dense.spacing / 2 - 1e-8 * size);
      }
    }
  }
}

TEST_CASE("AFieldFromLinesEndsAtItsMax") {
  std::mt19937 random(test_seed() + 3);
  const Surface surface(shapes::terrain(9, 3, test_seed()));
  LineQuestion question(surface);
  question.boundary();
  const Field whole = question.field(Method::exact);
  FieldLimits limits;
  limits.max = whole.max / 2;
  for (const Method method : {Method::exact, Method::chen_han, Method::back_traced}) {
    const Field part = question.field(method, limits);
    CHECK(part.max <= limits.max);
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      if (part.distance[v] == kUnreached) {
        CHECK(whole.distance[v] > limits.max * (1 - 1e-2));
      } else {
        CHECK(part.distance[v] == doctest::Approx(whole.distance[v]).epsilon(1e-2));
      }
    }
  }
}

TEST_CASE("LoopsOfABoundaryAreAsManyAsTheReportSays") {
  std::mt19937 random(test_seed() + 4);
  for (int round = 0; round < 40; ++round) {
    RandomMesh mesh(random());
    const Surface surface(mesh.soup());
    const Cancel never;
    Poll poll(never);
    const auto loops = boundary_loops(surface.adjacency(), poll);
    CHECK(loops.size() == surface.adjacency().report().boundary_loops);
    std::size_t edges = 0;
    for (const BoundaryLoop& loop : loops) edges += loop.edges.size();
    CHECK(edges == surface.adjacency().report().edges_boundary);
    for (const std::size_t most : {std::size_t{0}, std::size_t{2}, loops.size() + 1}) {
      const auto sizes = longest_boundaries(surface.adjacency(), most, poll);
      REQUIRE(sizes.size() == std::min(most, loops.size()));
      for (std::size_t i = 0; i < sizes.size(); ++i) {
        CHECK(sizes[i].length == loops[i].length);
        CHECK(sizes[i].edges == loops[i].edges.size());
        CHECK(sizes[i].is_closed == loops[i].is_closed);
        std::uint64_t least = kNone;
        for (const Halfedge h : loops[i].edges) {
          for (const std::uint32_t v : {surface.adjacency().tail(h), surface.adjacency().head(h)}) {
            least = std::min<std::uint64_t>(least, surface.mesh().source_of_vertex(v));
          }
        }
        CHECK(sizes[i].vertex == least);
      }
    }
  }
}

TEST_CASE("StripsStopWhenTheyAreTold") {
  const Surface surface(shapes::terrain(40, 3, 5));
  LineQuestion question(surface);
  question.boundary();
  std::uint64_t asked = 0;
  std::uint64_t most = ~std::uint64_t{0};
  const Cancel cancel([&] { return ++asked > most; });
  const auto lines = std::make_shared<const SourceLines>(question.lines());
  REQUIRE(spread_strips(surface.adjacency(), question.sources(), lines, {}, cancel));
  const std::uint64_t all = asked;
  CHECK(all > 10);
  for (const std::uint64_t few : {std::uint64_t{0}, all / 3, all - 2}) {
    asked = 0;
    most = few;
    const auto stopped = spread_strips(surface.adjacency(), question.sources(), lines, {}, cancel);
    REQUIRE(!stopped);
    CHECK(stopped.error().code == ErrorCode::cancelled);
  }
  MemoryBudget none([](std::uint64_t) {
    return std::optional(Error{ErrorCode::too_large, "no room", {}, {}, {}});
  });
  const Cancel poor({}, {}, &none);
  const auto refused = spread_strips(surface.adjacency(), question.sources(), lines, {}, poor);
  REQUIRE(!refused);
  CHECK(refused.error().code == ErrorCode::too_large);
}

TEST_CASE("LinesThatAreThereAgainAreLeftOut") {
  std::mt19937 random(test_seed());
  for (int i = 0; i < 20; ++i) {
    const auto number = static_cast<std::uint32_t>(random());
    CAPTURE(number);
    const Surface surface(RandomMesh(number).soup());
    LineQuestion once(surface);
    LineQuestion again(surface);
    const std::uint32_t state = random();
    for (int round = 0; round < 3; ++round) {
      std::mt19937 same(state);
      ask_some_lines(surface, same, again);
      if (round > 0) continue;
      same.seed(state);
      ask_some_lines(surface, same, once);
    }
    const std::size_t thrice = again.lines().segments.size();
    once.merge();
    again.merge();
    CHECK(again.lines().segments.size() == once.lines().segments.size());
    if (thrice > 0) CHECK(again.lines().segments.size() < thrice);
    CHECK(again.sources().size() == once.sources().size());
    CHECK(again.lines().item_of_source.size() == again.sources().size());
    for (const std::uint32_t item : again.lines().item_of_source) CHECK(item == 0);
    const Field one = once.field(Method::exact);
    const Field other = again.field(Method::exact);
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      CHECK(one.distance[v] == other.distance[v]);
    }
  }
  // Backwards, and from the other face.
  const Surface plane(shapes::plane(3, 3));
  LineQuestion both(plane);
  const Adjacency& adjacency = plane.adjacency();
  for (std::uint32_t f = 0; f < plane.mesh().face_count(); ++f) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      const Halfedge h = halfedge(f, c);
      for (const auto& [from, to] : {std::pair(adjacency.tail(h), adjacency.head(h)),
                                     std::pair(adjacency.head(h), adjacency.tail(h))}) {
        both.curve({point_at_vertex(adjacency, from), point_at_vertex(adjacency, to)}, false);
      }
    }
  }
  both.merge();
  CHECK(both.lines().segments.size() == 16);  // edges of the plane
  CHECK(both.sources().size() == 9);
}
