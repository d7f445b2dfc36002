// Where faces have no area, or hardly any, there are ways along edges at least; and no method's
// answer is worse.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "core/mesh.h"
#include "tests/fixtures/crumpled_surfaces.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::Surface;

namespace {

struct Named {
  std::string name;
  Method method;
  bool never_below = true;  // the straight line in space
  Bound bound = Bound::none;
};

const Named kMethods[] = {{"wavefront", Method::wavefront, false},
                          {"novotni", Method::novotni, false},
                          {"dijkstra", Method::dijkstra},
                          {"fast_marching", Method::fast_marching, false},
                          {"steiner", Method::steiner},
                          {"auto", Method::back_traced},
                          {"upper", Method::back_traced, true, Bound::upper}};

// Triangles put onto edges at random, of points on a line, off it by at most that.
TriangleSoup on_a_line(std::mt19937& random, double off) {
  const int faces = 5 + static_cast<int>(random() % 60);
  TriangleSoup soup = fixtures::grown(random, faces);
  const Vec3 line{1, fixtures::fraction(random), random() % 2 == 0 ? 0.0 : 1.0};
  const bool whole = random() % 2 == 0;
  for (Vec3& p : soup.positions) {
    double along = 40 * fixtures::fraction(random);
    if (whole) along = std::round(along);
    p = along * line + off * p;
  }
  return soup;
}

void check_as_near_as_along_edges(const Surface& surface, std::uint32_t from) {
  const Source source{point_at_vertex(surface.adjacency(), from), 0};
  const Field edges = surface.field_by(Method::dijkstra, {source});
  for (const Named& by : kMethods) {
    CAPTURE(by.name);
    MethodOptions options;
    options.bound = by.bound;
    const Field field = surface.field_by(by.method, {source}, {}, options);
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      CAPTURE(v);
      CAPTURE(edges.distance[v]);
      if (edges.distance[v] == kUnreached) {
        CHECK(field.distance[v] == kUnreached);
        continue;
      }
      // Fast marching goes by the shapes of faces, in which a short side beside long ones is not
      // exact.
      const double slack = by.method == Method::fast_marching ? 1e-3 : 1e-6;
      CHECK(field.distance[v] <= edges.distance[v] * (1 + slack));
      if (!by.never_below) continue;
      const Vec3 from_there = surface.mesh().positions()[v] - surface.mesh().positions()[from];
      CHECK(field.distance[v] >= norm(from_there) * (1 - 1e-6));
    }
  }
}

}  // namespace

TEST_CASE("OfPointsOnALineNoMethodIsWorseThanEdges") {
  std::mt19937 random(fixtures::test_seed());
  for (const double off : {0.0, 1e-300, 1e-100, 1e-30, 1e-16, 1e-12, 1e-8}) {
    CAPTURE(off);
    for (int round = 0; round < 25; ++round) {
      CAPTURE(round);
      const TriangleSoup soup = on_a_line(random, off);
      if (!Mesh::build(soup)) continue;  // all faces without two distinct points
      const Surface surface(soup);
      check_as_near_as_along_edges(surface, random() % surface.mesh().vertex_count());
    }
  }
}

TEST_CASE("OfPointsAllInOnePlaceButOneNoMethodIsWorseThanEdges") {
  for (const double apart : {0.0, 1e-300, 1e-30, 1e-16, 1e-12}) {
    CAPTURE(apart);
    TriangleSoup soup;
    for (int i = 0; i < 12; ++i) {
      soup.positions.push_back({apart * std::cos(i), apart * std::sin(2 * i), apart * i});
    }
    soup.positions.push_back({3, 4, 0});
    for (std::uint32_t i = 0; i < 11; ++i) soup.faces.push_back({i, i + 1, 12});
    if (!Mesh::build(soup)) continue;
    const Surface surface(soup);
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      CAPTURE(v);
      check_as_near_as_along_edges(surface, v);
    }
  }
}
