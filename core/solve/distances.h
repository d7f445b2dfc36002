// The distances of a mesh's vertices from one of them, in one call.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/error.h"
#include "core/field/method.h"
#include "core/mesh/mesh.h"

namespace geodesic {

// The geodesic distance of each source vertex of the mesh (mesh.h) from the source vertex
// `vertex`, in mesh units: one number for each of mesh.source_vertex_count(), in the order of the
// file. kUnreached where no way leads. `Method::exact` by default; `Method::back_traced` is ten
// times as fast and some 0.01 % off on scans.
//
// Prepares the mesh each time. For a second question of the same mesh keep an Adjacency and a
// SolveScratch, and call solve_field, which can be cancelled too.
//
// Errors: index_out_of_range.
[[nodiscard]] Result<std::vector<double>> distances(const Mesh& mesh, std::uint32_t vertex,
                                                    Method method = Method::exact);

}  // namespace geodesic
