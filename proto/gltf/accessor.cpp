#include "proto/gltf/accessor.h"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <span>
#include <string>

namespace geodesic::proto {
namespace {

// One element of an accessor that no bytes stand for; the largest are 4 x 4 floats.
constexpr std::array<std::byte, 64> kZeroElement{};

std::uint64_t size_of_component(int type) {
  switch (type) {
    case gltf_int8:
    case gltf_uint8:
      return 1;
    case gltf_int16:
    case gltf_uint16:
      return 2;
    case gltf_uint32:
    case gltf_float32:
      return 4;
    default:
      return 0;
  }
}

bool is_index_type(int type) {
  return type == gltf_uint8 || type == gltf_uint16 || type == gltf_uint32;
}

std::string name_of_accessor(std::size_t index) { return "accessor " + std::to_string(index); }

// What keeps an accessor from a use, as the rest of a sentence; null if nothing.
const char* unusable(const GltfAccessor& accessor, GltfUse use) {
  const int type = accessor.component_type;
  const bool is_float = type == gltf_float32;
  switch (use) {
    case GltfUse::indices:
      if (accessor.components == 1 && is_index_type(type)) return nullptr;
      return " can't hold indices: it is not a SCALAR of unsigned integers.";
    case GltfUse::position:
    case GltfUse::displacement:
      if (accessor.components == 3 && type != gltf_uint32 && size_of_component(type) != 0) {
        return nullptr;
      }
      return " can't hold positions: it is not a VEC3 of float32, 8 or 16 bits.";
    case GltfUse::vector:
      if (accessor.components == 3 && is_float) return nullptr;
      return " can't hold translations or scales: it is not a VEC3 of float32.";
    case GltfUse::rotation:
      if (accessor.components == 4 && (is_float || type == gltf_int8 || type == gltf_int16)) {
        return nullptr;
      }
      return " can't hold rotations: it is not a VEC4 of float32 or signed 8 or 16 bits.";
    case GltfUse::any:
      if (size_of_component(type) != 0) return nullptr;
      return " has no `componentType` that glTF knows.";
  }
  return nullptr;
}

bool may_be_zeros(GltfUse use) { return use != GltfUse::position && use != GltfUse::indices; }

// `count` elements of `size` bytes from `offset` in a view, `stride` apart.
// The operands are below 2^53 and 252 < 2^8, so nothing overflows.
Result<const std::byte*> locate(std::span<const std::byte> view, std::uint64_t offset,
                                std::uint64_t count, std::uint64_t stride, std::uint64_t size,
                                const std::string& name, std::size_t view_index) {
  const std::uint64_t end = offset + (count - 1) * stride + size;
  if (end > view.size()) {
    return fail(ErrorCode::mesh_invalid, name + " reaches to byte " + std::to_string(end) +
                                             " of bufferView " + std::to_string(view_index) +
                                             ", which has " + std::to_string(view.size()) + ".");
  }
  return view.data() + offset;
}

std::uint64_t index_at(const std::byte* data, int type, std::uint64_t i) {
  const auto read = [&]<class T>(T value) -> std::uint64_t {
    std::memcpy(&value, data + i * sizeof(T), sizeof(T));
    return value;
  };
  if (type == gltf_uint8) return read(std::uint8_t{});
  if (type == gltf_uint16) return read(std::uint16_t{});
  return read(std::uint32_t{});
}

// A tightly packed copy of `base` with the sparse elements put in.
Result<GltfElements> resolve_sparse(GltfBuffers& buffers, const GltfSparse& sparse,
                                    const GltfElements& base, const std::string& name) {
  if (!is_index_type(sparse.index_type)) {
    return fail(ErrorCode::mesh_invalid, name + ": its sparse indices are not unsigned integers.");
  }
  if (sparse.count > base.count) {
    return fail(ErrorCode::mesh_invalid, name + " has more sparse elements than elements.");
  }
  const std::uint64_t size =
      size_of_component(base.component_type) * static_cast<std::uint64_t>(base.components);
  const auto index_bytes = buffers.view(sparse.index_view);
  if (!index_bytes) return fail(index_bytes.error());
  const std::uint64_t index_size = size_of_component(sparse.index_type);
  const auto indices = locate(*index_bytes, sparse.index_offset, sparse.count, index_size,
                              index_size, name + ": its sparse indices", sparse.index_view);
  if (!indices) return fail(indices.error());
  const auto value_bytes = buffers.view(sparse.value_view);
  if (!value_bytes) return fail(value_bytes.error());
  const auto values = locate(*value_bytes, sparse.value_offset, sparse.count, size, size,
                             name + ": its sparse values", sparse.value_view);
  if (!values) return fail(values.error());

  std::vector<std::byte> packed(base.count * size);
  if (base.data != nullptr) {
    for (std::uint64_t i = 0; i < base.count; ++i) {
      std::memcpy(packed.data() + i * size, base.data + i * base.stride, size);
    }
  }
  for (std::uint64_t i = 0; i < sparse.count; ++i) {
    const std::uint64_t index = index_at(*indices, sparse.index_type, i);
    if (index >= base.count) {
      return fail(ErrorCode::mesh_invalid, name + ": sparse index " + std::to_string(index) +
                                               " is not below its count of " +
                                               std::to_string(base.count) + ".");
    }
    std::memcpy(packed.data() + index * size, *values + i * size, size);
  }
  GltfElements elements = base;
  elements.stride = size;
  elements.owned = std::make_shared<const std::vector<std::byte>>(std::move(packed));
  elements.data = elements.owned->data();
  return elements;
}

}  // namespace

double GltfElements::number(std::uint64_t element, int which) const {
  const auto read = [&]<class T>(T) {
    const auto value = static_cast<double>(component<T>(element, which));
    if (!normalized) return value;
    return std::max(value / static_cast<double>(std::numeric_limits<T>::max()), -1.0);
  };
  switch (component_type) {
    case gltf_int8:
      return read(std::int8_t{});
    case gltf_uint8:
      return read(std::uint8_t{});
    case gltf_int16:
      return read(std::int16_t{});
    case gltf_uint16:
      return read(std::uint16_t{});
    case gltf_uint32:
      return read(std::uint32_t{});
    default:
      return component<float>(element, which);
  }
}

Result<GltfElements> read_accessor(const GltfDocument& document, GltfBuffers& buffers,
                                   std::size_t index, GltfUse use, std::uint64_t max_absent) {
  const GltfAccessor& accessor = document.accessors[index];
  const std::string name = name_of_accessor(index);
  if (const char* wanted = unusable(accessor, use); wanted != nullptr) {
    return fail(ErrorCode::mesh_invalid, name + wanted);
  }
  const std::uint64_t size =
      size_of_component(accessor.component_type) * static_cast<std::uint64_t>(accessor.components);
  GltfElements elements;
  elements.count = accessor.count;
  elements.component_type = accessor.component_type;
  elements.components = accessor.components;
  elements.normalized = accessor.normalized;
  if (accessor.view) {
    const auto bytes = buffers.view(*accessor.view);
    if (!bytes) return fail(bytes.error());
    const std::uint64_t stride = document.views[*accessor.view].stride;
    if (stride != 0 && stride < size) {
      return fail(ErrorCode::mesh_invalid,
                  name + ": its elements are larger than the `byteStride` of bufferView " +
                      std::to_string(*accessor.view) + ".");
    }
    elements.stride = stride == 0 ? size : stride;
    const auto data = locate(*bytes, accessor.offset, accessor.count, elements.stride, size, name,
                             *accessor.view);
    if (!data) return fail(data.error());
    elements.data = *data;
  } else if (!accessor.sparse && !may_be_zeros(use)) {
    return fail(ErrorCode::mesh_invalid, name + " has no bufferView.");
  } else if (accessor.count > max_absent) {
    return fail(ErrorCode::mesh_invalid, name + " claims " + std::to_string(accessor.count) +
                                             " elements without a bufferView: more than the "
                                             "file has bytes.");
  } else if (!accessor.sparse) {
    elements.data = kZeroElement.data();  // for all of them: the stride is 0
  }
  if (!accessor.sparse) return elements;
  return resolve_sparse(buffers, *accessor.sparse, elements, name);
}

}  // namespace geodesic::proto
