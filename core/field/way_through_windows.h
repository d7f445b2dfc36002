// From the windows on a face's sides to a point of the face: the last step of
// Mitchell, Mount and Papadimitriou 1987, and the first of a trace back.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/field/field.h"
#include "core/field/window_table.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"

namespace geodesic {

// The shortest way to a point of a face through the window of a side.
struct WayThroughWindow {
  double distance = kUnreached;             // mesh units; kUnreached where the face has no window
  std::uint32_t corner = 0;                 // the side starts at this corner of the face
  double crossing = 0;                      // where on it: 0 at that corner, 1 at the next
  const VisibleInterval* window = nullptr;  // valid while the table is
};

// `place` lies in `place.face`; sides that it lies on are passed over. Each
// window's way is a real path even for a point that its source does not see: then it bends at
// the window's end.
[[nodiscard]] WayThroughWindow shortest_way_through_windows(const Adjacency& adjacency,
                                                            const WindowTable& windows,
                                                            const SurfacePoint& place);

// The same for a place in a face of any triangulation, whose table it is.
[[nodiscard]] WayThroughWindow shortest_way_through_windows(std::span<const FaceRecord> faces,
                                                            const WindowTable& windows,
                                                            std::uint32_t face,
                                                            const std::array<double, 3>& weights);

}  // namespace geodesic
