// The arithmetic of a list of windows that crosses a face, in the lanes of vector
// registers. To the last bit the same whatever the processor has for vectors.
#pragma once

#include <cstddef>

#include "core/base/vectors.h"
#include "core/windows/window_columns.h"

namespace geodesic::exact {

// Fills `crossing` of the windows from `first` to before `last` for a far corner at (x, y) and
// returns the window by which the corner is nearest; of two equally near ones, one that sees it
// straight. There is at least one.
[[nodiscard]] std::size_t find_crossings(Vectors vectors, EnteringWindows& entering,
                                         std::size_t first, std::size_t last, double x, double y,
                                         double base_length);

// A side of the face, and its edge. On the left side, t is counted from the base's tail, on
// the right from its head; `flipped` is whether the edge's frame counts the other way.
struct SideFrame {
  bool on_right;
  bool flipped;
  double base_length;
  double cosine;  // of the angle between base and side
  double sine;
  double length;
  double at_tail;  // distances of the edge's ends
  double at_head;
  double upper_bound;  // what is as far as this anywhere is of no use,
  double max;          // nor what is farther than this
};

// What becomes of the entering windows from `first` to before `last`.
void cross_to_side(Vectors vectors, const EnteringWindows& entering, std::size_t first,
                   std::size_t last, const SideFrame& side, PropagatedWindows& beyond);

// Which of those windows overlap the next one; `upwards`: numbers ascend along the edge.
// Fills `overlaps` and `pair`, and `left` and `right` of the pairs, behind those that are there.
void pair_overlaps(Vectors vectors, std::size_t first, std::size_t last, bool upwards,
                   double length, PropagatedWindows& beyond, EquidistantPoints& equidistant);

// Fills `place`, `at_left`, `at_right` and `found` for the pairs.
void find_equidistant_points(Vectors vectors, const EnteringWindows& entering,
                             const PropagatedWindows& beyond, EquidistantPoints& equidistant);

}  // namespace geodesic::exact
