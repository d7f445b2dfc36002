// Faults in what a glTF file says of its data, beyond those that reading it would
// come upon.
#pragma once

#include <cstdint>

#include "core/base/error.h"
#include "proto/gltf/accessor.h"
#include "proto/gltf_file/buffers.h"
#include "proto/gltf_file/document.h"
#include "proto/mesh/decoded_mesh.h"

namespace geodesic::proto {

// Whether elements have about the `min` and `max` that their accessor says, if it
// does: rounding in the last digits is common, but bounds that are off by more than a
// hundredth of the whole are those of other data. Errors: mesh_invalid.
[[nodiscard]] Result<void> check_bounds(const GltfDocument& document, std::size_t accessor,
                                        const GltfElements& elements);

// For a file in which nothing is drawn: the first fault among all its views, accessors,
// scenes and primitives, which may be why. What is in other files or encoded by extensions is
// passed over, and so are elements beyond as many as the largest mesh has within the limits.
// Errors: those of `read_accessor`, index_out_of_range.
[[nodiscard]] Result<void> find_fault(const GltfDocument& document, GltfBuffers& buffers,
                                      std::uint64_t file_bytes, const DecodeLimits& limits);

}  // namespace geodesic::proto
