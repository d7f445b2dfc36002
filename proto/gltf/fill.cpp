#include "proto/gltf/fill.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

namespace geodesic::proto {
namespace {

bool is_finite(const Vec3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

// `read(i)` gives position i as the file has it.
template <class Read>
std::optional<BadPosition> fill(const Read& read, const GltfTransform& to_world,
                                std::span<Vec3> out) {
  // No branch per vertex: x - x is 0 for a finite x, else NaN, and so is the sum.
  double probe = 0;
  const auto accept = [&probe](Vec3 p) {
    probe += (p.x - p.x) + (p.y - p.y) + (p.z - p.z);
    return p;
  };
  if (to_world == GltfTransform{}) {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = accept(read(i));
  } else {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = accept(to_world.point(read(i)));
  }
  if (probe == 0) return std::nullopt;
  const auto bad = std::ranges::find_if_not(out, is_finite);
  const auto element = static_cast<std::size_t>(bad - out.begin());
  return BadPosition{element, !is_finite(read(element))};
}

template <class T>
std::optional<BadPosition> fill_as(const GltfElements& elements, const GltfTransform& to_world,
                                   std::span<Vec3> out) {
  if constexpr (std::is_integral_v<T>) {
    if (elements.normalized) {
      constexpr double kFull = std::numeric_limits<T>::max();
      const auto value = [&](std::uint64_t i, int which) {
        return std::max(elements.component<T>(i, which) / kFull, -1.0);
      };
      return fill(
          [&](std::uint64_t i) {
            return Vec3{value(i, 0), value(i, 1), value(i, 2)};
          },
          to_world, out);
    }
  }
  const auto value = [&](std::uint64_t i, int which) {
    return static_cast<double>(elements.component<T>(i, which));
  };
  return fill(
      [&](std::uint64_t i) {
        return Vec3{value(i, 0), value(i, 1), value(i, 2)};
      },
      to_world, out);
}

// `index(k)` gives the vertex of corner k. Returns the greatest index.
template <class Index>
std::uint64_t expand(const Index& index, int mode, std::uint32_t base, std::span<Face> out) {
  std::uint32_t greatest = 0;
  const auto write = [&](Face& face, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    greatest = std::max({greatest, a, b, c});
    face = {base + a, base + b, base + c};
  };
  for (std::size_t f = 0; f < out.size(); ++f) {
    if (mode == gltf_triangles) {
      write(out[f], index(3 * f), index(3 * f + 1), index(3 * f + 2));
    } else if (mode == gltf_triangle_strip) {
      write(out[f], index(f), index(f + 1 + f % 2), index(f + 2 - f % 2));
    } else {
      write(out[f], index(f + 1), index(f + 2), index(0));
    }
  }
  return greatest;
}

template <class T>
std::optional<BadIndex> fill_faces_as(const GltfElements& indices, int mode, std::uint32_t base,
                                      std::uint64_t vertices, std::span<Face> out) {
  const auto index = [&](std::uint64_t k) -> std::uint32_t { return indices.component<T>(k, 0); };
  if (expand(index, mode, base, out) < vertices) return std::nullopt;
  for (std::uint64_t k = 0; k < indices.count; ++k) {
    if (index(k) >= vertices) {
      return BadIndex{k, index(k), index(k) == std::numeric_limits<T>::max()};
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<BadPosition> fill_positions(const GltfElements& elements,
                                          const GltfTransform& to_world, std::span<Vec3> out) {
  switch (elements.component_type) {
    case gltf_int8:
      return fill_as<std::int8_t>(elements, to_world, out);
    case gltf_uint8:
      return fill_as<std::uint8_t>(elements, to_world, out);
    case gltf_int16:
      return fill_as<std::int16_t>(elements, to_world, out);
    case gltf_uint16:
      return fill_as<std::uint16_t>(elements, to_world, out);
    default:
      return fill_as<float>(elements, to_world, out);
  }
}

std::optional<BadPosition> fill_positions(std::span<const Vec3> positions,
                                          const GltfTransform& to_world, std::span<Vec3> out) {
  return fill([&](std::uint64_t i) { return positions[i]; }, to_world, out);
}

std::optional<BadIndex> fill_faces(const GltfElements& indices, int mode, std::uint32_t base,
                                   std::uint64_t vertices, std::span<Face> out) {
  switch (indices.component_type) {
    case gltf_uint8:
      return fill_faces_as<std::uint8_t>(indices, mode, base, vertices, out);
    case gltf_uint16:
      return fill_faces_as<std::uint16_t>(indices, mode, base, vertices, out);
    default:
      return fill_faces_as<std::uint32_t>(indices, mode, base, vertices, out);
  }
}

void fill_faces(int mode, std::uint32_t base, std::span<Face> out) {
  (void)expand([](std::uint64_t k) { return static_cast<std::uint32_t>(k); }, mode, base, out);
}

}  // namespace geodesic::proto
