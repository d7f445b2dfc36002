// The windows that an exact field leaves on the edges: what paths and points
// inside faces are answered from. Mitchell, Mount and Papadimitriou 1987.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/adjacency.h"

namespace geodesic {

// An interval of a halfedge's edge that is lit straight from one unfolded source,
// through the faces on the other side: it lights the halfedge's own face.
//
// The frame: the edge lies on the x axis, vertex[c] of the halfedge 4f + c at 0 and
// vertex[c + 1] at the edge's length L; face f is above, the source at or below.
struct LitWindow {
  double begin;  // 0 <= begin < end <= L, mesh units
  double end;
  double x;              // the unfolded source, mesh units
  double y;              // its depth below the axis, not negative
  double offset;         // its own distance
  std::uint32_t root;    // the pseudo-source, a vertex; kNone: the source itself
  std::uint32_t source;  // the number of the source at the root of it all
};

class WindowTable {
 public:
  // Any order; sorted here by halfedge and then by `begin`.
  WindowTable(std::size_t face_count, std::vector<std::pair<Halfedge, LitWindow>> windows);

  // The windows through which light enters a halfedge's face.
  [[nodiscard]] std::span<const LitWindow> into(Halfedge h) const {
    return {windows_.data() + begin_[h], begin_[h + 1] - begin_[h]};
  }
  [[nodiscard]] std::size_t size() const { return windows_.size(); }
  [[nodiscard]] std::size_t bytes() const;

 private:
  std::vector<std::uint64_t> begin_;  // 4 * face_count + 1, by halfedge
  std::vector<LitWindow> windows_;
};

}  // namespace geodesic
