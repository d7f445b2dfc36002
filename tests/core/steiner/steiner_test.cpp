// Kanai and Suzuki 2001: the graph with points on edges, and the refinement of a
// path around itself.
#include "core/steiner/steiner.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/field/around_points.h"
#include "core/field/edge_points.h"
#include "core/field/longest_edge.h"
#include "core/mesh/shapes.h"
#include "core/paths/arrive_at_point.h"
#include "core/solve/scratch_parts.h"
#include "core/steiner/path.h"
#include "tests/fixtures/among_squares.h"
#include "tests/fixtures/awkward_meshes.h"
#include "tests/fixtures/path_checks.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::Surface;

namespace {

constexpr double kRounding = 1e-9;

MethodOptions with_points(std::uint32_t points_per_edge) {
  MethodOptions options;
  options.points_per_edge = points_per_edge;
  return options;
}

Field steiner(const Surface& surface, const std::vector<Source>& sources,
              std::uint32_t points_per_edge = 3, const FieldLimits& limits = {}) {
  return surface.field_by(Method::steiner, sources, limits, with_points(points_per_edge));
}

std::optional<Path> refined(const Surface& surface, const Source& from, const SurfacePoint& to,
                            const MethodOptions& options = {}) {
  WavefrontScratch scratch;
  auto result = steiner_path(surface.adjacency(), from, to, options, scratch, Cancel());
  REQUIRE(result.has_value());
  return std::move(*result);
}

double extent_of(const Surface& surface) {
  return distance(surface.mesh().box().min, surface.mesh().box().max);
}

}  // namespace

TEST_CASE("OnePointInTheMiddleOfEachEdgeByHand") {
  // A unit square cut from (0, 0) to (1, 1) or from (1, 0) to (0, 1).
  const Surface along(shapes::plane(2, 2, shapes::Diagonal::rising));
  const Surface across(shapes::plane(2, 2, shapes::Diagonal::falling));
  const auto to_far_corner = [](const Surface& surface) {
    return steiner(surface, {{surface.at(0), 0}}, 1).distance[surface.vertex(3)];
  };
  // Along the diagonal, or over its middle.
  CHECK(to_far_corner(along) == doctest::Approx(std::sqrt(2)));
  CHECK(to_far_corner(across) == doctest::Approx(std::sqrt(2)));
}

TEST_CASE("AWayThroughAMiddleBendsThere") {
  // From (0, 0) to (1, 2) over two squares whose diagonals fall: straight over
  // (1/2, 1), a middle of nothing but the edge between the squares, which is a node.
  const Surface surface(shapes::plane(2, 3, shapes::Diagonal::falling));
  const auto to_top = [&](std::uint32_t points) {
    return steiner(surface, {{surface.at(0), 0}}, points).distance[surface.vertex(5)];
  };
  // The diagonals are crossed at 2/3 and 1/3 of them: two points on each edge have
  // those, but not the middle between the squares; five have all three.
  CHECK(to_top(5) == doctest::Approx(std::sqrt(5)));
  CHECK(to_top(2) > std::sqrt(5) * 1.001);
  const double by_middles = 2 * (std::hypot(0.5, 0.5) + std::hypot(0, 0.5));
  CHECK(to_top(1) == doctest::Approx(by_middles));
}

TEST_CASE("MorePointsComeCloserFromAbove") {
  const TriangleSoup soup = shapes::plane(30, 30);
  const Surface surface(soup);
  double fewer = 1;
  for (const std::uint32_t points : {1U, 3U, 7U, 15U}) {
    CAPTURE(points);
    const auto d = surface.in_source_order(steiner(surface, {{surface.at(64), 0}}, points));
    double mean = 0;
    double worst = 0;
    for (std::uint32_t i = 0; i < d.size(); ++i) {
      if (i == 64) continue;
      const double truth = distance(soup.positions[i], soup.positions[64]);
      CHECK(d[i] >= truth * (1 - kRounding));
      worst = std::max(worst, d[i] / truth - 1);
      mean += (d[i] / truth - 1) / static_cast<double>(d.size() - 1);
    }
    MESSAGE(points, " points: mean ", 100 * mean, " %, worst ", 100 * worst, " %");
    // Points half as far apart: an error of a third or less.
    CHECK(mean < 0.4 * fewer);
    // The best of the directions that the points offer is off by half a spacing at
    // most, and a detour grows with the square of that.
    const double spacing = 1.0 / (points + 1);
    CHECK(worst <= 0.55 * spacing * spacing);
    fewer = mean;
  }
  CHECK(fewer < 0.001);
}

TEST_CASE("BetweenTheTruthAndTheWayAlongEdges") {
  for (std::uint32_t number = 0; number < 40; ++number) {
    CAPTURE(number);
    fixtures::RandomMesh random(number);
    const Surface surface(random.soup());
    const Source source{surface.on(random.below(random.face_count()),
                                   {random.unit() + 0.01, random.unit() + 0.01, random.unit()}),
                        0};
    const Field one = steiner(surface, {source}, 1);
    const Field three = steiner(surface, {source}, 3);
    const Field along_edges = surface.field_by(Method::dijkstra, {source});
    const Field exact = surface.field_by(Method::exact, {source});
    const PointArrivals arrivals(surface.adjacency(), three);
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      REQUIRE((one.distance[v] == kUnreached) == (along_edges.distance[v] == kUnreached));
      if (one.distance[v] == kUnreached) continue;
      CHECK(one.distance[v] <= along_edges.distance[v] * (1 + kRounding));
      CHECK(three.distance[v] <= one.distance[v] * (1 + kRounding));  // they are among them
      CHECK(three.distance[v] >= exact.distance[v] * (1 - kRounding));
      const auto path = surface.path(three, point_at_vertex(surface.adjacency(), v));
      REQUIRE(path);
      fixtures::check_is_a_path(surface.adjacency(), *path, extent_of(surface));
      // The path in the graph is as long as the graph says.
      CHECK(std::abs(path->length - three.distance[v]) <= kRounding * extent_of(surface));
    }
    for (int i = 0; i < 10; ++i) {
      const SurfacePoint to = surface.on(random.below(random.face_count()),
                                         {random.unit() + 0.01, random.unit(), random.unit()});
      const auto path = surface.path(three, to);
      REQUIRE(path.has_value() == (arrivals.distance_at(to) != kUnreached));
      if (!path) continue;
      fixtures::check_is_a_path(surface.adjacency(), *path, extent_of(surface));
      CHECK(std::abs(path->length - arrivals.distance_at(to)) <= kRounding * extent_of(surface));
    }
  }
}

TEST_CASE("SteinerSeveralSourcesGiveTheLeastOfEach") {
  const Surface surface(shapes::terrain(20, 2, 3));
  std::vector<Source> sources{{surface.at(0), 0},
                              {surface.on(300, {0.2, 0.3, 0.5}), 1.5},
                              {surface.on(500, {0.4, 0.6, 0}), 0}};
  const Field all = steiner(surface, sources);
  std::vector<Field> each;
  for (const Source& source : sources) each.push_back(steiner(surface, {source}));
  for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
    double least = kUnreached;
    for (const Field& field : each) least = std::min(least, field.distance[v]);
    CHECK(all.distance[v] == least);
    CHECK(each[all.nearest_source[v]].distance[v] == least);
  }
  REQUIRE(all.edge_points);
  for (std::size_t i = 0; i < all.edge_points->distance.size(); ++i) {
    const std::uint32_t s = all.edge_points->nearest_source[i];
    CHECK(all.edge_points->distance[i] == each[s].edge_points->distance[i]);
  }
  const auto path = surface.path(all, surface.on(301, {0.1, 0.1, 0.8}));
  REQUIRE(path);
  CHECK(path->source ==
        all.nearest_source[surface.mesh().faces()[surface.mesh().face_of_source(301)][2]]);
}

TEST_CASE("SteinerStopsAtMaxAndAtTargets") {
  const Surface surface(shapes::terrain(30, 8, 2));
  const std::vector<Source> from{{surface.at(0), 0}};
  const Field whole = steiner(surface, from);
  FieldLimits limits;
  limits.max = 15;
  const Field near = steiner(surface, from, 3, limits);
  for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
    CHECK(near.distance[v] == (whole.distance[v] <= 15 ? whole.distance[v] : kUnreached));
  }
  for (std::size_t i = 0; i < whole.edge_points->distance.size(); ++i) {
    const double d = whole.edge_points->distance[i];
    CHECK(near.edge_points->distance[i] == (d <= 15 ? d : kUnreached));
  }
  const std::vector<std::uint32_t> targets{surface.vertex(31), surface.vertex(70)};
  FieldLimits until;
  until.targets = targets;
  const Field part = steiner(surface, from, 3, until);
  CHECK(part.reached < whole.reached / 2);
  for (const std::uint32_t v : targets) CHECK(part.distance[v] == whole.distance[v]);
  WavefrontScratch scratch;
  const auto cancelled =
      steiner_field(surface.adjacency(), from, 3, {}, scratch, Cancel([] { return true; }));
  REQUIRE_FALSE(cancelled);
  CHECK(cancelled.error().code == ErrorCode::cancelled);
  const auto no_path = steiner_path(surface.adjacency(), from[0], surface.at(899), {}, scratch,
                                    Cancel([] { return true; }));
  REQUIRE_FALSE(no_path);
  CHECK(no_path.error().code == ErrorCode::cancelled);
}

TEST_CASE("WithoutDetailsNothingIsKeptOfTheEdges") {
  const Surface surface(shapes::plane(10, 10));
  FieldLimits limits;
  limits.keep_details = false;
  const Field field = steiner(surface, {{surface.at(0), 0}}, 3, limits);
  CHECK_FALSE(field.edge_points);
  CHECK(field.distance == steiner(surface, {{surface.at(0), 0}}, 3).distance);
  // Points inside faces are still near the truth: straight from the face's corners.
  const PointArrivals arrivals(surface.adjacency(), field);
  const SurfacePoint point = surface.on(101, {0.2, 0.3, 0.5});
  const double truth = norm(position_of(surface.mesh(), point));
  CHECK(arrivals.distance_at(point) >= truth * (1 - kRounding));
  CHECK(arrivals.distance_at(point) <= truth + 1);
}

TEST_CASE("TooManyPointsAreRefusedBeforeTheyAreMade") {
  const Surface surface(shapes::plane(10, 10));
  const Source source{surface.at(0), 0};
  SolveScratch scratch;
  const std::uint32_t most =
      static_cast<std::uint32_t>((kMaxSteinerNodes - 100) / surface.adjacency().report().edges);
  for (const std::uint32_t points : {0U, most + 1, 0xffffffffU}) {
    CAPTURE(points);
    const auto field = solve_field(Method::steiner, with_points(points), surface.adjacency(),
                                   {&source, 1}, {}, scratch, Cancel());
    REQUIRE_FALSE(field);
    CHECK(field.error().code == ErrorCode::value_out_of_range);
    CHECK(field.error().parameter == "points_per_edge");
    const auto path = steiner_path(surface.adjacency(), source, surface.at(5), with_points(points),
                                   scratch.parts().wavefront, Cancel());
    REQUIRE_FALSE(path);
    CHECK(path.error().parameter == "points_per_edge");
  }
  for (const double tolerance : {-1.0, std::numeric_limits<double>::quiet_NaN()}) {
    MethodOptions options;
    options.tolerance = tolerance;
    const auto path = steiner_path(surface.adjacency(), source, surface.at(5), options,
                                   scratch.parts().wavefront, Cancel());
    REQUIRE_FALSE(path);
    CHECK(path.error().code == ErrorCode::value_out_of_range);
    CHECK(path.error().parameter == "tolerance");
  }
}

TEST_CASE("ASearchTowardsAGoalFindsWhatTheWholeFieldSays") {
  for (std::uint32_t number = 0; number < 40; ++number) {
    CAPTURE(number);
    fixtures::RandomMesh random(number);
    const Surface surface(random.soup());
    const auto anywhere = [&] {
      return surface.on(random.below(random.face_count()),
                        {random.unit(), random.below(3) == 0 ? 0 : random.unit(),
                         random.below(3) == 0 ? 0 : random.unit() + 0.01});
    };
    const Source source{anywhere(), 0};
    const SurfacePoint goal = anywhere();
    WavefrontScratch scratch;
    const auto towards =
        steiner_field_towards(surface.adjacency(), source, goal, 2, scratch, Cancel());
    REQUIRE(towards);
    const Field whole = steiner(surface, {source}, 2);
    CHECK(PointArrivals(surface.adjacency(), *towards).distance_at(goal) ==
          PointArrivals(surface.adjacency(), whole).distance_at(goal));
    CHECK(towards->reached <= whole.reached);
  }
}

namespace {

// What a field that stops at the corners about a point says of it, and the way there, are those of
// the whole field.
void check_limited_is_as_whole(const Surface& surface, const std::vector<Source>& sources,
                               const Field& whole, const SurfacePoint& point) {
  const auto faces = *faces_around(surface.adjacency(), {&point, 1}, Cancel());
  const auto corners = *vertices_around(surface.adjacency(), {&point, 1}, Cancel());
  FieldLimits limits;
  limits.targets = corners;
  limits.beyond_targets = longest_edge_of(surface.adjacency(), faces);
  const Field near = steiner(surface, sources, whole.edge_points->per_edge, limits);
  const double expected = PointArrivals(surface.adjacency(), whole).distance_at(point);
  CHECK(PointArrivals(surface.adjacency(), near).distance_at(point) == expected);
  const auto path = surface.path(near, point);
  REQUIRE(path.has_value() == (expected != kUnreached));
  if (!path) return;
  const auto whole_path = surface.path(whole, point);
  REQUIRE(whole_path);
  CHECK(path->source == whole_path->source);
  CHECK(path->length == whole_path->length);
}

}  // namespace

// A point may be farther than all corners of its face, where these have sources of their own.
TEST_CASE("APointInsideAFaceIsAsFarByAFieldThatStopsAtItsCorners") {
  const Surface two({{{0, 0, 0}, {10, 0, 0}, {5, 9, 0}, {5, -1, 0}}, {{0, 1, 2}, {1, 0, 3}}});
  const std::vector<Source> at_corners{
      {two.at(0), 0}, {two.at(1), 0}, {two.at(2), 0}, {two.on(1, {0.25, 0.25, 0.5}), 0}};
  const Field whole = steiner(two, at_corners);
  const double z = 0.5 / 9;
  const SurfacePoint beside = two.on(0, {(1 - z) / 2, (1 - z) / 2, z});
  CHECK(PointArrivals(two.adjacency(), whole).distance_at(beside) == doctest::Approx(1));
  check_limited_is_as_whole(two, at_corners, whole, beside);

  for (std::uint32_t round = 0; round < 30; ++round) {
    const std::uint32_t number = fixtures::test_seed() + round;
    CAPTURE(number);
    fixtures::RandomMesh random(number);
    const Surface surface(random.soup());
    const auto anywhere = [&] {
      if (random.below(3) == 0) return surface.at(random.vertex());
      return surface.on(random.below(random.face_count()),
                        {random.unit() + 0.01, random.below(4) == 0 ? 0 : random.unit() + 0.01,
                         random.unit() + 0.01});
    };
    // In half of the rounds up to as many as there are faces.
    const std::uint32_t count = 1 + random.below(random.below(2) == 0 ? 3 : random.face_count());
    std::vector<Source> sources;
    for (std::uint32_t s = 0; s < count; ++s) {
      sources.push_back({anywhere(), 0.3 * random.unit()});
    }
    const Field everywhere = steiner(surface, sources, 1 + random.below(3));
    for (int i = 0; i < 10; ++i) {
      check_limited_is_as_whole(surface, sources, everywhere, anywhere());
    }
  }
}

TEST_CASE("ARefinedPathOnAPlaneIsNearlyStraight") {
  const Surface surface(shapes::plane(30, 30));
  MethodOptions options;
  options.tolerance = 1e-7;
  for (const std::uint32_t target : {31U, 217U, 500U, 617U, 893U}) {
    CAPTURE(target);
    for (const std::uint32_t points : {1U, 3U}) {
      options.points_per_edge = points;
      const auto path = refined(surface, {surface.at(0), 5}, surface.at(target), options);
      REQUIRE(path);
      fixtures::check_is_a_path(surface.adjacency(), *path, 30);
      const double truth = norm(surface.mesh().positions()[surface.vertex(target)]);
      CHECK(path->length >= truth * (1 - kRounding));
      CHECK(path->length <= truth * 1.0001);
    }
  }
}

TEST_CASE("ARefinedPathAmongSquaresIsTheShortest") {
  const std::vector<shapes::Hole> holes{{5, 5, 8}, {18, 12, 6}, {8, 20, 5}};
  const std::vector<fixtures::Square> squares{{5, 5, 13, 13}, {18, 12, 24, 18}, {8, 20, 13, 25}};
  const Surface surface(shapes::plane_with_holes(31, 31, holes));
  double worst = 0;
  for (const std::uint32_t target :
       {960U, 30U * 31, 30U, 15U * 31 + 14, 14U * 31 + 30, 26U * 31 + 11}) {
    CAPTURE(target);
    const auto path = refined(surface, {surface.at(0), 0}, surface.at(target));
    REQUIRE(path);
    fixtures::check_is_a_path(surface.adjacency(), *path, 31);
    const double truth =
        fixtures::shortest_among(squares, {0, 0}, {double(target % 31), double(target / 31)});
    CHECK(path->length >= truth * (1 - kRounding));
    worst = std::max(worst, path->length / truth - 1);
  }
  MESSAGE("among squares: over the truth by up to ", 100 * worst, " %");
  CHECK(worst < 5e-4);
}

TEST_CASE("RefiningNeverLengthensAndKeepsTheEnds") {
  for (std::uint32_t number = 200; number < 260; ++number) {
    CAPTURE(number);
    fixtures::RandomMesh random(number);
    const Surface surface(random.soup());
    const auto anywhere = [&] {
      return surface.on(random.below(random.face_count()),
                        {random.unit(), random.below(3) == 0 ? 0 : random.unit(),
                         random.below(3) == 0 ? 0 : random.unit() + 0.01});
    };
    const Source source{anywhere(), random.unit()};
    const Field field = steiner(surface, {source}, 2);
    const Field exact = surface.field_by(Method::exact, {source});
    const PointArrivals exactly(surface.adjacency(), exact);
    for (int i = 0; i < 6; ++i) {
      const SurfacePoint to = anywhere();
      const auto before = surface.path(field, to);
      const auto after = refined(surface, source, to, with_points(2));
      REQUIRE(before.has_value() == after.has_value());
      if (!after) continue;
      fixtures::check_is_a_path(surface.adjacency(), *after, extent_of(surface));
      CHECK(after->length <= before->length * (1 + kRounding));
      const double truth = exactly.distance_at(to) - source.offset;
      CHECK(after->length >= truth - kRounding * extent_of(surface));
      const double apart = kRounding * extent_of(surface);
      CHECK(distance(after->points.front().position, position_of(surface.mesh(), source.point)) <=
            apart);
      CHECK(distance(after->points.back().position, position_of(surface.mesh(), to)) <= apart);
    }
  }
}

TEST_CASE("RefinedPathsOnHillsComeCloseToTheExactOnes") {
  for (const TriangleSoup& soup : {shapes::icosphere(3), shapes::terrain(30, 2, 5)}) {
    const Surface surface(soup);
    const Source source{surface.on(3, {0.2, 0.3, 0.5}), 0};
    const Field exact = surface.field_by(Method::exact, {source});
    double before = 0;
    double after = 0;
    int count = 0;
    for (std::uint32_t v = 7; v < surface.mesh().vertex_count(); v += 41) {
      const SurfacePoint to = point_at_vertex(surface.adjacency(), v);
      if (!(exact.distance[v] > 1e-3)) continue;
      const auto path = refined(surface, source, to);
      REQUIRE(path);
      fixtures::check_is_a_path(surface.adjacency(), *path, extent_of(surface));
      const Field field = steiner(surface, {source});
      before += field.distance[v] / exact.distance[v] - 1;
      after += path->length / exact.distance[v] - 1;
      ++count;
    }
    MESSAGE("over the exact distance by ", 100 * before / count, " % unrefined, ",
            100 * after / count, " % refined");
    CHECK(after < 0.1 * before);
    CHECK(after / count < 5e-4);
  }
}

TEST_CASE("SteinerOnAwkwardMeshes") {
  for (const fixtures::AwkwardMesh& mesh : fixtures::awkward_meshes()) {
    CAPTURE(mesh.name);
    const Surface surface(mesh.soup);
    const Source source{surface.at(mesh.source), 0};
    const Field field = steiner(surface, {source});
    const Field along_edges = surface.field_by(Method::dijkstra, {source});
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      CAPTURE(v);
      CHECK((field.distance[v] == kUnreached) == (along_edges.distance[v] == kUnreached));
      const SurfacePoint to = point_at_vertex(surface.adjacency(), v);
      const auto path = surface.path(field, to);
      const auto shorter = refined(surface, source, to);
      REQUIRE(path.has_value() == (field.distance[v] != kUnreached));
      REQUIRE(path.has_value() == shorter.has_value());
      if (!path) continue;
      CHECK(field.distance[v] <= along_edges.distance[v] * (1 + kRounding));
      fixtures::check_is_a_path(surface.adjacency(), *path, 10);
      fixtures::check_is_a_path(surface.adjacency(), *shorter, 10);
      CHECK(path->length == doctest::Approx(field.distance[v]).epsilon(kRounding));
      CHECK(shorter->length <= path->length * (1 + kRounding));
    }
  }
  // The corner of one page to the far corner of another, unfolded.
  const Surface book(fixtures::book_of_three_pages());
  const auto over_spine = refined(book, {book.at(2), 0}, book.at(18 + 8));
  REQUIRE(over_spine);
  CHECK(over_spine->length == doctest::Approx(std::hypot(4, 2)).epsilon(1e-4));
  TriangleSoup apart = shapes::plane(3, 3);
  apart.positions.push_back({50, 50, 50});
  const Surface isolated(apart);
  const auto to_itself = refined(isolated, {isolated.at(9), 1}, isolated.at(9));
  REQUIRE(to_itself);
  CHECK(to_itself->length == 0);
  CHECK_FALSE(refined(isolated, {isolated.at(9), 1}, isolated.at(0)));
  CHECK_FALSE(refined(isolated, {isolated.at(0), 1}, isolated.at(9)));
}

TEST_CASE("SteinerScales") {
  const TriangleSoup unit = shapes::terrain(12, 3, 1);
  const Surface plain(unit);
  const auto expected = plain.in_source_order(steiner(plain, {{plain.at(0), 0}}));
  const auto path = refined(plain, {plain.at(0), 0}, plain.at(143));
  REQUIRE(path);
  for (const double scale : {0x1p-130, 0x1p130}) {
    TriangleSoup soup = unit;
    for (Vec3& p : soup.positions) p = scale * p;
    const Surface surface(soup);
    const auto d = surface.in_source_order(steiner(surface, {{surface.at(0), 0}}));
    for (std::size_t i = 0; i < d.size(); ++i) {
      CHECK(d[i] == doctest::Approx(scale * expected[i]).epsilon(kRounding));
    }
    const auto scaled = refined(surface, {surface.at(0), 0}, surface.at(143));
    REQUIRE(scaled);
    CHECK(scaled->length == doctest::Approx(scale * path->length).epsilon(1e-6));
  }
}

TEST_CASE("SteinerWithAnOffsetBeyondAllLengthsStillLeadsHome") {
  const Surface surface(shapes::plane(8, 8));
  const Field field = steiner(surface, {{surface.at(0), 0x1p60}});
  for (std::uint32_t i = 0; i < 64; ++i) {
    const auto path = surface.path(field, surface.at(i));
    REQUIRE(path);
    fixtures::check_is_a_path(surface.adjacency(), *path, 8);
    CHECK(path->points.front().position == Vec3{0, 0, 0});
  }
  // A refined path does not feel the offset.
  const auto path = refined(surface, {surface.at(0), 0x1p60}, surface.at(63 - 8));
  REQUIRE(path);
  CHECK(path->length == doctest::Approx(std::hypot(7, 6)).epsilon(1e-4));
}
