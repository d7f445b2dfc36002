// A surface cut along isolines: what lies between two levels, as triangles. Inside faces the field
// is taken as linear, as for isolines (isolines.h), and cuts run where these do.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/base/vec3.h"
#include "core/field/field.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// The surface at least as far as `begin` and no farther than `end`. Within a strip, faces share
// their vertices; strips have none in common, but equal ones where they meet.
struct Strip {
  double begin = 0;  // mesh units
  double end = 0;
  double area = 0;  // of its faces
  std::vector<Vec3> positions;
  std::vector<std::array<std::uint32_t, 3>> faces;  // wound as those that they are cut from
};

// At most so many triangles and vertices have all strips together, where isolines at their levels
// cross faces `crossings` times.
[[nodiscard]] constexpr std::uint64_t most_faces_of_strips(std::uint64_t faces,
                                                           std::uint64_t crossings) {
  return faces + 2 * crossings;
}
[[nodiscard]] constexpr std::uint64_t most_vertices_of_strips(std::uint64_t vertices,
                                                              std::uint64_t crossings) {
  return 2 * vertices + 4 * crossings;
}

// The strips from each level to the next: one fewer than `levels`, which must ascend, each once.
// A face that is level, with all its corners at one, is in the strip below it; at the first level,
// in the one above. Faces with an unreached vertex are in no strip, nor is what is beyond the
// levels. O(f log l + s log s) for f faces, l levels and s triangles. Errors: cancelled.
[[nodiscard]] Result<std::vector<Strip>> cut_strips(const Adjacency& adjacency, const Field& field,
                                                    std::span<const double> levels,
                                                    const Cancel& cancel);

}  // namespace geodesic
