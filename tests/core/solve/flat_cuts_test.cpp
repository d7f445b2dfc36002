// What `auto` says beside faces without width, singly, in rows and in heaps: what it says of the
// same surface without them.
#include "tests/fixtures/flat_cuts.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "core/mesh/shapes.h"
#include "core/paths/arrive_at_point.h"
#include "core/solve/distance_at_point.h"
#include "core/straighten/refine_path.h"
#include "tests/fixtures/path_checks.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"
#include "tests/fixtures/uneven_planes.h"

using namespace geodesic;
using fixtures::CutSurface;
using fixtures::FlatCuts;
using fixtures::RandomMesh;
using fixtures::Surface;

namespace {

TriangleSoup plate(RandomMesh& random) {
  const std::uint32_t columns = 6 + random.below(12);
  const std::uint32_t rows = 6 + random.below(12);
  std::vector<shapes::Hole> holes;
  for (int i = 0; i < 2; ++i) {
    const std::uint32_t size = 1 + random.below(2);
    holes.push_back(
        {1 + random.below(columns - 2 - size), 1 + random.below(rows - 2 - size), size});
  }
  return shapes::plane_with_holes(columns, rows, holes);
}

TriangleSoup bumpy(RandomMesh& random) {
  TriangleSoup soup = fixtures::uneven_plane(random, 5 + random.below(20));
  for (Vec3& p : soup.positions) p.z = 0.5 * std::sin(1.3 * p.x) * std::cos(0.9 * p.y);
  return soup;
}

// A part: two polygons of triangles to their middles, and walls of one square each.
TriangleSoup prism(RandomMesh& random) {
  const std::uint32_t around = 5 + random.below(10);
  const double height = 0.3 + 2 * random.unit();
  TriangleSoup soup;
  for (const double z : {0.0, height}) {
    for (std::uint32_t i = 0; i < around; ++i) {
      const double angle = 2 * std::numbers::pi * i / around;
      const double radius = i % 2 == 0 ? 1 : 0.8;
      soup.positions.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
    }
  }
  soup.positions.push_back({0, 0, 0});
  soup.positions.push_back({0, 0, height});
  for (std::uint32_t i = 0; i < around; ++i) {
    const std::uint32_t next = (i + 1) % around;
    soup.faces.push_back({i, next, around + next});
    soup.faces.push_back({i, around + next, around + i});
    soup.faces.push_back({next, i, 2 * around});
    soup.faces.push_back({around + i, around + next, 2 * around + 1});
  }
  return soup;
}

FlatCuts any_rows(RandomMesh& random) {
  FlatCuts cuts;
  cuts.part = random.unit() < 0.5 ? 0.15 : 0.6;
  cuts.row = 1 + random.below(5);
  cuts.both_sides = random.unit() < 0.5;
  if (random.unit() < 0.5) cuts.apart = random.unit();
  return cuts;
}

// The same with vertices that are next to each other.
FlatCuts any_cuts(RandomMesh& random) {
  FlatCuts cuts = any_rows(random);
  if (random.unit() < 0.3) cuts.needles = 0.3;
  cuts.needle_width = std::pow(10.0, -6 * random.unit() - 1);
  return cuts;
}

// A point of the cut surface, and the same on the surface before it was cut.
struct Twice {
  SurfacePoint cut;
  SurfacePoint whole;
};

Twice any_point(RandomMesh& random, const TriangleSoup& soup, const CutSurface& cut,
                const Surface& on_cut, const Surface& on_whole) {
  const std::uint32_t face = random.below(static_cast<std::uint32_t>(cut.soup.faces.size()));
  std::array<double, 3> bary{random.unit() + 0.01, random.unit() + 0.01, random.unit() + 0.01};
  const std::uint32_t kind = random.below(6);
  if (kind == 0) bary[random.below(3)] = 0;
  if (kind == 1) {
    bary = {0, 0, 0};
    bary[random.below(3)] = 1;
  }
  const SurfacePoint point = on_cut.on(face, bary);
  const Vec3 position = position_of(on_cut.mesh(), point);
  const std::uint32_t parent = cut.parent[face];
  const Triangle& corners = soup.faces[parent];
  const auto at = [&](std::size_t c) { return soup.positions[corners[c % 3]]; };
  const Vec3 normal = cross(at(1) - at(0), at(2) - at(0));
  std::array<double, 3> weights{};
  for (std::size_t c = 0; c < 3; ++c) {
    const double part = dot(cross(at(c + 2) - at(c + 1), position - at(c + 1)), normal);
    weights[c] = part < 1e-12 * dot(normal, normal) ? 0 : part;
  }
  const SurfacePoint same = on_whole.on(parent, weights);
  REQUIRE(distance(position_of(on_whole.mesh(), same), position) < 1e-9);
  return {point, same};
}

double read_at(const Surface& surface, const Field& field, const SurfacePoint& point) {
  const PointArrivals arrivals(surface.adjacency(), field);
  const auto found = distance_at_point(surface.adjacency(), field, arrivals, point, Cancel());
  REQUIRE(found);
  return *found;
}

struct Errors {
  double sum = 0;
  double most = 0;
  int count = 0;
  int far = 0;  // by more than 1 %

  void add(double told, double truth) {
    const double error = std::abs(told / truth - 1);
    sum += error;
    most = std::max(most, error);
    ++count;
    if (error > 0.01) ++far;
  }
  [[nodiscard]] double mean() const { return sum / count; }
};

struct Kinds {
  Errors vertices, points, paths;
};

// `auto` on the cut surface against `exact` on the whole one.
void compare(RandomMesh& random, const TriangleSoup& soup, const FlatCuts& cuts, Kinds& errors) {
  const Surface whole(soup);
  const CutSurface cut = fixtures::with_flat_cuts(random, soup, cuts);
  const Surface surface(cut.soup);
  const Twice source = any_point(random, soup, cut, surface, whole);
  const Field truth = whole.field_by(Method::exact, {{source.whole, 0}});
  const Field field = surface.field_by(Method::back_traced, {{source.cut, 0}});
  const Box& box = whole.mesh().box();
  const double size = distance(box.min, box.max);
  const double near = 0.01 * size;  // errors would be parts of nothing
  for (std::uint32_t v = 0; v < soup.positions.size(); ++v) {
    const double expected = truth.distance[whole.vertex(v)];
    if (expected == kUnreached || expected < near) continue;
    errors.vertices.add(field.distance[surface.vertex(v)], expected);
  }
  for (int i = 0; i < 20; ++i) {
    const Twice target = any_point(random, soup, cut, surface, whole);
    const double expected = read_at(whole, truth, target.whole);
    if (expected == kUnreached || expected < near) continue;
    errors.points.add(read_at(surface, field, target.cut), expected);
    const auto path =
        path_through(surface.adjacency(), field, target.cut, PathWork::refined, Cancel());
    REQUIRE(path);
    REQUIRE(*path);
    CHECK((*path)->length >= expected * (1 - 1e-9));
    errors.paths.add((*path)->length, expected);
  }
}

}  // namespace

// Faces split each by itself, at vertices of their own: faces without width may lie on each other.
TEST_CASE("OnPlatesOfSplitFacesDistancesByAutoAreStraightLines") {
  double greatest = 0;
  for (std::uint32_t round = 0; round < fixtures::all_or(20U, 4U); ++round) {
    CAPTURE(round);
    RandomMesh random(fixtures::test_seed() + round);
    FlatCuts cuts;
    cuts.part = 0.1 + 0.8 * random.unit();
    cuts.row = 1 + random.below(3);
    cuts.both_sides = true;
    cuts.apart = 1;
    const TriangleSoup whole = fixtures::uneven_plane(random, 8 + random.below(20));
    const TriangleSoup soup = fixtures::with_flat_cuts(random, whole, cuts).soup;
    const Surface surface(soup);
    for (int i = 0; i < 4; ++i) {
      const std::uint32_t from = random.below(static_cast<std::uint32_t>(soup.positions.size()));
      MethodOptions options;
      if (i % 2 == 1) options.bound = Bound::upper;
      const Field field =
          surface.field_by(Method::back_traced, {{surface.at(from), 0}}, {}, options);
      for (std::uint32_t v = 0; v < soup.positions.size(); ++v) {
        const double straight = distance(soup.positions[from], soup.positions[v]);
        const double told = field.distance[surface.vertex(v)];
        CHECK(told >= straight * (1 - 1e-6));  // floats
        if (straight > 0) greatest = std::max(greatest, told / straight - 1);
      }
    }
  }
  MESSAGE("at most " << greatest << " too far");
  CHECK(greatest < 0.01);
}

TEST_CASE("OnPlanesPathsByAutoGoStraightThroughFacesWithoutWidth") {
  Kinds errors;
  for (std::uint32_t round = 0; round < fixtures::all_or(40U, 8U); ++round) {
    CAPTURE(round);
    RandomMesh random(fixtures::test_seed() + round);
    const TriangleSoup soup = fixtures::uneven_plane(random, 4 + random.below(20));
    compare(random, soup, any_rows(random), errors);
  }
  CHECK(errors.vertices.most < 0.01);
  CHECK(errors.points.most < 0.01);
  CHECK(errors.paths.most < 0.01);
}

TEST_CASE("BesideFacesWithoutWidthAutoErrsAsItDoesWithoutThem") {
  struct Shape {
    std::string name;
    TriangleSoup (*draw)(RandomMesh&);
  };
  for (const Shape& shape : {Shape{"plate", plate}, Shape{"bumps", bumpy}, Shape{"prism", prism}}) {
    CAPTURE(shape.name);
    Kinds with;
    Kinds without;
    for (std::uint32_t round = 0; round < fixtures::all_or(25U, 5U); ++round) {
      CAPTURE(round);
      RandomMesh random(fixtures::test_seed() + round);
      const TriangleSoup soup = shape.draw(random);
      compare(random, soup, any_cuts(random), with);
      FlatCuts none;
      none.part = 0;
      compare(random, soup, none, without);
    }
    MESSAGE(shape.name << ": means " << with.vertices.mean() << ", " << with.points.mean() << ", "
                       << with.paths.mean() << ", largest " << with.vertices.most << ", "
                       << with.points.most << ", " << with.paths.most << "; without "
                       << without.vertices.mean() << ", " << without.points.mean() << ", "
                       << without.paths.mean() << ", largest " << without.vertices.most << ", "
                       << without.points.most << ", " << without.paths.most
                       << "; paths more than 1 % off " << with.paths.far << " of "
                       << with.paths.count << ", without " << without.paths.far << " of "
                       << without.paths.count);
    if (fixtures::kSanitized) continue;  // so few say nothing of how often
    CHECK(with.vertices.mean() < 0.001);
    for (const Errors& errors : {with.points, with.paths}) {
      CHECK(errors.mean() < 0.003);
      CHECK(errors.far < 0.05 * errors.count);
      CHECK(errors.most < 1);
    }
  }
}
