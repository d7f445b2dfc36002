// Which faces windows run over: those of the mesh, of its intrinsic Delaunay triangulation, or of
// its refined surface. The mesh's vertices have the same distances on all; what differs is how many
// edges lie in the way.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/field/field.h"
#include "core/surface/adjacency.h"
#include "core/surface/triangulation.h"

namespace geodesic::exact {

// A surface of the mesh has so many edges: vertices less edges plus faces are as many however it is
// cut up.
[[nodiscard]] std::size_t count_edges(const Adjacency& adjacency, const Triangulation& surface);

// Whether that surface of the mesh is its refined one.
[[nodiscard]] bool is_refined(const Adjacency& adjacency, const Triangulation& surface);

// A point in a face: its barycentric weights, and how far it is from the corners.
struct PlaceInFace {
  std::uint32_t face;
  std::array<double, 3> weights;
  std::array<double, 3> to_corner;
};

// The faces of a surface of the mesh that a point inside one of the mesh's faces, or on an edge,
// lies in. Empty where that is not known: on the Delaunay triangulation, and at some places of a
// refined surface.
[[nodiscard]] std::vector<PlaceInFace> places_on(const Adjacency& adjacency,
                                                 const Triangulation& surface,
                                                 const SurfacePoint& point, Poll& poll);

// The one on which straight lines away from the sources cross the fewest edges, or nearly so, of
// those that have a place for each source.
// Estimated as in Cauchy's and Crofton's formula: lines with the direction u across a face
// cross its side e in proportion to |e x u|, those of any direction to |e| 2 / pi. On the mesh
// u is taken straight away from the nearest source in space; the other two have no
// directions to speak of. The faces of the mesh if the poll says to stop.
[[nodiscard]] Triangulation surface_for_windows(const Adjacency& adjacency,
                                                std::span<const Source> sources, Poll& poll);

// The same for a machine part, whose windows may be kept: surfaces on which points may have no
// places only where lines cross less than a third as many edges on them as on the mesh.
[[nodiscard]] Triangulation surface_of_part(const Adjacency& adjacency,
                                            std::span<const Source> sources, Poll& poll);

// The same of the mesh's own faces and the refined surface alone: the latter only where all its
// vertices have directions (RefinedSurface::has_all_directions).
[[nodiscard]] Triangulation surface_with_directions(const Adjacency& adjacency,
                                                    std::span<const Source> sources, Poll& poll);

}  // namespace geodesic::exact
