// Many back traces at once, in the lanes of vector registers: what BackTrace::over
// computes, to the last bit, whatever the processor has for vectors.
//
// The faces that the traces go over lie apart in memory. What makes a batch fast is as
// much that the waits for them overlap as that the arithmetic is done in lanes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/back_trace.h"
#include "core/triangulation.h"
#include "core/vectors.h"

namespace geodesic {

struct TraceLanes {
  static constexpr std::size_t kLanes = 16;

  // One trace a lane; what is in lanes from `count` on counts for nothing.
  std::size_t count = 0;
  std::array<Halfedge, kLanes> base{};
  std::array<double, kLanes> crossing{};
  std::array<double, kLanes> best{};
  // Of traces that looked back near only: whether they are to look farther.
  std::array<bool, kLanes> is_unsure{};

  // There must be room. Returns the lane.
  std::size_t add(Halfedge over, double at, double so_far) {
    base[count] = over;
    crossing[count] = at;
    best[count] = so_far;
    return count++;
  }
  [[nodiscard]] bool full() const { return count == kLanes; }
};

// Lowers `best` of every lane as BackTrace::over does, for a source at a vertex: looking
// back far where `reach` says so, or near; then those that are unsure must go far.
void trace_lanes(const Triangulation& surface, std::span<const double> distance,
                 BackTrace::Takes takes, BackTrace::Reach reach, Vectors vectors,
                 TraceLanes& lanes);

}  // namespace geodesic
