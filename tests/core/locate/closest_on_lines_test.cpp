// The closest point beside faces without width, which are lines but for rounding.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "core/locate/closest_on_triangle.h"
#include "core/locate/closest_point.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"
#include "tests/fixtures/to_segment.h"
#include "tests/fixtures/uneven_planes.h"

using namespace geodesic;
using fixtures::RandomMesh;
using fixtures::Surface;
using fixtures::test_seed;

namespace {

using Hierarchy = ClosestPointIndex::Hierarchy;

Vec3 random_vector(RandomMesh& random) {
  return {2 * random.unit() - 1, 2 * random.unit() - 1, 2 * random.unit() - 1};
}

// Anywhere in space, bent or flat: where a line is one no more to the last bit.
void place_anywhere(RandomMesh& random, TriangleSoup& soup) {
  const Vec3 x = (1 + 3 * random.unit()) * random_vector(random);
  const Vec3 y = (1 + 3 * random.unit()) * random_vector(random);
  const Vec3 z = random_vector(random);
  const Vec3 origin = 10.0 * random_vector(random);
  for (Vec3& p : soup.positions) p = origin + p.x * x + p.y * y + p.z * z;
}

// Over all sides, and over all faces that have a width.
double distance_by_all(const TriangleSoup& soup, Vec3 p) {
  double least = std::numeric_limits<double>::infinity();
  for (const Triangle& t : soup.faces) {
    const auto at = [&](std::size_t c) { return soup.positions[t[c % 3]]; };
    double longest = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      least = std::min(least, fixtures::to_segment(p, at(c), at(c + 1)));
      longest = std::max(longest, distance(at(c), at(c + 1)));
    }
    const Vec3 normal = cross(at(1) - at(0), at(2) - at(0));
    if (norm(normal) < 1e-9 * longest * longest) continue;
    bool is_above = true;
    for (std::size_t c = 0; c < 3; ++c) {
      is_above = is_above && dot(normal, cross(at(c + 1) - at(c), p - at(c))) > 0;
    }
    if (is_above) least = std::min(least, std::abs(dot(normal, p - at(0))) / norm(normal));
  }
  return least;
}

}  // namespace

TEST_CASE("TheClosestPointBesideFacesWithoutWidthIsThatOfAllFacesAndSides") {
  for (std::uint32_t round = 0; round < fixtures::all_or(60U, 12U); ++round) {
    CAPTURE(round);
    RandomMesh random(test_seed() + round);
    TriangleSoup soup = fixtures::uneven_plane(random, 3 + random.below(4));
    if (random.unit() < 0.5) {
      for (Vec3& p : soup.positions) p.z = random.unit();
    }
    for (std::uint32_t i = 0; i <= random.below(4); ++i) {
      fixtures::put_flat_faces_in(random, soup);
    }
    place_anywhere(random, soup);
    const Surface surface(soup);
    const double size = distance(surface.mesh().box().min, surface.mesh().box().max);
    std::vector<std::shared_ptr<const ClosestPointIndex>> indices;
    for (const Hierarchy hierarchy : {Hierarchy::quickest, Hierarchy::boxes}) {
      indices.push_back(*ClosestPointIndex::build(surface.shared(), Cancel(), hierarchy));
    }
    for (std::uint32_t i = 0; i < 200; ++i) {
      CAPTURE(i);
      const Triangle& t = soup.faces[random.below(static_cast<std::uint32_t>(soup.faces.size()))];
      const auto at = [&](std::size_t c) { return soup.positions[t[c]]; };
      const double u = random.unit();
      const double v = random.unit();
      Vec3 from = at(0) + u * (at(1) - at(0)) + (1 - u) * v * (at(2) - at(0));
      if (i % 4 == 1) from = at(0) + (3 * u - 1) * (at(1) - at(0));  // on a side's line
      if (i % 4 == 2) from = from + std::pow(10, -15 * v) * random_vector(random);
      if (i % 4 == 3) from = from + std::pow(10, 4 * v) * size * random_vector(random);
      const double wanted = distance_by_all(soup, from);
      const double rounding = 1e-13 * (wanted + size + norm(from));
      for (const auto& index : indices) {
        const ClosestPoint found = index->closest(from);
        CHECK(std::abs(found.distance - wanted) <= rounding);
        CHECK(distance(position_of(surface.mesh(), found.point), from) == found.distance);
      }
    }
  }
}

TEST_CASE("AFootOnALowTriangleIsAsGoodAsOnAHighOne") {
  for (std::uint32_t round = 0; round < 2000; ++round) {
    CAPTURE(round);
    RandomMesh random(test_seed() + round);
    const Vec3 along = random_vector(random);
    const Vec3 other = cross(along, random_vector(random));
    const double height = std::pow(10, -12 * random.unit());
    const std::array<Vec3, 3> corner{
        Vec3{0, 0, 0}, along, random.unit() * along + (height / norm(other) * norm(along)) * other};
    const double u = 0.1 + 0.8 * random.unit();
    const double v = (1 - u) * (0.1 + 0.8 * random.unit());
    const Vec3 p = u * corner[1] + v * corner[2];
    if (v * height < 1e-10) continue;  // it may be on the side by rounding
    const auto foot = foot_inside(p, corner);
    REQUIRE(foot.has_value());
    CHECK(norm(p - (*foot)[1] * corner[1] - (*foot)[2] * corner[2]) <= 1e-15 * norm(along));
  }
}
