// Queries whose numbers go into the file that was uploaded, or come from there.
#include <nlohmann/json.hpp>
#include <utility>

#include "proto/wire/input_codes.h"
#include "server/routes/routes.h"

namespace geodesic::server {

// Before anything is computed.
Result<Routes::GltfSize> Routes::size_of_gltf(const Query& query, const Error& otherwise,
                                              const Caller& caller) {
  const auto metadata = catalog_.metadata(query.mesh, caller);
  if (!metadata) return fail(metadata.error());
  const auto description = nlohmann::ordered_json::parse(*metadata, nullptr, false);
  const std::string format = description.value("format", "");
  if (format == "glb" || format == "gltf") {
    return GltfSize{description.value("bytes", std::uint64_t{0}),
                    description.value("faces", std::uint64_t{0})};
  }
  return fail(otherwise.code,
              "only a .glb or .gltf has attributes of vertices by name, and this mesh was "
              "uploaded as ." +
                  format + "; " + otherwise.detail,
              otherwise.parameter);
}

Result<void> Routes::read_weights(const Query& query, proto::Costs& costs,
                                  ReplyBudget::Share& memory, const Caller& caller) {
  if (costs.weight_attribute.empty()) return {};
  const auto file = size_of_gltf(
      query,
      {ErrorCode::value_out_of_range, "send face_weights instead", "weight_attribute", {}, {}},
      caller);
  if (!file) return fail(file.error());
  const std::uint64_t bytes_of_weights = file->faces * sizeof(double);
  // The file, and once more for who decodes it.
  const std::uint64_t before = memory.bytes();
  if (auto more = memory.grow(2 * file->bytes + bytes_of_weights); !more) return more;
  auto weights =
      catalog_.face_numbers(query.mesh, costs.weight_attribute, proto::FaceNumber::weight, caller);
  if (!weights) return fail(std::move(weights.error()));
  costs.face_weights = (*weights)->by_face;
  memory.shrink(before + bytes_of_weights);
  return {};
}

Result<std::shared_ptr<const UploadedGltf>> Routes::upload_to_annotate(
    const Query& query, const std::vector<proto::VertexAttribute>& attributes,
    std::uint64_t file_bytes, ReplyBudget::Share& memory, const Caller& caller) {
  // The file, once more for who takes it apart, and the document that comes of it.
  constexpr std::uint64_t kTimes = 4;
  const std::uint64_t before = memory.bytes();
  if (auto more = memory.grow(kTimes * file_bytes); !more) return fail(std::move(more.error()));
  auto upload = catalog_.uploaded_gltf(query.mesh, attributes, caller);
  if (!upload) return fail(std::move(upload.error()));
  memory.shrink(before + upload->bytes.size() + upload->annotation.json.size());
  return std::make_shared<const UploadedGltf>(std::move(*upload));
}

}  // namespace geodesic::server
