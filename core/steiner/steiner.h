// The distance field of Kanai and Suzuki, "Approximate shortest path on a polyhedral
// surface and its applications", CAD 2001: Dijkstra's algorithm on a graph of the
// mesh's vertices and of points on its edges, joined straight across the faces.
// Every distance is the length of a path on the surface, so never below the true
// one; the more points there are, the closer it comes.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/field.h"
#include "core/field/travel_cost.h"
#include "core/surface/adjacency.h"
#include "core/wavefront/wavefront.h"

namespace geodesic {

// Vertices and points on edges together may not be more than this.
inline constexpr std::uint64_t kMaxSteinerNodes = std::uint64_t{1} << 31U;

// The edges of a mesh, numbered. core/exact/frames.h numbers edges too, and it cannot be for both:
// there they are those of a triangulation, whose edges need not be the mesh's, and the number
// stands in the record of a face that windows are carried across. Here it outlives the computation,
// by halfedge alone, in the details that a field keeps (core/field/edge_points.h).
struct EdgeNumbers {
  std::vector<std::uint32_t> of;  // by halfedge 4f + c
  std::vector<Halfedge> first;    // by edge: one of its halfedges

  // Incomplete if the poll says to stop.
  [[nodiscard]] static EdgeNumbers count(const Adjacency& adjacency, Poll& poll);
};

// The distances from the nearest of the sources in the graph with `points_per_edge`
// evenly spaced points inside each edge. Two nodes are joined when they lie on
// different sides of a face, or next to each other on an edge; a source is joined
// to all nodes of the faces it lies in. With k points, the path along which a front
// crosses a face may turn by an angle of about 1 / (k + 1) at each edge, and the
// error falls with the square of that. Nodes: V + k E; arcs: about 6 k^2 a face.
// With a cost, all that is said of distances is said of the costs of ways from the sources:
// Lanthier, Maheshwari, Sack, "Approximating weighted shortest paths on polyhedral surfaces", SCG
// 1997. Each is that of a way in the graph, so never below the least there is. It is above it by no
// more than the sum over the edges that the cheapest way crosses of their spacing times the greater
// of the weights beside them, where there are no slopes.
// With targets and details, the field goes on by limits.beyond_targets, in its own unit. What it
// comes to there keeps its distance, vertices too: of points in the targets' faces it then says
// what a whole field does, and has the same ways. Errors: cancelled; value_out_of_range
// ("points_per_edge") when there is no point or there are more nodes than kMaxSteinerNodes.
[[nodiscard]] Result<Field> steiner_field(const Adjacency& adjacency,
                                          std::span<const Source> sources,
                                          std::uint32_t points_per_edge, const FieldLimits& limits,
                                          WavefrontScratch& scratch, const Cancel& cancel,
                                          const std::shared_ptr<const TravelCost>& cost = nullptr);

// The same from one source, only as far as it takes to have the distance of `goal`,
// any point of the surface, and the path to it. Keeps the points on edges.
[[nodiscard]] Result<Field> steiner_field_towards(
    const Adjacency& adjacency, const Source& source, const SurfacePoint& goal,
    std::uint32_t points_per_edge, WavefrontScratch& scratch, const Cancel& cancel,
    const std::shared_ptr<const TravelCost>& cost = nullptr);

}  // namespace geodesic
