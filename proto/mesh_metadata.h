// What is known of a stored mesh, and its JSON: made once at upload, kept beside
// the bytes, and completed with what changes (`state`, `prepared`) when asked for.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/adjacency.h"
#include "core/error.h"
#include "core/mesh.h"
#include "proto/decode_mesh.h"

namespace geodesic::proto {

// The part that never changes, as a JSON object.
[[nodiscard]] std::string describe_mesh(std::string_view id, std::uint64_t bytes,
                                        const DecodedMesh& decoded, const Mesh& mesh,
                                        const TopologyReport& topology);

// That object with `state` and `prepared` added. Errors: store_corrupt.
[[nodiscard]] Result<std::string> with_state(const std::string& description, bool resident,
                                             bool prepared);

}  // namespace geodesic::proto
