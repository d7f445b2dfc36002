// What regions leave of a mesh.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/mesh/mesh.h"
#include "proto/region/file_faces.h"
#include "proto/region/region.h"

namespace geodesic::proto {

// By source face, 1 for those that the shapes of a region have, but for insides of lines. `within`
// has all if there is no region.
struct RegionFaces {
  std::vector<std::uint8_t> within;
  std::vector<std::uint8_t> forbid;
};

// Errors: index_out_of_range (a face, a part or a material that there is not), those of parts_meant
// and materials_meant, cancelled.
[[nodiscard]] Result<RegionFaces> faces_of_regions(const Mesh& whole, const Regions& regions,
                                                   const FileFaces& file, const Cancel& cancel);

// Why nothing is left of a surface.
[[nodiscard]] Error nothing_left(const Regions& regions);

// The mesh of the faces that are left by regions without lines (core/mesh/cut_mesh.h). Errors:
// those of faces_of_regions, and value_out_of_range (nothing is left).
[[nodiscard]] Result<Mesh> cut_regions(const Mesh& whole, const Regions& regions,
                                       const FileFaces& file, const Cancel& cancel);

// By source face, not 0 for those of a shape. Errors: those of faces_of_regions.
[[nodiscard]] Result<std::vector<std::uint8_t>> faces_of_shape(const Mesh& whole,
                                                               const Shape& shape,
                                                               const FileFaces& file,
                                                               const Cancel& cancel);

}  // namespace geodesic::proto
