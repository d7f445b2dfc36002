#include "server/decoder/mesh_form.h"

#include <utility>

#include "proto/gltf_file/pack.h"
#include "proto/wire/input_codes.h"
#include "server/http/multipart.h"

namespace geodesic::server {

Result<FormFile> file_of_form(std::string_view body, std::string_view boundary,
                              const proto::DecodeLimits& limits) {
  const auto parts = read_multipart(body, boundary);
  if (!parts) return fail(parts.error());
  const Part* document = nullptr;
  proto::NamedFiles files;
  for (const Part& part : *parts) {
    if (part.filename.empty()) continue;  // a field of the form
    const bool is_document = part.filename.ends_with(".gltf") || part.filename.ends_with(".GLTF");
    if (is_document && document != nullptr) {
      return fail(InputCode::bad_syntax, "more than one part is a .gltf file", "body");
    }
    if (is_document) document = &part;
    if (!files.emplace(part.filename, part.bytes).second) {
      return fail(InputCode::bad_syntax, "two parts are files of the same name", "body");
    }
  }
  if (document != nullptr) {
    auto packed = proto::pack_gltf(document->bytes, files, limits);
    if (!packed) return fail(std::move(packed.error()));
    return FormFile{document->filename, std::move(*packed)};
  }
  if (files.size() != 1) {
    return fail(InputCode::bad_syntax, "one part is to be a .gltf file, the others its buffers",
                "body");
  }
  return FormFile{files.begin()->first, std::string(files.begin()->second)};
}

}  // namespace geodesic::server
