#include "core/steiner/strip_graph.h"

#include <algorithm>

#include "core/base/polled_sort.h"
#include "core/field/field.h"
#include "core/surface/copied_faces.h"

namespace geodesic {
namespace {

// How far the points of a round reach along an edge from where the last path
// crosses it, in points.
constexpr std::uint32_t kReach = 4;

}  // namespace

Halfedge least_in_ring(const Adjacency& adjacency, Halfedge h) {
  Halfedge least = h;
  for (Halfedge other = adjacency.ring(h); other != h; other = adjacency.ring(other)) {
    least = std::min(least, other);
  }
  return least;
}

StripGraph::StripGraph(const Adjacency& adjacency, const SurfacePoint& from, const SurfacePoint& to,
                       const std::vector<Crossing>& path, std::uint32_t steps,
                       const TravelCost* cost, Poll& poll)
    : adjacency_(adjacency), steps_(steps), cost_(cost), ends_{&from, &to} {
  for (const std::uint32_t end : {0U, 1U}) {
    nodes_.push_back({{ends_[end]->vertex, kNone, 0}, position_of(adjacency.mesh(), *ends_[end])});
    if (ends_[end]->at_vertex()) {
      node_of_vertex_.emplace(ends_[end]->vertex, end);
      near_.push_back(ends_[end]->vertex);
    }
  }
  for (const Crossing& crossing : path) add_window(crossing);
  add_edges_at_vertices(poll);
  make_nodes(poll);
  gather_faces(poll);
}

double StripGraph::shortest(std::vector<Crossing>& way, VertexHeap& heap, Poll& poll) {
  std::vector<double> known(nodes_.size(), kUnreached);
  std::vector<std::uint32_t> before(nodes_.size(), kNone);
  heap.reset(nodes_.size());
  known[0] = 0;
  heap.push_or_lower(0, 0);
  while (!heap.empty() && !heap.accepted(1)) {
    if (poll.cancelled()) return kUnreached;
    const VertexHeap::Entry next = heap.pop();
    for (const std::uint32_t f : faces_at_[next.vertex]) {
      if (poll.cancelled()) return kUnreached;
      for (const std::uint32_t node : nodes_in_[f]) {
        if (heap.accepted(node)) continue;
        const Vec3 from = nodes_[next.vertex].at;
        const Vec3 to = nodes_[node].at;
        const double d =
            next.key + (cost_ == nullptr ? distance(from, to) : cost_->of(faces_[f], from, to));
        if (!(d < known[node])) continue;
        known[node] = d;
        before[node] = next.vertex;
        heap.push_or_lower(node, d);
      }
    }
  }
  if (known[1] == kUnreached) return kUnreached;
  way.clear();
  for (std::uint32_t node = before[1]; node != 0; node = before[node]) {
    way.push_back(nodes_[node].crossing);
  }
  std::reverse(way.begin(), way.end());
  return known[1];
}

std::pair<std::uint32_t, std::uint32_t> StripGraph::ends_of(Halfedge h) const {
  const FaceRecord& face = adjacency_.face(face_of(h));
  return std::minmax({face.vertex[corner_of(h)], face.vertex[next_corner(corner_of(h))]});
}

void StripGraph::add_window(const Crossing& crossing) {
  if (crossing.vertex != kNone) {
    near_.push_back(crossing.vertex);
    return;
  }
  const auto [low, high] = ends_of(crossing.edge);
  const std::uint32_t to_high = steps_ - crossing.step;
  // What comes near a vertex may want to pass it on the other side.
  if (crossing.step <= kReach) near_.push_back(low);
  if (to_high <= kReach) near_.push_back(high);
  windows_.push_back({crossing.edge, crossing.step - std::min(crossing.step - 1, kReach),
                      crossing.step + std::min(to_high - 1, kReach)});
}

void StripGraph::add_edges_at_vertices(Poll& poll) {
  std::sort(near_.begin(), near_.end());
  near_.erase(std::unique(near_.begin(), near_.end()), near_.end());
  const std::uint32_t reach = std::min(kReach, steps_ - 1);
  std::unordered_set<Halfedge> known;  // of the vertex's edges that are in many faces
  for (const std::uint32_t v : near_) {
    known.clear();
    for (const std::uint32_t corner : adjacency_.corners(v)) {
      if (poll.cancelled()) return;
      const std::uint32_t c = corner_of(corner);
      for (const std::uint32_t side : {c, previous_corner(c)}) {
        const Halfedge h = halfedge(face_of(corner), side);
        if (known.contains(h)) continue;
        const Halfedge edge = least_of_new_ring(h, known, poll);
        const bool is_low = ends_of(edge).first == v;
        windows_.push_back({edge, is_low ? 1 : steps_ - reach, is_low ? reach : steps_ - 1});
      }
    }
  }
}

Halfedge StripGraph::least_of_new_ring(Halfedge h, std::unordered_set<Halfedge>& known,
                                       Poll& poll) const {
  Halfedge least = h;
  const bool is_shared = adjacency_.ring(adjacency_.ring(h)) != h;
  for (Halfedge other = adjacency_.ring(h); other != h && !poll.cancelled();
       other = adjacency_.ring(other)) {
    least = std::min(least, other);
    if (is_shared) known.insert(other);
  }
  return least;
}

void StripGraph::make_nodes(Poll& poll) {
  std::vector<Window> spare;
  const auto earlier = [](const Window& a, const Window& b) {
    return std::pair{a.edge, a.first} < std::pair{b.edge, b.first};
  };
  polled_sort(windows_, 0, windows_.size(), earlier, spare, poll);
  for (std::size_t i = 0; i < windows_.size() && !poll.cancelled();) {
    const Halfedge edge = windows_[i].edge;
    const auto [low, high] = ends_of(edge);
    make_vertex(low);
    make_vertex(high);
    const Vec3 from = adjacency_.mesh().positions()[low];
    const Vec3 along = adjacency_.mesh().positions()[high] - from;
    const auto first_node = static_cast<std::uint32_t>(nodes_.size());
    std::uint32_t next = 0;
    for (; i < windows_.size() && windows_[i].edge == edge; ++i) {
      for (next = std::max(next, windows_[i].first); next <= windows_[i].last; ++next) {
        nodes_.push_back({{kNone, edge, next}, from + double(next) / steps_ * along});
      }
    }
    points_of_edge_.push_back({edge, first_node, static_cast<std::uint32_t>(nodes_.size())});
  }
}

void StripGraph::make_vertex(std::uint32_t v) {
  const auto node = static_cast<std::uint32_t>(nodes_.size());
  if (node_of_vertex_.emplace(v, node).second) {
    nodes_.push_back({{v, kNone, 0}, adjacency_.mesh().positions()[v]});
  }
}

void StripGraph::gather_faces(Poll& poll) {
  faces_at_.resize(nodes_.size());
  for (const auto& [edge, first, last] : points_of_edge_) {
    Halfedge h = edge;
    do {
      if (poll.cancelled()) return;
      if (!is_repeated(face_of(h))) {
        const std::uint32_t f = number_of(face_of(h));
        for (std::uint32_t node = first; node < last; ++node) join(f, node);
      }
      h = adjacency_.ring(h);
    } while (h != edge);
  }
  for (const std::uint32_t end : {0U, 1U}) {
    if (ends_[end]->at_vertex()) continue;  // joined with the vertices
    for (const SurfacePoint& place : in_all_faces(adjacency_, *ends_[end])) {
      if (poll.cancelled()) return;
      if (!is_repeated(place.face)) join(number_of(place.face), end);
    }
  }
  // In the order in which faces were numbered, not in that of a hash: of ways as short as each
  // other the one that is found depends on it.
  for (std::uint32_t f = 0; f < faces_.size(); ++f) {
    if (poll.cancelled()) return;
    for (const std::uint32_t v : adjacency_.face(faces_[f]).vertex) {
      const auto node = node_of_vertex_.find(v);
      if (node != node_of_vertex_.end()) join(f, node->second);
    }
  }
}

bool StripGraph::is_repeated(std::uint32_t f) const {
  if (cost_ != nullptr && cost_->has_weights()) return false;
  return f != ends_[0]->face && f != ends_[1]->face && has_later_copy(adjacency_, f);
}

std::uint32_t StripGraph::number_of(std::uint32_t face) {
  const auto [it, is_new] =
      number_of_face_.emplace(face, static_cast<std::uint32_t>(nodes_in_.size()));
  if (is_new) {
    nodes_in_.emplace_back();
    faces_.push_back(face);
  }
  return it->second;
}

void StripGraph::join(std::uint32_t f, std::uint32_t node) {
  nodes_in_[f].push_back(node);
  faces_at_[node].push_back(f);
}

}  // namespace geodesic
