// Warnings of points in space that the surface is far from: often in other units, or along other
// axes, than the mesh.
#pragma once

#include <string>
#include <vector>

#include "core/mesh/mesh.h"
#include "proto/replies/replies.h"
#include "proto/wire/point_request.h"

namespace geodesic::server {

// A point farther from the surface than this part of the diagonal of the mesh's box is far.
inline constexpr double kFarPart = 0.05;

// Appends to `warnings` a sentence for each parameter with points in space that are far and that
// were given without `max_snap`. `found` has the points of `asked`, in their order. Plain ASCII.
void warn_of_far_points(const Mesh& mesh, const std::vector<proto::PointRequest>& asked,
                        const std::vector<proto::ResolvedPoint>& found,
                        std::vector<std::string>& warnings);

}  // namespace geodesic::server
