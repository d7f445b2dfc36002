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
  PartTrace(const FrontState& front, std::span<const std::uint32_t> vertices,
            std::span<double> best, FrontRoom& room, Poll& poll)
      : front_(front),
        surface_(front.surface),
        distance_(front.distance),
        part_(vertices),
        best_(best),
        room_(room),
        poll_(poll) {}

  // Over the bases that the front knows.
  void trace_known();
  // A distance above what the front expected needs a second look: every other face whose
  // ends promise a shorter way is asked.
  void ask_other_faces();

 private:
  [[nodiscard]] bool is_doubtful(std::uint32_t vertex, double best) const;
  void trace_past_vertex(std::uint32_t place, std::uint32_t bend);

  // Adds a trace for the vertex at `place` of the part. It ends early where it cannot be less than
  // `best`. The caller gives `best`, because the part's own value depends on which other traces of
  // the vertex are done.
  void trace(std::uint32_t place, Halfedge base, double crossing, double best) {
    traced_[traces_.add(base, crossing, best)] = place;
    if (traces_.full()) flush();
  }
  void trace(std::uint32_t place, const TraceStart& start, double best) {
    traced_[traces_.add(start, best)] = place;
    if (traces_.full()) flush();
  }
  void flush();

  const FrontState& front_;
  const Triangulation& surface_;
  const std::span<const double> distance_;
  const std::span<const std::uint32_t> part_;
  const std::span<double> best_;
  FrontRoom& room_;
  Poll& poll_;
  // Traces that wait for company, and their places in the part.
  TraceLanes traces_;
  std::array<std::uint32_t, TraceLanes::kLanes> traced_{};
};

}  // namespace geodesic
