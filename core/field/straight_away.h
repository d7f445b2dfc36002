// Which way straight lines in space lead away from the sources, and how wide faces are
// across it: what can be told of shortest paths before there are any.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/base/vec3.h"
#include "core/field/field.h"
#include "core/mesh/mesh.h"
#include "core/surface/point.h"

namespace geodesic {

class StraightAway {
 public:
  // The mesh must outlive this object.
  StraightAway(const Mesh& mesh, std::span<const Source> sources) : positions_(mesh.positions()) {
    for (const Source& source : sources.first(std::min(sources.size(), kMostSources))) {
      sources_.push_back(position_of(mesh, source.point));
    }
  }

  // Of each side, its extent in the triangle's plane across the way from the nearest source;
  // nothing where that way goes through the plane or the triangle has no area. There must
  // be a source.
  [[nodiscard]] std::optional<std::array<double, 3>> extents_across(
      const std::array<std::uint32_t, 3>& triangle) const {
    const Vec3 a = positions_[triangle[0]];
    const Vec3 b = positions_[triangle[1]];
    const Vec3 c = positions_[triangle[2]];
    const std::array<Vec3, 3> sides{b - a, c - b, a - c};
    const Vec3 away = from_nearest((1.0 / 3) * (a + b + c));
    // In the triangle's plane, turned by a right angle, and twice the area too long.
    const Vec3 turned = cross(cross(sides[0], sides[1]), away);
    const double scale = norm(turned);
    if (!(scale > 0)) return {};
    std::array<double, 3> extents;
    for (std::size_t i = 0; i < 3; ++i) extents[i] = std::abs(dot(sides[i], turned)) / scale;
    return extents;
  }

 private:
  // Among so many of the sources the nearest is looked for.
  static constexpr std::size_t kMostSources = 8;

  [[nodiscard]] Vec3 from_nearest(const Vec3& place) const {
    Vec3 best = place - sources_.front();
    for (const Vec3& source : sources_) {
      const Vec3 way = place - source;
      if (dot(way, way) < dot(best, best)) best = way;
    }
    return best;
  }

  std::span<const Vec3> positions_;
  std::vector<Vec3> sources_;
};

}  // namespace geodesic
