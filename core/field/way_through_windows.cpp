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

// A side of a face, as windows see it: how long it is, and where a place in the face is, whose foot
// is so far along it.
struct PlaceOverSide {
  double length;
  double x;
  double y;
};

PlaceOverSide over_side(const FaceRecord& face, const std::array<double, 3>& weights,
                        std::uint32_t c) {
  const double length = std::sqrt(face.length2(c));
  const double above = weights[previous_corner(c)];
  return {length, weights[next_corner(c)] * length + above * (face.dot[c] / length),
          above * (face.area2 / length)};
}

// Makes `best` the shortest through the windows of the side that begins at corner c, if one of them
// is shorter.
void take_shorter(std::span<const VisibleInterval> windows, std::uint32_t c,
                  const PlaceOverSide& place, WayThroughWindow& best) {
  const auto& [length, x, y] = place;
  for (const VisibleInterval& window : windows) {
    const double at = crossing_of(window, x, y);
    const double d = window.offset + std::hypot(at - window.x, window.y) + std::hypot(x - at, y);
    if (d < best.distance) best = {d, c, std::clamp(at / length, 0.0, 1.0), &window};
  }
}

}  // namespace

WayThroughWindow shortest_way_through_windows(const Adjacency& adjacency,
                                              const WindowTable& windows,
                                              const SurfacePoint& place) {
  const FaceRecord& face = adjacency.face(place.face);
  WayThroughWindow best;
  for (std::uint32_t c = 0; c < 3; ++c) {
    const double above = place.bary[previous_corner(c)];
    const bool loses_digits = face.loses_digits_of_length(c);
    if (above == 0 || (!(face.length2(c) > 0) && !loses_digits)) continue;
    PlaceOverSide over = over_side(face, place.bary, c);
    if (loses_digits) {
      const FaceOverEdge exact = face_over_edge(adjacency.mesh(), halfedge(place.face, c));
      over = {exact.length,
              place.bary[next_corner(c)] * exact.length + above * exact.apex_from_tail.x,
              above * exact.apex_from_tail.y};
    }
    take_shorter(windows.into(halfedge(place.face, c)), c, over, best);
  }
  return best;
}

WayThroughWindow shortest_way_through_windows(std::span<const FaceRecord> faces,
                                              const WindowTable& windows, std::uint32_t face,
                                              const std::array<double, 3>& weights) {
  WayThroughWindow best;
  for (std::uint32_t c = 0; c < 3; ++c) {
    if (weights[previous_corner(c)] == 0 || !(faces[face].length2(c) > 0)) continue;
    take_shorter(windows.into(halfedge(face, c)), c, over_side(faces[face], weights, c), best);
  }
  return best;
}

}  // namespace geodesic
