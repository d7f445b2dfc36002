// The weights of a mesh's faces.
#pragma once

#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/mesh/mesh.h"
#include "proto/region/costs.h"
#include "proto/region/cut_regions.h"

namespace geodesic::proto {

// By face of `mesh`, 1 where nothing else is said; empty if that is everywhere. `whole`: the mesh
// of the file, by whose faces shapes are; what regions have left of it, or lines have split, may be
// `mesh`. `parts`: by their numbers. Asks the budget for 16 bytes a face. Errors:
// index_out_of_range (a face or a part that there is not), value_out_of_range (not as many weights
// as faces), cancelled.
[[nodiscard]] Result<std::vector<double>> weigh_faces(const Mesh& mesh, const Mesh& whole,
                                                      const Costs& costs,
                                                      std::span<const PartFaces> parts,
                                                      const Cancel& cancel);

}  // namespace geodesic::proto
