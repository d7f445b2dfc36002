// What a front does with some of the vertices that it accepts together: computes their distances,
// and then estimates of their neighbours'. Several threads may do so at once, each with vertices of
// its own: what is read here no thread changes meanwhile.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/back_traced/arrive_lanes.h"
#include "core/back_traced/scratch.h"
#include "core/back_traced/trace.h"
#include "core/base/cancel.h"
#include "core/base/vectors.h"
#include "core/surface/triangulation.h"

namespace geodesic {

// A front between two of its steps.
struct FrontState {
  const Triangulation& surface;
  FrontDistances distances;
  std::span<const FrontVertex> vertices;  // by slot
  std::span<const Source> sources;
  const CrowdedEdges& crowds;
  BackTrace::Rule rule;
  Vectors vectors;
};

// The distances of the vertices at these slots, in `best`: by traces over the bases that the front
// knows, and where those are longer than the front expected, over every other face whose ends
// promise a shorter way. Incomplete if the poll says to stop.
void trace_back(const FrontState& front, std::span<const Slot> slots, std::span<double> best,
                FrontRoom& room, Poll& poll);

// Lists in `room.bases` what has an estimate for its opposite vertex: the base of every triangle at
// the vertices of these slots that has two accepted ones from the slot's source, of which this
// one is the nearer, opposite its farthest vertex. Returns how many; behind them is what nobody
// asked for.
[[nodiscard]] std::size_t list_bases(const FrontState& front, std::span<const Slot> slots,
                                     FrontRoom& room);

// The estimates over the first `count` of the room's bases: `tell(at, distance, crossing)` of
// each. Not of all if the poll says to stop.
template <class Tell>
void arrive_over_bases(const FrontState& front, std::size_t count, FrontRoom& room, Poll& poll,
                       Tell tell) {
  if (count == 0) return;
  constexpr std::size_t kLanes = ArrivalLanes::kLanes;
  std::vector<Halfedge>& bases = room.bases;
  // Lanes without one of their own do the same as the first, with nobody to see it.
  const auto fill_up = [count](std::vector<std::uint32_t>& of_each) {
    of_each.resize((count + kLanes - 1) / kLanes * kLanes, of_each[0]);
    std::fill(of_each.begin() + static_cast<std::ptrdiff_t>(count), of_each.end(), of_each[0]);
  };
  fill_up(bases);
  const std::uint32_t* sources = nullptr;
  if (front.distances.has_several_sources()) {
    fill_up(room.sources_of_bases);
    sources = room.sources_of_bases.data();
  }
  ArrivalLanes arrivals;
  for (std::size_t first = 0; first < count; first += kLanes) {
    if (poll.cancelled()) return;
    arrive_lanes(front.surface.faces, front.distances,
                 std::span<const Halfedge, kLanes>(bases.data() + first, kLanes),
                 sources == nullptr ? nullptr : sources + first, front.vectors, arrivals);
    for (std::size_t i = 0; i < kLanes && first + i < count; ++i) {
      tell(first + i, arrivals.distance[i], arrivals.crossing[i]);
    }
  }
}

// The vertex that the halfedge's face has besides the halfedge's ends.
[[nodiscard]] inline std::uint32_t opposite(const Triangulation& surface, Halfedge h) {
  return surface.faces[face_of(h)].vertex[previous_corner(corner_of(h))];
}

}  // namespace geodesic
