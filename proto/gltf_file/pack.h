// A glTF document and the files it refers to, packed into one GLB.
#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "proto/mesh/decoded_mesh.h"

namespace geodesic::proto {

// Files by name, as they came with the document.
using NamedFiles = std::map<std::string, std::string_view, std::less<>>;

// The buffers that are in files become the GLB's binary chunk, one after another in the
// document's order, each from a multiple of 8 on and cut to its `byteLength`, and once
// for all buffers that are in one file; the views are pointed there, and all else in
// the document stays, in its order. So equal files give equal bytes. A buffer's URI is
// percent-decoded, and means the file of that name, else that of the name behind its
// last slash. Images stay where they are: nobody opens them.
// Errors: external_uri naming the file that is missing; mesh_invalid naming buffer or
// view; too_large (a GLB holds 4 GB; nesting and number of values, as for decoding; an
// object of more than kMostOrderedMembers).
[[nodiscard]] Result<std::string> pack_gltf(std::string_view document, const NamedFiles& files,
                                            const DecodeLimits& limits);

}  // namespace geodesic::proto
