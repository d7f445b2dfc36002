#include "core/back_trace_lanes.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/virtual_source.h"
#include "tests/fixtures/awkward_meshes.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/surface.h"

using namespace geodesic;
using fixtures::RandomMesh;
using fixtures::Surface;

namespace {

std::vector<Vectors> vectors_here() {
  std::vector<Vectors> all{Vectors::plain};
  if (best_vectors() == Vectors::avx2) all.push_back(Vectors::avx2);
  if (best_vectors() == Vectors::avx512) {
    all.push_back(Vectors::avx2);
    all.push_back(Vectors::avx512);
  }
  return all;
}

// From every vertex over the side opposite it, as far as the distances go.
std::vector<TraceStart> starts_on(const Triangulation& surface, const std::vector<double>& distance,
                                  RandomMesh& random) {
  std::vector<TraceStart> starts;
  for (std::uint32_t f = 0; f < surface.faces.size(); ++f) {
    const FaceRecord& face = surface.faces[f];
    for (std::uint32_t c = 0; c < 3; ++c) {
      const std::uint32_t right = face.vertex[next_corner(c)];
      const std::uint32_t left = face.vertex[previous_corner(c)];
      const double length = std::sqrt(face.length2(c));
      if (!(distance[right] + distance[left] < kUnreached) || !(length > 0)) continue;
      const Vec2 to_right{length, 0};
      const Vec2 to_left{face.dot[c] / length, face.area2 / length};
      const double share = random.unit();
      starts.push_back({halfedge(f, next_corner(c)), right, left, to_right, to_left,
                        to_right + share * (to_left - to_right)});
    }
  }
  return starts;
}

std::size_t check_lanes(const Surface& surface, RandomMesh& random, std::uint32_t source) {
  Field field =
      surface.field_by(Method::exact, {Source{point_at_vertex(surface.adjacency(), source), 0}});
  // Part of the surface is not yet reached, as in front of a wave.
  for (double& d : field.distance) {
    if (d > 0.8 * field.max) d = kUnreached;
  }
  std::size_t compared = 0;
  for (const Triangulation& faces :
       {surface.adjacency().triangulation(), surface.adjacency().delaunay()}) {
    const std::vector<TraceStart> starts = starts_on(faces, field.distance, random);
    for (const auto takes : {BackTrace::Takes::paths, BackTrace::Takes::virtual_sources}) {
      const BackTrace one(faces, field.distance, {}, takes);
      for (std::size_t first = 0; first < starts.size();) {
        const std::size_t count =
            std::min<std::size_t>(1 + random.below(TraceLanes::kLanes), starts.size() - first);
        for (const Vectors vectors : vectors_here()) {
          TraceLanes lanes;
          for (std::size_t i = 0; i < count; ++i) lanes.set(i, starts[first + i], kUnreached);
          lanes.count = count;
          trace_lanes(faces, field.distance, takes, vectors, lanes);
          for (std::size_t i = 0; i < count; ++i) {
            CHECK(lanes.best[i] == one.least(starts[first + i], kUnreached));
            ++compared;
          }
        }
        first += count;
      }
    }
  }
  return compared;
}

}  // namespace

// To the last bit, so that a distance is the same whatever machine computes it.
TEST_CASE("LanesComputeWhatOneTraceDoes") {
  std::size_t compared = 0;
  for (std::uint32_t number = 0; number < 40; ++number) {
    CAPTURE(number);
    RandomMesh random(number);
    const Surface surface(random.soup());
    compared += check_lanes(surface, random, surface.vertex(random.vertex()));
  }
  for (const fixtures::AwkwardMesh& mesh : fixtures::awkward_meshes()) {
    CAPTURE(mesh.name);
    RandomMesh random(1);
    const Surface surface(mesh.soup);
    compared += check_lanes(surface, random, surface.vertex(mesh.source));
  }
  CHECK(compared > 10000);
}
