// Surfaces and lines as a GLB that any viewer opens.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/vec3.h"
#include "proto/picture/colour_map.h"

namespace geodesic::proto {

// What readers of glTF find directions of vertices by.
inline constexpr const char* kDirectionAttribute = "_GEODESIC_DIRECTION";

// One node with one mesh of one primitive.
struct GlbPart {
  enum class Mode : std::uint8_t { line_strip = 3, triangles = 4 };  // glTF's numbers

  std::string name;
  Mode mode = Mode::triangles;
  std::vector<Vec3> positions;                // stored as float32
  std::vector<std::uint32_t> indices;         // empty: the positions in their order
  std::vector<Colour> colours;                // one per position, sRGB; empty: none
  std::vector<std::array<float, 2>> texture;  // coordinates, one pair per position; empty: none
  // Of the node: numbers by name. Whole ones are written as such.
  std::vector<std::pair<std::string, std::variant<double, std::uint64_t>>> extras;
  std::vector<Vec3> directions = {};  // one per position, as kDirectionAttribute; empty: none
};

// A valid glTF 2.0 binary with a node for each part; a part without positions is a
// node that draws nothing. Indices must be in range. Lines and coloured parts are
// not lit (KHR_materials_unlit), so that colours read as on a scale. No file if the poll says to
// stop.
[[nodiscard]] std::vector<std::byte> encode_glb_parts(std::span<const GlbPart> parts,
                                                      Poll* poll = nullptr);

}  // namespace geodesic::proto
