// The wavefront of one source, apart from the queue it uses, so that queues can
// be measured against each other. `Queue` is an interface like VertexHeap's.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/tolerances.h"
#include "core/field/field.h"
#include "core/surface/adjacency.h"
#include "core/surface/unfold_rounding.h"
#include "core/wavefront/virtual_source.h"

namespace geodesic::detail {

// Tang et al. 2007, section 3.1. The paper's three groups of vertices are the
// queue's: fixed = accepted, computed = considered, unprocessed = far. `kArrive`
// gives a triangle's third vertex its distance from the other two.
template <class Queue, Arrival (*kArrive)(double, double, const UnfoldedApex&) = arrive>
class Wavefront {
 public:
  // `distance` and `parents` have an entry per vertex; they are kUnreached and
  // empty wherever this wave has not been, and so is the queue.
  Wavefront(const Adjacency& adjacency, Queue& queue, std::span<double> distance,
            std::span<Parents> parents)
      : adjacency_(adjacency),
        has_flat_faces_(adjacency.triangulation().has_flat_faces),
        queue_(queue),
        distance_(distance),
        parents_(parents) {}

  // Accepts the vertices in the same face as the source: along the edge from a
  // source at a vertex, straight across the face from any other. Straight lines
  // in space, they are the shortest ways there can be. Returns these vertices.
  std::vector<std::uint32_t> start(const Source& source, std::uint32_t number) {
    const Parents straight{kNone, number};
    if (source.point.at_vertex()) lower(source.point.vertex, source.offset, straight);
    for (const SurfacePoint& place : in_all_faces(adjacency_, source.point)) {
      for (std::uint32_t c = 0; c < 3; ++c) {
        lower(adjacency_.face(place.face).vertex[c],
              source.offset + distance_to_corner(adjacency_.mesh(), place, c), straight);
      }
    }
    std::vector<std::uint32_t> first_ring;
    while (!queue_.empty()) first_ring.push_back(queue_.pop().vertex);
    return first_ring;
  }

  // Step 2 of the paper's loop: every triangle at v with exactly two accepted
  // vertices gives its third a distance.
  void spread_from(std::uint32_t v) {
    if (adjacency_.is_pinched(v)) spread_along_edges(v);
    for (const std::uint32_t corner : adjacency_.corners(v)) {
      const std::uint32_t c = corner_of(corner);
      const FaceRecord& face = adjacency_.face(face_of(corner));
      const std::uint32_t ahead = face.vertex[next_corner(c)];
      const std::uint32_t behind = face.vertex[previous_corner(c)];
      if (has_flat_faces_ && is_lower_than(tolerance::kFlat, face)) {
        // Along its sides, of which one may be all that leads on.
        lower_along_edge(v, ahead);
        lower_along_edge(v, behind);
        // Of a needle's short side rounding has left nothing.
        const auto [shorter, longer] =
            std::minmax({face.length2(0), face.length2(1), face.length2(2)});
        if (!(shorter > tolerance::kWithoutArea * tolerance::kWithoutArea * longer)) continue;
      }
      const bool ahead_accepted = queue_.accepted(ahead);
      if (ahead_accepted == queue_.accepted(behind)) continue;
      if (ahead_accepted) {
        update(behind, v, ahead, face.apex_over(c));
      } else {
        update(ahead, behind, v, face.apex_over(previous_corner(c)));
      }
    }
  }

  // Inlined by force: GCC takes out calls of functions that do nothing but fetch.
  __attribute__((always_inline)) void expect(std::uint32_t vertex) const {
    for (const std::uint32_t corner : adjacency_.corners(vertex)) {
      __builtin_prefetch(&adjacency_.face(face_of(corner)));
    }
  }
  [[nodiscard]] double distance(std::uint32_t v) const { return distance_[v]; }
  [[nodiscard]] Parents parents(std::uint32_t v) const { return parents_[v]; }
  void forget(std::uint32_t v) {
    distance_[v] = kUnreached;
    parents_[v] = {};
  }

 private:
  // Where faces meet in nothing but the vertex v, no triangle beyond it has two
  // accepted vertices: there the paper's rule would leave the surface unreached,
  // and the front goes on along the edges, as from a new source.
  void spread_along_edges(std::uint32_t v) {
    for (const std::uint32_t corner : adjacency_.corners(v)) {
      const FaceRecord& face = adjacency_.face(face_of(corner));
      const std::uint32_t c = corner_of(corner);
      for (const std::uint32_t side : {c, previous_corner(c)}) {
        const std::uint32_t w = face.vertex[side == c ? next_corner(c) : side];
        if (queue_.accepted(w)) continue;
        lower(w, distance_[v] + std::sqrt(std::max(face.length2(side), 0.0)), {v, v});
      }
    }
  }

  void lower_along_edge(std::uint32_t v, std::uint32_t w) {
    if (queue_.accepted(w)) return;
    const auto positions = adjacency_.mesh().positions();
    lower(w, distance_[v] + geodesic::distance(positions[v], positions[w]), {v, v});
  }

  void update(std::uint32_t w, std::uint32_t p, std::uint32_t q, const UnfoldedApex& apex) {
    lower(w, kArrive(distance_[p], distance_[q], apex).distance, {p, q});
  }

  void lower(std::uint32_t v, double d, Parents parents) {
    if (!(d < distance_[v])) return;
    // Long before it is accepted: to find its faces, their list is waited for.
    if (distance_[v] == kUnreached) __builtin_prefetch(adjacency_.corners(v).data());
    distance_[v] = d;
    parents_[v] = parents;
    queue_.push_or_lower(v, d);
  }

  const Adjacency& adjacency_;
  const bool has_flat_faces_;
  Queue& queue_;
  std::span<double> distance_;
  std::span<Parents> parents_;
};

}  // namespace geodesic::detail
