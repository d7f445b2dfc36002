// Where a straightest geodesic ends before its length, and where it does not begin.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <random>

#include "core/mesh/shapes.h"
#include "core/straighten/straightest_geodesic.h"
#include "tests/fixtures/faces_thrown_together.h"
#include "tests/fixtures/straightest.h"
#include "tests/fixtures/surface.h"

using namespace geodesic;
using fixtures::check_refused;
using fixtures::checked;
using fixtures::End;
using fixtures::end_of;
using fixtures::go;
using fixtures::Surface;

TEST_CASE("ABoundaryEndsIt") {
  const Surface surface(shapes::plane(5, 5));
  const auto out = go(surface, surface.on(13, {0.2, 0.3, 0.5}), {1, 0.1, 0}, 100);
  CHECK(out.end == End::boundary);
  CHECK(std::abs(end_of(out).x - 4) <= 1e-14);
  CHECK(distance(out.direction_at_end, (1 / std::hypot(1, 0.1)) * Vec3{1, 0.1, 0}) <= 1e-12);
  // At a vertex of the boundary, on the boundary, and as far as the boundary.
  CHECK(go(surface, surface.at(6), {-1, -1, 0}, 100).end == End::boundary);
  CHECK(end_of(go(surface, surface.at(6), {-1, -1, 0}, 100)) == Vec3{0, 0, 0});
  CHECK(go(surface, surface.at(0), {1, 0, 0}, 0.5).end == End::length);
  CHECK(end_of(go(surface, surface.at(0), {1, 0, 0}, 100)) == Vec3{1, 0, 0});
  CHECK(go(surface, surface.on(13, {0.5, 0.5, 0}), {1, 0, 0}, 1.5).end == End::length);
  // From the boundary and away from the surface.
  for (const SurfacePoint& from : {surface.at(2), surface.on(0, {0.5, 0.5, 0})}) {
    for (const Vec3 away : {Vec3{0, -1, 0}, Vec3{1, -1, 0}}) {
      const auto nowhere = go(surface, from, away, 1);
      CHECK(nowhere.end == End::boundary);
      CHECK(nowhere.path.points.size() == 1);
      CHECK(nowhere.path.length == 0);
    }
  }
}

TEST_CASE("NonManifoldEdgesAndPinchedVerticesEndIt") {
  // Three pages on the spine x = 0, z = 0.
  TriangleSoup book;
  for (const Vec3 page : {Vec3{1, 0, 0}, Vec3{-1, 0, 0}, Vec3{0, 0, 1}}) {
    const auto first = static_cast<std::uint32_t>(book.positions.size());
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 3; ++i)
        book.positions.push_back(double(i) * page + Vec3{0, double(j), 0});
    }
    for (auto t : shapes::plane(3, 3).faces) {
      book.faces.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
  }
  const Surface pages(book);
  const auto at_spine = go(pages, pages.on(1, {0.25, 0.5, 0.25}), {-1, 0, 0}, 9);
  CHECK(at_spine.end == End::non_manifold);
  CHECK(end_of(at_spine).x == 0);
  CHECK(go(pages, pages.at(4), {-1, 0, 0}, 9).end == End::non_manifold);
  // From the spine into the page that the direction is in.
  CHECK(distance(end_of(go(pages, pages.at(3), {0, 0.2, 1}, 0.5)),
                 0.5 / std::hypot(0.2, 1) * Vec3{0, 0.2, 1} + Vec3{0, 1, 0}) <= 1e-14);

  const Surface bowtie(TriangleSoup{{{0, 0, 0}, {-1, 1, 0}, {-1, -1, 0}, {1, 1, 0}, {1, -1, 0}},
                                    {{0, 1, 2}, {0, 3, 4}}});
  const auto at_pinch = go(bowtie, bowtie.on(0, {0, 0.5, 0.5}), {1, 0, 0}, 9);
  CHECK(at_pinch.end == End::vertex);
  CHECK(end_of(at_pinch) == Vec3{0, 0, 0});
  CHECK(end_of(go(bowtie, bowtie.at(0), {1, 0.1, 0}, 0.5)).x > 0.4);
}

TEST_CASE("NoLengthIsOnePoint") {
  const Surface surface(shapes::plane(5, 5));
  const auto here = go(surface, surface.at(12), {1, 2, 3}, 0);
  CHECK(here.end == End::length);
  CHECK(here.path.points.size() == 1);
  CHECK(here.path.length == 0);
  CHECK(distance(here.direction_at_end, (1 / std::sqrt(5)) * Vec3{1, 2, 0}) <= 1e-14);
}

TEST_CASE("WhatMakesNoSenseIsRefused") {
  const Surface surface(shapes::plane(5, 5));
  const auto& adjacency = surface.adjacency();
  const SurfacePoint from = surface.at(12);
  const SurfacePoint inside = surface.on(3, {0.2, 0.3, 0.5});
  const auto out_of_range = ErrorCode::value_out_of_range;
  for (const SurfacePoint& p : {from, inside, surface.on(3, {0, 0.5, 0.5})}) {
    for (const Vec3 direction : {Vec3{}, Vec3{0, 0, 2}, Vec3{NAN, 0, 0}, Vec3{0, INFINITY, 0}}) {
      check_refused(straightest_geodesic(adjacency, p, direction, 1, Cancel()), out_of_range,
                    "direction");
    }
    for (const double length : {-1.0, double(INFINITY), double(NAN)}) {
      check_refused(straightest_geodesic(adjacency, p, {1, 0, 0}, length, Cancel()), out_of_range,
                    "length");
      check_refused(straightest_geodesic_at_angle(adjacency, p, 1, length, Cancel()), out_of_range,
                    "length");
    }
    check_refused(straightest_geodesic_at_angle(adjacency, p, NAN, 1, Cancel()), out_of_range,
                  "angle");
  }
  // Vectors whose square is nothing or everything still point somewhere.
  CHECK(go(surface, inside, {1e-200, 0, 0}, 0.1).path.length == doctest::Approx(0.1));
  CHECK(go(surface, inside, {0, 1e200, 0}, 0.1).path.length == doctest::Approx(0.1));
  // At a vertex of the boundary, beyond its faces.
  check_refused(straightest_geodesic_at_angle(adjacency, surface.at(2), 4, 1, Cancel()),
                out_of_range, "angle");
  check_refused(straightest_geodesic_at_angle(adjacency, surface.at(2), -4, 1, Cancel()),
                out_of_range, "angle");
  // At a corner with one face, beyond it.
  check_refused(straightest_geodesic_at_angle(adjacency, surface.at(0), 3, 1, Cancel()),
                out_of_range, "angle");
  // Straight up from the top of a pyramid leads nowhere.
  const Surface pyramid(TriangleSoup{{{0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}},
                                     {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}}});
  check_refused(straightest_geodesic(pyramid.adjacency(), pyramid.at(0), {0, 0, 1}, 1, Cancel()),
                out_of_range, "direction");
  // A vertex in no face.
  const Surface lonely(TriangleSoup{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 5, 5}}, {{0, 1, 2}}});
  check_refused(straightest_geodesic(lonely.adjacency(), lonely.at(3), {1, 0, 0}, 1, Cancel()),
                out_of_range, "from");
}

TEST_CASE("ALengthWithoutEndIsRefused") {
  const Surface surface(shapes::icosphere(2));
  const SurfacePoint from = surface.on(7, {0.2, 0.3, 0.5});
  check_refused(straightest_geodesic_at_angle(surface.adjacency(), from, 0.3, 1e30, Cancel()),
                ErrorCode::too_large, "length");
  int polls = 0;
  const auto cancelled = straightest_geodesic_at_angle(surface.adjacency(), from, 0.3, 1e30,
                                                       Cancel([&] { return ++polls == 3; }));
  REQUIRE_FALSE(cancelled.has_value());
  CHECK(cancelled.error().code == ErrorCode::cancelled);
  CHECK(polls == 3);
}

TEST_CASE("ItComesToAnEndOnFacesThrownTogetherAtRandom") {
  std::mt19937 random(12);
  for (int round = 0; round < 150; ++round) {
    const Surface surface(fixtures::faces_thrown_together(random, 14));
    const auto faces = surface.mesh().face_count();
    for (int i = 0; i < 30; ++i) {
      std::array<double, 3> bary{double(random() % 3), double(random() % 3), double(random() % 3)};
      if (bary[0] + bary[1] + bary[2] == 0) bary[2] = 1;
      const SurfacePoint from = point_on_face(surface.adjacency(), random() % faces, bary);
      const Vec3 direction{random() % 5 - 2.0, random() % 5 - 2.0, random() % 5 - 2.0};
      const auto by_vector =
          straightest_geodesic(surface.adjacency(), from, direction, 20, Cancel());
      if (by_vector) {
        checked(surface, by_vector, 20);
      } else {
        CHECK(by_vector.error().code == ErrorCode::value_out_of_range);
      }
      const auto by_angle =
          straightest_geodesic_at_angle(surface.adjacency(), from, 0.5 * i - 5, 20, Cancel());
      if (by_angle) {
        checked(surface, by_angle, 20);
      } else {
        CHECK(by_angle.error().code == ErrorCode::value_out_of_range);
      }
    }
  }
}
