// Nothing is nearer over the surface than straight through space.
#pragma once

#include <cstdint>
#include <span>

#include "core/cancel.h"
#include "core/field.h"
#include "core/mesh.h"

namespace geodesic {

// Raises to the straight line in space what is below that from its source, of these vertices.
// Whether any was, by more than rounding (1e-9): then it is not what it was taken for, and nor may
// be what was computed from it. Leaves off when the poll says to stop.
bool raise_to_straight_lines(const Mesh& mesh, std::span<const std::uint32_t> vertices,
                             Field& field, Poll& poll);
// The same, of all vertices.
bool raise_to_straight_lines(const Mesh& mesh, Field& field, Poll& poll);

}  // namespace geodesic
