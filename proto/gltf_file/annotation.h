// What changes in a glTF file when its vertices get attributes of our own. Made of the file
// without the values, so that a file that nobody trusts can be read by another process than the
// one that has the values.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace geodesic::proto {

// An attribute to be added: so many floats a vertex.
struct VertexAttribute {
  std::string name;  // as in `attributes` of a primitive; begins with an underscore
  std::uint64_t components = 1;

  [[nodiscard]] bool operator==(const VertexAttribute&) const = default;
};

// Source vertices that follow one another: those of a primitive.
struct VertexRun {
  std::uint64_t first = 0;
  std::uint64_t count = 0;

  [[nodiscard]] bool operator==(const VertexRun&) const = default;
};

struct GltfAnnotation {
  // The whole document, with views and accessors for the values.
  std::string json;
  // Where in it the values go, in base64; none: to the end of the GLB's binary chunk.
  std::uint64_t values_at = kInChunk;
  // Of each attribute, one after another, the values of these vertices in this order, as floats.
  std::vector<VertexRun> runs;

  static constexpr std::uint64_t kInChunk = ~std::uint64_t{0};
};

}  // namespace geodesic::proto
