// The shortest path from one end of an unfolded strip to the other without leaving
// the strip: Lee and Preparata, "Euclidean shortest paths in the presence of
// rectilinear barriers", 1984, section 3, in time linear in the number of portals. The
// faces may overlap in the plane, as those of a surface do: each decision looks at
// nothing but the funnel, which never does.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/straighten/face_strip.h"

namespace geodesic {

// A vertex on one side of the strip, for as long as the portals go through it. A
// vertex that the strip comes back to later is another one.
struct StripVertex {
  Vec2 at;
  std::uint32_t vertex;
  std::size_t first_portal;  // the first and the last of the consecutive portals
  std::size_t last_portal;   // that end in it
};

class Funnel {
 public:
  // The vertices at which the shortest path touches the sides, in the order of the
  // path, without start and end. A vertex that the path passes exactly may or may
  // not be among them. Valid until the next call.
  [[nodiscard]] const std::vector<StripVertex>& touched(const UnfoldedStrip& strip);

  // After touched(): the vertex at the left or right end of a portal.
  [[nodiscard]] const StripVertex& left_of(std::size_t portal) const {
    return nodes_[left_node_[portal]];
  }
  [[nodiscard]] const StripVertex& right_of(std::size_t portal) const {
    return nodes_[right_node_[portal]];
  }

 private:
  void list_sides(const UnfoldedStrip& strip);
  void widen_left(std::uint32_t node);
  void widen_right(std::uint32_t node);

  std::vector<StripVertex> nodes_;  // the start, then as the portals bring them, then the end
  std::vector<std::uint32_t> parent_;
  std::vector<std::uint32_t> left_node_;  // per portal
  std::vector<std::uint32_t> right_node_;
  // The funnel: from deque_[first_], the left end of the portal, back to the apex,
  // and on to deque_[last_], the right end.
  std::vector<std::uint32_t> deque_;
  std::size_t first_ = 0;
  std::size_t apex_ = 0;
  std::size_t last_ = 0;
  std::vector<StripVertex> touched_;
};

}  // namespace geodesic
