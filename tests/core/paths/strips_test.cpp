#include "core/paths/strips.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <utility>
#include <vector>

#include "core/mesh/shapes.h"
#include "core/paths/discs.h"
#include "core/paths/isolines.h"
#include "tests/fixtures/awkward_meshes.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::Surface;
using fixtures::test_seed;

namespace {

std::vector<Strip> strips_of(const Surface& surface, const Field& field,
                             const std::vector<double>& levels) {
  auto strips = cut_strips(surface.adjacency(), field, levels, Cancel());
  REQUIRE(strips);
  return std::move(*strips);
}

double area_of(const Strip& strip) {
  double area = 0;
  for (const auto& [a, b, c] : strip.faces) {
    const Vec3 p = strip.positions[a];
    area += norm(cross(strip.positions[b] - p, strip.positions[c] - p)) / 2;
  }
  return area;
}

// Of edges in one face alone: the strip's outline.
double outline_of(const Strip& strip) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& t : strip.faces) {
    for (std::size_t c = 0; c < 3; ++c) ++edges[std::minmax(t[c], t[(c + 1) % 3])];
  }
  double length = 0;
  for (const auto& [edge, faces] : edges) {
    if (faces == 1) length += distance(strip.positions[edge.first], strip.positions[edge.second]);
  }
  return length;
}

void check_strips(const Surface& surface, const Field& field, std::mt19937& random) {
  std::vector<double> levels{0, field.max};
  for (int i = 0; i < 5; ++i) {
    levels.push_back(field.max * (random() / 4294967296.0));
    const double there = field.distance[random() % surface.mesh().vertex_count()];
    if (std::isfinite(there)) levels.push_back(there);
  }
  std::sort(levels.begin(), levels.end());
  levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
  const std::vector<Strip> strips = strips_of(surface, field, levels);
  REQUIRE(strips.size() + 1 == levels.size());
  const auto measured = measure_discs(surface.adjacency(), field, levels, Cancel());
  REQUIRE(measured);
  const double whole = measured->discs.back().area;
  double sum = 0;
  std::uint64_t faces = 0;
  std::uint64_t vertices = 0;
  for (std::size_t i = 0; i < strips.size(); ++i) {
    const Strip& strip = strips[i];
    CAPTURE(strip.begin);
    CAPTURE(strip.end);
    CHECK(strip.begin == levels[i]);
    CHECK(strip.end == levels[i + 1]);
    CHECK(std::abs(strip.area - area_of(strip)) <= 1e-12 * whole);
    // A level face at the first level is in the strip above it, not in the disc of that radius.
    const double from = i == 0 ? 0 : measured->discs[i].area;
    CHECK(std::abs(strip.area - (measured->discs[i + 1].area - from)) <= 1e-9 * whole);
    std::vector<bool> is_used(strip.positions.size());
    for (const auto& face : strip.faces) {
      for (const std::uint32_t v : face) {
        REQUIRE(v < strip.positions.size());
        is_used[v] = true;
      }
    }
    CHECK(std::find(is_used.begin(), is_used.end(), false) == is_used.end());
    sum += strip.area;
    faces += strip.faces.size();
    vertices += strip.positions.size();
  }
  CHECK(std::abs(sum - whole) <= 1e-12 * whole);
  CHECK(faces <= most_faces_of_strips(surface.mesh().face_count(), measured->crossings));
  CHECK(vertices <= most_vertices_of_strips(surface.mesh().vertex_count(), measured->crossings));
}

}  // namespace

TEST_CASE("StripsAddUpToTheSurface") {
  std::mt19937 random(test_seed());
  for (int i = 0; i < 40; ++i) {
    const auto number = static_cast<std::uint32_t>(random());
    CAPTURE(number);
    const Surface surface(fixtures::RandomMesh(number).soup());
    const auto v = static_cast<std::uint32_t>(random() % surface.mesh().source_vertex_count());
    const Method methods[] = {Method::exact, Method::back_traced, Method::dijkstra};
    check_strips(surface, surface.field_by(methods[random() % 3], {{surface.at(v), 0}}), random);
  }
}

TEST_CASE("StripsOfAwkwardSurfacesAddUp") {
  std::mt19937 random(test_seed());
  for (const fixtures::AwkwardMesh& mesh : fixtures::awkward_meshes()) {
    CAPTURE(mesh.name);
    const Surface surface(mesh.soup);
    const auto v = static_cast<std::uint32_t>(random() % surface.mesh().source_vertex_count());
    check_strips(surface, surface.field_by(Method::exact, {{surface.at(v), 0}}), random);
  }
}

// The outline of a strip is the isolines of both its levels and what is between of the boundary:
// faces of a strip have their vertices in common, and strips meet along the isolines.
TEST_CASE("StripsAreWholeBetweenTheirIsolines") {
  std::mt19937 random(test_seed());
  for (int i = 0; i < 20; ++i) {
    const Surface surface(shapes::terrain(14, 3, static_cast<std::uint32_t>(random())));
    const Field field =
        surface.field_from(static_cast<std::uint32_t>(random() % surface.mesh().vertex_count()));
    const std::vector<double> levels{0, 0.31 * field.max, 0.57 * field.max, field.max};
    const auto strips = strips_of(surface, field, levels);
    const auto discs = measure_discs(surface.adjacency(), field, levels, Cancel());
    REQUIRE(discs);
    for (std::size_t k = 0; k < strips.size(); ++k) {
      const Disc& inner = discs->discs[k];
      const Disc& outer = discs->discs[k + 1];
      const double expected = inner.perimeter + outer.perimeter + outer.boundary - inner.boundary;
      CHECK(outline_of(strips[k]) == doctest::Approx(expected).epsilon(1e-9));
    }
  }
}

TEST_CASE("StripsAreWoundAsTheirFaces") {
  const Surface surface(shapes::plane(9, 9));
  const Field field = surface.field_from(40);
  std::size_t faces = 0;
  for (const Strip& strip : strips_of(surface, field, {0, 1.3, 2.1, 2.2, 5})) {
    for (const auto& [a, b, c] : strip.faces) {
      const Vec3 p = strip.positions[a];
      const Vec3 normal = cross(strip.positions[b] - p, strip.positions[c] - p);
      CHECK(normal.z > 0);
      ++faces;
    }
  }
  CHECK(faces > 128);
}

TEST_CASE("BetweenLessThanTwoLevelsThereIsNoStrip") {
  const Surface surface(shapes::plane(4, 4));
  const Field field = surface.field_from(0);
  CHECK(strips_of(surface, field, {}).empty());
  CHECK(strips_of(surface, field, {1}).empty());
  const auto beyond = strips_of(surface, field, {100, 200});
  REQUIRE(beyond.size() == 1);
  CHECK(beyond[0].faces.empty());
}

TEST_CASE("StripsAreStoppedInTheMiddle") {
  const Surface surface(shapes::icosphere(5));
  const Field field = surface.field_from(3);
  std::vector<double> levels;
  for (int i = 0; i <= 100; ++i) levels.push_back(field.max * i / 100);
  for (const std::size_t most : {0U, 3U, 20U}) {
    std::size_t asked = 0;
    const Cancel counting([&] { return ++asked > most; });
    const auto strips = cut_strips(surface.adjacency(), field, levels, counting);
    REQUIRE_FALSE(strips.has_value());
    CHECK(strips.error().code == ErrorCode::cancelled);
  }
}
