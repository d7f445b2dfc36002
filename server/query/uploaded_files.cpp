// What an uploaded file says that its mesh does not: its bytes, attributes, materials and parts.
#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "proto/gltf/annotate.h"
#include "proto/gltf/weights.h"
#include "proto/mesh/metadata.h"
#include "proto/wire/input_codes.h"
#include "proto/wire/query_limits.h"
#include "server/query/mesh_catalog.h"

namespace geodesic::server {
namespace {

std::span<const std::byte> as_bytes(const std::string& text) {
  return {reinterpret_cast<const std::byte*>(text.data()), text.size()};
}

// In the cache of prepared things. They begin with the mesh's id, and go with the mesh.
std::string parts_key(const std::string& mesh) { return mesh + "/parts"; }
std::string materials_key(const std::string& mesh) { return mesh + "/materials"; }
std::string numbers_key(const std::string& mesh, const std::string& attribute,
                        proto::FaceNumber which) {
  return mesh + (which == proto::FaceNumber::label ? "/labels/" : "/weights/") + attribute;
}

}  // namespace

Result<std::string> MeshCatalog::source(const std::string& id) { return store_.get_source(id); }

Result<MeshCatalog::StoredFile> MeshCatalog::stored_file(const std::string& id,
                                                         const Caller& caller) {
  auto turn = file_turns_.take(caller);
  if (!turn) return fail(std::move(turn.error()));
  auto bytes = store_.get_source(id, std::cref(caller));
  if (!bytes) {
    const bool is_stopped = bytes.error().code == ErrorCode::cancelled;
    return fail(is_stopped ? caller.why_stopped() : std::move(bytes.error()));
  }
  auto options = options_of(id);
  if (!options) return fail(std::move(options.error()));
  return StoredFile{std::move(*bytes), std::move(*options), std::move(*turn)};
}

Result<UploadedGltf> MeshCatalog::uploaded_gltf(
    const std::string& id, const std::vector<proto::VertexAttribute>& attributes,
    const Caller& caller) {
  auto file = stored_file(id, caller);
  if (!file) return fail(std::move(file.error()));
  auto annotation = pool_.run(
      [&](Worker&) {
        const auto limits = decode_limits_.get();
        const auto& [bytes, options, turn] = *file;
        return decoders_ != nullptr
                   ? decoders_->annotation(bytes, attributes, *limits, options, caller)
                   : proto::annotate_gltf(as_bytes(bytes), *limits, options, attributes);
      },
      caller);
  if (!annotation) return fail(std::move(annotation.error()));
  return UploadedGltf{std::move(file->bytes), std::move(*annotation)};
}

// What `make` gives is made once, and kept with what is prepared of the mesh.
template <class Kept, class Make>
Result<std::shared_ptr<const Kept>> MeshCatalog::kept(const std::string& key, const Caller& caller,
                                                      const Make& make) {
  const auto known = prepared_.get_or_create(
      key,
      [&]() -> Result<std::shared_ptr<const Prepared>> {
        auto made = make();
        if (!made) return fail(std::move(made.error()));
        return std::make_shared<const Prepared>(std::make_shared<const Kept>(std::move(*made)));
      },
      caller);
  if (!known) return fail(known.error());
  return std::get<std::shared_ptr<const Kept>>(*known->value);
}

Result<MeshCatalog::Numbers> MeshCatalog::face_numbers(const std::string& id,
                                                       const std::string& attribute,
                                                       proto::FaceNumber which,
                                                       const Caller& caller) {
  return kept<proto::FaceNumbers>(
      numbers_key(id, attribute, which), caller, [&]() -> Result<proto::FaceNumbers> {
        const auto file = stored_file(id, caller);
        if (!file) return fail(file.error());
        return pool_.run(
            [&](Worker&) {
              const auto limits = decode_limits_.get();
              const auto& [bytes, options, turn] = *file;
              return decoders_ != nullptr ? decoders_->face_numbers(bytes, attribute, which,
                                                                    *limits, options, caller)
                                          : proto::read_face_numbers(as_bytes(bytes), *limits,
                                                                     options, attribute, which);
            },
            caller);
      });
}

Result<proto::FileFaces> MeshCatalog::file_faces(const std::string& id,
                                                 const proto::NamedOfFile& named,
                                                 const Caller& caller) {
  proto::FileFaces file;
  if (!named.parts && !named.materials && named.labels.empty()) return file;
  const auto description = metadata(id, caller);
  if (!description) return fail(description.error());
  if (named.labels.size() > proto::kMaxLabelAttributes) {
    return fail_limit(ErrorCode::too_large, "labels of too many attributes in one request",
                      proto::kMaxLabelAttributes, named.labels.size(),
                      named.labels.begin()->second);
  }
  for (const auto& [attribute, parameter] : named.labels) {
    auto labels = face_labels(id, *description, attribute, caller);
    if (!labels) {
      if (labels.error().parameter.empty()) labels.error().parameter = parameter;
      return fail(std::move(labels.error()));
    }
    file.labels.emplace(attribute, std::move(*labels));
  }
  if (!named.parts && !named.materials) return file;
  auto told = proto::parts_in(*description);
  if (!told) return fail(std::move(told.error()));
  file.parts = std::move(*told);
  if (named.parts && file.parts.are_missing()) {
    const auto parts = this->parts(id, caller);
    if (!parts) return fail(parts.error());
    const bool has_no_materials = file.parts.has_no_materials;
    file.parts = **parts;
    file.parts.has_no_materials = has_no_materials;
  }
  if (named.materials && !file.parts.has_no_materials) {
    auto materials = this->materials(id, caller);
    if (!materials) return fail(std::move(materials.error()));
    file.materials = std::move(*materials);
  }
  return file;
}

Result<MeshCatalog::Numbers> MeshCatalog::face_labels(const std::string& id,
                                                      const std::string& description,
                                                      const std::string& attribute,
                                                      const Caller& caller) {
  const std::string format = proto::format_in(description);
  if (format != "glb" && format != "gltf") {
    return fail(ErrorCode::value_out_of_range,
                "only a .glb or .gltf has attributes of vertices, and this mesh was uploaded as ." +
                    format + "; name faces by number");
  }
  auto labels = face_numbers(id, attribute, proto::FaceNumber::label, caller);
  // There is no such form of a reply; the region cannot be had.
  if (!labels && labels.error().code == InputCode::not_acceptable) {
    labels.error().code = ErrorCode::value_out_of_range;
  }
  return labels;
}

void MeshCatalog::keep_materials(const std::string& id, proto::FaceMaterials materials,
                                 const Caller& caller) {
  if (materials.names.empty()) return;
  (void)kept<proto::FaceMaterials>(
      materials_key(id), caller,
      [&]() -> Result<proto::FaceMaterials> { return std::move(materials); });
}

Result<proto::DecodedMesh> MeshCatalog::decode_stored(const std::string& id, const Caller& caller) {
  const auto file = step("read", Stage::load, caller, [&] { return stored_file(id, caller); });
  if (!file) return fail(file.error());
  return pool_.run(
      [&](Worker&) {
        return step("decode", Stage::load, caller,
                    [&] { return decode(file->bytes, file->options, caller); });
      },
      caller);
}

Result<MeshCatalog::Parts> MeshCatalog::parts(const std::string& id, const Caller& caller) {
  return kept<proto::ToldParts>(parts_key(id), caller, [&]() -> Result<proto::ToldParts> {
    const auto decoded = decode_stored(id, caller);
    if (!decoded) return fail(decoded.error());
    return proto::told_parts(*decoded);
  });
}

Result<MeshCatalog::Materials> MeshCatalog::materials(const std::string& id, const Caller& caller) {
  return kept<proto::FaceMaterials>(materials_key(id), caller,
                                    [&]() -> Result<proto::FaceMaterials> {
                                      auto decoded = decode_stored(id, caller);
                                      if (!decoded) return fail(std::move(decoded.error()));
                                      return std::move(decoded->materials);
                                    });
}

}  // namespace geodesic::server
