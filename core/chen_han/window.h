// The plane geometry of Chen and Han's method: a window over a face, the face
// unfolded over the window's edge, and the parts of the window that leave it by its
// two other sides. Frames are those of VisibleInterval (window_table.h).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "core/base/tolerances.h"
#include "core/base/vec3.h"
#include "core/surface/adjacency.h"

namespace geodesic::chen_han {

[[nodiscard]] inline double length(double x, double y) { return std::sqrt(x * x + y * y); }

struct Window {
  double begin;
  double end;
  double x;
  double y;  // positive: a source on the edge's line counts as below it (tolerance::kDepthOnLine)
  double offset;
  Halfedge into;
  std::uint32_t pseudo_source;
  std::uint32_t source;
  std::uint32_t seen;          // its number among SeenWindows, where they are kept
  std::uint32_t crossed : 30;  // faces since the pseudo-source
  // Its strip of faces has crossed a non-manifold edge or a face without area: there
  // other paths may enter or leave the strip unseen, and "one angle, one split", whose
  // proof needs two paths in a strip to cross, does not hold.
  std::uint32_t branched : 1;
  // Of two that a window was split into, the one on the side of the base's beginning.
  std::uint32_t left : 1;
  // The halfedge through which its parent met a corner, kNone when it did not; and how
  // far a nearer window's crossing may lie to the other side, until this window is one
  // that its parent may not have.
  Halfedge split_by;
  double split_limit;

  // The length of its straight way to a point of the edge.
  [[nodiscard]] double at(double p) const { return offset + length(p - x, y); }
  // The same window in the frame of the edge run the other way.
  void mirror(double base) {
    begin = base - std::exchange(end, base - begin);
    x = base - x;
  }
  [[nodiscard]] double least() const { return at(std::clamp(x, begin, end)); }
};

// A face over one of its halfedges, which runs from (0, 0) to (base, 0).
struct UnfoldedFace {
  std::uint32_t at_begin;
  std::uint32_t at_end;
  std::uint32_t opposite;
  double base;
  double left;   // the length of the side from the base's beginning to the apex
  double right;  // and from its end
  double apex_x;
  double apex_y;
  // The apex's x counted back from the base's end. Not base - apex_x: of a base far longer than the
  // right side, its rounding would turn that side.
  double apex_back;

  [[nodiscard]] static UnfoldedFace over(const Adjacency& adjacency, Halfedge h) {
    const FaceRecord& face = adjacency.face(face_of(h));
    const std::uint32_t c = corner_of(h);
    UnfoldedFace unfolded{};
    unfolded.at_begin = face.vertex[c];
    unfolded.at_end = face.vertex[next_corner(c)];
    unfolded.opposite = face.vertex[previous_corner(c)];
    // From the positions: dot products of long sides cannot give the length of a
    // short one to the last bits, and all faces on an edge must agree on its length.
    const auto positions = adjacency.mesh().positions();
    const Vec3 begin = positions[unfolded.at_begin];
    const Vec3 end = positions[unfolded.at_end];
    const Vec3 apex = positions[unfolded.opposite];
    unfolded.base = distance(begin, end);
    unfolded.left = distance(begin, apex);
    unfolded.right = distance(end, apex);
    unfolded.apex_x = face.dot[c] / unfolded.base;
    unfolded.apex_y = face.area2 / unfolded.base;
    unfolded.apex_back = face.dot[next_corner(c)] / unfolded.base;
    return unfolded;
  }
};

[[nodiscard]] inline bool has_no_area(const FaceRecord& face) {
  return !(face.area2 > tolerance::kWindowZeroArea * face.longest2());
}

// What a window sees of one side of the face above it. The side runs from the
// base's beginning (its origin) to the apex.
struct SideInterval {
  double begin;
  double end;
  double x;
  double y;
};

// The part of [begin, end] that lies before `to_apex`, where the straight line from
// the source (x, -y) to the apex crosses the base, carried on to the side of length
// `side`. Needs begin < to_apex. For the other side, mirror the frame.
//
// With s the source and a the apex, the line from s through (p, 0) meets the side at
//   side * p y / (p y + (to_apex - p) (y + a_y)),
// and the depth of s below the side is to_apex (y + a_y) / side.
[[nodiscard]] inline SideInterval over_side(double begin, double end, double x, double y,
                                            double apex_x, double apex_y, double to_apex,
                                            double side) {
  const auto carried = [&](double p) {
    if (p >= to_apex) return side;
    const double along = p * y;
    return std::min(side * (along / (along + (to_apex - p) * (y + apex_y))), side);
  };
  return {carried(begin), carried(end), (x * apex_x - y * apex_y) / side,
          to_apex * (y + apex_y) / side};
}

[[nodiscard]] inline bool is_gap(const SideInterval& at, double side) {
  const double width = at.end - at.begin;
  if (!(width > 0)) return true;
  if (width > tolerance::kLeastWidth * side) return false;
  const double to_begin = length(at.begin - at.x, at.y);
  const double to_end = length(at.end - at.x, at.y);
  return width * at.y <= tolerance::kLeastWidth * to_begin * to_end;
}

[[nodiscard]] inline bool clearly_less(double a, double b) {
  return a < b - tolerance::kSameDistance * b;
}

// Where on the edge the difference of a window's distances and those from a place at (x, y) is
// least or greatest: where both sources are seen in the same direction. There is one such place at
// most, and none when they are equally deep.
[[nodiscard]] inline double extremum_along(double x, double y, const Window& window) {
  const double depth = std::abs(y);
  return (x * window.y - window.x * depth) / (window.y - depth);
}

// Whether between two places of the window the way from a place at (x, y), on either side of the
// edge and with the distance `offset`, is clearly shorter. At one of the two it may be as long, if
// that is allowed there.
[[nodiscard]] inline bool nearer_along(double x, double y, double offset, const Window& window,
                                       double begin, double end, bool may_be_equal_at_begin,
                                       bool may_be_equal_at_end) {
  const auto nearer_at = [&](double p) {
    return clearly_less(offset + length(p - x, y), window.at(p));
  };
  const auto as_near_at = [&](double p) {
    return !clearly_less(window.at(p), offset + length(p - x, y));
  };
  const bool at_begin = nearer_at(begin);
  const bool at_end = nearer_at(end);
  if (!at_begin && !(may_be_equal_at_begin && at_end && as_near_at(begin))) return false;
  if (!at_end && !(may_be_equal_at_end && at_begin && as_near_at(end))) return false;
  const double level = extremum_along(x, y, window);
  const bool inside = level > begin && level < end;
  return !inside || nearer_at(level);
}

// Whether it is everywhere in the window.
[[nodiscard]] inline bool nearer_along(double x, double y, double offset, const Window& window) {
  return nearer_along(x, y, offset, window, window.begin, window.end, false, false);
}

// Whether it is clearly longer nowhere between the two.
[[nodiscard]] inline bool as_near_along(double x, double y, double offset, const Window& window,
                                        double begin, double end) {
  const auto as_near_at = [&](double p) {
    return !clearly_less(window.at(p), offset + length(p - x, y));
  };
  const double level = extremum_along(x, y, window);
  const bool inside = level > begin && level < end;
  return as_near_at(begin) && as_near_at(end) && (!inside || as_near_at(level));
}

}  // namespace geodesic::chen_han
