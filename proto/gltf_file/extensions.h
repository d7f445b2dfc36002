// Which glTF extensions a file may require. What only concerns looks, metadata
// or animation is accepted and ignored; what would change where a vertex is, and
// is not implemented, is refused.
#pragma once

#include <string_view>

namespace geodesic::proto {

inline constexpr std::string_view kDracoExtension = "KHR_draco_mesh_compression";
inline constexpr std::string_view kInstancingExtension = "EXT_mesh_gpu_instancing";
inline constexpr std::string_view kRtcExtension = "CESIUM_RTC";
inline constexpr std::string_view kMeshoptExtensions[] = {"EXT_meshopt_compression",
                                                          "KHR_meshopt_compression"};

// May a file list this extension in `extensionsRequired`?
[[nodiscard]] bool is_accepted_extension(std::string_view name);

}  // namespace geodesic::proto
