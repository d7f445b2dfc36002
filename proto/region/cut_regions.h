// What regions leave of a mesh.
#pragma once

#include <cstdint>
#include <span>
#include <utility>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/mesh/mesh.h"
#include "proto/region/region.h"

namespace geodesic::proto {

// The first face of a part of the file, and how many it has.
using PartFaces = std::pair<std::uint64_t, std::uint64_t>;

// The mesh of the faces that are left (core/mesh/cut_mesh.h). `parts`: by their numbers. Errors:
// index_out_of_range (a face or a part that there is not), value_out_of_range (nothing is left),
// cancelled.
[[nodiscard]] Result<Mesh> cut_regions(const Mesh& whole, const Regions& regions,
                                       std::span<const PartFaces> parts, const Cancel& cancel);

}  // namespace geodesic::proto
