#include "core/refine/flat_faces.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "core/base/memory_budget.h"
#include "core/refine/cut_along.h"
#include "core/refine/faces_inside.h"
#include "tests/core/refine/cut_surface.h"
#include "tests/core/refine/lines_on_meshes.h"
#include "tests/fixtures/awkward_meshes.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::Cut;
using fixtures::RandomMesh;
using fixtures::straight;
using fixtures::Surface;
using fixtures::test_seed;

namespace {

// A square with vertices where they happen to be: at multiples of 2^-12, so that points at eighths
// of edges lie on them to the last bit.
TriangleSoup plane_of_eighths(RandomMesh& random, std::uint32_t side) {
  TriangleSoup soup = fixtures::uneven_plane(random, side);
  for (Vec3& p : soup.positions) {
    p = {std::round(4096 * p.x) / 4096, std::round(4096 * p.y) / 4096, 0};
  }
  return soup;
}

// The same surface with more vertices on some of its inner edges. One face of each has them, the
// other has the whole edge, and between the two lies a face without width.
void put_flat_faces_in(RandomMesh& random, TriangleSoup& soup) {
  using Edge = std::pair<std::uint32_t, std::uint32_t>;
  const auto key = [](std::uint32_t a, std::uint32_t b) { return Edge(std::minmax(a, b)); };
  std::map<Edge, std::vector<std::uint32_t>> faces_of_edge;
  for (std::uint32_t f = 0; f < soup.faces.size(); ++f) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      faces_of_edge[key(soup.faces[f][c], soup.faces[f][(c + 1) % 3])].push_back(f);
    }
  }
  std::set<std::uint32_t> used;
  for (const auto& [edge, faces] : faces_of_edge) {
    if (faces.size() != 2 || random.unit() < 0.4) continue;
    if (used.contains(faces[0]) || used.contains(faces[1])) continue;
    const std::uint32_t split = faces[random.below(2)];
    const Triangle whole = soup.faces[split];
    std::uint32_t c = 0;
    while (key(whole[c], whole[(c + 1) % 3]) != edge) ++c;
    const auto [a, b, apex] = std::array{whole[c], whole[(c + 1) % 3], whole[(c + 2) % 3]};
    const double part = (2 + random.below(5)) / 8.0;
    const Vec3 position = soup.positions[a] + part * (soup.positions[b] - soup.positions[a]);
    const auto same = [&](const Vec3& other) { return other == position; };
    if (std::any_of(soup.positions.begin(), soup.positions.end(), same)) continue;
    used.insert(faces.begin(), faces.end());
    const auto middle = static_cast<std::uint32_t>(soup.positions.size());
    soup.positions.push_back(position);
    soup.faces[split] = {a, middle, apex};
    soup.faces.push_back({middle, b, apex});
    soup.faces.push_back({a, b, middle});
  }
}

// The place of a position of a plane on another mesh of it.
SurfacePoint at_position(const Surface& plane, Vec3 position) {
  for (std::uint32_t f = 0; f < plane.mesh().source_face_count(); ++f) {
    const Triangle& t = plane.mesh().faces()[plane.mesh().face_of_source(f)];
    const auto corners = std::array{plane.mesh().positions()[t[0]], plane.mesh().positions()[t[1]],
                                    plane.mesh().positions()[t[2]]};
    const auto area = [](Vec3 a, Vec3 b, Vec3 c) { return cross(b - a, c - a).z; };
    const double whole = area(corners[0], corners[1], corners[2]);
    if (whole == 0) continue;
    std::array<double, 3> bary{};
    for (std::size_t c = 0; c < 3; ++c) {
      bary[c] = area(position, corners[(c + 1) % 3], corners[(c + 2) % 3]) / whole;
    }
    if (std::all_of(bary.begin(), bary.end(), [](double weight) { return weight > -1e-12; })) {
      for (double& weight : bary) weight = std::max(weight, 0.0);
      return plane.on(f, bary);
    }
  }
  FAIL("the position is on the plane");
  return {};
}

// A point of the plane that both meshes of it have, inside a face or at a vertex.
struct Twice {
  SurfacePoint plain;
  SurfacePoint flat;
};

Twice point_of_both(RandomMesh& random, const Surface& plain, const Surface& flat) {
  if (random.unit() < 0.3) {
    const std::uint32_t vertex = random.below(plain.mesh().source_vertex_count());
    return {plain.at(vertex), flat.at(vertex)};
  }
  const SurfacePoint point = fixtures::random_point(random, plain);
  return {point, at_position(flat, position_of(plain.mesh(), point))};
}

}  // namespace

TEST_CASE("LinesThroughFacesWithoutWidthAreThoseOfTheSameSurfaceWithoutThem") {
  std::size_t left_out = 0;
  for (std::uint32_t round = 0; round < 40; ++round) {
    CAPTURE(round);
    RandomMesh random(test_seed() + round);
    const TriangleSoup soup = plane_of_eighths(random, 4 + random.below(4));
    TriangleSoup split = soup;
    for (std::uint32_t i = 0; i <= random.below(3); ++i) put_flat_faces_in(random, split);
    const Surface plain(soup);
    const Surface flat(split);
    const Twice a = point_of_both(random, plain, flat);
    const Twice b = point_of_both(random, plain, flat);
    if (distance(position_of(plain.mesh(), a.plain), position_of(plain.mesh(), b.plain)) < 0.1) {
      continue;
    }
    const SurfacePolyline line = straight(flat, a.flat, b.flat);
    const Cancel never;
    Poll poll(never);
    const SurfacePolyline whole = with_flat_faces(flat.adjacency(), line, poll);
    left_out += whole.size() - line.size();
    double longer = 0;
    for (std::size_t i = 1; i < whole.size(); ++i) {
      CHECK(face_in_common(flat.adjacency(), whole[i - 1], whole[i], poll) != kNone);
      longer +=
          distance(position_of(flat.mesh(), whole[i - 1]), position_of(flat.mesh(), whole[i]));
    }
    CHECK(longer == doctest::Approx(distance(position_of(flat.mesh(), a.flat),
                                             position_of(flat.mesh(), b.flat))));
    // A wall stops there what it stops on the plane.
    const Cut plain_cut(plain, {straight(plain, a.plain, b.plain)});
    const Cut flat_cut(flat, {line});
    const SurfacePoint from = fixtures::random_point(random, plain);
    const auto bary_of = [](const SurfacePoint& point) { return Weights(point.bary); };
    const Field wanted =
        plain_cut.field(plain_cut.on(plain.mesh().source_of_face(from.face), bary_of(from)));
    const SurfacePoint there = at_position(flat, position_of(plain.mesh(), from));
    const Field found =
        flat_cut.field(flat_cut.on(flat.mesh().source_of_face(there.face), bary_of(there)));
    for (std::uint32_t s = 0; s < soup.positions.size(); ++s) {
      CAPTURE(s);
      // On the wall itself it depends on the side that is meant.
      const auto least = [s](const Cut& cut, const Field& field) {
        double distance = kUnreached;
        for (std::uint32_t v = 0; v < cut.cut.mesh.vertex_count(); ++v) {
          if (cut.cut.mesh.source_of_vertex(v) == s) {
            distance = std::min(distance, field.distance[v]);
          }
        }
        return distance;
      };
      const double expected = least(plain_cut, wanted);
      if (expected == kUnreached) {
        CHECK(least(flat_cut, found) == kUnreached);
      } else {
        CHECK(least(flat_cut, found) == doctest::Approx(expected).epsilon(1e-9));
      }
    }
  }
  CHECK(left_out > 20);
}

TEST_CASE("LinesOfWhichNothingIsLeftOutStayAsTheyAre") {
  for (std::uint32_t round = 0; round < 60; ++round) {
    CAPTURE(round);
    RandomMesh random(test_seed() + round);
    const Surface surface(random.soup());
    const SurfacePolyline line = fixtures::random_line(random, surface.adjacency(), 12);
    const Cancel never;
    Poll poll(never);
    const SurfacePolyline whole = with_flat_faces(surface.adjacency(), line, poll);
    REQUIRE(whole.size() == line.size());
    for (std::size_t i = 0; i < line.size(); ++i) {
      CHECK(whole[i].face == line[i].face);
      CHECK(whole[i].vertex == line[i].vertex);
      CHECK(whole[i].bary == line[i].bary);
    }
  }
}
