// Angles round a vertex, and the ways from one face there to another.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <queue>
#include <vector>

#include "core/base/cancel.h"
#include "core/straighten/face_strip.h"
#include "core/surface/adjacency.h"
#include "core/surface/walk_over_faces.h"

namespace geodesic {

// The corner of a face that is at a vertex of it.
[[nodiscard]] inline std::uint32_t corner_at(const Adjacency& adjacency, std::uint32_t face,
                                             std::uint32_t vertex) {
  const auto& corners = adjacency.face(face).vertex;
  return corners[0] == vertex ? 0 : corners[1] == vertex ? 1 : 2;
}

// The other edge of the same face that ends in the vertex at which `side` begins or
// ends.
[[nodiscard]] inline Halfedge other_side_at(const Adjacency& adjacency, Halfedge side,
                                            std::uint32_t vertex) {
  const std::uint32_t f = face_of(side);
  const std::uint32_t c = corner_of(side);
  return adjacency.face(f).vertex[c] == vertex ? halfedge(f, previous_corner(c))
                                               : halfedge(f, next_corner(c));
}

// The sum of the angles of the fan that a corner is in, or nothing when the fan ends at
// a boundary or at a non-manifold edge. Goes round once: over edges of two faces the way on is
// one to one, so it comes back to where it began. Of no use if the poll says to stop.
[[nodiscard]] std::optional<double> closed_fan_angle(const Adjacency& adjacency,
                                                     std::uint32_t corner, Poll& poll);

// A direction from a vertex into a face there: its angles to the two edges.
struct DirectionAtVertex {
  std::uint32_t face = kNone;
  double to_next = 0;      // to the edge from the vertex's corner to the next corner
  double to_previous = 0;  // to that to the previous one
};

// Faces one after the other round a vertex, by the edges that end in it.
struct Fan {
  double angle = 0;
  std::vector<Portal> portals;  // none when both directions are in one face
};

// Finds fans at vertices; keeps its memory for the next search.
class FanSearch {
 public:
  // Both must outlive this object.
  FanSearch(const Adjacency& adjacency, Poll& poll) : adjacency_(adjacency), poll_(poll) {}

  // The fan with the least angle between two directions at a vertex, or nothing
  // when none has an angle below `bound`, or the faces meet in nothing but the
  // vertex. At a vertex of one fan of faces there are two ways to go, at a boundary
  // one; a non-manifold edge leads on into each of its faces, so that a spine of n pages takes
  // up to n^2 steps. Of no use once the poll says to stop.
  [[nodiscard]] std::optional<Fan> least(std::uint32_t vertex, const DirectionAtVertex& from,
                                         const DirectionAtVertex& to, double bound);

 private:
  // The edges at the vertex, as each of its faces has them: two per corner.
  struct Side {
    double angle;         // from the start, within this face up to the edge
    std::uint32_t from;   // the side over whose edge this face was entered, or kNone
    Halfedge entered_by;  // the halfedge of this face on that edge
  };
  struct Reached {
    double angle;
    std::uint32_t side;
    friend bool operator>(const Reached& a, const Reached& b) {
      return a.angle != b.angle ? a.angle > b.angle : a.side > b.side;
    }
  };
  using Queue = std::priority_queue<Reached, std::vector<Reached>, std::greater<>>;

  [[nodiscard]] std::uint32_t side_of(Halfedge h) const;
  [[nodiscard]] Halfedge halfedge_of(std::uint32_t side) const;
  void reach(Halfedge h, double angle, std::uint32_t from, Halfedge entered_by);

  const Adjacency& adjacency_;
  Poll& poll_;
  std::uint32_t vertex_ = kNone;
  std::vector<Side> sides_;
  Queue queue_;
};

}  // namespace geodesic
