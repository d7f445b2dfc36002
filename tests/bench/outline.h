// Solids as CAD programs export them: flat regions cut up into long triangles over their outlines.
#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh/triangle_soup.h"

namespace geodesic::bench {

struct OutlinePoint {
  double x = 0;
  double y = 0;
};
// Closed, without a point twice. The outer one goes counter-clockwise, holes clockwise.
using Outline = std::vector<OutlinePoint>;

[[nodiscard]] Outline circle(OutlinePoint centre, double radius, std::uint32_t points,
                             bool clockwise = false);

// The solid between z = 0 and `height` over a region: two flat faces, cut up by clipping ears, and
// walls in `rings` rows of squares, each cut in two.
[[nodiscard]] TriangleSoup extrusion(const Outline& outer, const std::vector<Outline>& holes,
                                     double height, std::uint32_t rings);

struct ProfilePoint {
  double radius = 0;  // zero: on the axis
  double z = 0;
};
// A turned part: the profile round the z axis, with a fan where it meets the axis.
[[nodiscard]] TriangleSoup turned(const std::vector<ProfilePoint>& profile, std::uint32_t around);

// What is below the plane with this normal through `at`, closed by a flat face, of a solid that the
// plane meets in one convex curve. Faces at the cut become slivers as boolean operations leave
// them.
[[nodiscard]] TriangleSoup cut_off(const TriangleSoup& solid, Vec3 normal, Vec3 at);

}  // namespace geodesic::bench
