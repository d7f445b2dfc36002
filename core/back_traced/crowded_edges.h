// The edges that many faces share: copies of a face, or the pages of a book. A trace that crosses
// such an edge goes on in the face whose apex is nearest to the source. Asking all faces at each
// crossing would take the square of their number. So each edge keeps its two nearest apexes: one
// of them may be of the face that the trace comes from.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/base/cancel.h"
#include "core/field/field.h"
#include "core/surface/triangulation.h"

namespace geodesic {

class CrowdedEdges {
 public:
  // Numbers the edges in more than kCrowd faces. Keeps nothing if there are none. Stops early when
  // the poll says to stop.
  void reset(const Triangulation& surface, Poll& poll) {
    number_.clear();
    nearest_.clear();
    if (!surface.is_crowded) return;
    number_.assign(4 * surface.faces.size(), kNone);
    for (std::uint32_t f = 0; f < surface.faces.size() && !poll.cancelled(); ++f) {
      for (std::uint32_t c = 0; c < 3; ++c) number_ring(surface, halfedge(f, c), poll);
    }
  }

  // To be called when a vertex gets its first distance, or a smaller one. Updates the sides
  // opposite it.
  void tell(const Triangulation& surface, std::uint32_t vertex, double distance) {
    if (number_.empty()) return;
    for (const std::uint32_t corner : surface.corners(vertex)) {
      const Halfedge side = halfedge(face_of(corner), next_corner(corner_of(corner)));
      const std::uint32_t number = number_[side];
      if (number == kNone) continue;
      auto& [first, second] = nearest_[number];
      if (side == first.side || distance < first.distance) {
        if (side != first.side) second = first;
        first = {side, distance};
      } else if (side == second.side || distance < second.distance) {
        second = {side, distance};
      }
    }
  }

  // Of the other faces on this edge, the one whose apex has the least distance. kNone if the edge
  // is not crowded, or if no apex of another face has a distance.
  [[nodiscard]] Halfedge nearest_beyond(Halfedge edge) const {
    if (number_.empty() || number_[edge] == kNone) return kNone;
    const auto& [first, second] = nearest_[number_[edge]];
    return first.side != edge ? first.side : second.side;
  }

 private:
  struct Apex {
    Halfedge side = kNone;
    double distance = kUnreached;
  };

  void number_ring(const Triangulation& surface, Halfedge h, Poll& poll) {
    if (number_[h] != kNone) return;
    std::size_t faces = 1;
    for (Halfedge g = surface.ring(h); g != h && faces <= Triangulation::kCrowd; ++faces) {
      g = surface.ring(g);
    }
    if (faces <= Triangulation::kCrowd) return;
    const auto number = static_cast<std::uint32_t>(nearest_.size());
    nearest_.emplace_back();
    number_[h] = number;
    for (Halfedge g = surface.ring(h); g != h && !poll.cancelled(); g = surface.ring(g)) {
      number_[g] = number;
    }
  }

  std::vector<std::uint32_t> number_;  // of each halfedge's edge; kNone if not crowded
  std::vector<std::array<Apex, 2>> nearest_;
};

}  // namespace geodesic
