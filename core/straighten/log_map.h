// The surface round a point laid into the plane that touches it there: at each vertex the distance
// from the point, and the direction in which the shortest path to the vertex leaves it. This is
// the logarithmic map, the inverse of going straight ahead (straightest_geodesic.h) as far as
// shortest paths are straight: do Carmo, "Riemannian Geometry", 1992, chapter 3; on meshes
// Schmidt, Grimm and Wyvill, "Interactive decal compositing with discrete exponential maps", 2006.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/base/vec2.h"
#include "core/base/vec3.h"
#include "core/field/field.h"
#include "core/straighten/refine_path.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"

namespace geodesic {

struct LogMap {
  struct Entry {
    std::uint32_t vertex;
    double distance;  // the length of the path, mesh units
    // Radians, as straightest_geodesic_at_angle has them; 0 at the point itself, and where edges
    // without a length leave no direction.
    double angle;
    // The path comes to no other vertex, nor to an edge of three faces: going straight ahead leads
    // there.
    bool is_straight;
  };
  double total_angle = 0;      // of all directions at the point
  bool all_round = true;       // whether no boundary is in the way
  double scale = 1;            // of angles, to the plane: DirectionsAt::scale
  std::vector<Entry> entries;  // by vertex
  // For each entry, if they were asked for: a direction at the point carried along the entry's path
  // by parallel transport. Of length one, in the plane of the face in which the path arrives; zero
  // where there is none: where edges without a length leave no direction, where the path passes a
  // vertex at which the faces are no fan, and at the point itself if no face there has the
  // direction.
  std::vector<Vec3> directions;

  // In the plane, mesh units: the x axis is the direction of that angle, and y is to the left of
  // it. Round a vertex whose angles do not add up to a full turn, they are spread or pressed
  // together to make one; at a boundary only if they are more.
  [[nodiscard]] Vec2 coordinates(const Entry& entry, double x_axis = 0) const;
  [[nodiscard]] std::uint64_t bytes() const {
    return entries.capacity() * sizeof(Entry) + directions.capacity() * sizeof(Vec3);
  }
};

// The point itself; or, within 1e-6 of a face's size of an edge or a vertex, that of the edge or
// the vertex: a path past them does not say in which direction it set out.
[[nodiscard]] SurfacePoint snap_to_edges(const Adjacency& adjacency, const SurfacePoint& point);

// How much farther away than by its path a vertex may be by the field, and still have its place.
inline constexpr double kFieldBeyondRadius = 1.1;

// Of the vertices that a path no longer than `radius` leads to, by the field, which is of `from`
// alone, snapped to edges, and without an offset, with details, and has all vertices to two edges
// beyond kFieldBeyondRadius times the radius. A refined path for each, by path_through.
//
// `carried`: the angle of the direction, radians, that is carried along each path. Unfolded, it
// keeps its angle to the path over each edge. At a vertex that the path passes, it keeps it as
// angles are once they are spread over a full turn (`scale`): the parallel translation of Polthier
// and Schmies, "Straightest geodesics on polyhedral surfaces", 1998. At the point itself, too, so
// that it has to the path there the angle that the x axis of that angle has to the vertex's
// coordinates.
//
// Errors: those of DirectionsAt; cancelled.
[[nodiscard]] Result<LogMap> log_map(const Adjacency& adjacency, const Field& field,
                                     const SurfacePoint& from, double radius, const Cancel& cancel,
                                     std::optional<double> carried = std::nullopt);

}  // namespace geodesic
