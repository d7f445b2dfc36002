// Triangles to the bytes of a mesh file: what the sample meshes and the tests
// are made with.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/mesh/triangle_soup.h"

namespace geodesic::proto {

// A GLB with one node, one mesh and one primitive: float32 positions and uint32
// indices, as glTF 2.0 stores them. Indices must be in range. Without faces, a
// valid file that draws nothing.
[[nodiscard]] std::vector<std::byte> encode_glb(const TriangleSoup& soup, const std::string& name);

// A Draco bitstream (edgebreaker); `position_bits` 0 keeps float32 positions
// exactly, else they are quantised to so many bits (1 to 30). Draco orders
// vertices and faces anew, splits vertices that are not manifold, and drops
// degenerate faces and vertices without a face.
// Errors: value_out_of_range (bits), index_out_of_range, no_triangles,
// too_many_vertices, unsupported (Draco refuses), too_large (memory).
[[nodiscard]] Result<std::vector<std::byte>> encode_drc(const TriangleSoup& soup,
                                                        int position_bits);

}  // namespace geodesic::proto
