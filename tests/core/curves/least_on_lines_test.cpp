// How near lines come to each other: the closed form in planes, and dense points on any surface.
#include "core/curves/least_on_lines.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <random>
#include <vector>

#include "core/base/memory_budget.h"
#include "tests/core/curves/curve_fixtures.h"
#include "tests/core/solve/crowded_meshes.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/sanitizers.h"

using namespace geodesic;
using fixtures::ask_some_lines;
using fixtures::dense_points;
using fixtures::LineQuestion;
using fixtures::RandomMesh;
using fixtures::some_point;
using fixtures::Surface;
using fixtures::test_seed;
using fixtures::to_segment;
using fixtures::turned_plane;

namespace {

constexpr double kExact = 1e-9;

struct Piece {
  Vec3 from;
  Vec3 to;
};

std::vector<Piece> pieces_of(const Surface& surface, const LineQuestion& question) {
  std::vector<Piece> pieces;
  for (const LineSegment& segment : question.lines().segments) {
    const auto at = [&](const std::array<double, 3>& bary) {
      return position_of(surface.mesh(), {segment.face, bary, kNone});
    };
    pieces.push_back({at(segment.from), at(segment.to)});
  }
  for (const Source& end : question.sources()) {
    const Vec3 at = position_of(surface.mesh(), end.point);
    pieces.push_back({at, at});
  }
  return pieces;
}

// Of a plane with that normal.
double between(const Piece& a, const Piece& b, Vec3 normal) {
  const auto side = [&](const Piece& of, Vec3 p) {
    return dot(normal, cross(of.to - of.from, p - of.from));
  };
  const bool is_crossed =
      side(a, b.from) * side(a, b.to) < 0 && side(b, a.from) * side(b, a.to) < 0;
  if (is_crossed) return 0;
  return std::min({to_segment(a.from, b.from, b.to), to_segment(a.to, b.from, b.to),
                   to_segment(b.from, a.from, a.to), to_segment(b.to, a.from, a.to)});
}

// The least from one to the other, with details where they are needed alone.
double least_between(const Surface& surface, LineQuestion& from, const LineQuestion& to,
                     Method method) {
  const Cancel cancel;
  Poll poll(cancel);
  std::vector<std::uint32_t> faces = faces_of_lines(surface.adjacency(), to.lines().segments, poll);
  CHECK(std::is_sorted(faces.begin(), faces.end()));
  for (const Source& end : to.sources()) {
    for (const SurfacePoint& place : in_all_faces(surface.adjacency(), end.point)) {
      faces.push_back(place.face);
    }
  }
  FieldLimits limits;
  limits.detail_faces = faces;
  const Field field = from.field(method, limits);
  double least = FieldOnLines(surface.adjacency(), field, poll).least(to.lines().segments);
  for (const Source& end : to.sources()) least = std::min(least, from.at(field, end.point));
  return least;
}

void ask_some_curve(const Surface& surface, std::mt19937& random, LineQuestion& question) {
  std::vector<SurfacePoint> points;
  for (std::size_t i = 2 + random() % 2; i > 0; --i) points.push_back(some_point(surface, random));
  (void)question.curve(points, points.size() > 2 && random() % 2 == 0);
}

}  // namespace

TEST_CASE("LinesInPlanesAreAsNearAsTheClosedFormSays") {
  std::mt19937 random(test_seed());
  int crossed = 0;
  for (int round = 0; round < fixtures::all_or(120, 24); ++round) {
    CAPTURE(round);
    const Surface surface(turned_plane(4 + random() % 8, 4 + random() % 8, random));
    LineQuestion a(surface);
    LineQuestion b(surface);
    ask_some_curve(surface, random, a);
    if (random() % 4 == 0) {
      b.boundary();
    } else {
      ask_some_curve(surface, random, b);
    }
    const auto positions = surface.mesh().positions();
    const Triangle& t = surface.mesh().faces()[0];
    const Vec3 normal = cross(positions[t[1]] - positions[t[0]], positions[t[2]] - positions[t[0]]);
    double wanted = kUnreached;
    const std::vector<Piece> others = pieces_of(surface, b);
    for (const Piece& one : pieces_of(surface, a)) {
      for (const Piece& other : others) wanted = std::min(wanted, between(one, other, normal));
    }
    crossed += wanted == 0 ? 1 : 0;
    for (const Method method : {Method::exact, Method::chen_han}) {
      CHECK(std::abs(least_between(surface, a, b, method) - wanted) <= kExact);
      CHECK(std::abs(least_between(surface, b, a, method) - wanted) <= kExact);
    }
  }
  if (fixtures::kSanitized) return;  // so few say nothing of how often
  CHECK(crossed > 5);
  CHECK(crossed < 115);
}

// Whichever of the two the field is from.
TEST_CASE("WhatLiesWithinFacesIsAtNoDistanceFromThem") {
  std::mt19937 random(test_seed() + 2);
  const Cancel cancel;
  Poll poll(cancel);
  for (int round = 0; round < 30; ++round) {
    CAPTURE(round);
    const Surface surface(turned_plane(9, 9, random));
    std::vector<std::uint32_t> faces;
    for (std::uint32_t f = 0; f < surface.mesh().face_count(); ++f) {
      if (random() % 3 > 0) faces.push_back(f);
    }
    const std::uint32_t some = faces[random() % faces.size()];
    const SurfacePoint corner =
        point_at_vertex(surface.adjacency(), surface.mesh().faces()[some][random() % 3]);
    const SurfacePoint inside = point_on_face(surface.adjacency(), some, {0.2, 0.5, 0.3});
    const SurfacePoint beside = point_on_face(surface.adjacency(), some, {0.4, 0.3, 0.3});
    const std::vector<std::vector<SurfacePoint>> within{
        {corner, corner}, {corner, inside}, {inside, beside}, {inside, inside}};
    LineQuestion set(surface);
    set.faces(faces);
    for (const std::vector<SurfacePoint>& points : within) {
      LineQuestion curve(surface);
      (void)curve.curve(points, false);
      const Field from_curve = curve.field(Method::exact);
      CHECK(FieldOnLines(surface.adjacency(), from_curve, poll).meets(faces));
      CHECK(least_between(surface, set, curve, Method::exact) == 0);
    }
    const Field from_faces = set.field(Method::exact);
    const FieldOnLines on_faces(surface.adjacency(), from_faces, poll);
    for (const std::uint32_t f : faces) CHECK(on_faces.meets(std::vector{f}));
  }
}

// A curve with many points along the edge of many pages, and a point on one of the pages.
TEST_CASE("OfACurveAlongACrowdedEdgeItsPointsAndTheFacesThereAreKeptAndNotEachPair") {
  std::mt19937 random(test_seed() + 3);
  constexpr std::uint32_t kPages = 1000;
  constexpr std::size_t kPoints = 500;
  const Surface surface(crowded::book(kPages, 1));
  const Adjacency& adjacency = surface.adjacency();
  LineQuestion question(surface);
  std::vector<double> up;  // along the edge, which is from 0 to 1
  for (std::size_t i = 0; i < kPoints; ++i) up.push_back(0.2 + 0.2 * (random() / 4294967296.0));
  std::sort(up.begin(), up.end());
  std::vector<SurfacePoint> points;
  for (const double at : up) points.push_back(surface.on(2 * (random() % kPages), {1 - at, 0, at}));
  (void)question.curve(points, false);
  const std::uint32_t page = random() % kPages;
  question.point(surface.on(2 * page, {0.3, 0.4, 0.3}));
  const std::vector<LineSegment>& segments = question.lines().segments;

  std::uint64_t asked = 0;
  std::uint64_t taken = 0;
  MemoryBudget budget([&](std::uint64_t bytes) -> std::optional<Error> {
    taken += bytes;
    return std::nullopt;
  });
  const Cancel cancel([&] { return ++asked == 0; }, {}, &budget);
  Poll poll(cancel);
  std::vector<std::uint32_t> on_edge;
  for (std::uint32_t p = 0; p < kPages; ++p) {
    on_edge.push_back(surface.mesh().face_of_source(2 * p));
  }
  std::sort(on_edge.begin(), on_edge.end());
  CHECK(faces_of_lines(adjacency, segments, poll) == on_edge);
  // No vertex has a distance: what is near is the points alone.
  Field field;
  field.sources = question.sources();
  field.distance.assign(surface.mesh().vertex_count(), kUnreached);
  field.lines = std::make_shared<const LineWaves>(
      adjacency, std::make_shared<const SourceLines>(question.lines()),
      static_cast<std::uint32_t>(field.sources.size()), std::vector<LineStrip>(), true, poll);
  asked = taken = 0;
  const FieldOnLines on_lines(adjacency, field, poll);
  CHECK(taken > 0);
  CHECK(taken < 200 * (kPoints + kPages));
  CHECK(asked < 20);

  for (std::uint32_t f = 0; f < surface.mesh().face_count(); ++f) {
    const bool is_met = std::binary_search(on_edge.begin(), on_edge.end(), f);
    CHECK(on_lines.meets(std::vector{f}) == is_met);
  }
  const auto least = [&](std::uint32_t of_page, const std::array<double, 3>& from,
                         const std::array<double, 3>& to) {
    const LineSegment asked_of{surface.mesh().face_of_source(2 * of_page), from, to, 0};
    return on_lines.least({&asked_of, 1});
  };
  CHECK(std::abs(least(random() % kPages, {0.4, 0, 0.6}, {0.2, 0, 0.8}) - (0.6 - up.back())) <
        kExact);
  double wanted = kUnreached;
  for (const double at : up) wanted = std::min(wanted, std::hypot(0.3, at - 0.3));
  const std::uint32_t another = (page + 1) % kPages;
  CHECK(std::abs(least(another, {0.4, 0.3, 0.3}, {0.1, 0.6, 0.3}) - wanted) < kExact);
  CHECK(std::abs(least(page, {0.2, 0.5, 0.3}, {0.1, 0.6, 0.3}) - 0.1) < kExact);

  MemoryBudget none([](std::uint64_t) -> std::optional<Error> {
    return Error{ErrorCode::too_large, "no more", {}, {}, {}};
  });
  const Cancel poor({}, {}, &none);
  Poll first(poor);
  (void)faces_of_lines(adjacency, segments, first);
  CHECK(first.stopped());
  Poll second(poor);
  const FieldOnLines refused(adjacency, field, second);
  CHECK(second.stopped());
}

TEST_CASE("LinesOnSurfacesAreAsNearAsTheirPointsInTheLimit") {
  std::mt19937 random(test_seed() + 1);
  for (int round = 0; round < fixtures::all_or(40, 8); ++round) {
    CAPTURE(round);
    RandomMesh mesh(random());
    const Surface surface(mesh.soup());
    LineQuestion a(surface);
    LineQuestion b(surface);
    ask_some_lines(surface, random, a);
    ask_some_lines(surface, random, b);
    const double size = norm(surface.mesh().box().max - surface.mesh().box().min);
    const double rounding = 1e-9 * size;
    const auto dense = dense_points(surface, b.lines(), b.sources(), 32);
    const double exact = least_between(surface, a, b, Method::exact);
    for (const Method method :
         {Method::exact, Method::chen_han, Method::dijkstra, Method::steiner}) {
      CAPTURE(int(method));
      const double least = least_between(surface, a, b, method);
      const Field field = a.field(method);
      double limit = kUnreached;
      for (const Source& point : dense.sources) limit = std::min(limit, a.at(field, point.point));
      CHECK((least == kUnreached) == (limit == kUnreached));
      if (limit == kUnreached) continue;
      CHECK(least <= limit + rounding);
      // By other methods a strip may pass between two points that are far by edges.
      const bool is_exact = traits_of(method).has_windows;
      CHECK(least >= (is_exact ? limit - dense.spacing / 2 : exact) - rounding);
    }
    // From either end, where no set lies within the other.
    if (!a.lines().item_of_face.empty() || !b.lines().item_of_face.empty()) continue;
    const double back = least_between(surface, b, a, Method::exact);
    CHECK((exact == back || std::abs(exact - back) <= rounding));
  }
}
