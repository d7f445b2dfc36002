#include "core/steiner/steiner.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "core/base/polled_fill.h"
#include "core/base/polled_sort.h"
#include "core/field/edge_points.h"
#include "core/field/remaining_targets.h"
#include "core/surface/copied_faces.h"

namespace geodesic {
namespace {

// Nodes are numbered: the vertices first, then the points of each edge in turn.
class SteinerGraph {
 public:
  // Incomplete if the poll says to stop.
  SteinerGraph(const Adjacency& adjacency, std::uint32_t points_per_edge, const TravelCost* cost,
               Poll& poll)
      : adjacency_(adjacency),
        cost_(cost),
        vertex_count_(adjacency.mesh().vertex_count()),
        per_edge_(points_per_edge),
        spacing_(1.0 / (double(points_per_edge) + 1)),
        // Of copies each may have a weight of its own.
        has_copies_(adjacency.report().faces_duplicate > 0 &&
                    !(cost != nullptr && cost->has_weights())),
        edges_(EdgeNumbers::count(adjacency, poll)) {}

  [[nodiscard]] std::uint32_t node_count() const {
    return vertex_count_ + per_edge_ * static_cast<std::uint32_t>(edges_.first.size());
  }
  [[nodiscard]] std::uint32_t vertex_count() const { return vertex_count_; }
  [[nodiscard]] EdgeNumbers take_edges() { return std::move(edges_); }

  // How far it is straight inside a face from one point to another, or what that costs.
  [[nodiscard]] double length(std::uint32_t f, Vec3 from, Vec3 to) const {
    return cost_ == nullptr ? distance(from, to) : cost_->of(f, from, to);
  }

  // Calls `visit(node, position, face)` for the points of side c of a face …
  template <class Visit>
  void points_of_side(std::uint32_t f, std::uint32_t c, Visit visit) const {
    const std::uint32_t edge = edges_.of[halfedge(f, c)];
    const std::uint32_t first = vertex_count_ + edge * per_edge_;
    const auto [from, along] = ends(f, c);
    for (std::uint32_t i = 0; i < per_edge_; ++i) visit(first + i, place(from, along, i), f);
  }

  // … and for all nodes of a face.
  template <class Visit>
  void nodes_of_face(std::uint32_t f, Visit visit) const {
    for (std::uint32_t c = 0; c < 3; ++c) {
      const std::uint32_t v = adjacency_.face(f).vertex[c];
      visit(v, adjacency_.mesh().positions()[v], f);
      points_of_side(f, c, visit);
    }
  }

  // Whether the nodes of a face are those of a later one, with the same corners.
  [[nodiscard]] bool is_repeated(std::uint32_t f) const {
    return has_copies_ && has_later_copy(adjacency_, f);
  }

  // Calls `visit(node, position, face)` for every node that `node` is joined to in the face, and
  // perhaps twice. Of an edge's faces each is asked where there are costs, for the least. Leaves
  // off when the poll says to stop: a vertex may be in all faces.
  template <class Visit>
  void neighbours(std::uint32_t node, Visit visit, Poll& poll) const {
    if (node < vertex_count_) {
      for (const std::uint32_t corner : adjacency_.corners(node)) {
        if (poll.cancelled()) return;
        const std::uint32_t f = face_of(corner);
        if (is_repeated(f)) continue;
        const std::uint32_t c = corner_of(corner);
        points_of_side(f, next_corner(c), visit);
        next_on_side(f, c, node, visit);
        next_on_side(f, previous_corner(c), node, visit);
      }
      return;
    }
    const Halfedge first = edges_.first[(node - vertex_count_) / per_edge_];
    const std::uint32_t i = (node - vertex_count_) % per_edge_;
    if (cost_ == nullptr) next_on_edge(first, i, node, visit);
    Halfedge h = first;
    do {
      if (poll.cancelled()) return;
      const std::uint32_t f = face_of(h);
      const std::uint32_t c = corner_of(h);
      if (cost_ != nullptr) next_on_edge(h, i, node, visit);
      h = adjacency_.ring(h);
      if (is_repeated(f)) continue;
      const std::uint32_t opposite = adjacency_.face(f).vertex[previous_corner(c)];
      visit(opposite, adjacency_.mesh().positions()[opposite], f);
      points_of_side(f, next_corner(c), visit);
      points_of_side(f, previous_corner(c), visit);
    } while (h != first);
  }

  [[nodiscard]] Vec3 position(std::uint32_t node) const {
    if (node < vertex_count_) return adjacency_.mesh().positions()[node];
    const Halfedge h = edges_.first[(node - vertex_count_) / per_edge_];
    const auto [from, along] = ends(face_of(h), corner_of(h));
    return place(from, along, (node - vertex_count_) % per_edge_);
  }

 private:
  // The end with the smaller vertex number, and the way from there to the other.
  [[nodiscard]] std::pair<Vec3, Vec3> ends(std::uint32_t f, std::uint32_t c) const {
    const auto [low, high] =
        std::minmax({adjacency_.face(f).vertex[c], adjacency_.face(f).vertex[next_corner(c)]});
    const Vec3 from = adjacency_.mesh().positions()[low];
    return {from, adjacency_.mesh().positions()[high] - from};
  }
  [[nodiscard]] Vec3 place(Vec3 from, Vec3 along, std::uint32_t i) const {
    return from + (double(i) + 1) * spacing_ * along;
  }

  // The point next to the vertex v on side c, which ends there.
  template <class Visit>
  void next_on_side(std::uint32_t f, std::uint32_t c, std::uint32_t v, Visit visit) const {
    const FaceRecord& face = adjacency_.face(f);
    const bool is_low = std::min(face.vertex[c], face.vertex[next_corner(c)]) == v;
    const std::uint32_t node =
        vertex_count_ + edges_.of[halfedge(f, c)] * per_edge_ + (is_low ? 0 : per_edge_ - 1);
    visit(node, position(node), f);
  }

  template <class Visit>
  void next_on_edge(Halfedge h, std::uint32_t i, std::uint32_t node, Visit visit) const {
    const FaceRecord& face = adjacency_.face(face_of(h));
    const auto [low, high] =
        std::minmax({face.vertex[corner_of(h)], face.vertex[next_corner(corner_of(h))]});
    const std::uint32_t before = i == 0 ? low : node - 1;
    const std::uint32_t after = i + 1 == per_edge_ ? high : node + 1;
    visit(before, position(before), face_of(h));
    visit(after, position(after), face_of(h));
  }

  const Adjacency& adjacency_;
  const TravelCost* cost_;  // null: lengths
  std::uint32_t vertex_count_;
  std::uint32_t per_edge_;
  double spacing_;
  bool has_copies_;
  EdgeNumbers edges_;
};

// Calls `visit(node, position, face)` for all nodes of the faces that a point lies in, and perhaps
// twice. Leaves off when the poll says to stop.
template <class Visit>
void nodes_around(const SteinerGraph& graph, std::span<const SurfacePoint> places, Visit visit,
                  Poll& poll) {
  for (const SurfacePoint& place : places) {
    if (poll.cancelled()) return;
    // Alone it is inside its face, and in no later one.
    if (places.size() > 1 && graph.is_repeated(place.face)) continue;
    graph.nodes_of_face(place.face, visit);
  }
}

// A point that a search is for: known once nothing that is still to come can
// shorten the way to it.
class Goal {
 public:
  // Of no use if the poll says to stop.
  Goal(const Adjacency& adjacency, const SteinerGraph& graph, const Source& source,
       const SurfacePoint& point, Poll& poll) {
    if (point.at_vertex()) {
      ways_.push_back({point.vertex, 0});
      return;
    }
    const Vec3 at = position_of(adjacency.mesh(), point);
    const auto places = in_all_faces(adjacency, point);
    const auto add = [&](std::uint32_t node, Vec3 from, std::uint32_t f) {
      ways_.push_back({node, graph.length(f, from, at)});
    };
    nodes_around(graph, places, add, poll);
    std::vector<std::pair<std::uint32_t, double>> spare;
    polled_sort(ways_, 0, ways_.size(), std::less<>(), spare, poll);
    const Vec3 start = position_of(adjacency.mesh(), source.point);
    each_shared_face(places, in_all_faces(adjacency, source.point), poll, [&](std::uint32_t f) {
      best_ = std::min(best_, source.offset + graph.length(f, start, at));
    });
  }

  void accept(std::uint32_t node, double d) {
    auto way = std::lower_bound(ways_.begin(), ways_.end(), std::pair{node, 0.0});
    for (; way != ways_.end() && way->first == node; ++way)
      best_ = std::min(best_, d + way->second);
  }
  [[nodiscard]] double best() const { return best_; }

 private:
  // Both may lie in all of an edge's faces.
  template <class Visit>
  static void each_shared_face(std::span<const SurfacePoint> some,
                               std::span<const SurfacePoint> others, Poll& poll, Visit visit) {
    std::vector<std::uint32_t> faces;
    faces.reserve(others.size());
    for (const SurfacePoint& place : others) faces.push_back(place.face);
    std::vector<std::uint32_t> spare;
    polled_sort(faces, 0, faces.size(), std::less<>(), spare, poll);
    for (const SurfacePoint& place : some) {
      if (poll.cancelled()) return;
      if (std::binary_search(faces.begin(), faces.end(), place.face)) visit(place.face);
    }
  }

  std::vector<std::pair<std::uint32_t, double>> ways_;  // by node, the length from there
  double best_ = kUnreached;
};

class SteinerFront {
 public:
  SteinerFront(const Adjacency& adjacency, const SteinerGraph& graph, Field& field,
               EdgePoints& points, VertexHeap& heap, Poll& poll)
      : adjacency_(adjacency),
        graph_(graph),
        field_(field),
        distance_(field.distance.doubles()),
        points_(points),
        heap_(heap),
        poll_(poll) {}

  void start(const Source& source, std::uint32_t number) {
    if (source.point.at_vertex()) lower(source.point.vertex, source.offset, number, kNone);
    const Vec3 at = position_of(adjacency_.mesh(), source.point);
    const auto come_to = [&](std::uint32_t node, Vec3 to, std::uint32_t f) {
      lower(node, source.offset + graph_.length(f, at, to), number, kNone);
    };
    nodes_around(graph_, in_all_faces(adjacency_, source.point), come_to, poll_);
  }

  void spread_from(std::uint32_t node, double d) {
    const Vec3 at = graph_.position(node);
    const std::uint32_t source = field_.nearest_source.empty() ? 0 : source_at(node);
    const auto come_to = [&](std::uint32_t to, Vec3 there, std::uint32_t f) {
      if (heap_.accepted(to)) return;
      double sum = d + graph_.length(f, at, there);
      // However short the step beside the distance: the way back is found by
      // distances that fall.
      if (!(sum > d)) sum = std::nextafter(d, std::numeric_limits<double>::infinity());
      lower(to, sum, source, node);
    };
    graph_.neighbours(node, come_to, poll_);
  }

  // What is still considered is not final.
  void forget(std::uint32_t node) {
    distance_at(node) = kUnreached;
    if (!field_.nearest_source.empty()) source_at(node) = kNone;
  }

 private:
  double& distance_at(std::uint32_t node) {
    return node < graph_.vertex_count() ? distance_[node]
                                        : points_.distance[node - graph_.vertex_count()];
  }
  std::uint32_t& source_at(std::uint32_t node) {
    return node < graph_.vertex_count() ? field_.nearest_source[node]
                                        : points_.nearest_source[node - graph_.vertex_count()];
  }
  void lower(std::uint32_t node, double d, std::uint32_t source, std::uint32_t before) {
    double& known = distance_at(node);
    if (!(d < known)) return;
    known = d;
    if (!field_.nearest_source.empty()) source_at(node) = source;
    if (!points_.before.empty()) points_.before[node] = before;
    heap_.push_or_lower(node, d);
  }

  const Adjacency& adjacency_;
  const SteinerGraph& graph_;
  Field& field_;
  std::span<double> distance_;  // the field's
  EdgePoints& points_;
  VertexHeap& heap_;
  Poll& poll_;
};

Result<Field> search(const Adjacency& adjacency, std::span<const Source> sources,
                     const SurfacePoint* goal_point, std::uint32_t points_per_edge,
                     const FieldLimits& limits, const std::shared_ptr<const TravelCost>& cost,
                     WavefrontScratch& scratch, const Cancel& cancel) {
  const std::uint64_t vertex_count = adjacency.mesh().vertex_count();
  const std::uint64_t most = (kMaxSteinerNodes - std::min(kMaxSteinerNodes, vertex_count)) /
                             std::max<std::uint64_t>(adjacency.report().edges, 1);
  if (points_per_edge == 0) {
    return fail(ErrorCode::value_out_of_range, "at least one point on each edge",
                "points_per_edge");
  }
  if (points_per_edge > most) {
    return fail_limit(ErrorCode::value_out_of_range, "too many points for a mesh of this size",
                      most, points_per_edge, "points_per_edge");
  }
  // A face of a node has two or three times as many neighbours as there are points on an edge.
  Poll poll(cancel, std::max(8192 / points_per_edge, 1U));
  SteinerGraph graph(adjacency, points_per_edge, cost.get(), poll);
  if (poll.stopped()) return fail_stopped(cancel);
  const std::size_t point_count = graph.node_count() - vertex_count;
  Field field;
  field.method = Method::steiner;
  field.sources.assign(sources.begin(), sources.end());
  field.distance.assign(vertex_count, kUnreached);
  auto points = std::make_shared<EdgePoints>();
  points->per_edge = points_per_edge;
  polled_assign(points->distance, point_count, kUnreached, poll);
  points->cost = cost;
  if (cost && limits.keep_details) polled_assign(points->before, graph.node_count(), kNone, poll);
  if (sources.size() > 1) {
    field.nearest_source.assign(vertex_count, kNone);
    polled_assign(points->nearest_source, point_count, kNone, poll);
  }
  if (poll.stopped()) return fail_stopped(cancel);
  VertexHeap& heap = scratch.heap;
  heap.reset(graph.node_count());
  SteinerFront front(adjacency, graph, field, *points, heap, poll);
  // Each may be in all faces.
  for (std::uint32_t s = 0; s < sources.size() && !poll.stopped(); ++s) front.start(sources[s], s);
  std::optional<Goal> goal;
  if (goal_point != nullptr) goal.emplace(adjacency, graph, sources.front(), *goal_point, poll);
  RemainingTargets targets(limits.targets, vertex_count, scratch.is_target);
  // Without details no point inside a face is asked for.
  const double beyond = limits.keep_details ? limits.beyond_targets : 0;
  double end = limits.max;
  bool is_at_targets = false;
  std::uint64_t accepted = 0;
  while (!heap.empty()) {
    if (poll.cancelled(accepted++, graph.node_count())) {
      return fail_stopped(cancel);
    }
    const VertexHeap::Entry next = heap.pop();
    if (next.key > end || (goal && next.key > goal->best())) {
      front.forget(next.vertex);
      break;
    }
    if (next.vertex < vertex_count) targets.accept(next.vertex);
    if (goal) goal->accept(next.vertex, next.key);
    if (targets.done() && !is_at_targets) {
      if (!(beyond > 0)) break;
      is_at_targets = true;
      end = std::min(end, next.key + beyond);
    }
    front.spread_from(next.vertex, next.key);
  }
  for (const VertexHeap::Entry& entry : heap.entries()) {
    if (poll.cancelled()) break;
    front.forget(entry.vertex);
  }
  if (poll.stopped()) return fail_stopped(cancel);
  field.count_reached();
  if (limits.keep_details) {
    points->edge_of = graph.take_edges().of;
    field.edge_points = std::move(points);
  }
  return field;
}

}  // namespace

EdgeNumbers EdgeNumbers::count(const Adjacency& adjacency, Poll& poll) {
  EdgeNumbers edges;
  polled_assign(edges.of, 4 * adjacency.faces().size(), kNone, poll);
  edges.first.reserve(adjacency.report().edges);
  for (std::uint32_t f = 0; f < adjacency.faces().size() && !poll.cancelled(); ++f) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      const Halfedge first = halfedge(f, c);
      if (edges.of[first] != kNone) continue;
      const auto number = static_cast<std::uint32_t>(edges.first.size());
      edges.first.push_back(first);
      Halfedge h = first;
      do {
        edges.of[h] = number;
        h = adjacency.ring(h);
      } while (h != first && !poll.cancelled());
    }
  }
  return edges;
}

Result<Field> steiner_field(const Adjacency& adjacency, std::span<const Source> sources,
                            std::uint32_t points_per_edge, const FieldLimits& limits,
                            WavefrontScratch& scratch, const Cancel& cancel,
                            const std::shared_ptr<const TravelCost>& cost) {
  return search(adjacency, sources, nullptr, points_per_edge, limits, cost, scratch, cancel);
}

Result<Field> steiner_field_towards(const Adjacency& adjacency, const Source& source,
                                    const SurfacePoint& goal, std::uint32_t points_per_edge,
                                    WavefrontScratch& scratch, const Cancel& cancel,
                                    const std::shared_ptr<const TravelCost>& cost) {
  return search(adjacency, {&source, 1}, &goal, points_per_edge, {}, cost, scratch, cancel);
}

}  // namespace geodesic
