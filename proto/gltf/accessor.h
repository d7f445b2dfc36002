// The one bounds-checked reader of glTF accessors. `read_accessor` proves that
// every element lies within bytes that are present; what is made from its result
// needs no further check.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <vector>

#include "core/base/error.h"
#include "proto/gltf_file/buffers.h"
#include "proto/gltf_file/document.h"

namespace geodesic::proto {

// `count` elements of `components` components each, the first at `data`, the
// next `stride` bytes on; with a stride of 0 they are all the one at `data`.
// Components may be unaligned.
struct GltfElements {
  const std::byte* data = nullptr;
  std::uint64_t count = 0;
  std::uint64_t stride = 0;
  int component_type = 0;
  int components = 1;
  bool normalized = false;
  std::shared_ptr<const std::vector<std::byte>> owned;  // of a sparse accessor, else null

  template <class T>
  [[nodiscard]] T component(std::uint64_t element, int which) const {
    T value;
    std::memcpy(&value, data + element * stride + static_cast<std::size_t>(which) * sizeof(T),
                sizeof(T));
    return value;
  }

  // Component `which` as a number, integers divided by their greatest when they are
  // normalised (glTF 2.0, section 3.11). For what is read once, not per vertex.
  [[nodiscard]] double number(std::uint64_t element, int which) const;
};

// What a caller is able to use. Positions and indices are to have bytes of their own:
// zeros alone make no triangle.
enum class GltfUse : std::uint8_t {
  position,      // VEC3 of float32, or of 8 or 16 bits (KHR_mesh_quantization)
  indices,       // SCALAR of unsigned 8, 16 or 32 bits
  displacement,  // of positions, by a morph target: as they are, or all zeros
  vector,        // VEC3 of float32
  rotation,      // VEC4 of float32, or of signed 8 or 16 bits, normalised
  any,           // whatever glTF allows
};

// Elements of an accessor, sparse ones resolved; zeros where it has no buffer view
// (glTF 2.0, section 5.1.1). `max_absent`: how many elements may be zeros that no
// bytes stand for. The buffers must outlive the result.
// Errors: those of `GltfBuffers::view`, and mesh_invalid naming the accessor.
[[nodiscard]] Result<GltfElements> read_accessor(const GltfDocument& document, GltfBuffers& buffers,
                                                 std::size_t index, GltfUse use,
                                                 std::uint64_t max_absent);

}  // namespace geodesic::proto
