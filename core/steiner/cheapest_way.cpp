#include "core/steiner/cheapest_way.h"

#include <algorithm>
#include <unordered_map>

#include "core/base/polled_sort.h"
#include "core/field/edge_points.h"

namespace geodesic {

CheapestWays::CheapestWays(const Adjacency& adjacency, const Field& field, Poll& poll)
    : adjacency_(adjacency), field_(field), poll_(poll) {
  if (!field.edge_points) return;
  for (std::uint32_t s = 0; s < field.sources.size(); ++s) {
    // From a vertex one comes by its node.
    if (field.sources[s].point.at_vertex()) continue;
    for (const SurfacePoint& place : in_all_faces(adjacency, field.sources[s].point)) {
      if (poll.cancelled()) return;
      source_places_.push_back({place.face, s});
    }
  }
  std::vector<SourcePlace> spare;
  polled_sort(
      source_places_, 0, source_places_.size(),
      [](const SourcePlace& a, const SourcePlace& b) {
        return a.face != b.face ? a.face < b.face : a.source < b.source;
      },
      spare, poll);
}

std::uint32_t CheapestWays::source_of_node(std::uint32_t node) const {
  if (field_.nearest_source.empty()) return 0;
  const std::uint32_t vertices = adjacency_.mesh().vertex_count();
  return node < vertices ? field_.nearest_source[node]
                         : field_.edge_points->nearest_source[node - vertices];
}

void CheapestWays::consider_node(std::uint32_t node, double d, double step, LastStep& best) const {
  if (!(d + step < best.cost)) return;
  best = {d + step, node, source_of_node(node)};
}

CheapestWays::LastStep CheapestWays::last_step_to(const SurfacePoint& point) const {
  LastStep best;
  if (point.at_vertex()) {
    consider_node(point.vertex, field_.distance[point.vertex], 0, best);
    return best;
  }
  if (!field_.edge_points || !field_.edge_points->cost) return best;
  const EdgePoints& points = *field_.edge_points;
  const TravelCost& cost = *points.cost;
  const Mesh& mesh = adjacency_.mesh();
  const Vec3 at = position_of(mesh, point);
  const double spacing = 1.0 / (double(points.per_edge) + 1);
  for (const SurfacePoint& place : in_all_faces(adjacency_, point)) {
    if (poll_.cancelled_after(1 + 3 * points.per_edge)) return best;
    const std::uint32_t f = place.face;
    const FaceRecord& face = adjacency_.face(f);
    for (std::uint32_t c = 0; c < 3; ++c) {
      const std::uint32_t v = face.vertex[c];
      consider_node(v, field_.distance[v], cost.of(f, mesh.positions()[v], at), best);
      const auto [low, high] = std::minmax({v, face.vertex[next_corner(c)]});
      const Vec3 from = mesh.positions()[low];
      const Vec3 along = mesh.positions()[high] - from;
      const std::uint32_t first = points.edge_of[halfedge(f, c)] * points.per_edge;
      for (std::uint32_t i = 0; i < points.per_edge; ++i) {
        const double d = points.distance[first + i];
        if (!(d < best.cost)) continue;
        const Vec3 node = from + (double(i) + 1) * spacing * along;
        consider_node(mesh.vertex_count() + first + i, d, cost.of(f, node, at), best);
      }
    }
    auto near = std::lower_bound(
        source_places_.begin(), source_places_.end(), f,
        [](const SourcePlace& source, std::uint32_t number) { return source.face < number; });
    for (; near != source_places_.end() && near->face == f; ++near) {
      if (poll_.cancelled()) return best;
      const Source& source = field_.sources[near->source];
      const double whole = source.offset + cost.of(f, position_of(mesh, source.point), at);
      if (whole < best.cost) best = {whole, kNone, near->source};
    }
  }
  return best;
}

std::vector<Crossing> CheapestWays::way_of(const LastStep& last) const {
  std::vector<Crossing> way;
  if (!field_.edge_points || field_.edge_points->before.empty()) return way;
  const EdgePoints& points = *field_.edge_points;
  const std::uint32_t vertices = adjacency_.mesh().vertex_count();
  std::unordered_map<std::uint32_t, Halfedge> edges;
  // Costs fall from node to node, so it ends.
  for (std::uint32_t node = last.node; node != kNone; node = points.before[node]) {
    if (poll_.cancelled()) return way;
    if (node < vertices) {
      way.push_back({node, kNone, 0});
    } else {
      const std::uint32_t edge = (node - vertices) / points.per_edge;
      edges.emplace(edge, kNone);
      way.push_back({kNone, edge, (node - vertices) % points.per_edge + 1});
    }
  }
  std::reverse(way.begin(), way.end());
  // The least halfedge of an edge comes first.
  for (std::uint32_t f = 0; f < adjacency_.faces().size() && !edges.empty(); ++f) {
    if (poll_.cancelled()) return way;
    for (std::uint32_t c = 0; c < 3; ++c) {
      const auto edge = edges.find(points.edge_of[halfedge(f, c)]);
      if (edge != edges.end() && edge->second == kNone) edge->second = halfedge(f, c);
    }
  }
  for (Crossing& crossing : way) {
    if (crossing.vertex == kNone) crossing.edge = edges.at(crossing.edge);
  }
  return way;
}

}  // namespace geodesic
