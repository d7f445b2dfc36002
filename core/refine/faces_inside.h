// What a closed line has inside.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// By face, 1 for those inside a closed chain of edges and 0 for the others. The chain divides the
// faces that edges join into parts. The one with the largest area of those that touch the chain
// is outside, the others are inside: of a line that crosses itself all its loops. Of two as large,
// the one with the face of the least number in the file is inside.
// Errors: value_out_of_range (the line does not separate the surface), cancelled.
[[nodiscard]] Result<std::vector<std::uint8_t>> faces_inside(const Adjacency& adjacency,
                                                             std::span<const std::uint32_t> chain,
                                                             const Cancel& cancel);

}  // namespace geodesic
