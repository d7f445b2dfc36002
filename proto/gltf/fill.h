// Elements of accessors to positions and faces: the loops that run once per
// vertex and once per face. They check values (finite, in range), not bytes:
// `GltfElements` are proved to be present.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "core/base/vec3.h"
#include "proto/gltf/accessor.h"
#include "proto/gltf_file/transform.h"

namespace geodesic::proto {

using Face = std::array<std::uint32_t, 3>;

struct BadPosition {
  std::uint64_t element = 0;
  bool in_file = true;  // else it is the transform that made it infinite
};

struct BadIndex {
  std::uint64_t element = 0;
  std::uint64_t value = 0;
  bool is_restart = false;  // the largest value of its type
};

// Writes one position per element, converted and transformed; `out` has as many.
// Returns the first that is not finite, if any.
[[nodiscard]] std::optional<BadPosition> fill_positions(const GltfElements& elements,
                                                        const GltfTransform& to_world,
                                                        std::span<Vec3> out);
[[nodiscard]] std::optional<BadPosition> fill_positions(std::span<const Vec3> positions,
                                                        const GltfTransform& to_world,
                                                        std::span<Vec3> out);

// Writes the faces that a triangle mode makes of indices into `vertices`
// vertices, each index raised by `base`. Strips and fans are expanded as glTF
// 2.0, section 3.7.2.1, orders their corners; degenerate faces are kept, so that
// face k of a strip starts at its corner k. `out` is as long as the mode makes
// of the elements. Returns the first index out of range, if any.
[[nodiscard]] std::optional<BadIndex> fill_faces(const GltfElements& indices, int mode,
                                                 std::uint32_t base, std::uint64_t vertices,
                                                 std::span<Face> out);

// The same for a primitive without indices: its vertices in order.
void fill_faces(int mode, std::uint32_t base, std::span<Face> out);

}  // namespace geodesic::proto
