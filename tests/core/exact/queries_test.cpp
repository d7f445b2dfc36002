// What can be asked of the exact field: points inside faces, several sources,
// offsets, limits, targets.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/exact/field.h"
#include "core/field/window_table.h"
#include "core/mesh/shapes.h"
#include "core/paths/arrive_at_point.h"
#include "tests/fixtures/crumpled_surfaces.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::crumpled;
using fixtures::dented_ball;
using fixtures::fraction;
using fixtures::grown;
using fixtures::Surface;

namespace {

void check_nearly(double got, double wanted, double relative) {
  CAPTURE(got);
  CAPTURE(wanted);
  CHECK(std::abs(got - wanted) <= relative * wanted);
}

// The distance of any point from the vertices' distances and the windows, as the
// field's contract says.
double distance_at(const Surface& surface, const Field& field, const SurfacePoint& point) {
  const auto positions = surface.mesh().positions();
  double least = kUnreached;
  for (const SurfacePoint& place : in_all_faces(surface.adjacency(), point)) {
    const Vec3 at = position_of(surface.mesh(), place);
    const FaceRecord& face = surface.adjacency().face(place.face);
    for (std::uint32_t c = 0; c < 3; ++c) {
      const Vec3 a = positions[face.vertex[c]];
      const Vec3 b = positions[face.vertex[next_corner(c)]];
      least = std::min(least, field.distance[face.vertex[c]] + distance(at, a));
      const double length = distance(a, b);
      const double along = dot(at - a, b - a) / length;
      const double above = norm(cross(at - a, b - a)) / length;
      for (const VisibleInterval& w : field.windows->into(halfedge(place.face, c))) {
        CHECK(0 <= w.begin);
        CHECK(w.begin < w.end);
        CHECK(w.end <= length);
        CHECK(w.y >= 0);
        const double rise = above + w.y;
        const double straight = rise > 0 ? (w.x * above + along * w.y) / rise : along;
        const double crossing = std::clamp(straight, w.begin, w.end);
        least = std::min(least, w.offset + std::hypot(crossing - w.x, w.y) +
                                    std::hypot(along - crossing, above));
      }
    }
    for (const Source& source : field.sources) {
      for (const SurfacePoint& there : in_all_faces(surface.adjacency(), source.point)) {
        if (there.face != place.face) continue;
        least = std::min(least, source.offset + distance(at, position_of(surface.mesh(), there)));
      }
    }
  }
  return least;
}

SurfacePoint some_point(const Surface& surface, std::mt19937& random) {
  const auto face = static_cast<std::uint32_t>(random() % surface.mesh().source_face_count());
  std::array<double, 3> bary{fraction(random), fraction(random), fraction(random)};
  const auto kind = random() % 3;
  if (kind > 0) bary[random() % 3] = 0;
  if (kind > 1) {
    bary = {0, 0, 0};
    bary[random() % 3] = 1;
  }
  return surface.on(face, bary);
}

}  // namespace

// From x to y is as far as from y to x: each is read from the other's windows.
TEST_CASE("WindowsGiveTheDistancesInsideFaces") {
  for (std::uint32_t seed = 0; seed < 24; ++seed) {
    CAPTURE(seed);
    std::mt19937 random(seed);
    TriangleSoup soup;
    switch (seed % 4) {
      case 0:
        soup = grown(random, 60);
        break;
      case 1:
        soup = crumpled(random, 9, 0.8, 1);
        break;
      case 2:
        soup = dented_ball(random, 2);
        break;
      default:
        soup = shapes::plane(9, 9);
    }
    const Surface surface(soup);
    const SurfacePoint from = some_point(surface, random);
    const Field field = surface.field_by(Method::exact, {Source{from, 0}});
    REQUIRE(field.windows);
    for (int i = 0; i < 6; ++i) {
      const SurfacePoint to = some_point(surface, random);
      const double there = distance_at(surface, field, to);
      const Field back = surface.field_by(Method::exact, {Source{to, 0}});
      CHECK(std::abs(distance_at(surface, back, from) - there) <= 1e-11 * field.max);
    }
  }
}

TEST_CASE("SeveralSourcesAreTheNearestOfThem") {
  for (std::uint32_t seed = 0; seed < 6; ++seed) {
    CAPTURE(seed);
    std::mt19937 random(seed);
    const Surface surface(seed % 2 == 0 ? shapes::terrain(20, 3, seed) : grown(random, 80));
    std::vector<Source> sources;
    for (int i = 0; i < 5; ++i) sources.push_back({some_point(surface, random), 0.4 * i});
    const Field all = surface.field_by(Method::exact, sources);
    REQUIRE(all.nearest_source.size() == all.distance.size());
    std::vector<Field> one;
    for (const Source& source : sources) one.push_back(surface.field_by(Method::exact, {source}));
    for (std::size_t v = 0; v < all.distance.size(); ++v) {
      double least = kUnreached;
      for (const Field& field : one) least = std::min(least, field.distance[v]);
      if (least == kUnreached) {
        CHECK(all.distance[v] == kUnreached);
        CHECK(all.nearest_source[v] == kNone);
        continue;
      }
      CHECK(std::abs(all.distance[v] - least) <= 1e-12 * all.max);
      REQUIRE(all.nearest_source[v] < 5);
      CHECK(one[all.nearest_source[v]].distance[v] <= least + 1e-12 * all.max);
    }
  }
}

TEST_CASE("AnOffsetIsAddedAndCanHideASource") {
  const Surface surface(shapes::plane(6, 1 + 5));
  const Field field = surface.field_by(Method::exact, {{surface.at(0), 2}, {surface.at(5), 9}});
  check_nearly(field.distance[surface.vertex(0)], 2, 1e-15);
  check_nearly(field.distance[surface.vertex(5)], 7, 1e-13);  // the other's offset is more
  for (const std::uint32_t nearest : field.nearest_source) CHECK(nearest == 0);
  for (const VisibleInterval& w : field.windows->into(0)) CHECK(w.source == 0);
}

// The surface drowns in the rounding of such an offset; it is still all reached.
TEST_CASE("AnOffsetMayBeOutOfAllProportion") {
  const Surface surface(shapes::terrain(12, 3, 1));
  const Field field = surface.field_by(Method::exact, {{surface.at(70), 1e20}});
  CHECK(field.reached == 144);
  for (const double d : field.distance.values()) check_nearly(d, 1e20, 1e-12);
}

TEST_CASE("ALimitLeavesTheRestUnreached") {
  const Surface surface(shapes::terrain(24, 4, 3));
  const Source source{surface.at(77), 0};
  const Field whole = surface.field_by(Method::exact, {source});
  FieldLimits limits;
  limits.max = 0.4 * whole.max;
  const Field part = surface.field_by(Method::exact, {source}, limits);
  CHECK(part.reached > 20);
  CHECK(part.reached < whole.reached);
  for (std::size_t v = 0; v < whole.distance.size(); ++v) {
    if (whole.distance[v] > limits.max) {
      CHECK(part.distance[v] == kUnreached);
    } else {
      check_nearly(part.distance[v], whole.distance[v], 1e-12);
    }
  }
}

TEST_CASE("TargetsEndTheFieldWithTheFarthestOfThem") {
  const Surface surface(shapes::terrain(24, 4, 3));
  const Source source{surface.at(77), 0};
  const Field whole = surface.field_by(Method::exact, {source});
  const std::vector<std::uint32_t> targets{surface.vertex(80), surface.vertex(160),
                                           surface.vertex(80)};
  const double farthest = std::max(whole.distance[targets[0]], whole.distance[targets[1]]);
  FieldLimits limits;
  limits.targets = targets;
  for (const bool keep : {true, false}) {
    limits.keep_details = keep;
    const Field part = surface.field_by(Method::exact, {source}, limits);
    CHECK(part.reached < whole.reached);
    for (std::size_t v = 0; v < whole.distance.size(); ++v) {
      if (whole.distance[v] > farthest * (1 + 1e-12)) {
        CHECK(part.distance[v] == kUnreached);
      } else if (whole.distance[v] < farthest * (1 - 1e-12)) {
        check_nearly(part.distance[v], whole.distance[v], 1e-12);
      }
    }
    check_nearly(part.max, farthest, 1e-12);
  }
}

TEST_CASE("WindowsAreKeptOnlyForDetails") {
  const Surface surface(shapes::terrain(24, 4, 3));
  const Source source{surface.at(300), 0};
  FieldLimits limits;
  limits.keep_details = false;
  const Field without = surface.field_by(Method::exact, {source}, limits);
  const Field with = surface.field_by(Method::exact, {source});
  CHECK(!without.windows);
  REQUIRE(with.windows);
  CHECK(with.windows->size() > surface.mesh().face_count());
  CHECK(with.parents.empty());
  for (std::size_t v = 0; v < with.distance.size(); ++v) {
    CHECK(std::abs(without.distance[v] - with.distance[v]) <= 1e-13 * with.max);
  }
}

TEST_CASE("OneScratchServesManySurfaces") {
  ExactScratch scratch;
  for (const std::uint32_t side : {9U, 3U, 14U}) {
    const Surface surface(shapes::plane(side, side));
    const Source source{surface.at(0), 0};
    const auto field = exact_field(surface.adjacency(), {&source, 1}, {}, scratch, Cancel());
    REQUIRE(field.has_value());
    check_nearly(field->max, (side - 1) * std::sqrt(2.0), 1e-13);
  }
}

// What a scratch keeps of a surface serves the next query there, and no other one.
TEST_CASE("OneScratchServesEveryQueryAsANewOneDoes") {
  constexpr std::uint32_t kSide = fixtures::all_or(50, 24);
  TriangleSoup soup = shapes::terrain(kSide, 4, 3);
  for (Vec3& position : soup.positions) position.x *= 8;
  const Surface thin(soup);
  const Surface other(shapes::terrain(kSide, 4, 5));
  FieldLimits only_vertices;
  only_vertices.keep_details = false;
  ExactScratch kept;
  for (const Surface* surface : {&thin, &thin, &other, &thin}) {
    for (const FieldLimits& limits : {FieldLimits{}, only_vertices, only_vertices}) {
      for (const std::uint32_t v : {0U, 77U}) {
        const Source source{surface->at(v), 0};
        ExactScratch fresh;
        const auto wanted =
            exact_field(surface->adjacency(), {&source, 1}, limits, fresh, Cancel());
        const auto got = exact_field(surface->adjacency(), {&source, 1}, limits, kept, Cancel());
        REQUIRE(got.has_value());
        CHECK(got->distance == wanted->distance);
      }
    }
    // What was built halfway serves nobody.
    const Surface& next = surface == &thin ? other : thin;
    const Source source{next.at(0), 0};
    CHECK(!exact_field(next.adjacency(), {&source, 1}, {}, kept, Cancel([] { return true; })));
  }
}

TEST_CASE("ExactPropagationCanBeCancelled") {
  const Surface surface(shapes::terrain(60, 4, 3));
  const Source source{surface.at(0), 0};
  ExactScratch scratch;
  const auto field =
      exact_field(surface.adjacency(), {&source, 1}, {}, scratch, Cancel([] { return true; }));
  REQUIRE(!field.has_value());
  CHECK(field.error().code == ErrorCode::cancelled);
}

TEST_CASE("WithoutASourceNothingIsReached") {
  const Surface surface(shapes::plane(3, 3));
  const Field field = surface.field_by(Method::exact, {});
  CHECK(field.reached == 0);
  CHECK(field.windows->size() == 0);
}

// Of two points of one face that are next to each other, the squares of its sides tell the distance
// as coarsely as half of their digits.
TEST_CASE("WithinOneFaceADistanceIsTheStraightLineHoweverShort") {
  const auto check = [](const Surface& surface, const SurfacePoint& from, const SurfacePoint& to) {
    const double straight =
        distance(position_of(surface.mesh(), from), position_of(surface.mesh(), to));
    for (const Method method : {Method::exact, Method::chen_han}) {
      CAPTURE(static_cast<int>(method));
      const Field field = surface.field_by(method, {{from, 0}});
      const double found = PointArrivals(surface.adjacency(), field).distance_at(to);
      CHECK(std::abs(found - straight) <= 1e-6 * straight + 4e-15);
    }
  };
  const Surface sliver({{{-1.1483151980354904e-10, -5.431292829022035e-10, 2.709894660315713e-10},
                         {0.9999999999506259, 2.2389691545981642e-10, 1.8529649003740324e-11},
                         {3.0000000004698784, -1.4717961598858471e-10, -3.416995399748161e-10}},
                        {{2, 1, 0}}});
  check(sliver, sliver.at(1), sliver.on(0, {0.25, 0.25, 0.5}));
  std::mt19937 random(fixtures::test_seed());
  for (int round = 0; round < 100; ++round) {
    CAPTURE(round);
    const double off = std::pow(10, -1 - 11 * fixtures::fraction(random));
    TriangleSoup soup{{{0, 0, 0}, {1, 0, 0}, {3, 0, 0}}, {{2, 1, 0}}};
    for (Vec3& p : soup.positions) {
      p = p + off * Vec3{fixtures::fraction(random), fixtures::fraction(random),
                         fixtures::fraction(random)};
    }
    const Surface surface(soup);
    const double x = 0.25 + off * fixtures::fraction(random);
    check(surface, surface.at(1), surface.on(0, {x, 0.25, 0.75 - x}));
  }
}
