// An edge as exact propagation knows it: its shape, and the windows on it. One edge is one
// cache line, for a front touches each of them a few times, at long intervals.
#pragma once

#include <cstdint>

#include "core/field/field.h"
#include "core/surface/adjacency.h"
#include "core/windows/window.h"

namespace geodesic::exact {

struct alignas(64) Edge {
  double length;  // mesh units
  std::uint32_t tail;
  std::uint32_t head;
  Halfedge first;   // one of its halfedges, the way from tail to head
  Halfedge second;  // the next one in the ring: itself on a boundary

  Window* windows = nullptr;
  std::uint32_t size = 0;
  std::uint32_t capacity : 31 = 0;
  std::uint32_t let_go : 1 = 0;     // windows were dropped, once bounded
  double pending = kUnreached;      // the least distance of a window not yet propagated
  double queued = kUnreached;       // the least key under which the edge waits
  double upper_bound = kUnreached;  // no place of the edge is farther than this

  [[nodiscard]] bool on_boundary() const { return first == second; }

  // As if nothing had arrived.
  void forget_arrivals() {
    windows = nullptr;
    size = capacity = let_go = 0;
    pending = queued = upper_bound = kUnreached;
  }
};

}  // namespace geodesic::exact
