#include "core/exact_surface.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "core/surface_point.h"
#include "core/vec3.h"

namespace geodesic::exact {
namespace {

// Among so many of the sources the nearest is looked for.
constexpr std::size_t kMostSources = 8;

// On scans stretched 8 times, the windows on the Delaunay triangulation over those on the mesh
// are this part of the estimates' ratio, from 0.68 to 0.79.
constexpr double kFewerWindows = 0.75;

// Of so many faces or more, some are looked at: they are numbered along a curve that fills
// space, so those come from everywhere.
constexpr std::size_t kSample = 8192;
std::size_t stride_through(std::size_t faces) { return std::max<std::size_t>(faces / kSample, 1); }

Vec3 from_nearest(std::span<const Vec3> sources, const Vec3& place) {
  Vec3 best = place - sources.front();
  for (const Vec3& source : sources.subspan(1)) {
    const Vec3 way = place - source;
    if (dot(way, way) < dot(best, best)) best = way;
  }
  return best;
}

double crossings_on_mesh(const Adjacency& adjacency, std::span<const Vec3> sources, Poll& poll) {
  const auto positions = adjacency.mesh().positions();
  const auto faces = adjacency.faces();
  const std::size_t stride = stride_through(faces.size());
  double sum = 0;
  for (std::size_t f = 0; f < faces.size() && !poll.cancelled(); f += stride) {
    const FaceRecord& face = faces[f];
    const Vec3 a = positions[face.vertex[0]];
    const Vec3 b = positions[face.vertex[1]];
    const Vec3 c = positions[face.vertex[2]];
    const Vec3 sides[] = {b - a, c - b, a - c};
    const Vec3 normal = cross(sides[0], sides[1]);
    const Vec3 away = from_nearest(sources, (1.0 / 3) * (a + b + c));
    // In the face's plane, turned by a right angle, and twice the area too long.
    const Vec3 turned = cross(normal, away);
    const double scale = norm(turned);
    if (!(scale > 0)) continue;
    for (const Vec3& side : sides) sum += std::abs(dot(side, turned)) / scale;
  }
  return sum;
}

double crossings_in_any_direction(const Triangulation& surface, Poll& poll) {
  const std::size_t stride = stride_through(surface.faces.size());
  double sum = 0;
  for (std::size_t f = 0; f < surface.faces.size() && !poll.cancelled(); f += stride) {
    const FaceRecord& face = surface.faces[f];
    for (std::uint32_t c = 0; c < 3; ++c) sum += std::sqrt(std::max(face.length2(c), 0.0));
  }
  return 2 / std::numbers::pi * sum;
}

}  // namespace

Triangulation surface_for_windows(const Adjacency& adjacency, std::span<const Source> sources,
                                  Poll& poll) {
  const Triangulation mesh = adjacency.triangulation();
  const Triangulation delaunay = adjacency.delaunay();
  if (delaunay.faces.data() == mesh.faces.data() || sources.empty()) return mesh;
  std::vector<Vec3> places;
  for (const Source& source : sources.first(std::min(sources.size(), kMostSources))) {
    places.push_back(position_of(adjacency.mesh(), source.point));
  }
  const double on_mesh = crossings_on_mesh(adjacency, places, poll);
  // Fewer windows come of that than these lines say.
  const double on_delaunay = kFewerWindows * crossings_in_any_direction(delaunay, poll);
  if (poll.stopped()) return mesh;
  return on_delaunay < on_mesh ? delaunay : mesh;
}

}  // namespace geodesic::exact
