// The traces of some vertices of a round, which is what trace_back() of front_part.h does.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/back_traced/front_part.h"
#include "core/back_traced/trace_lanes.h"

namespace geodesic {

class PartTrace {
 public:
  PartTrace(const FrontState& front, std::span<const Slot> slots, std::span<double> best,
            FrontRoom& room, Poll& poll)
      : front_(front),
        surface_(front.surface),
        distances_(front.distances),
        part_(slots),
        best_(best),
        room_(room),
        poll_(poll) {}

  // Over the bases that the front knows.
  void trace_known();
  // A distance above what the front expected needs a second look: every other face whose
  // ends promise a shorter way is asked.
  void ask_other_faces();
  // If it is above that all the same: the ways to its neighbours, continued straight past them.
  void ask_neighbours();

 private:
  [[nodiscard]] bool is_doubtful(Slot slot, double best) const;
  void trace_past_vertex(std::uint32_t place, std::uint32_t bend);
  [[nodiscard]] std::uint32_t vertex(std::uint32_t place) const {
    return distances_.vertex_of(part_[place]);
  }
  [[nodiscard]] std::uint32_t source(std::uint32_t place) const {
    return distances_.source_of(part_[place]);
  }

  // Adds a trace for the vertex at `place` of the part. It ends early where it cannot be less than
  // `best`. The caller gives `best`, because the part's own value depends on which other traces of
  // the vertex are done.
  void trace(std::uint32_t place, Halfedge base, double crossing, double best) {
    traced_[traces_.add(base, crossing, best, source(place))] = place;
    if (traces_.full()) flush();
  }
  void trace(std::uint32_t place, const TraceStart& start, double best) {
    traced_[traces_.add(start, best, source(place))] = place;
    if (traces_.full()) flush();
  }
  void flush();

  const FrontState& front_;
  const Triangulation& surface_;
  const FrontDistances distances_;
  const std::span<const Slot> part_;
  const std::span<double> best_;
  FrontRoom& room_;
  Poll& poll_;
  // Traces that wait for company, and their places in the part.
  TraceLanes traces_;
  std::array<std::uint32_t, TraceLanes::kLanes> traced_{};
};

}  // namespace geodesic
