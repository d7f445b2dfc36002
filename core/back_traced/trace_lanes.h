// Many back traces at once, in the lanes of vector registers: what BackTrace::over
// computes, to the last bit, whatever the processor has for vectors.
//
// The faces that the traces go over lie apart in memory. What makes a batch fast is as
// much that the waits for them overlap as that the arithmetic is done in lanes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/back_traced/front_distances.h"
#include "core/back_traced/trace.h"
#include "core/base/vectors.h"
#include "core/surface/triangulation.h"

namespace geodesic {

struct TraceLanes {
  static constexpr std::size_t kLanes = 16;

  // One trace a lane; what is in lanes from `count` on counts for nothing.
  std::size_t count = 0;
  std::array<Halfedge, kLanes> base{};
  std::array<double, kLanes> crossing{};
  std::array<double, kLanes> best{};
  std::array<std::uint32_t, kLanes> source{};
  // Those that begin elsewhere than over a base, each a bit, and where.
  std::uint32_t elsewhere = 0;
  std::array<TraceStart, kLanes> start{};

  // There must be room. Return the lane.
  std::size_t add(Halfedge over, double at, double so_far, std::uint32_t number = 0) {
    base[count] = over;
    crossing[count] = at;
    best[count] = so_far;
    source[count] = number;
    return count++;
  }
  std::size_t add(const TraceStart& from, double so_far, std::uint32_t number = 0) {
    start[count] = from;
    elsewhere |= 1U << count;
    return add(from.edge, 0.5, so_far, number);
  }
  [[nodiscard]] bool begins_elsewhere(std::size_t lane) const {
    return ((elsewhere >> lane) & 1U) != 0;
  }
  [[nodiscard]] bool full() const { return count == kLanes; }
  void clear() {
    count = 0;
    elsewhere = 0;
  }
};

// Lowers `best` of every lane as BackTrace::over does, or BackTrace::least, for a source at
// a vertex.
void trace_lanes(const Triangulation& surface, const FrontDistances& distances,
                 BackTrace::Rule rule, Vectors vectors, TraceLanes& lanes,
                 const CrowdedEdges* crowds = nullptr);

}  // namespace geodesic
