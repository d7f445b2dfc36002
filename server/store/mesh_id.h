// What a mesh is called: by the SHA-256 of its file, and by the options that the file is read with
// if they are not the defaults.
#pragma once

#include <string>
#include <string_view>

namespace geodesic::server {

// Whether `id` is 64 lower-case hexadecimal digits, alone or followed by `~` and 32. With
// 12 behind the `~` it is of a mesh that an older version has stored, which is still read.
[[nodiscard]] bool is_mesh_id(std::string_view id);

// The id of a file of that SHA-256, read with the options of that canonical text,
// which is empty for the defaults.
[[nodiscard]] std::string mesh_id(std::string_view sha256, std::string_view options);

// Whether an id is of a mesh read with the options of that canonical text.
[[nodiscard]] bool is_of_options(std::string_view id, std::string_view options);

// Of an id: the SHA-256 of its bytes, and whether it has options.
[[nodiscard]] std::string_view source_digest(std::string_view id);
[[nodiscard]] bool has_options(std::string_view id);

}  // namespace geodesic::server
