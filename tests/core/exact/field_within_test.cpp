// Distances within a tolerance: the guarantee, against the exact field of every kind of
// mesh, and what a field is besides.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/exact/propagation.h"
#include "core/field/vertex_front.h"
#include "core/mesh/shapes.h"
#include "tests/fixtures/awkward_meshes.h"
#include "tests/fixtures/path_checks.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::RandomMesh;
using fixtures::Surface;

namespace {

constexpr double kTolerances[] = {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6};
// Of the exact distances themselves.
constexpr double kExactRounding = 1e-11;

Field within(double tolerance, const Surface& surface, const std::vector<Source>& sources,
             const FieldLimits& limits = {}) {
  MethodOptions options;
  options.error_at_most = tolerance;
  return surface.field_by(Method::back_traced, sources, limits, options);
}

struct Worst {
  double above = 0;
  double below = 0;
};

// Checks that the same vertices are reached.
Worst worst_of(const Field& field, const Field& truth) {
  Worst worst;
  for (std::size_t v = 0; v < truth.distance.size(); ++v) {
    REQUIRE((field.distance[v] == kUnreached) == (truth.distance[v] == kUnreached));
    if (truth.distance[v] == kUnreached) continue;
    if (truth.distance[v] == 0) {
      CHECK(field.distance[v] == 0);
      continue;
    }
    const double off = field.distance[v] / truth.distance[v] - 1;
    worst.above = std::max(worst.above, off);
    worst.below = std::max(worst.below, -off);
  }
  return worst;
}

// Every vertex may become a source, however few windows are there to be spared.
Field within_by_early_sources(double tolerance, const Surface& surface,
                              const std::vector<Source>& sources) {
  Field field = unreached_field(Method::back_traced, sources, surface.mesh().vertex_count());
  exact::PropagationMemory memory;
  const Cancel never;
  Poll poll(never);
  exact::Propagation propagation(surface.adjacency(), surface.adjacency().triangulation(), memory,
                                 field, kUnreached, tolerance, false, poll);
  propagation.set_windows_for_early_source(1);
  for (std::uint32_t s = 0; s < sources.size(); ++s) propagation.start(sources[s], s);
  do {
    while (propagation.step()) {
    }
  } while (propagation.relax_along_edges(poll));
  propagation.raise_to_paths(poll);
  return field;
}

void check_guarantee(const Surface& surface, const std::vector<Source>& sources) {
  const Field truth = surface.field_by(Method::exact, sources);
  for (const double tolerance : kTolerances) {
    CAPTURE(tolerance);
    for (const Field& field : {within(tolerance, surface, sources),
                               within_by_early_sources(tolerance, surface, sources)}) {
      const Worst worst = worst_of(field, truth);
      CHECK(worst.above <= tolerance + kExactRounding);
      CHECK(worst.below <= kExactRounding);
    }
  }
}

TriangleSoup stretched_terrain() {
  TriangleSoup soup = shapes::terrain(60, 8, 3);
  for (Vec3& p : soup.positions) p.x *= 8;
  return soup;
}

TriangleSoup slivers() {
  TriangleSoup soup = shapes::terrain(50, 4, 9);
  for (Vec3& p : soup.positions) p.y *= 0.005;
  return soup;
}

// Windows that cross a face on the way to all of a mesh.
std::uint64_t windows_within(double tolerance, const Surface& surface, std::uint32_t source) {
  const Source from{surface.at(source), 0};
  Field field = unreached_field(Method::exact, {&from, 1}, surface.mesh().vertex_count());
  exact::PropagationMemory memory;
  const Cancel never;
  Poll poll(never);
  exact::Propagation propagation(surface.adjacency(), surface.adjacency().triangulation(), memory,
                                 field, kUnreached, tolerance, false, poll);
  propagation.start(from, 0);
  while (propagation.step()) {
  }
  return propagation.propagated();
}

}  // namespace

TEST_CASE("NoErrorIsAboveTheToleranceOnAnyKindOfMesh") {
  const std::vector<shapes::Hole> holes{{5, 5, 8}, {20, 8, 12}, {6, 24, 9}};
  std::vector<std::pair<std::string, TriangleSoup>> meshes{
      {"icosphere", shapes::icosphere(4)},
      {"terrain", shapes::terrain(60, 8, 1)},
      {"stretched terrain", stretched_terrain()},
      {"slivers", slivers()},
      {"saddle", shapes::saddle(40, 20)},
      {"torus knot", shapes::torus_knot(120, 12, 0.4)},
      {"plane with holes", shapes::plane_with_holes(40, 40, holes)},
  };
  std::shuffle(meshes.begin(), meshes.end(), std::mt19937(fixtures::test_seed()));
  meshes.resize(fixtures::all_or<std::size_t>(meshes.size(), 1));
  for (const auto& [name, soup] : meshes) {
    CAPTURE(name);
    const Surface surface(soup);
    for (const std::uint32_t source : {0U, static_cast<std::uint32_t>(soup.faces[77][1])}) {
      check_guarantee(surface, {Source{surface.at(source), 0}});
    }
    check_guarantee(surface, {Source{surface.on(9, {0.2, 0.3, 0.5}), 0}});
  }
}

TEST_CASE("NoErrorIsAboveTheToleranceOnAwkwardMeshes") {
  for (const fixtures::AwkwardMesh& mesh : fixtures::awkward_meshes()) {
    CAPTURE(mesh.name);
    const Surface surface(mesh.soup);
    check_guarantee(surface, {Source{surface.at(mesh.source), 0}});
  }
}

TEST_CASE("NoErrorIsAboveTheToleranceOnRandomMeshes") {
  std::uint32_t differ = 0;
  constexpr std::uint32_t kMeshes = fixtures::all_or(400, 40);
  for (std::uint32_t number = 0; number < kMeshes; ++number) {
    CAPTURE(number);
    RandomMesh random(number);
    const Surface surface(random.soup());
    std::vector<Source> sources{{surface.at(random.vertex()), 0}};
    if (number % 4 == 0) sources.push_back({surface.at(random.vertex()), random.unit()});
    check_guarantee(surface, sources);
    differ += within_by_early_sources(1e-2, surface, sources).distance !=
              surface.field_by(Method::exact, sources).distance;
  }
  CHECK(differ > kMeshes / 2);
}

TEST_CASE("AToleranceOfNothingIsExact") {
  for (std::uint32_t number = 0; number < 30; ++number) {
    CAPTURE(number);
    RandomMesh random(number);
    const Surface surface(random.soup());
    const std::vector<Source> sources{{surface.at(random.vertex()), 0}};
    // Over the same faces.
    FieldLimits only_vertices;
    only_vertices.keep_details = false;
    CHECK(within(0, surface, sources).distance ==
          surface.field_by(Method::exact, sources, only_vertices).distance);
  }
}

// Time falls as the tolerance grows, and so do the errors as it shrinks.
TEST_CASE("AToleranceBuysTimeSmoothly") {
  const Surface surface(shapes::icosphere(5));
  const std::vector<Source> sources{{surface.at(0), 0}};
  const Field truth = surface.field_by(Method::exact, sources);
  std::uint64_t more = windows_within(1e-1, surface, 0);
  double further = 1;
  for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 0.0}) {
    CAPTURE(tolerance);
    const std::uint64_t windows = windows_within(tolerance, surface, 0);
    // Not by chance's last percents.
    CHECK(static_cast<double>(windows) >= 0.95 * static_cast<double>(more));
    more = windows;
    const Worst worst = worst_of(within(tolerance, surface, sources), truth);
    CHECK(worst.above < further);
    further = std::max(worst.above, 1e-15);
  }
  CHECK(static_cast<double>(windows_within(1e-3, surface, 0)) < 0.4 * static_cast<double>(more));
}

// Traced by distances alone, as those of `auto` are, a path may be longer than they are.
TEST_CASE("ADistanceWithinAToleranceHasAPath") {
  const Surface surface(shapes::terrain(40, 8, 2));
  const std::vector<Source> sources{{surface.at(820), 0}};
  const Field truth = surface.field_by(Method::exact, sources);
  const Field field = within(1e-3, surface, sources);
  const double size = distance(surface.mesh().box().min, surface.mesh().box().max);
  for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); v += 7) {
    const auto path = surface.path(field, point_at_vertex(surface.adjacency(), v));
    REQUIRE(path);
    fixtures::check_is_a_path(surface.adjacency(), *path, size);
    CHECK(path->length >= truth.distance[v] * (1 - 1e-9));
    CHECK(path->length <= truth.distance[v] * 1.1);
  }
}

TEST_CASE("WhereToStopChangesNoDistanceWithinATolerance") {
  const Surface surface(shapes::terrain(30, 6, 5));
  const auto vertex_count = static_cast<std::uint32_t>(surface.mesh().vertex_count());
  const std::vector<Source> sources{{surface.at(465), 0}, {surface.at(3), 2}};
  for (const double tolerance : {1e-1, 1e-2, 1e-4}) {
    CAPTURE(tolerance);
    const Field whole = within(tolerance, surface, sources);
    for (const std::uint32_t target : {480U, 600U, 899U}) {
      CAPTURE(target);
      const std::vector<std::uint32_t> targets{surface.vertex(target)};
      const double reach = whole.distance[targets[0]];
      FieldLimits near;
      near.targets = targets;
      FieldLimits below;
      below.max = reach;
      for (const FieldLimits& limits : {near, below}) {
        const Field part = within(tolerance, surface, sources, limits);
        for (std::uint32_t v = 0; v < vertex_count; ++v) {
          CAPTURE(v);
          if (whole.distance[v] <= reach) {
            REQUIRE(part.distance[v] == doctest::Approx(whole.distance[v]).epsilon(1e-12));
          } else {
            REQUIRE(part.distance[v] > reach);
          }
        }
      }
    }
  }
}
