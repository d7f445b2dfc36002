// The header of a PLY file: which elements follow, and of what properties.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"

namespace geodesic::proto {

enum class PlyType : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

[[nodiscard]] std::size_t size_of(PlyType type);
[[nodiscard]] bool is_integer(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::float32;
  std::optional<PlyType> count;  // of a list: the type of its length
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  // Bytes of one in a binary file, its lists empty.
  [[nodiscard]] std::uint64_t least_bytes() const;
};

struct PlyHeader {
  enum class Encoding : std::uint8_t { text, little_endian, big_endian };
  Encoding encoding = Encoding::text;
  std::vector<PlyElement> elements;
  std::size_t size = 0;  // bytes up to the data
};

[[nodiscard]] bool is_ply(std::string_view text);

// Errors: mesh_invalid, naming the line or the element.
// What the elements claim is checked against the bytes that follow.
[[nodiscard]] Result<PlyHeader> read_ply_header(std::string_view text);

}  // namespace geodesic::proto
