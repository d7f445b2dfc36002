// Perceptual colour maps for pictures and coloured meshes.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "core/base/error.h"

namespace geodesic::proto {

enum class ColourMap : std::uint8_t { viridis, magma, turbo };

using Colour = std::array<std::uint8_t, 3>;  // sRGB

// Errors: value_out_of_range with parameter "colormap", listing those there are.
[[nodiscard]] Result<ColourMap> find_colour_map(std::string_view name);

// The colour at t in [0, 1]; t is clamped.
[[nodiscard]] Colour colour_at(ColourMap map, double t);

}  // namespace geodesic::proto
