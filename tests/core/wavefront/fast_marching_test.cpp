// Kimmel and Sethian 1998: the rule for one triangle, the splitting of obtuse ones,
// and how the error falls as faces get smaller.
#include "core/wavefront/fast_marching.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/mesh/shapes.h"
#include "core/paths/arrive_at_point.h"
#include "tests/fixtures/awkward_meshes.h"
#include "tests/fixtures/path_checks.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/surface.h"

using namespace geodesic;
using fixtures::Surface;

namespace {

// A plane of `side` x `side` vertices, each (i, j) moved to i * u + j * v.
TriangleSoup sheared_plane(std::uint32_t side, Vec3 u, Vec3 v) {
  TriangleSoup soup = shapes::plane(side, side);
  for (Vec3& p : soup.positions) p = p.x * u + p.y * v;
  return soup;
}

struct Errors {
  double mean;
  double worst;
};

// Relative to the straight line from the source vertex.
Errors errors_on_plane(const TriangleSoup& soup, std::uint32_t source,
                       const std::vector<double>& distances) {
  Errors errors{0, 0};
  for (std::uint32_t i = 0; i < distances.size(); ++i) {
    if (i == source) continue;
    const double truth = distance(soup.positions[i], soup.positions[source]);
    const double error = std::abs(distances[i] - truth) / truth;
    errors.mean += error / static_cast<double>(distances.size() - 1);
    errors.worst = std::max(errors.worst, error);
  }
  return errors;
}

Field marched(const Surface& surface, const std::vector<Source>& sources,
              const FieldLimits& limits = {}) {
  return surface.field_by(Method::fast_marching, sources, limits);
}

Errors errors_from_centre(const TriangleSoup& soup, std::uint32_t side) {
  const Surface surface(soup);
  const std::uint32_t source = (side / 2) * side + side / 2;
  return errors_on_plane(soup, source,
                         surface.in_source_order(marched(surface, {{surface.at(source), 0}})));
}

// The same rule for every triangle, obtuse or not.
std::vector<double> march_without_unfolding(const Surface& surface, std::uint32_t source) {
  const Adjacency& adjacency = surface.adjacency();
  std::vector<double> d(adjacency.mesh().vertex_count(), kUnreached);
  VertexHeap heap;
  heap.reset(d.size());
  const auto lower = [&](std::uint32_t v, double to) {
    if (heap.accepted(v) || !(to < d[v])) return;
    d[v] = to;
    heap.push_or_lower(v, to);
  };
  lower(surface.vertex(source), 0);
  while (!heap.empty()) {
    const std::uint32_t v = heap.pop().vertex;
    for (const std::uint32_t corner : adjacency.corners(v)) {
      const FaceRecord& face = adjacency.face(face_of(corner));
      for (std::uint32_t c = 0; c < 3; ++c) {
        const std::uint32_t p = face.vertex[c];
        const std::uint32_t q = face.vertex[next_corner(c)];
        const double length = std::sqrt(face.length2(c));
        if (p == v) lower(q, d[v] + length);
        if (q == v) lower(p, d[v] + length);
        if (!heap.accepted(p) || !heap.accepted(q)) continue;
        const Arrival arrival = arrive_plane_wave(d[p], d[q], face.apex_over(c));
        if (arrival.distance >= std::max(d[p], d[q])) {
          lower(face.vertex[previous_corner(c)], arrival.distance);
        }
      }
    }
  }
  return d;
}

}  // namespace

TEST_CASE("APlaneWaveIsExactBehindAStraightFront") {
  // Base from (0, 0) to (4, 0), apex (1, 3); a front with its normal (sin a, cos a).
  const UnfoldedApex apex{4, 12, 12, 10, 18};
  int over_base = 0;
  for (int degrees = -85; degrees <= 85; degrees += 5) {
    const double a = degrees * 3.141592653589793 / 180;
    const double dp = 7;
    const double dq = dp + 4 * std::sin(a);
    const Arrival arrival = arrive_plane_wave(dp, dq, apex);
    const double foot = 1 - 3 * std::tan(a);  // where the characteristic meets the base
    CAPTURE(degrees);
    if (foot > 0 && foot < 4) {
      ++over_base;
      CHECK(arrival.which == Fig4::a);
      CHECK(arrival.distance == doctest::Approx(dp + std::sin(a) + 3 * std::cos(a)));
      CHECK(arrival.crossing == doctest::Approx(foot / 4));
    } else {
      const double by_p = dp + std::sqrt(10);
      const double by_q = dq + std::sqrt(18);
      CHECK(arrival.which == (by_p <= by_q ? Fig4::b : Fig4::c));
      CHECK(arrival.distance == doctest::Approx(std::min(by_p, by_q)));
    }
  }
  CHECK(over_base > 10);
  // More apart than the base is long: no straight front has these values.
  CHECK(arrive_plane_wave(1, 6, apex).distance == doctest::Approx(1 + std::sqrt(10)));
}

TEST_CASE("ErrorsFallAsTheGridIsRefined") {
  // Right-angled and equilateral faces; the square is the same, the spacing halves.
  const Vec3 right{0, 1, 0};
  const Vec3 acute{-0.5, std::sqrt(0.75), 0};
  for (const Vec3 v : {right, acute}) {
    Errors coarser{1, 1};
    for (const std::uint32_t side : {17U, 33U, 65U, 129U}) {
      CAPTURE(side);
      const double spacing = 1.0 / (side - 1);
      const Errors errors =
          errors_from_centre(sheared_plane(side, {spacing, 0, 0}, spacing * v), side);
      // Of the order of h log h.
      CHECK(errors.mean < 0.75 * coarser.mean);
      coarser = errors;
      MESSAGE("side ", side, ": mean ", 100 * errors.mean, " %, worst ", 100 * errors.worst, " %");
    }
    CHECK(coarser.mean < 0.012);
  }
}

TEST_CASE("AnObtuseFaceIsSplitByTheVertexBeyondItsBase") {
  // Apex (0, 0) over the base (2, 1) - (-2, 1), the far vertex (0.5, 3).
  TriangleSoup kite{{{0, 0, 0}, {2, 1, 0}, {-2, 1, 0}, {0.5, 3, 0}}, {{0, 1, 2}, {1, 2, 3}}};
  const Surface surface(kite);
  const auto split_at_apex = [](const Surface& on) {
    const std::uint32_t face = on.mesh().face_of_source(0);
    std::uint32_t c = 0;
    while (on.adjacency().face(face).vertex[c] != on.vertex(0)) ++c;
    REQUIRE(on.adjacency().face(face).dot[c] < 0);
    return split_obtuse(on.adjacency(), face, c);
  };
  const ObtuseSplit split = split_at_apex(surface);
  CHECK(split.far == surface.vertex(3));
  CHECK(std::hypot(split.far_at[0], split.far_at[1]) == doctest::Approx(std::hypot(0.5, 3)));
  // Both virtual triangles are acute at the obtuse vertex.
  for (const auto& end : {split.first_at, split.second_at}) {
    CHECK(split.far_at[0] * end[0] + split.far_at[1] * end[1] > 0);
  }
  // A vertex outside the section: one more face is unfolded.
  TriangleSoup longer = kite;
  longer.positions[3] = {5, 3, 0};
  longer.positions.push_back({-0.5, 7, 0});
  longer.faces.push_back({2, 3, 4});
  const Surface second(longer);
  const ObtuseSplit by_second = split_at_apex(second);
  CHECK(by_second.far == second.vertex(4));
  CHECK(std::hypot(by_second.far_at[0], by_second.far_at[1]) ==
        doctest::Approx(std::hypot(0.5, 7)));
  // Nothing beyond the base, and too much.
  kite.faces.pop_back();
  CHECK(split_at_apex(Surface(kite)).far == kNone);
  kite.faces = {{0, 1, 2}, {1, 2, 3}, {2, 1, 3}};
  CHECK(split_at_apex(Surface(kite)).far == kNone);
}

TEST_CASE("UnfoldingMendsWhatObtuseFacesSpoil") {
  // Angles of up to 146 degrees.
  const std::uint32_t side = 61;
  const TriangleSoup soup = sheared_plane(side, {1, 0, 0}, {1.5, 1, 0});
  const Surface surface(soup);
  const std::uint32_t source = (side / 2) * side + side / 2;
  const auto plain = march_without_unfolding(surface, source);
  std::vector<double> without;
  for (const std::uint32_t v : surface.mesh().vertex_of_source()) without.push_back(plain[v]);
  const Errors before = errors_on_plane(soup, source, without);
  const Errors after = errors_from_centre(soup, side);
  MESSAGE("sheared plane: without unfolding mean ", 100 * before.mean, " %, worst ",
          100 * before.worst, " %; with it ", 100 * after.mean, " %, ", 100 * after.worst, " %");
  CHECK(after.mean < 0.1 * before.mean);

  // A terrain stretched along one axis, against the exact distances.
  TriangleSoup terrain = shapes::terrain(50, 3, 4);
  for (Vec3& p : terrain.positions) p.x *= 2;
  const Surface hills(terrain);
  const Field exact = hills.field_by(Method::exact, {{hills.at(0), 0}});
  const Field with = marched(hills, {{hills.at(0), 0}});
  const auto naive = march_without_unfolding(hills, 0);
  double sum_with = 0;
  double sum_without = 0;
  for (std::uint32_t v = 0; v < naive.size(); ++v) {
    if (!(exact.distance[v] > 0)) continue;
    sum_with += std::abs(with.distance[v] / exact.distance[v] - 1);
    sum_without += std::abs(naive[v] / exact.distance[v] - 1);
  }
  MESSAGE("stretched terrain: mean ", 100 * sum_without / naive.size(), " % without, ",
          100 * sum_with / naive.size(), " % with unfolding");
  CHECK(sum_with < 0.8 * sum_without);
}

TEST_CASE("FastMarchingIsNeverAboveTheWayAlongEdges") {
  for (std::uint32_t number = 0; number < 60; ++number) {
    CAPTURE(number);
    fixtures::RandomMesh random(number);
    const Surface surface(random.soup());
    const Source source{surface.at(random.vertex()), 0};
    const Field field = marched(surface, {source});
    const Field along_edges = surface.field_by(Method::dijkstra, {source});
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      REQUIRE((field.distance[v] == kUnreached) == (along_edges.distance[v] == kUnreached));
      if (field.distance[v] == kUnreached) continue;
      CHECK(field.distance[v] <= along_edges.distance[v] * (1 + 1e-12));
      const auto path = surface.path(field, point_at_vertex(surface.adjacency(), v));
      REQUIRE(path);
      fixtures::check_is_a_path(surface.adjacency(), *path,
                                distance(surface.mesh().box().min, surface.mesh().box().max));
    }
  }
}

TEST_CASE("FastMarchingFromSourcesAnywhere") {
  const std::uint32_t side = 65;
  const TriangleSoup soup = shapes::plane(side, side);
  const Surface surface(soup);
  const std::uint32_t face = 64 * 64 + 64;
  for (const std::array<double, 3> bary :
       {std::array{0.0, 0.5, 0.5}, std::array{0.3, 0.7, 0.0}, std::array{0.2, 0.3, 0.5}}) {
    const SurfacePoint point = surface.on(face, bary);
    const Vec3 at = position_of(surface.mesh(), point);
    const auto distances = surface.in_source_order(marched(surface, {{point, 2}}));
    double worst = 0;
    for (std::uint32_t i = 0; i < distances.size(); ++i) {
      worst = std::max(worst, std::abs(distances[i] - 2 - distance(soup.positions[i], at)));
    }
    CHECK(worst < 1.5);  // edges
    // Straight within the face.
    for (const std::uint32_t v : soup.faces[face]) {
      CHECK(distances[v] == doctest::Approx(2 + distance(soup.positions[v], at)));
    }
  }
}

TEST_CASE("OneFrontOfSeveralSources") {
  const std::uint32_t side = 41;
  const TriangleSoup soup = shapes::plane(side, side);
  const Surface surface(soup);
  const std::vector<std::uint32_t> at{0, 1, 20 * side + 20, 30 * side + 5};
  std::vector<Source> sources;
  for (const std::uint32_t v : at) sources.push_back({surface.at(v), 0});
  sources[2].offset = 3;
  const Field field = marched(surface, sources);
  REQUIRE(field.nearest_source.size() == field.distance.size());
  for (std::uint32_t i = 0; i < soup.positions.size(); ++i) {
    double least = kUnreached;
    std::vector<double> by;
    for (std::size_t s = 0; s < at.size(); ++s) {
      by.push_back(sources[s].offset + distance(soup.positions[i], soup.positions[at[s]]));
      least = std::min(least, by.back());
    }
    const std::uint32_t v = surface.vertex(i);
    CHECK(field.distance[v] <= least + 1.25);
    CHECK(field.distance[v] >= least - 0.5);
    CHECK(by[field.nearest_source[v]] <= least + 1.5);
  }
  const auto path = surface.path(field, surface.at(31 * side + 6));
  REQUIRE(path);
  CHECK(path->source == 3);
  CHECK(path->length == doctest::Approx(std::sqrt(2)));
  // A source that another one reaches sooner than its own offset.
  const Field late = marched(surface, {{surface.at(0), 100}, {surface.at(40), 0}});
  CHECK(late.distance[surface.vertex(0)] == doctest::Approx(40));
  CHECK(late.nearest_source[surface.vertex(0)] == 1);
  const auto from_other = surface.path(late, surface.at(0));
  REQUIRE(from_other);
  CHECK(from_other->length == doctest::Approx(40));
}

TEST_CASE("FastMarchingStopsAtMaxAndAtTargets") {
  const Surface surface(shapes::terrain(50, 8, 2));
  const std::vector<Source> from{{surface.at(0), 0}};
  const Field whole = marched(surface, from);
  FieldLimits limits;
  limits.max = 20;
  const Field near = marched(surface, from, limits);
  for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
    CHECK(near.distance[v] == (whole.distance[v] <= 20 ? whole.distance[v] : kUnreached));
  }
  const std::vector<std::uint32_t> targets{surface.vertex(51), surface.vertex(150)};
  FieldLimits until;
  until.targets = targets;
  const Field part = marched(surface, from, until);
  CHECK(part.reached < whole.reached / 2);
  for (const std::uint32_t v : targets) CHECK(part.distance[v] == whole.distance[v]);
  for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
    if (part.distance[v] != kUnreached) CHECK(part.distance[v] == whole.distance[v]);
  }
  FastMarchingScratch scratch;
  const auto cancelled = fast_marching_field(Surface(shapes::plane(80, 80)).adjacency(), from, {},
                                             scratch, Cancel([] { return true; }));
  REQUIRE_FALSE(cancelled);
  CHECK(cancelled.error().code == ErrorCode::cancelled);
}

TEST_CASE("FastMarchingPathsArePathsThatEndAtTheSource") {
  TriangleSoup obtuse = shapes::terrain(50, 6, 9);
  for (Vec3& p : obtuse.positions) p.x *= 4;
  for (const TriangleSoup& soup :
       {shapes::plane(40, 40), shapes::icosphere(4), shapes::torus_knot(150, 12, 0.4),
        shapes::saddle(40, 12), shapes::shuffled(shapes::terrain(50, 3, 4), 2), obtuse}) {
    const Surface surface(soup);
    const double size = distance(surface.mesh().box().min, surface.mesh().box().max);
    const Field field = marched(surface, {{surface.at(0), 0}});
    const PointArrivals arrivals(surface.adjacency(), field);
    double difference = 0;
    std::size_t count = 0;
    for (std::uint32_t f = 0; f < soup.faces.size(); f += 17) {
      for (const SurfacePoint& to : {surface.on(f, {0.2, 0.5, 0.3}), surface.on(f, {0, 0.4, 0.6}),
                                     surface.on(f, {1, 0, 0})}) {
        const auto path = surface.path(field, to);
        REQUIRE(path);
        fixtures::check_is_a_path(surface.adjacency(), *path, size);
        CHECK(path->points.front().position == soup.positions[0]);
        CHECK(path->points.back().position == position_of(surface.mesh(), to));
        const double stated = arrivals.distance_at(to);
        if (!(stated > 0)) continue;
        CHECK(path->length <= 1.02 * stated + 0.5 * surface.adjacency().report().mean_edge);
        difference += std::abs(path->length - stated) / stated;
        ++count;
      }
    }
    CHECK(difference / static_cast<double>(count) < 0.03);
  }
}

TEST_CASE("FastMarchingOnAwkwardMeshes") {
  for (const fixtures::AwkwardMesh& mesh : fixtures::awkward_meshes()) {
    CAPTURE(mesh.name);
    const Surface surface(mesh.soup);
    const Source source{surface.at(mesh.source), 0};
    const Field field = marched(surface, {source});
    const Field along_edges = surface.field_by(Method::dijkstra, {source});
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      CAPTURE(v);
      CHECK((field.distance[v] == kUnreached) == (along_edges.distance[v] == kUnreached));
      const auto path = surface.path(field, point_at_vertex(surface.adjacency(), v));
      REQUIRE(path.has_value() == (field.distance[v] != kUnreached));
      if (!path) continue;
      CHECK(field.distance[v] <= along_edges.distance[v] * (1 + 1e-12));
      fixtures::check_is_a_path(surface.adjacency(), *path, 10);
      CHECK(path->length <= along_edges.distance[v] * 1.001);
    }
  }
  // The pages of a book, straight over the spine.
  const Surface book(fixtures::book_of_three_pages());
  const auto d = book.in_source_order(marched(book, {{book.at(2), 0}}));
  CHECK(d[9 + 2] == doctest::Approx(4));
  CHECK(d[18 + 2] == doctest::Approx(4));
  // An isolated vertex reaches itself.
  TriangleSoup apart = shapes::plane(3, 3);
  apart.positions.push_back({50, 50, 50});
  const Surface isolated(apart);
  const Field alone = marched(isolated, {{isolated.at(9), 1}});
  CHECK(alone.reached == 1);
  const auto path = isolated.path(alone, isolated.at(9));
  REQUIRE(path);
  CHECK(path->length == 0);
}

TEST_CASE("FastMarchingScalesAndKeepsNoOrder") {
  const TriangleSoup unit = shapes::terrain(20, 3, 1);
  const Surface plain(unit);
  const auto expected = plain.in_source_order(marched(plain, {{plain.at(0), 0}}));
  for (const double scale : {0x1p-130, 0x1p130}) {
    TriangleSoup soup = unit;
    for (Vec3& p : soup.positions) p = scale * p;
    const Surface surface(soup);
    const auto d = surface.in_source_order(marched(surface, {{surface.at(0), 0}}));
    for (std::size_t i = 0; i < d.size(); ++i) {
      CHECK(d[i] == doctest::Approx(scale * expected[i]).epsilon(1e-9));
    }
  }
  // Faces rotated and flipped, vertices renumbered.
  const Surface mixed(shapes::shuffled(unit, 11));
  std::uint32_t same = kNone;
  for (std::uint32_t v = 0; v < mixed.mesh().vertex_count(); ++v) {
    if (mixed.mesh().positions()[v] == unit.positions[0]) same = v;
  }
  REQUIRE(same != kNone);
  const Field other = marched(mixed, {{point_at_vertex(mixed.adjacency(), same), 0}});
  std::vector<double> one = expected;
  std::vector<double> two = other.distance.values();
  std::sort(one.begin(), one.end());
  std::sort(two.begin(), two.end());
  for (std::size_t i = 0; i < one.size(); ++i) CHECK(one[i] == doctest::Approx(two[i]));
}

TEST_CASE("AnOffsetBeyondAllLengthsStillLeadsHome") {
  // Distances that differ by less than rounding: the way back must still end.
  const Surface surface(shapes::plane(12, 12));
  const Field field = marched(surface, {{surface.at(0), 0x1p60}});
  for (std::uint32_t i = 0; i < 144; ++i) {
    const auto path = surface.path(field, surface.at(i));
    REQUIRE(path);
    fixtures::check_is_a_path(surface.adjacency(), *path, 12);
    CHECK(path->points.front().position == Vec3{0, 0, 0});
  }
}
