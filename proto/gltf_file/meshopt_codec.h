// Buffer views compressed by meshoptimizer, as EXT_meshopt_compression and
// KHR_meshopt_compression have them, to plain bytes, in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/error.h"

namespace geodesic::proto {

enum class MeshoptMode : std::uint8_t { attributes, triangles, indices };
enum class MeshoptFilter : std::uint8_t { none, octahedral, quaternion, exponential, colour };

// `count` elements of `stride` bytes each once decoded.
struct MeshoptLayout {
  std::uint64_t count = 0;
  std::uint64_t stride = 0;
  MeshoptMode mode = MeshoptMode::attributes;
  MeshoptFilter filter = MeshoptFilter::none;
};

// Whether the bytes are of a codec and version that this decoder has, by their
// first byte; what else is wrong with them `decode_meshopt` tells.
[[nodiscard]] bool is_known_meshopt(std::span<const std::byte> bytes, const MeshoptLayout& layout);

// `count * stride` bytes. `name` is what messages call the data, such as
// "bufferView 3". `max_bytes`: how many may be made of them.
// Errors: mesh_invalid (a layout that the extension does not allow, more than so
// many bytes can stand for, or data that does not decode), extension_required (a
// newer codec, or the filter for colours), too_large.
[[nodiscard]] Result<std::vector<std::byte>> decode_meshopt(std::span<const std::byte> bytes,
                                                            const MeshoptLayout& layout,
                                                            std::uint64_t max_bytes,
                                                            const std::string& name);

}  // namespace geodesic::proto
