// What regions leave of a mesh.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/mesh/mesh.h"
#include "proto/region/region.h"

namespace geodesic::proto {

// The first face of a part of the file, and how many it has.
using PartFaces = std::pair<std::uint64_t, std::uint64_t>;

// By source face, 1 for those that the shapes of a region have, but for insides of lines. `within`
// has all if there is no region.
struct RegionFaces {
  std::vector<std::uint8_t> within;
  std::vector<std::uint8_t> forbid;
};

// Errors: index_out_of_range (a face or a part that there is not), cancelled.
[[nodiscard]] Result<RegionFaces> faces_of_regions(const Mesh& whole, const Regions& regions,
                                                   std::span<const PartFaces> parts,
                                                   const Cancel& cancel);

// Why nothing is left of a surface.
[[nodiscard]] Error nothing_left(const Regions& regions);

// The mesh of the faces that are left by regions without lines (core/mesh/cut_mesh.h). `parts`: by
// their numbers. Errors: index_out_of_range (a face or a part that there is not),
// value_out_of_range (nothing is left), cancelled.
[[nodiscard]] Result<Mesh> cut_regions(const Mesh& whole, const Regions& regions,
                                       std::span<const PartFaces> parts, const Cancel& cancel);

// By source face, not 0 for those of a shape. Errors: index_out_of_range, cancelled.
[[nodiscard]] Result<std::vector<std::uint8_t>> faces_of_shape(const Mesh& whole,
                                                               const Shape& shape,
                                                               std::span<const PartFaces> parts,
                                                               const Cancel& cancel);

}  // namespace geodesic::proto
