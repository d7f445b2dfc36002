// Welding within a tolerance: vertices near one another are moved to one place,
// where `Mesh::build` makes one vertex of them.
#pragma once

#include <cstdint>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/mesh/triangle_soup.h"

namespace geodesic {

// Goes through the vertices in order: each moves onto the nearest earlier vertex
// that has stayed and is at most `tolerance` away, or stays where it is. So nothing
// moves farther than the tolerance, however many vertices lie in a row, and those
// that stayed are farther apart than it. `tolerance` is in mesh units and from
// Mesh::kMinCoordinate to Mesh::kMaxCoordinate. Takes time n log n, whatever the
// coordinates. Returns how many moved, not counting those in the same place already.
// Errors: cancelled.
[[nodiscard]] Result<std::uint64_t> weld_within(TriangleSoup& soup, double tolerance,
                                                const Cancel& cancel = {});

}  // namespace geodesic
