// What people call a mesh. It is no part of the mesh's id, and two meshes may have the same.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "proto/wire/parameters.h"

namespace geodesic::proto {

inline constexpr std::size_t kMostMeshNameBytes = 200;

// Whether a text can be a name: 1 to kMostMeshNameBytes bytes of UTF-8, no control characters,
// line breaks or marks that turn the direction of what follows.
[[nodiscard]] bool is_mesh_name(std::string_view text);

// The parameter `name`; nothing where it is absent, and an empty text where it is that.
// Errors: bad_syntax (parameter `name`).
[[nodiscard]] Result<std::optional<std::string>> read_mesh_name(Parameters& parameters);

}  // namespace geodesic::proto
