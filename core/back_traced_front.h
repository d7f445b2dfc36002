// The front of back_traced_wavefront.h: what one source's wave knows and does.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/adjacency.h"
#include "core/back_trace.h"
#include "core/back_trace_lanes.h"
#include "core/back_traced_scratch.h"
#include "core/field.h"
#include "core/triangulation.h"

namespace geodesic {

class BackTracedFront {
 public:
  // `distance` has an entry per vertex, as have the scratch's arrays; they are
  // kUnreached and kNone wherever this wave has not been, and the heap is empty.
  BackTracedFront(const Adjacency& adjacency, BackTrace::Takes takes, BackTracedScratch& scratch,
                  std::span<double> distance)
      : adjacency_(adjacency), takes_(takes), scratch_(scratch), distance_(distance) {}

  // Considers the vertices in the same face as the source, straight from there, and
  // looks around from the source for those in sight of it.
  // Returns none: they are accepted with the others.
  std::vector<std::uint32_t> start(const Source& source, std::uint32_t number);

  // By how much a vertex may come after others that are farther.
  [[nodiscard]] double lag() const;

  // The vertex is likely to be the next. (Inlined by force: GCC takes out calls of
  // functions that do nothing but fetch.)
  __attribute__((always_inline)) void expect(std::uint32_t vertex) const {
    for (const std::uint32_t corner : surface_.corners(vertex)) {
      __builtin_prefetch(&surface_.faces[face_of(corner)]);
    }
  }
  // The vertex has been taken from the heap. It gets its distance with the next few.
  void accept(std::uint32_t vertex);
  // Every triangle at an accepted vertex with exactly two accepted ones gives its third
  // an estimate.
  void spread_from(std::uint32_t vertex);
  // All accepted vertices get their distances.
  void settle();
  // The vertex is as if the wave had not come there.
  void forget(std::uint32_t vertex);
  // The same for what was in sight and not accepted, and for the source's place.
  void end();

  [[nodiscard]] Parents parents(std::uint32_t /*vertex*/) const { return {}; }
  [[nodiscard]] double estimate(std::uint32_t vertex) const { return scratch_.estimate[vertex]; }
  [[nodiscard]] double distance(std::uint32_t vertex) const { return distance_[vertex]; }

 private:
  // So many vertices are traced back together.
  static constexpr std::size_t kTogether = TraceLanes::kLanes;

  void lower(std::uint32_t vertex, double estimate, Halfedge base);
  void see(std::uint32_t vertex, double straight);
  void spread_along_edges(std::uint32_t vertex);
  [[nodiscard]] double seen_by(std::uint32_t v, std::uint32_t other, double base2);
  [[nodiscard]] bool is_pending(std::uint32_t vertex) const;
  [[nodiscard]] double begin_trace(std::uint32_t vertex, TraceLanes& lanes) const;
  [[nodiscard]] double doubted(std::uint32_t vertex, double best) const;
  [[nodiscard]] double round_a_vertex(std::uint32_t vertex, std::uint32_t bend, double best) const;
  [[nodiscard]] double over_other_faces(std::uint32_t vertex, Halfedge base, double best) const;

  const Adjacency& adjacency_;
  BackTrace::Takes takes_;
  BackTracedScratch& scratch_;
  std::span<double> distance_;
  Triangulation surface_;                // what this wave goes over
  std::vector<std::uint32_t> stops_;     // the faces with the source in them, ascending
  std::vector<std::uint32_t> in_sight_;  // those that have a distance from `see`
  std::array<std::uint32_t, kTogether> pending_{};
  std::size_t pending_count_ = 0;
  Vectors vectors_ = best_vectors();
  TraceLanes lanes_;
};

}  // namespace geodesic
