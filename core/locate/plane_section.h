// Where a plane cuts the surface: the one closed curve of the section that runs through a point or
// through three.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/base/vec3.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"

namespace geodesic {

// The curve of the section by the plane through `at`, at a right angle to `normal` (mesh
// coordinates, any length), that runs through `at`. Each point is on an edge or at a vertex, in the
// face of the segment that leaves it; no two in a row are one place; a last segment leads from the
// last point to the first.
//
// A vertex in the plane counts as above it, so a curve never forks at a vertex. Where several run
// through `at`, it is that in the first of the faces there. At an edge of three faces or more it
// goes on into the next one in their ring. Of faces with the same corners one is as good as all.
// Errors: value_out_of_range for `normal` (not finite, zero); no_loop (the curve comes to the
// boundary, or the plane only touches the surface there); cancelled.
[[nodiscard]] Result<std::vector<SurfacePoint>> plane_section(const Adjacency& adjacency,
                                                              const SurfacePoint& at, Vec3 normal,
                                                              const Cancel& cancel);

// A section, and the plane that it is in.
struct SectionOfPoints {
  std::vector<SurfacePoint> points;  // as of plane_section
  Vec3 normal;                       // mesh coordinates, of any length
};

// The section by the plane of three points, if one curve of it runs through all of them: the same
// in whichever order they are given. Where none does, vertices in the plane count as below it.
// Errors, with the parameters `around` and `around[K]`: value_out_of_range (they lie in one line,
// to rounding); no_loop as of plane_section, or where the curve through one of them does not run
// through another; cancelled.
[[nodiscard]] Result<SectionOfPoints> section_through(const Adjacency& adjacency,
                                                      const std::array<SurfacePoint, 3>& points,
                                                      const Cancel& cancel);

// The corners of the convex hull of points in a plane at a right angle to `normal`, in their order
// round it, by their places in `points`: what a tape lies on that is pulled tight round them.
// Andrew, "Another efficient algorithm for convex hulls in two dimensions", 1979. Two for points
// in a line. Errors: cancelled.
[[nodiscard]] Result<std::vector<std::uint32_t>> hull_in_plane(std::span<const Vec3> points,
                                                               Vec3 normal, const Cancel& cancel);

}  // namespace geodesic
