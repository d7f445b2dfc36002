// The outer shape of a glTF file, looked at before any parser sees a byte: the
// header and chunks of a GLB, and how deep and how large its JSON is.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

#include "core/base/error.h"
#include "proto/mesh/decoded_mesh.h"

namespace geodesic::proto {

// Of one object, where the JSON is to keep its order: there each name is looked for among all that
// the object has.
inline constexpr std::size_t kMostOrderedMembers = 4096;

// Views into the file's bytes: nothing is copied.
struct GltfContainer {
  std::string_view json;
  std::span<const std::byte> binary;  // the BIN chunk; empty when there is none
  bool has_binary = false;
  std::size_t others_at = 0;       // where in a GLB the chunks of others begin, which are ignored
  std::size_t trailing_bytes = 0;  // after the length that the header gives
};

// Errors: mesh_invalid, naming the header field or chunk.
[[nodiscard]] Result<GltfContainer> open_glb(std::span<const std::byte> bytes);

// The whole file is the JSON; a byte order mark is stepped over.
[[nodiscard]] GltfContainer open_gltf(std::span<const std::byte> bytes);

// One linear pass over the JSON. A recursive parser or destructor can be driven
// out of stack by nesting, and out of memory by a great many tiny values.
// Errors: mesh_invalid (nesting, a string without an end), too_large (number of values).
[[nodiscard]] Result<void> check_json_shape(std::string_view json, const DecodeLimits& limits);

}  // namespace geodesic::proto
