#include "proto/gltf/instancing.h"

#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "proto/gltf/accessor.h"

namespace geodesic::proto {
namespace {

Vec3 vector_at(const std::optional<GltfElements>& elements, std::uint64_t i, double otherwise) {
  if (!elements) return {otherwise, otherwise, otherwise};
  return {elements->number(i, 0), elements->number(i, 1), elements->number(i, 2)};
}

std::array<double, 4> rotation_at(const std::optional<GltfElements>& elements, std::uint64_t i) {
  if (!elements) return {0, 0, 0, 1};
  std::array<double, 4> q{};
  double squares = 0;
  for (int k = 0; k < 4; ++k) {
    q[static_cast<std::size_t>(k)] = elements->number(i, k);
    squares += q[static_cast<std::size_t>(k)] * q[static_cast<std::size_t>(k)];
  }
  // Rounding to 8 bits alone would scale the instance by up to a hundredth.
  if (elements->component_type != gltf_float32 && squares > 0) {
    for (double& component : q) component /= std::sqrt(squares);
  }
  return q;
}

bool is_finite(const GltfTransform& transform) {
  const Vec3 sum = transform.x + transform.y + transform.z + transform.t;
  return std::isfinite(sum.x + sum.y + sum.z);
}

}  // namespace

Result<std::vector<GltfTransform>> read_instancing(const GltfDocument& document,
                                                   GltfBuffers& buffers, std::size_t node,
                                                   std::uint64_t max_instances,
                                                   std::uint64_t max_absent) {
  const GltfInstancing& instancing = *document.nodes[node].instancing;
  const std::string name = "node " + std::to_string(node);
  std::optional<std::uint64_t> count;
  for (const auto& accessor : {instancing.translation, instancing.rotation, instancing.scale}) {
    if (!accessor) continue;
    const std::uint64_t its_count = document.accessors[*accessor].count;
    if (count && *count != its_count) {
      return fail(ErrorCode::mesh_invalid,
                  name + ": the accessors of its instances have different counts.");
    }
    count = its_count;
  }
  if (*count > max_instances) {
    return fail_limit(ErrorCode::too_large, name + " draws too many instances.", max_instances,
                      *count);
  }
  const auto read = [&](const std::optional<std::size_t>& accessor,
                        GltfUse use) -> Result<std::optional<GltfElements>> {
    if (!accessor) return std::nullopt;
    auto elements = read_accessor(document, buffers, *accessor, use, max_absent);
    if (!elements) {
      elements.error().detail = name + ", its instances: " + elements.error().detail;
      return fail(std::move(elements.error()));
    }
    if (use == GltfUse::rotation && elements->component_type != gltf_float32) {
      elements->normalized = true;
    }
    return std::move(*elements);
  };
  const auto translation = read(instancing.translation, GltfUse::vector);
  if (!translation) return fail(translation.error());
  const auto rotation = read(instancing.rotation, GltfUse::rotation);
  if (!rotation) return fail(rotation.error());
  const auto scale = read(instancing.scale, GltfUse::vector);
  if (!scale) return fail(scale.error());

  std::vector<GltfTransform> transforms;
  transforms.reserve(*count);
  for (std::uint64_t i = 0; i < *count; ++i) {
    transforms.push_back(transform_of_trs(vector_at(*translation, i, 0), rotation_at(*rotation, i),
                                          vector_at(*scale, i, 1)));
    if (!is_finite(transforms.back())) {
      return fail(ErrorCode::mesh_invalid, name + ": the transform of its instance " +
                                               std::to_string(i) + " is not finite.");
    }
  }
  return transforms;
}

}  // namespace geodesic::proto
