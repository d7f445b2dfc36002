// Pictures of surfaces, fields and paths: a small software rasteriser. Orthographic,
// with a depth buffer, soft light that knows no front or back (winding plays no
// part), isolines as thin dark stripes, and a scale with numbers.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/base/vec3.h"
#include "core/mesh/mesh.h"
#include "proto/picture/colour_map.h"
#include "proto/picture/view.h"

namespace geodesic::proto {

// Pixels row by row from the top, three bytes each (sRGB).
struct Image {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<std::uint8_t> rgb;
};

struct PictureOptions {
  static constexpr std::uint32_t kMinSide = 64;
  static constexpr std::uint32_t kMaxSide = 2048;
  static constexpr std::uint32_t kMaxStripes = 200;

  std::uint32_t width = 1200;
  std::uint32_t height = 900;
  std::optional<View> view;  // none: from the corner, or straight at a flat mesh
  ColourMap colour_map = ColourMap::viridis;
  std::uint32_t stripes = 20;  // isolines between zero and the greatest value; 0: none
};

// A part of the surface in one colour: triangles that lie in faces of the mesh.
struct Patch {
  std::span<const Vec3> corners;         // three of each triangle
  std::span<const std::uint32_t> faces;  // that have them
  Colour colour;
};

struct PictureContent {
  // One value per vertex, not negative; kUnreached is grey. Empty: all grey, no scale.
  std::span<const double> values;
  std::vector<std::vector<Vec3>> lines;  // polylines on the surface
  std::vector<Vec3> sources;             // marked by discs
  std::vector<Vec3> targets;             // marked by rings
  std::vector<Patch> patches{};          // over what the values have coloured
};

// Errors: cancelled. The options must be within their bounds.
[[nodiscard]] Result<Image> draw_picture(const Mesh& mesh, const PictureContent& content,
                                         const PictureOptions& options, const Cancel& cancel);

// PNG, by libpng. Without an end if the poll says to stop.
[[nodiscard]] std::string encode_png(const Image& image, Poll* poll = nullptr);

}  // namespace geodesic::proto
