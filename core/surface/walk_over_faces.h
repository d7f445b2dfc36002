// Going over faces: round a vertex from corner to corner, or straight ahead, by laying one face
// after another into the plane.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/vec2.h"
#include "core/mesh/mesh.h"
#include "core/surface/face_record.h"
#include "core/surface/triangulation.h"

namespace geodesic {

// The angle of a face at one of its corners, between 0 and pi.
[[nodiscard]] inline double corner_angle(const FaceRecord& face, std::uint32_t corner) {
  return std::atan2(face.area2, face.dot[corner]);
}

// The halfedge of the only other face on an edge, if that goes along it the other way; or kNone.
[[nodiscard]] inline Halfedge opposite_halfedge(std::span<const FaceRecord> faces, Halfedge h) {
  const FaceRecord& face = faces[face_of(h)];
  const Halfedge over = face.ring[corner_of(h)];
  if (over == h || faces[face_of(over)].ring[corner_of(over)] != h) return kNone;
  const std::uint32_t head = face.vertex[next_corner(corner_of(h))];
  return faces[face_of(over)].vertex[corner_of(over)] == head ? over : kNone;
}

// The corner at the same vertex beyond the side that ends at this one; the same where faces do not
// go on there as they do here.
[[nodiscard]] inline std::uint32_t next_around(std::span<const FaceRecord> faces,
                                               std::uint32_t corner) {
  const Halfedge side = halfedge(face_of(corner), previous_corner(corner_of(corner)));
  const Halfedge over = opposite_halfedge(faces, side);
  return over == kNone ? corner : over;
}

// Likewise beyond the side that begins at it.
[[nodiscard]] inline std::uint32_t previous_around(std::span<const FaceRecord> faces,
                                                   std::uint32_t corner) {
  const Halfedge over = opposite_halfedge(faces, corner);
  return over == kNone ? corner : halfedge(face_of(over), next_corner(corner_of(over)));
}

// Where directions at a vertex begin: at the boundary, or at its first corner.
[[nodiscard]] inline std::uint32_t corner_of_directions(const Triangulation& surface,
                                                        std::uint32_t v, Poll& poll) {
  const std::uint32_t first = surface.corners(v).front();
  std::uint32_t corner = first;
  while (!poll.cancelled()) {
    const std::uint32_t before = previous_around(surface.faces, corner);
    if (before == corner) return corner;
    if (before == first) break;
    corner = before;
  }
  return first;
}

// Whether one goes round the vertex over all of its faces.
[[nodiscard]] inline bool is_one_fan(const Triangulation& surface, std::uint32_t v, Poll& poll) {
  if (surface.corners(v).empty()) return false;
  const std::uint32_t first = corner_of_directions(surface, v, poll);
  std::size_t count = 1;
  for (std::uint32_t at = first; !poll.cancelled(); ++count) {
    const std::uint32_t next = next_around(surface.faces, at);
    if (next == at || next == first) break;
    at = next;
  }
  return count == surface.corners(v).size();
}

// From where directions at a vertex begin to a corner there; nothing if it is in another fan.
[[nodiscard]] inline std::optional<double> direction_of(const Triangulation& surface,
                                                        std::uint32_t corner, Poll& poll) {
  const std::uint32_t v = surface.faces[face_of(corner)].vertex[corner_of(corner)];
  const std::uint32_t first = corner_of_directions(surface, v, poll);
  double sum = 0;
  for (std::uint32_t at = first; !poll.cancelled();) {
    if (at == corner) return sum;
    sum += corner_angle(surface.faces[face_of(at)], corner_of(at));
    const std::uint32_t next = next_around(surface.faces, at);
    if (next == at || next == first) break;
    at = next;
  }
  return std::nullopt;
}

[[nodiscard]] inline double sum_of_angles(const Triangulation& surface, std::uint32_t v,
                                          Poll& poll) {
  double sum = 0;
  for (const std::uint32_t corner : surface.corners(v)) {
    if (poll.cancelled()) break;
    sum += corner_angle(surface.faces[face_of(corner)], corner_of(corner));
  }
  return sum;
}

// A direction at a vertex: the angle in radians from the side that starts at a corner there,
// towards the inside of the face.
struct Heading {
  std::uint32_t corner;
  double angle;
};

// So far round the vertex of a surface, from its corner `first`, where directions begin.
[[nodiscard]] inline Heading turned_from(const Triangulation& surface, std::uint32_t first,
                                         double left, Poll& poll) {
  const auto faces = surface.faces;
  const double round = sum_of_angles(surface, faces[face_of(first)].vertex[corner_of(first)], poll);
  if (previous_around(faces, first) == first) {
    left = std::clamp(left, 0.0, round);  // from one side of the boundary to the other
  } else if (round > 0) {
    left -= std::floor(left / round) * round;  // flips leave directions beyond the first round
  }
  std::uint32_t at = first;
  while (!poll.cancelled()) {
    const double angle = corner_angle(faces[face_of(at)], corner_of(at));
    const std::uint32_t next = next_around(faces, at);
    if (left <= angle || next == at || next == first) break;
    left -= angle;
    at = next;
  }
  return {at, left};
}

// A face in the plane, counterclockwise. Side 0 is where a walk came in.
struct UnfoldedTriangle {
  std::uint32_t face;
  std::array<std::uint32_t, 3> corner;
  std::array<Vec2, 3> at;

  // With corner c at the origin and the side that it begins along the x axis.
  static UnfoldedTriangle from_corner(std::span<const FaceRecord> faces, std::uint32_t face,
                                      std::uint32_t c) {
    const FaceRecord& record = faces[face];
    const double length = std::sqrt(record.length2(c));
    return {face,
            {c, next_corner(c), previous_corner(c)},
            {{{0, 0}, {length, 0}, {record.dot[c] / length, record.area2 / length}}}};
  }
  // The face across `h`, whose side here is `side`.
  [[nodiscard]] UnfoldedTriangle across(std::span<const FaceRecord> faces, Halfedge h,
                                        int side) const {
    const FaceRecord& record = faces[face_of(h)];
    const Vec2 from = at[static_cast<std::size_t>((side + 1) % 3)];
    const Vec2 base = at[static_cast<std::size_t>(side)] - from;
    std::uint32_t tail = corner_of(h);
    std::uint32_t head = next_corner(tail);
    const std::uint32_t ends_here = corner[static_cast<std::size_t>((side + 1) % 3)];
    if (record.vertex[tail] != faces[face].vertex[ends_here]) std::swap(tail, head);
    const double along = record.dot[tail] / dot(base, base);
    const double above = record.area2 / dot(base, base);
    return {face_of(h),
            {tail, head, previous_corner(corner_of(h))},
            {{from, at[static_cast<std::size_t>(side)],
              from + along * base + above * Vec2{-base.y, base.x}}}};
  }
  [[nodiscard]] UnfoldedTriangle turned_by(double angle) const {
    const Vec2 x{std::cos(angle), std::sin(angle)};
    const Vec2 y{-x.y, x.x};
    UnfoldedTriangle turned = *this;
    for (Vec2& place : turned.at) place = place.x * x + place.y * y;
    return turned;
  }
  [[nodiscard]] Halfedge side(int i) const {
    const std::uint32_t a = corner[static_cast<std::size_t>(i)];
    const std::uint32_t b = corner[static_cast<std::size_t>((i + 1) % 3)];
    return halfedge(face, next_corner(a) == b ? a : b);
  }

  // Whether a place lies in the face, but for rounding.
  [[nodiscard]] bool contains(Vec2 place) const {
    constexpr double kBeside = 1e-9;  // of its area
    const double area2 = cross(at[1] - at[0], at[2] - at[0]);
    for (std::size_t i = 0; i < 3; ++i) {
      if (!(cross(at[(i + 1) % 3] - at[i], place - at[i]) >= -kBeside * area2)) return false;
    }
    return true;
  }
  // Barycentric weights of a place, by the face's own corners; of one beside the face, those of a
  // place near it within. Nothing of a face without area.
  [[nodiscard]] std::optional<std::array<double, 3>> weights_at(Vec2 place) const {
    std::array<double, 3> weights{};
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      // From the nearer end of the side, beside which the other one has too few digits.
      const Vec2 a = at[(i + 1) % 3];
      const Vec2 b = at[(i + 2) % 3];
      const Vec2 from_a = place - a;
      const Vec2 from_b = place - b;
      const Vec2 from_end = dot(from_a, from_a) < dot(from_b, from_b) ? from_a : from_b;
      weights[corner[i]] = std::max(cross(b - a, from_end), 0.0);
      sum += weights[corner[i]];
    }
    if (!(sum > 0)) return std::nullopt;
    for (double& weight : weights) weight /= sum;
    return weights;
  }
};

// All faces round one of a face's vertices, one unfolded after the other, each with its corner
// there: from one side of the boundary to the other, or once round. None where an edge there has
// three faces. On a flat surface they lie side by side.
[[nodiscard]] inline std::vector<std::pair<UnfoldedTriangle, std::uint32_t>> unfolded_round(
    std::span<const FaceRecord> faces, const UnfoldedTriangle& first, int vertex, Poll& poll) {
  const auto ring = [&](Halfedge h) { return faces[face_of(h)].ring[corner_of(h)]; };
  std::vector<std::pair<UnfoldedTriangle, std::uint32_t>> round{
      {first, first.corner[static_cast<std::size_t>(vertex)]}};
  for (const bool is_forward : {true, false}) {
    UnfoldedTriangle face = first;
    int side = is_forward ? vertex : (vertex + 2) % 3;
    while (!poll.cancelled()) {
      const Halfedge h = face.side(side);
      const Halfedge over = ring(h);
      if (over == h) break;
      if (ring(over) != h) return {};
      face = face.across(faces, over, side);
      const std::uint32_t corner = face.corner[is_forward ? 1 : 0];
      // A face may be there twice, by two corners.
      if (face.face == first.face && corner == round.front().second) return round;
      round.emplace_back(face, corner);
      side = is_forward ? 1 : 2;
    }
  }
  return round;
}

// Where a walk ends: in a face, or before an edge that is not in two faces.
struct WalkEnd {
  UnfoldedTriangle face;
  Halfedge blocked = kNone;
};

// Goes straight from `from`, in the first face or at its corner 0, to `to`. Nothing if it takes
// more than `steps`, or loses its way: rounding may hide the side that it has to cross.
[[nodiscard]] inline std::optional<WalkEnd> walk_straight(std::span<const FaceRecord> faces,
                                                          UnfoldedTriangle face, Vec2 from, Vec2 to,
                                                          std::size_t& steps, Poll& poll) {
  const bool is_from_corner = from == face.at[0];
  int first = is_from_corner ? 1 : 0;
  int last = is_from_corner ? 1 : 2;
  for (; steps > 0 && !poll.cancelled(); first = 1, last = 2, --steps) {
    int out = -1;
    for (int i = first; i <= last; ++i) {
      const Vec2 a = face.at[static_cast<std::size_t>(i)];
      const Vec2 b = face.at[static_cast<std::size_t>((i + 1) % 3)];
      if (cross(b - a, to - a) >= 0) continue;
      if (cross(to - from, a - from) <= 0 && cross(to - from, b - from) >= 0) out = i;
    }
    if (out < 0) {
      if (!face.contains(to)) return std::nullopt;
      return WalkEnd{face};
    }
    const Halfedge h = face.side(out);
    const Halfedge over = faces[face_of(h)].ring[corner_of(h)];
    if (over == h || faces[face_of(over)].ring[corner_of(over)] != h) {
      return WalkEnd{face, face.contains(to) ? kNone : h};
    }
    face = face.across(faces, over, out);
  }
  return std::nullopt;
}

// Likewise from corner 0 of a face to a place that is known to be no farther than faces go on flat:
// it always ends, in a face that has the place, but for rounding. So it asks each new corner alone
// on which side it is, and ends by how far it has come.
[[nodiscard]] inline UnfoldedTriangle walk_on_flat_faces(std::span<const FaceRecord> faces,
                                                         UnfoldedTriangle face, Vec2 to,
                                                         Poll& poll) {
  const double length2 = dot(to, to);
  int out = 1;
  for (std::size_t left = faces.size(); left > 0 && !poll.cancelled(); --left) {
    const Vec2 a = face.at[static_cast<std::size_t>(out)];
    const Vec2 b = face.at[static_cast<std::size_t>((out + 1) % 3)];
    const double right = -cross(to, a);
    const double across = cross(to, b) + right;
    const Vec2 crossing = across > 0 ? a + std::clamp(right / across, 0.0, 1.0) * (b - a) : a;
    const Halfedge h = face.side(out);
    const Halfedge over = faces[face_of(h)].ring[corner_of(h)];
    if (dot(to, crossing) >= length2 || over == h ||
        faces[face_of(over)].ring[corner_of(over)] != h) {
      break;
    }
    face = face.across(faces, over, out);
    out = cross(to, face.at[2]) > 0 ? 1 : 2;
  }
  return face;
}

}  // namespace geodesic
