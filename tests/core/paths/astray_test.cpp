// Holes that are hardly wider than the plate is thick: approximate distances fold on their walls,
// and a trace back over them may go round and round.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "core/paths/edge_path.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::Surface;

namespace {

// A square plate with one hole, closed, whose top and bottom are slivers from rim to rim.
TriangleSoup drilled_plate(std::mt19937& random) {
  const auto uniform = [&](double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random);
  };
  const auto sides = static_cast<std::uint32_t>(8 + random() % 60);
  const auto per_edge = static_cast<std::uint32_t>(1 + random() % 6);
  const double thick = std::pow(10, uniform(-2.5, -0.5));
  const double radius = std::pow(10, uniform(-2.5, -1));
  const Vec3 middle{uniform(0.3, 0.7), uniform(0.3, 0.7), 0};
  std::vector<Vec3> inner;
  std::vector<Vec3> outer;
  for (std::uint32_t i = 0; i < sides; ++i) {
    const double angle = 2 * std::numbers::pi * i / sides;
    inner.push_back(middle + radius * Vec3{std::cos(angle), std::sin(angle), 0});
  }
  const Vec3 square[] = {{1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 0}};
  for (std::uint32_t corner = 0; corner < 4; ++corner) {
    for (std::uint32_t i = 0; i < per_edge; ++i) {
      const double t = i / static_cast<double>(per_edge);
      outer.push_back((1 - t) * square[corner] + t * square[(corner + 1) % 4]);
    }
  }
  // Both rims counterclockwise, from the angle zero.
  const auto angle_of = [&](Vec3 p) {
    const double angle = std::atan2(p.y - middle.y, p.x - middle.x);
    return angle < 0 ? angle + 2 * std::numbers::pi : angle;
  };
  std::rotate(outer.begin(),
              std::min_element(outer.begin(), outer.end(),
                               [&](Vec3 a, Vec3 b) { return angle_of(a) < angle_of(b); }),
              outer.end());
  const auto n = static_cast<std::uint32_t>(outer.size());
  TriangleSoup soup;
  for (const double height : {0.0, thick}) {
    for (const auto* rim : {&inner, &outer}) {
      for (const Vec3 p : *rim) soup.positions.push_back({p.x, p.y, height});
    }
  }
  const std::uint32_t top = sides + n;
  std::uint32_t i = 0;
  std::uint32_t o = 0;
  while (i < sides || o < n) {
    const bool step_inside =
        o == n || (i < sides && angle_of(inner[i % sides]) + (i == sides ? 7 : 0) <=
                                    angle_of(outer[o % n]) + (o == n ? 7 : 0));
    const std::uint32_t a = i % sides;
    const std::uint32_t b = sides + o % n;
    const std::uint32_t c = step_inside ? (i + 1) % sides : sides + (o + 1) % n;
    soup.faces.push_back({a, b, c});
    soup.faces.push_back({top + b, top + a, top + c});
    ++(step_inside ? i : o);
  }
  const auto wall = [&](std::uint32_t first, std::uint32_t count) {
    for (std::uint32_t k = 0; k < count; ++k) {
      const std::uint32_t a = first + k;
      const std::uint32_t b = first + (k + 1) % count;
      soup.faces.push_back({a, b, top + b});
      soup.faces.push_back({a, top + b, top + a});
    }
  };
  wall(0, sides);
  wall(sides, n);
  return soup;
}

}  // namespace

TEST_CASE("PathsByAutoRoundSmallHolesAreNeverMuchLongerThanTheirDistanceIfThereIsAnother") {
  std::mt19937 random(fixtures::test_seed());
  double longest = 0;
  for (int round = 0; round < 60; ++round) {
    const Surface surface(drilled_plate(random));
    const auto vertices = surface.mesh().vertex_count();
    const auto source = static_cast<std::uint32_t>(random() % vertices);
    const std::vector<Source> from{{point_at_vertex(surface.adjacency(), source), 0}};
    const Field field = surface.field_by(Method::back_traced, from);
    for (std::uint32_t v = 0; v < vertices; ++v) {
      if (v == source) continue;
      const auto path = surface.path(field, point_at_vertex(surface.adjacency(), v));
      REQUIRE(path);
      WavefrontScratch scratch;
      const auto along_edges =
          edge_path(surface.adjacency(), from[0].point, point_at_vertex(surface.adjacency(), v),
                    scratch, Cancel());
      REQUIRE((along_edges && *along_edges));
      CHECK(path->length <=
            std::max(1.05 * field.distance[v], (*along_edges)->length) * (1 + 1e-9));
      longest = std::max(longest, path->length / field.distance[v]);
    }
  }
  MESSAGE("the longest path is " << longest << " times its distance");
}
