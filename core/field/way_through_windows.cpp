#include "core/field/way_through_windows.h"

#include <algorithm>
#include <cmath>

#include "core/surface/face_over_edge.h"

namespace geodesic {
namespace {

// Where the line from the window's source to the point (x, y) above its edge
// crosses the edge, kept inside the window.
double crossing_of(const VisibleInterval& window, double x, double y) {
  const double rise = window.y + y;
  // No rise: source, edge and point on one line; anywhere between them will do.
  const double at = rise > 0 ? window.x + (x - window.x) * (window.y / rise) : x;
  return std::clamp(at, window.begin, window.end);
}

}  // namespace

WayThroughWindow shortest_way_through_windows(const Adjacency& adjacency,
                                              const WindowTable& windows,
                                              const SurfacePoint& place) {
  const FaceRecord& face = adjacency.face(place.face);
  WayThroughWindow best;
  for (std::uint32_t c = 0; c < 3; ++c) {
    const double above = place.bary[previous_corner(c)];
    const double length2 = face.length2(c);
    const bool loses_digits = face.loses_digits_of_length(c);
    if (above == 0 || (!(length2 > 0) && !loses_digits)) continue;
    double length = std::sqrt(length2);
    double x = place.bary[next_corner(c)] * length + above * (face.dot[c] / length);
    double y = above * (face.area2 / length);
    if (loses_digits) {
      const FaceOverEdge over = face_over_edge(adjacency.mesh(), halfedge(place.face, c));
      length = over.length;
      x = place.bary[next_corner(c)] * length + above * over.apex_from_tail.x;
      y = above * over.apex_from_tail.y;
    }
    for (const VisibleInterval& window : windows.into(halfedge(place.face, c))) {
      const double at = crossing_of(window, x, y);
      const double d = window.offset + std::hypot(at - window.x, window.y) + std::hypot(x - at, y);
      if (d < best.distance) best = {d, c, std::clamp(at / length, 0.0, 1.0)};
    }
  }
  return best;
}

}  // namespace geodesic
