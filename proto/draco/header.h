// What a Draco bitstream claims about itself, read before the library sees it.
// libdraco allocates by these claims: 63 bytes made it ask for 20 GB.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/error.h"

namespace geodesic::proto {

struct DracoLimits {
  std::uint64_t max_vertices = 0;
  std::uint64_t max_faces = 0;
};

struct DracoClaims {
  std::uint64_t faces = 0;
  std::uint64_t points = 0;  // a lower bound: seams of attributes may split more
};

// Do the bytes start as a Draco bitstream?
[[nodiscard]] bool is_draco(std::span<const std::byte> bytes);

// Reads the header of a mesh, steps over its metadata, and checks the counts
// that follow against each other, the bytes present and the limits.
// Errors: mesh_invalid, no_triangles (a point cloud, or no faces),
// too_many_vertices, too_many_faces.
[[nodiscard]] Result<DracoClaims> check_draco_claims(std::span<const std::byte> bytes,
                                                     const DracoLimits& limits);

}  // namespace geodesic::proto
