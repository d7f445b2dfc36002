// One step back within one face: how far it is straight from a point of the face to another, and
// what the step to a corner or to a side is. All points are weights of the face's corners, so no
// frame is laid into the face.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "core/base/tolerances.h"
#include "core/base/vec3.h"
#include "core/paths/arrive_at_point.h"
#include "core/surface/adjacency.h"
#include "core/wavefront/virtual_source.h"

namespace geodesic {

using Weights = std::array<double, 3>;

[[nodiscard]] inline Weights weights_at_corner(std::uint32_t corner) {
  Weights bary{0, 0, 0};
  bary[corner] = 1;
  return bary;
}

// The squared length of the side that starts at corner c. Of a side far shorter than the others the
// record's dot products leave only rounding; its length comes from the positions.
[[nodiscard]] inline double side_length2(const Adjacency& adjacency, std::uint32_t f,
                                         std::uint32_t c) {
  const FaceRecord& face = adjacency.face(f);
  if (!face.loses_length(c)) [[likely]]
    return std::max(face.length2(c), 0.0);
  const auto positions = adjacency.mesh().positions();
  const Vec3 side = positions[face.vertex[next_corner(c)]] - positions[face.vertex[c]];
  return dot(side, side);
}

// The squared lengths of a face's sides, from the one that starts at corner 0.
using Sides2 = std::array<double, 3>;

[[nodiscard]] inline Sides2 sides_of(const Adjacency& adjacency, std::uint32_t f) {
  const FaceRecord& face = adjacency.face(f);
  Sides2 side2{face.length2(0), face.length2(1), face.length2(2)};
  const double least = std::min(std::min(side2[0], side2[1]), side2[2]);
  if (!(least > tolerance::kHalfOfDigits * (side2[0] + side2[1] + side2[2]))) [[unlikely]] {
    for (std::uint32_t c = 0; c < 3; ++c) side2[c] = side_length2(adjacency, f, c);
  }
  return side2;
}

// Squared distance between two points of a face; differences of weights add up to
// zero, so |sum u_i x_i|^2 = -sum over sides u_i u_j |x_i - x_j|^2.
[[nodiscard]] inline double squared_distance(const Sides2& side2, const Weights& a,
                                             const Weights& b) {
  double sum = 0;
  for (std::uint32_t c = 0; c < 3; ++c) {
    const std::uint32_t n = next_corner(c);
    sum -= (a[c] - b[c]) * (a[n] - b[n]) * side2[c];
  }
  return std::max(sum, 0.0);
}

// The straight line in space between two points of a face. Where they are so near to each other
// that the sides' squares have lost it, by their positions.
[[nodiscard]] inline double straight_distance(const Adjacency& adjacency, std::uint32_t f,
                                              const Sides2& side2, const Weights& a,
                                              const Weights& b) {
  const double square = squared_distance(side2, a, b);
  const double longest2 = std::max(std::max(side2[0], side2[1]), side2[2]);
  if (square > tolerance::kNearInFace2 * longest2) [[likely]]
    return std::sqrt(square);
  const auto positions = adjacency.mesh().positions();
  const FaceRecord& face = adjacency.face(f);
  const Vec3 corner = positions[face.vertex[0]];
  return norm((a[1] - b[1]) * (positions[face.vertex[1]] - corner) +
              (a[2] - b[2]) * (positions[face.vertex[2]] - corner));
}

// The step straight from `start` to a corner, for a point of that distance.
[[nodiscard]] inline StepBack to_vertex(const FaceRecord& face, std::uint32_t f,
                                        std::uint32_t corner, const Weights& start,
                                        double distance) {
  StepBack step;
  step.to = StepBack::To::vertex;
  step.distance = distance;
  step.face = f;
  step.start = start;
  step.bary = weights_at_corner(corner);
  step.vertex = face.vertex[corner];
  return step;
}

// The step that case (a), (b) or (c) of the paper's Fig. 4 asks for.
[[nodiscard]] inline StepBack over_side(const FaceRecord& face, std::uint32_t f, std::uint32_t c,
                                        const Weights& start, const Arrival& arrival,
                                        double at_end = tolerance::kAtEnd) {
  const std::uint32_t n = next_corner(c);
  if (arrival.which == Fig4::b || arrival.crossing < at_end) {
    return to_vertex(face, f, c, start, arrival.distance);
  }
  if (arrival.which == Fig4::c || arrival.crossing > 1 - at_end) {
    return to_vertex(face, f, n, start, arrival.distance);
  }
  StepBack step;
  step.to = StepBack::To::edge;
  step.distance = arrival.distance;
  step.face = f;
  step.start = start;
  step.bary[c] = 1 - arrival.crossing;
  step.bary[n] = arrival.crossing;
  step.base = halfedge(f, c);
  return step;
}

}  // namespace geodesic
