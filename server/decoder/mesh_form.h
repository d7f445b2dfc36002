// The mesh file in a form: the only file there is, or a glTF document with its buffers.
#pragma once

#include <string>
#include <string_view>

#include "core/base/error.h"
#include "proto/mesh/decoded_mesh.h"

namespace geodesic::server {

struct FormFile {
  std::string name;  // as the form calls it: any bytes
  std::string bytes;

  [[nodiscard]] bool operator==(const FormFile&) const = default;
};

// The only file; or, where one part's file name ends in .gltf, that document
// and the buffers that the other parts are, packed into one GLB (proto/gltf_file/pack.h).
// Parts without a file name are ignored.
// Errors: bad_syntax (parameter `body`) for what is no form (multipart.h), holds two
// files of one name or two documents, or several files and no document; those of
// `pack_gltf`.
[[nodiscard]] Result<FormFile> file_of_form(std::string_view body, std::string_view boundary,
                                            const proto::DecodeLimits& limits);

}  // namespace geodesic::server
