// The weights of a mesh's faces.
#pragma once

#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/mesh/mesh.h"
#include "proto/region/costs.h"
#include "proto/region/cut_regions.h"

namespace geodesic::proto {

// By face of `mesh`, 1 where nothing else is said; empty if that is everywhere. `whole`: the mesh
// of the file, by whose faces shapes are; what regions have left of it, or lines have split, may be
// `mesh`.  Asks the budget for 16 bytes a face. Errors:
// those of faces_of_regions, and value_out_of_range (not as many weights as faces).
[[nodiscard]] Result<std::vector<double>> weigh_faces(const Mesh& mesh, const Mesh& whole,
                                                      const Costs& costs, const FileFaces& file,
                                                      const Cancel& cancel);

}  // namespace geodesic::proto
