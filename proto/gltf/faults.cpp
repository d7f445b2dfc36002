#include "proto/gltf/faults.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "proto/gltf/geometry.h"
#include "proto/wire/input_codes.h"

namespace geodesic::proto {
namespace {

constexpr double kBoundsTolerance = 0.01;

struct Bounds {
  std::vector<double> low;
  std::vector<double> high;
};

Bounds bounds_of(const GltfElements& elements) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const auto components = static_cast<std::size_t>(elements.components);
  GltfElements raw = elements;  // bounds are of the numbers as stored
  raw.normalized = false;
  Bounds bounds{std::vector(components, kInfinity), std::vector(components, -kInfinity)};
  for (std::uint64_t i = 0; i < raw.count; ++i) {
    for (std::size_t k = 0; k < components; ++k) {
      const double value = raw.number(i, static_cast<int>(k));
      bounds.low[k] = std::min(bounds.low[k], value);
      bounds.high[k] = std::max(bounds.high[k], value);
    }
  }
  return bounds;
}

// Three floats are what nearly all positions are, of which there may be millions.
Bounds bounds_of_floats(const GltfElements& elements) {
  std::array<float, 3> low{};
  low.fill(std::numeric_limits<float>::infinity());
  std::array<float, 3> high{};
  high.fill(-std::numeric_limits<float>::infinity());
  for (std::uint64_t i = 0; i < elements.count; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto value = elements.component<float>(i, static_cast<int>(k));
      low[k] = std::min(low[k], value);
      high[k] = std::max(high[k], value);
    }
  }
  return {{low.begin(), low.end()}, {high.begin(), high.end()}};
}

// What reading would refuse, unless it is only that the bytes are elsewhere.
std::optional<Error> fault_in(const Result<GltfElements>& elements) {
  if (elements || elements.error().code == InputCode::external_uri ||
      elements.error().code == InputCode::extension_required) {
    return std::nullopt;
  }
  return elements.error();
}

// How many numbers may still be copied or gone through. Accessors may share bytes, and primitives
// accessors: without a bound, a file would take its square.
class NumbersLeft {
 public:
  explicit NumbersLeft(const DecodeLimits& limits)
      : left_(3 * (limits.max_vertices + limits.max_faces)) {}

  // False when so many are not left.
  bool take(std::uint64_t numbers) {
    if (numbers > left_) return false;
    left_ -= numbers;
    return true;
  }

 private:
  std::uint64_t left_;
};

// That an accessor has; none if reading refuses it before it looks at them, as it claims more
// elements than there are bytes.
std::uint64_t numbers_in(const GltfDocument& document, GltfBuffers& buffers, std::size_t index,
                         std::uint64_t file_bytes) {
  const GltfAccessor& accessor = document.accessors[index];
  std::uint64_t most = file_bytes;
  if (accessor.view) {
    const auto bytes = buffers.view(*accessor.view);
    most = bytes ? bytes->size() : 0;
  }
  if (accessor.count > most) return 0;
  return accessor.count * static_cast<std::uint64_t>(accessor.components);
}

Result<void> check_primitive(const GltfDocument& document, GltfBuffers& buffers,
                             const GltfPrimitive& primitive, std::uint64_t file_bytes,
                             NumbersLeft& left) {
  if (primitive.draco || !primitive.position) return {};
  const GltfAccessor& accessor = document.accessors[*primitive.position];
  const std::uint64_t vertices = accessor.count;
  for (const auto& target : primitive.targets) {
    if (!target || document.accessors[*target].count == vertices) continue;
    return fail(ErrorCode::mesh_invalid,
                "accessor " + std::to_string(*target) +
                    " is a morph target of another number of positions than the primitive has.");
  }
  // Only sparse ones are copied.
  const bool is_within =
      !accessor.sparse || left.take(numbers_in(document, buffers, *primitive.position, file_bytes));
  if ((accessor.view || accessor.sparse) && is_within) {
    const auto positions =
        read_accessor(document, buffers, *primitive.position, GltfUse::position, file_bytes);
    if (auto fault = fault_in(positions)) return fail(std::move(*fault));
  }
  if (!primitive.indices) return {};
  if (!left.take(numbers_in(document, buffers, *primitive.indices, file_bytes))) return {};
  const auto indices =
      read_accessor(document, buffers, *primitive.indices, GltfUse::indices, file_bytes);
  if (auto fault = fault_in(indices)) return fail(std::move(*fault));
  if (!indices) return {};
  for (std::uint64_t i = 0; i < indices->count; ++i) {
    if (const double index = indices->number(i, 0); index >= static_cast<double>(vertices)) {
      return fail(ErrorCode::index_out_of_range,
                  "accessor " + std::to_string(*primitive.indices) + ": index " +
                      std::to_string(i) + " is " +
                      std::to_string(static_cast<std::uint64_t>(index)) + ", but there are " +
                      std::to_string(vertices) + " vertices.");
    }
  }
  return {};
}

}  // namespace

Result<void> check_bounds(const GltfDocument& document, std::size_t accessor,
                          const GltfElements& elements) {
  const GltfAccessor& said = document.accessors[accessor];
  if (said.min.empty() && said.max.empty()) return {};
  const bool is_floats = elements.component_type == gltf_float32 && elements.components == 3;
  const Bounds is = is_floats ? bounds_of_floats(elements) : bounds_of(elements);
  double longest = 0;
  for (std::size_t k = 0; k < is.low.size(); ++k) {
    longest = std::max(longest, is.high[k] - is.low[k]);
  }
  if (!std::isfinite(longest)) return {};  // who fills positions names the one at fault
  const auto agree = [&](const std::vector<double>& stated, const std::vector<double>& found) {
    for (std::size_t k = 0; k < stated.size(); ++k) {
      if (std::abs(stated[k] - found[k]) > kBoundsTolerance * longest) return false;
    }
    return true;
  };
  for (const bool is_max : {false, true}) {
    if (agree(is_max ? said.max : said.min, is_max ? is.high : is.low)) continue;
    return fail(ErrorCode::mesh_invalid, "accessor " + std::to_string(accessor) + ": its " +
                                             (is_max ? "`max`" : "`min`") +
                                             " is not that of its elements.");
  }
  return {};
}

Result<void> find_fault(const GltfDocument& document, GltfBuffers& buffers,
                        std::uint64_t file_bytes, const DecodeLimits& limits) {
  NumbersLeft left(limits);
  for (std::size_t i = 0; i < document.views.size(); ++i) {
    const auto bytes = buffers.view(i);
    if (!bytes && bytes.error().code == ErrorCode::mesh_invalid) return fail(bytes.error());
    const GltfBufferView& view = document.views[i];
    if (view.stride > view.length) {
      return fail(ErrorCode::mesh_invalid,
                  "bufferView " + std::to_string(i) + ": its `byteStride` is more than its bytes.");
    }
  }
  for (std::size_t i = 0; i < document.accessors.size(); ++i) {
    const GltfAccessor& accessor = document.accessors[i];
    if (accessor.normalized &&
        (accessor.component_type == gltf_float32 || accessor.component_type == gltf_uint32)) {
      return fail(ErrorCode::mesh_invalid,
                  "accessor " + std::to_string(i) + ": only 8 and 16 bits can be `normalized`.");
    }
    if (!accessor.view && !accessor.sparse) continue;  // zeros, or Draco's
    if (accessor.sparse && !left.take(numbers_in(document, buffers, i, file_bytes))) continue;
    const auto elements = read_accessor(document, buffers, i, GltfUse::any, file_bytes);
    if (auto fault = fault_in(elements)) return fail(std::move(*fault));
  }
  std::vector<bool> is_child(document.nodes.size(), false);
  for (const GltfNode& node : document.nodes) {
    for (const std::size_t child : node.children) is_child[child] = true;
  }
  for (std::size_t s = 0; s < document.scenes.size(); ++s) {
    for (const std::size_t node : document.scenes[s]) {
      if (!is_child[node]) continue;
      return fail(ErrorCode::mesh_invalid, "scene " + std::to_string(s) + ": node " +
                                               std::to_string(node) + " is another's child.");
    }
  }
  for (std::size_t m = 0; m < document.meshes.size(); ++m) {
    const auto& primitives = document.meshes[m].primitives;
    for (std::size_t p = 0; p < primitives.size(); ++p) {
      if (auto sound = check_primitive(document, buffers, primitives[p], file_bytes, left);
          !sound) {
        return in_primitive(std::move(sound.error()), m, p);
      }
    }
  }
  return {};
}

}  // namespace geodesic::proto
