// One face as it is split by points and segments: a triangulation of it that has them all.
//
// Everything is in barycentric weights: which side of a line a point is on, and where two lines
// meet, does not depend on the face's shape. A segment is put in by splitting the triangles that it
// crosses where it crosses their edges. That makes more triangles than a constrained Delaunay
// triangulation would; but each step is a split, so that no rounding can tear the face, and lines
// mostly cross a face once, where nothing is added.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <unordered_map>
#include <vector>

#include "core/base/cancel.h"

namespace geodesic {

using Weights = std::array<double, 3>;

// Points nearer than this are one, and a point so near a line is on it, as a part of the face.
inline constexpr double kSnap = 1e-9;

class FacePieces {
 public:
  // The whole face: its corners are points 0, 1 and 2.
  FacePieces();

  // A point on the side from corner `side` to the next one, at part t of it. It lies more than
  // kSnap from its ends and from the others there.
  std::uint32_t add_on_side(std::uint32_t side, double t);
  // A point inside, each weight at least kSnap; one that is there, if that is so near.
  std::uint32_t add_inside(const Weights& weights, Poll& poll);
  // Puts the segment between two points in. Returns the points along it, `a` and `b` among them,
  // each joined to the next by an edge; fewer if the poll says to stop.
  std::vector<std::uint32_t> join(std::uint32_t a, std::uint32_t b, Poll& poll);
  // The same points with those that later segments have put between them.
  [[nodiscard]] std::vector<std::uint32_t> with_splits(
      const std::vector<std::uint32_t>& chain) const;

  [[nodiscard]] std::span<const Weights> points() const { return points_; }
  // Wound as the face is.
  [[nodiscard]] std::span<const std::array<std::uint32_t, 3>> triangles() const {
    return triangles_;
  }

 private:
  using Corners = std::array<std::uint32_t, 3>;

  // How far a place is inside the line of an edge: of a triangle's three, where that is least.
  struct Depth {
    double off;          // negative outside
    std::uint32_t side;  // the edge, from its corner on
  };

  std::uint32_t add_point(const Weights& weights);
  // The first of the points that are so near to a place that they are there; kNone if none is.
  std::uint32_t find_point(const Weights& weights);
  [[nodiscard]] Depth depth_in(std::uint32_t triangle, const Weights& weights) const;
  // The triangle that a place is deepest in.
  std::uint32_t deepest_at(const Weights& weights, Poll& poll) const;
  // The same, from triangle to triangle beginning at the point that was added last; kNone if it may
  // be another for rounding, or is not come to.
  std::uint32_t walk_to(const Weights& weights, Poll& poll) const;
  // Adds a point in that triangle, or on its edge.
  std::uint32_t split_at(const Weights& weights, std::uint32_t triangle);
  void put(std::uint32_t triangle, const Corners& corners);
  // The triangle that has this edge in this direction, or kNone.
  [[nodiscard]] std::uint32_t over(std::uint32_t from, std::uint32_t to) const;
  void split_edge(std::uint32_t u, std::uint32_t w, std::uint32_t at);
  // Calls `visit(u, w)` for the triangles (a, u, w) at a point.
  template <class Visit>
  void around(std::uint32_t a, Visit&& visit) const;
  // The point at the other end of the edge on which the segment to b leaves a; kNone if rounding
  // hides it.
  std::uint32_t step(std::uint32_t a, std::uint32_t b);
  [[nodiscard]] std::uint32_t step_along_side(std::uint32_t a, std::uint32_t b) const;
  // The fewest edges from a to b, without a.
  [[nodiscard]] std::vector<std::uint32_t> along_edges(std::uint32_t a, std::uint32_t b,
                                                       Poll& poll) const;

  std::vector<Weights> points_;
  std::vector<Corners> triangles_;
  std::vector<std::uint32_t> triangle_at_;                   // any, by point
  std::unordered_map<std::uint64_t, std::uint32_t> edges_;   // directed, to the triangle
  std::unordered_map<std::uint64_t, std::uint32_t> splits_;  // an edge that was, to its middle
  std::array<std::map<double, std::uint32_t>, 3> sides_;     // their points by part of the side
  std::uint32_t last_inside_ = 0;                            // what add_inside returned last
  // The first so many points by the cell of a grid, each with the one before it there.
  std::unordered_map<std::uint64_t, std::uint32_t> cells_;
  std::vector<std::uint32_t> before_in_cell_;
};

}  // namespace geodesic
