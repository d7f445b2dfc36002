// The graph in which `steiner_path` finds a path again, among points that lie closer on the edges.
#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/vec3.h"
#include "core/field/travel_cost.h"
#include "core/field/vertex_heap.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"

namespace geodesic {

// A point of the path between its ends: a vertex, or a point on an edge at `step` of
// as many equal steps as the round has, counted from the smaller vertex number.
struct Crossing {
  std::uint32_t vertex = kNone;
  Halfedge edge = kNone;  // the least halfedge of its ring
  std::uint32_t step = 0;
};

// The one halfedge of an edge that stands for it.
[[nodiscard]] Halfedge least_in_ring(const Adjacency& adjacency, Halfedge h);

// The graph of one pass: the faces around a path, and on their edges the points
// near it. Nodes: 0 is the path's start and 1 its end, wherever they are.
class StripGraph {
 public:
  // `cost`: what the ways cost that are to be cheap instead of short, or null.
  StripGraph(const Adjacency& adjacency, const SurfacePoint& from, const SurfacePoint& to,
             const std::vector<Crossing>& path, std::uint32_t steps, const TravelCost* cost,
             Poll& poll);

  // The shortest way from start to end: its points between them, and its length or cost;
  // kUnreached when there is none, or when the poll says to stop.
  double shortest(std::vector<Crossing>& way, VertexHeap& heap, Poll& poll);

 private:
  struct Node {
    Crossing crossing;
    Vec3 at;
  };
  struct Window {
    Halfedge edge;
    std::uint32_t first;
    std::uint32_t last;
  };

  // The smaller vertex number first.
  [[nodiscard]] std::pair<std::uint32_t, std::uint32_t> ends_of(Halfedge h) const;

  void add_window(const Crossing& crossing);
  void add_edges_at_vertices(Poll& poll);
  // As least_in_ring. Where the edge is in more than two faces, it becomes known.
  Halfedge least_of_new_ring(Halfedge h, std::unordered_set<Halfedge>& known, Poll& poll) const;

  void make_nodes(Poll& poll);
  void make_vertex(std::uint32_t v);

  // Every face with a point on a side, and those of the path's ends. All its nodes
  // are joined to each other: what is on one side, along it.
  void gather_faces(Poll& poll);

  // Whether another face joins the same nodes: a later one with the same corners, and no end of
  // the path is inside this one.
  [[nodiscard]] bool is_repeated(std::uint32_t f) const;

  std::uint32_t number_of(std::uint32_t face);
  void join(std::uint32_t f, std::uint32_t node);

  struct PointsOfEdge {
    Halfedge edge;
    std::uint32_t first_node;
    std::uint32_t last_node;  // one past
  };

  const Adjacency& adjacency_;
  std::uint32_t steps_;
  const TravelCost* cost_;
  std::array<const SurfacePoint*, 2> ends_;
  std::vector<std::uint32_t> near_;  // vertices that the path passes or comes near
  std::vector<Window> windows_;
  std::vector<Node> nodes_;
  std::vector<PointsOfEdge> points_of_edge_;
  std::unordered_map<std::uint32_t, std::uint32_t> node_of_vertex_;
  std::unordered_map<std::uint32_t, std::uint32_t> number_of_face_;
  std::vector<std::uint32_t> faces_;                  // by face number
  std::vector<std::vector<std::uint32_t>> nodes_in_;  // by face number
  std::vector<std::vector<std::uint32_t>> faces_at_;  // by node
};

}  // namespace geodesic
