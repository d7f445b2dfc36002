#include "core/straighten/vertex_fan.h"

#include <algorithm>
#include <limits>

namespace geodesic {

std::optional<double> closed_fan_angle(const Adjacency& adjacency, std::uint32_t corner,
                                       Poll& poll) {
  const std::uint32_t vertex = adjacency.face(face_of(corner)).vertex[corner_of(corner)];
  double sum = 0;
  Halfedge side = corner;
  do {
    if (poll.cancelled()) return std::nullopt;
    const std::uint32_t f = face_of(side);
    sum += corner_angle(adjacency.face(f), corner_at(adjacency, f, vertex));
    const Halfedge other = other_side_at(adjacency, side, vertex);
    side = adjacency.ring(other);
    if (side == other || adjacency.ring(side) != other) return std::nullopt;
  } while (side != corner);
  return sum;
}

// Side 2 i is the edge to the next corner of the vertex's i-th face, 2 i + 1 that to
// the previous one.
std::uint32_t FanSearch::side_of(Halfedge h) const {
  const auto corners = adjacency_.corners(vertex_);
  // Corners ascend with their faces, and a face has the vertex once.
  const auto it = std::lower_bound(corners.begin(), corners.end(), halfedge(face_of(h), 0));
  const auto i = static_cast<std::uint32_t>(it - corners.begin());
  return 2 * i + (*it == h ? 0 : 1);
}

Halfedge FanSearch::halfedge_of(std::uint32_t side) const {
  const std::uint32_t corner = adjacency_.corners(vertex_)[side / 2];
  return side % 2 == 0 ? corner : halfedge(face_of(corner), previous_corner(corner_of(corner)));
}

void FanSearch::reach(Halfedge h, double angle, std::uint32_t from, Halfedge entered_by) {
  const std::uint32_t i = side_of(h);
  if (!(angle < sides_[i].angle)) return;
  sides_[i] = {angle, from, entered_by};
  queue_.push({angle, i});
}

// Dijkstra over the edges at the vertex, with angles for lengths.
std::optional<Fan> FanSearch::least(std::uint32_t vertex, const DirectionAtVertex& from,
                                    const DirectionAtVertex& to, double bound) {
  vertex_ = vertex;
  const std::size_t corner_count = adjacency_.corners(vertex).size();
  sides_.assign(2 * corner_count, {kInfinity, kNone, kNone});
  queue_ = Queue();

  double best = bound;
  std::uint32_t best_side = kNone;  // crossed last
  Halfedge best_entry = kNone;      // into the target's face
  bool found = false;
  if (from.face == to.face) {
    const double angle = std::abs(from.to_next - to.to_next);
    if (angle < best) {
      best = angle;
      found = true;
    }
  }
  const Halfedge next = halfedge(from.face, corner_at(adjacency_, from.face, vertex));
  reach(next, from.to_next, kNone, kNone);
  reach(other_side_at(adjacency_, next, vertex), from.to_previous, kNone, kNone);

  while (!queue_.empty()) {
    const Reached at = queue_.top();
    queue_.pop();
    if (at.angle >= best) break;
    if (at.angle > sides_[at.side].angle) continue;
    const Halfedge out = halfedge_of(at.side);
    for (Halfedge in = adjacency_.ring(out); in != out; in = adjacency_.ring(in)) {
      if (poll_.cancelled()) return std::nullopt;
      const std::uint32_t f = face_of(in);
      const std::uint32_t c = corner_of(in);
      if (f == to.face) {
        const bool by_next = adjacency_.face(f).vertex[c] == vertex;
        const double angle = at.angle + (by_next ? to.to_next : to.to_previous);
        if (angle < best) {
          best = angle;
          best_side = at.side;
          best_entry = in;
          found = true;
        }
      }
      const Halfedge across = other_side_at(adjacency_, in, vertex);
      const double angle =
          at.angle + corner_angle(adjacency_.face(f), corner_at(adjacency_, f, vertex));
      if (angle < best) reach(across, angle, at.side, in);
    }
  }
  if (!found) return std::nullopt;

  Fan fan;
  fan.angle = best;
  for (Halfedge entry = best_entry; entry != kNone;) {
    fan.portals.push_back({halfedge_of(best_side), entry});
    entry = sides_[best_side].entered_by;
    best_side = sides_[best_side].from;
  }
  std::reverse(fan.portals.begin(), fan.portals.end());
  return fan;
}

}  // namespace geodesic
