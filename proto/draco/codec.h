// Draco bitstreams to triangles and back, in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/base/error.h"
#include "core/mesh/triangle_soup.h"
#include "proto/draco/header.h"

namespace geodesic::proto {

// Which attribute of a bitstream, as KHR_draco_mesh_compression says it.
struct DracoAttribute {
  std::uint32_t unique_id = 0;
  bool normalized = false;  // integers stand for [0, 1] or [-1, 1]
};

// Vertices are Draco's points in decoded order. Without `position`, the
// attribute is the first one of that type.
// Errors: those of `check_draco_claims`, and mesh_invalid naming the point,
// index_out_of_range, too_large when memory runs out.
[[nodiscard]] Result<TriangleSoup> decode_draco(std::span<const std::byte> bytes,
                                                const DracoLimits& limits,
                                                std::optional<DracoAttribute> position = {});

// What an attribute of one component has for each of these vertices, in the same order. They may be
// no numbers.
// Errors: those of `check_draco_claims`; mesh_invalid where the data is damaged, or where there is
// no such attribute, or one of several components; too_large when memory runs out.
[[nodiscard]] Result<std::vector<double>> decode_draco_numbers(std::span<const std::byte> bytes,
                                                               const DracoLimits& limits,
                                                               DracoAttribute attribute);

}  // namespace geodesic::proto
