// The front of back_traced/wavefront.h: what one source's wave knows and does.
//
// It goes in rounds. The considered vertices with the least estimates, all within a small
// part of an edge, are accepted together: first they all get their distances, none of
// which depends on another, then they all give their neighbours estimates. So what needs
// arithmetic is done in lanes, and what lies apart in memory is fetched ahead.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/back_traced/scratch.h"
#include "core/back_traced/trace.h"
#include "core/back_traced/trace_lanes.h"
#include "core/base/cancel.h"
#include "core/base/vectors.h"
#include "core/field/field.h"
#include "core/surface/adjacency.h"
#include "core/surface/triangulation.h"
#include "core/wavefront/waves.h"

namespace geodesic {

class BackTracedFront {
 public:
  // Each step leaves off, with nothing whole, when the poll says to stop. `distance` has an entry
  // per vertex, as have the scratch's vertices; they are
  // kUnreached and as constructed wherever this wave has not been.
  BackTracedFront(const Adjacency& adjacency, BackTrace::Candidates candidates,
                  BackTracedScratch& scratch, std::span<double> distance, Poll& poll)
      : adjacency_(adjacency),
        candidates_(candidates),
        scratch_(scratch),
        distance_(distance),
        poll_(poll) {}

  // Considers the vertices in the same face as the source, straight from there, and
  // those that a look around from the source finds visible from it, as far as no other source is
  // nearer.
  void start(const SurfacePoint& source, const detail::Worthwhile& worthwhile);

  // Accepts the next vertices: they get their distances. False, and none, when there are
  // no more, or only such as are farther than `last` and by more than `lag`.
  [[nodiscard]] bool accept_next(double last);
  // Those that were accepted last, ascending; whoever is taken out spreads no further.
  // Among them are some for the second time: those whose estimate was found to be too
  // large just after they had been accepted.
  [[nodiscard]] std::vector<std::uint32_t>& accepted() { return scratch_.round; }
  // Every triangle at those with two accepted vertices gives its third, the farthest, an
  // estimate.
  void spread();
  // Whether one that was accepted may be accepted again.
  [[nodiscard]] bool may_improve() const { return scratch_.waiting.has_more_now(); }

  // By how much a vertex may come after others that are farther.
  [[nodiscard]] double lag();
  [[nodiscard]] double distance(std::uint32_t vertex) const { return distance_[vertex]; }
  // The vertex is as if the wave had not come there.
  void forget(std::uint32_t vertex);
  // The same for all that were not accepted.
  void end();

 private:
  void see(std::uint32_t vertex, double straight);
  void lower(std::uint32_t vertex, double estimate, Halfedge base, float crossing);
  [[nodiscard]] std::size_t list_corners();
  void spread_along_edges(std::uint32_t vertex);
  void take_round();
  [[nodiscard]] bool is_early(std::uint32_t vertex, double least) const;
  void trace_round();
  void ask_other_faces();
  [[nodiscard]] bool is_doubtful(std::uint32_t vertex, double best) const;
  void trace(std::uint32_t place, Halfedge base, double crossing, double best);
  void trace(std::uint32_t place, const TraceStart& start, double best);
  void trace_past_vertex(std::uint32_t place, std::uint32_t bend);
  void flush_traces();
  // The estimates over the first `count` of the scratch's bases, told by their place.
  template <class Tell>
  void arrive_over_bases(std::size_t count, Tell tell);
  [[nodiscard]] std::uint32_t opposite(Halfedge h) const {
    return surface_.faces[face_of(h)].vertex[previous_corner(corner_of(h))];
  }

  const Adjacency& adjacency_;
  BackTrace::Candidates candidates_;
  BackTracedScratch& scratch_;
  std::span<double> distance_;
  Poll& poll_;
  Triangulation surface_;    // what this wave goes over
  double lag_ = kUnreached;  // until it was asked for
  double least_gain_ = 0;    // that makes an accepted vertex wait again
  int rounds_in_bucket_ = 0;
  Vectors vectors_ = best_vectors();
  // Traces that wait for company, and their places in the round.
  TraceLanes traces_;
  std::array<std::uint32_t, TraceLanes::kLanes> traced_{};
};

}  // namespace geodesic
