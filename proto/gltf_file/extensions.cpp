#include "proto/gltf_file/extensions.h"

#include <algorithm>

namespace geodesic::proto {
namespace {

// Of all others the geometry might depend on them.
constexpr std::string_view kImplemented[] = {kDracoExtension,         kInstancingExtension,
                                             kMeshoptExtensions[0],   kMeshoptExtensions[1],
                                             "KHR_mesh_quantization", kRtcExtension};

constexpr std::string_view kIrrelevant[] = {
    "ADOBE_materials_clearcoat_specular",
    "ADOBE_materials_clearcoat_tint",
    "ADOBE_materials_thin_transparency",
    "CESIUM_primitive_outline",
    "EXT_feature_metadata",
    "EXT_instance_features",
    "EXT_lights_ies",
    "EXT_lights_image_based",
    "EXT_mesh_features",
    "EXT_mesh_manifold",
    "EXT_structural_metadata",
    "EXT_texture_avif",
    "EXT_texture_procedurals_mx_1_39",
    "EXT_texture_webp",
    "KHR_animation_pointer",
    "KHR_lights_punctual",
    "KHR_techniques_webgl",
    "KHR_texture_basisu",
    "KHR_texture_procedurals",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "MSFT_packing_normalRoughnessMetallic",
    "MSFT_packing_occlusionRoughnessMetallic",
    "MSFT_texture_dds",
};

}  // namespace

bool is_accepted_extension(std::string_view name) {
  return name.starts_with("KHR_materials_") || std::ranges::count(kImplemented, name) != 0 ||
         std::ranges::count(kIrrelevant, name) != 0;
}

}  // namespace geodesic::proto
