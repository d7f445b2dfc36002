#include "proto/formats/decode_mesh.h"

#include <exception>
#include <new>
#include <stdexcept>
#include <utility>

#include "proto/draco/codec.h"
#include "proto/formats/decode_obj.h"
#include "proto/formats/decode_ply.h"
#include "proto/formats/decode_stl.h"
#include "proto/formats/ply_header.h"
#include "proto/gltf/decode.h"
#include "proto/mesh/one_part.h"
#include "proto/mesh/text_tokens.h"
#include "proto/wire/input_codes.h"

namespace geodesic::proto {
namespace {

Result<DecodedMesh> decode_drc(std::span<const std::byte> bytes, const DecodeLimits& limits) {
  auto soup = decode_draco(bytes, {limits.max_vertices, limits.max_faces});
  if (!soup) return fail(std::move(soup.error()));
  if (soup->faces.empty()) {
    return fail(ErrorCode::no_triangles, "The Draco data has no triangles.");
  }
  return mesh_of_one_part(MeshFormat::drc, std::move(*soup));
}

}  // namespace

Result<MeshFormat> sniff_format(std::span<const std::byte> bytes) {
  const std::string_view raw{reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  if (raw.starts_with("glTF")) return MeshFormat::glb;
  if (is_draco(bytes)) return MeshFormat::drc;
  const std::string_view text = text_of_file(bytes);
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first != std::string_view::npos && text[first] == '{') return MeshFormat::gltf;
  if (is_ply(text)) return MeshFormat::ply;
  if (is_stl(bytes)) return MeshFormat::stl;
  if (is_obj(bytes)) return MeshFormat::obj;
  return fail(InputCode::format_unknown,
              "The bytes are none of GLB, glTF, Draco, OBJ, PLY and STL.");
}

namespace {

Result<DecodedMesh> decode_as(MeshFormat format, std::span<const std::byte> bytes,
                              const DecodeLimits& limits, const ImportOptions& options) {
  if (format == MeshFormat::glb || format == MeshFormat::gltf) {
    return decode_gltf(bytes, format, limits, options);
  }
  if (options.scene || options.node) {
    return fail(ErrorCode::value_out_of_range, "Only glTF files have scenes and nodes.",
                options.scene ? "scene" : "node");
  }
  if (format == MeshFormat::obj) return decode_obj(bytes, limits);
  if (format == MeshFormat::ply) return decode_ply(bytes, limits);
  if (format == MeshFormat::stl) return decode_stl(bytes, limits);
  return decode_drc(bytes, limits);
}

}  // namespace

Result<DecodedMesh> decode_mesh(std::span<const std::byte> bytes, const DecodeLimits& limits,
                                const ImportOptions& options) {
  const auto format = sniff_format(bytes);
  if (!format) return fail(format.error());
  try {
    auto mesh = decode_as(*format, bytes, limits, options);
    if (mesh) place(mesh->soup, options);
    return mesh;
  } catch (const std::bad_alloc&) {
    return fail(ErrorCode::too_large, "Decoding the mesh needs more memory than there is.");
  } catch (const std::length_error&) {
    return fail(ErrorCode::too_large, "Decoding the mesh needs more memory than there is.");
  } catch (const std::exception&) {
    return fail(ErrorCode::internal, "The mesh could not be decoded.");
  }
}

}  // namespace geodesic::proto
