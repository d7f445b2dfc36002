// What goes between the server and a process that decodes for it: the order, and the
// decoded mesh, the file found in a form, what is to change in a glTF file, or the error, as flat
// bytes. Both ends are the same program on the same machine, so numbers are as they are in memory;
// but whoever reads a frame takes none of it on trust.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "proto/gltf/weights.h"
#include "proto/gltf_file/annotation.h"
#include "proto/mesh/decoded_mesh.h"
#include "proto/wire/import_options.h"
#include "server/decoder/mesh_form.h"

namespace geodesic::server {

struct DecodeOrder {
  std::string boundary;  // of the form in which the file is to be found; empty: decode it
  // To be added to a glTF file; empty: decode it.
  std::vector<proto::VertexAttribute> attributes;
  std::string numbers;  // the attribute of which numbers of faces are to be made; empty: none
  proto::FaceNumber which = proto::FaceNumber::weight;  // of these
  proto::DecodeLimits limits;
  proto::ImportOptions options;
  std::uint64_t file_bytes = 0;
  std::uint64_t memory_bytes = 0;
  std::uint64_t cpu_seconds = 0;
};

[[nodiscard]] std::string write_order(const DecodeOrder& order);
[[nodiscard]] std::optional<DecodeOrder> read_order(std::string_view bytes);

using Decoded = Result<proto::DecodedMesh>;

// `Content` is a proto::DecodedMesh, a FormFile, a proto::GltfAnnotation or proto::FaceNumbers.
template <class Content>
[[nodiscard]] std::size_t frame_size(const Result<Content>& answer);
// `frame` has just that size.
template <class Content>
void write_frame(const Result<Content>& answer, std::span<std::byte> frame);
// Nothing if the bytes are no frame of that content. Otherwise counts and names are those
// of the frame, which may lie: what they mean is for whoever uses them to check, as with a
// file's own. Nothing as well once `cancel` says so.
template <class Content = proto::DecodedMesh>
[[nodiscard]] std::optional<Result<Content>> read_frame(std::span<const std::byte> frame,
                                                        const Cancel& cancel = {});

}  // namespace geodesic::server
