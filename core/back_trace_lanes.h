// Eight back traces at once, in the lanes of vector registers: what BackTrace::least
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

namespace geodesic {

struct TraceLanes {
  static constexpr std::size_t kLanes = 8;

  // One trace a lane, as in TraceStart; what is in lanes from `count` on counts for
  // nothing.
  std::size_t count = 0;
  std::array<Halfedge, kLanes> edge{};
  std::array<std::uint32_t, kLanes> right{};
  std::array<std::uint32_t, kLanes> left{};
  std::array<double, kLanes> right_x{};
  std::array<double, kLanes> right_y{};
  std::array<double, kLanes> left_x{};
  std::array<double, kLanes> left_y{};
  std::array<double, kLanes> aim_x{};
  std::array<double, kLanes> aim_y{};
  std::array<double, kLanes> best{};

  void set(std::size_t lane, const TraceStart& start, double so_far) {
    edge[lane] = start.edge;
    right[lane] = start.right;
    left[lane] = start.left;
    right_x[lane] = start.to_right.x;
    right_y[lane] = start.to_right.y;
    left_x[lane] = start.to_left.x;
    left_y[lane] = start.to_left.y;
    aim_x[lane] = start.aim.x;
    aim_y[lane] = start.aim.y;
    best[lane] = so_far;
  }
  [[nodiscard]] TraceStart start(std::size_t lane) const {
    return {edge[lane],
            right[lane],
            left[lane],
            {right_x[lane], right_y[lane]},
            {left_x[lane], left_y[lane]},
            {aim_x[lane], aim_y[lane]}};
  }
};

// The instructions to use. Those of another processor must not be asked for.
enum class Vectors : std::uint8_t { plain, avx2, avx512 };

// The best of those that this processor has.
[[nodiscard]] Vectors best_vectors();

// Lowers `best` of every lane as BackTrace::least does, for a source at a vertex.
void trace_lanes(const Triangulation& surface, std::span<const double> distance,
                 BackTrace::Takes takes, Vectors vectors, TraceLanes& lanes);

}  // namespace geodesic
