#include "core/steiner/path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "core/base/polled_sort.h"
#include "core/field/edge_points.h"
#include "core/steiner/steiner.h"
#include "core/surface/copied_faces.h"

namespace geodesic {
namespace {

// How far the points of a round reach along an edge from where the last path
// crosses it, in points.
constexpr std::uint32_t kReach = 4;
// Bounds for paths that would creep on for ever. Twenty halvings leave a millionth
// of the first spacing.
// The search takes about so much of the time, refining the rest.
constexpr double kSearch = 0.9;
constexpr int kMostRounds = 20;
constexpr int kMostPasses = 40;
// The finest spacing is one part in this of an edge.
constexpr std::uint32_t kFinest = 1U << 30U;

// A point of the path between its ends: a vertex, or a point on an edge at `step` of
// as many equal steps as the round has, counted from the smaller vertex number.
struct Crossing {
  std::uint32_t vertex = kNone;
  Halfedge edge = kNone;  // the least halfedge of its ring
  std::uint32_t step = 0;
};

Halfedge least_in_ring(const Adjacency& adjacency, Halfedge h) {
  Halfedge least = h;
  for (Halfedge other = adjacency.ring(h); other != h; other = adjacency.ring(other)) {
    least = std::min(least, other);
  }
  return least;
}

// The graph of one pass: the faces around a path, and on their edges the points
// near it. Nodes: 0 is the path's start and 1 its end, wherever they are.
class StripGraph {
 public:
  StripGraph(const Adjacency& adjacency, const SurfacePoint& from, const SurfacePoint& to,
             const std::vector<Crossing>& path, std::uint32_t steps, Poll& poll)
      : adjacency_(adjacency), steps_(steps), ends_{&from, &to} {
    for (const std::uint32_t end : {0U, 1U}) {
      nodes_.push_back(
          {{ends_[end]->vertex, kNone, 0}, position_of(adjacency.mesh(), *ends_[end])});
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

  // The shortest way from start to end: its points between them, and its length;
  // kUnreached when there is none, or when the poll says to stop.
  double shortest(std::vector<Crossing>& way, VertexHeap& heap, Poll& poll) {
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
          const double d = next.key + distance(nodes_[next.vertex].at, nodes_[node].at);
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

  [[nodiscard]] std::pair<std::uint32_t, std::uint32_t> ends_of(Halfedge h) const {
    const FaceRecord& face = adjacency_.face(face_of(h));
    return std::minmax({face.vertex[corner_of(h)], face.vertex[next_corner(corner_of(h))]});
  }

  void add_window(const Crossing& crossing) {
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

  void add_edges_at_vertices(Poll& poll) {
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

  // As least_in_ring. Where the edge is in more than two faces, it becomes known.
  Halfedge least_of_new_ring(Halfedge h, std::unordered_set<Halfedge>& known, Poll& poll) const {
    Halfedge least = h;
    const bool is_shared = adjacency_.ring(adjacency_.ring(h)) != h;
    for (Halfedge other = adjacency_.ring(h); other != h && !poll.cancelled();
         other = adjacency_.ring(other)) {
      least = std::min(least, other);
      if (is_shared) known.insert(other);
    }
    return least;
  }

  void make_nodes(Poll& poll) {
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

  void make_vertex(std::uint32_t v) {
    const auto node = static_cast<std::uint32_t>(nodes_.size());
    if (node_of_vertex_.emplace(v, node).second) {
      nodes_.push_back({{v, kNone, 0}, adjacency_.mesh().positions()[v]});
    }
  }

  // Every face with a point on a side, and those of the path's ends. All its nodes
  // are joined to each other: what is on one side, along it.
  void gather_faces(Poll& poll) {
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
    for (const auto& [face, f] : number_of_face_) {
      if (poll.cancelled()) return;
      for (const std::uint32_t v : adjacency_.face(face).vertex) {
        const auto node = node_of_vertex_.find(v);
        if (node != node_of_vertex_.end()) join(f, node->second);
      }
    }
  }

  // Whether another face joins the same nodes: a later one with the same corners, and no end of
  // the path is inside this one.
  [[nodiscard]] bool is_repeated(std::uint32_t f) const {
    return f != ends_[0]->face && f != ends_[1]->face && has_later_copy(adjacency_, f);
  }

  std::uint32_t number_of(std::uint32_t face) {
    const auto [it, is_new] =
        number_of_face_.emplace(face, static_cast<std::uint32_t>(nodes_in_.size()));
    if (is_new) nodes_in_.emplace_back();
    return it->second;
  }

  void join(std::uint32_t f, std::uint32_t node) {
    nodes_in_[f].push_back(node);
    faces_at_[node].push_back(f);
  }

  struct PointsOfEdge {
    Halfedge edge;
    std::uint32_t first_node;
    std::uint32_t last_node;  // one past
  };

  const Adjacency& adjacency_;
  std::uint32_t steps_;
  std::array<const SurfacePoint*, 2> ends_;
  std::vector<std::uint32_t> near_;  // vertices that the path passes or comes near
  std::vector<Window> windows_;
  std::vector<Node> nodes_;
  std::vector<PointsOfEdge> points_of_edge_;
  std::unordered_map<std::uint32_t, std::uint32_t> node_of_vertex_;
  std::unordered_map<std::uint32_t, std::uint32_t> number_of_face_;
  std::vector<std::vector<std::uint32_t>> nodes_in_;  // by face number
  std::vector<std::vector<std::uint32_t>> faces_at_;  // by node
};

bool are_one(const Adjacency& adjacency, const SurfacePoint& a, const SurfacePoint& b) {
  if (a.at_vertex() || b.at_vertex()) return a.vertex == b.vertex;
  const std::vector<SurfacePoint> places = in_all_faces(adjacency, a);
  return std::any_of(places.begin(), places.end(), [&](const SurfacePoint& place) {
    return place.face == b.face && place.bary == b.bary;
  });
}

// The points of a path traced in the unrefined graph, without its ends. Where a face has no area,
// the path may begin or end at another point of it that lies in the same place: from there it goes
// on into faces that the end itself is not in.
std::vector<Crossing> crossings_of(const Adjacency& adjacency, const Path& path,
                                   const SurfacePoint& from, const SurfacePoint& to,
                                   std::uint32_t steps) {
  std::vector<Crossing> crossings;
  for (const PathPoint& passed : path.points) {
    const SurfacePoint& point = passed.point;
    const bool is_first = &passed == &path.points.front();
    const bool is_last = &passed == &path.points.back();
    if (is_first && are_one(adjacency, from, point)) continue;
    if (is_last && are_one(adjacency, to, point)) continue;
    if (point.at_vertex()) {
      crossings.push_back({point.vertex, kNone, 0});
      continue;
    }
    for (std::uint32_t c = 0; c < 3; ++c) {
      if (point.bary[previous_corner(c)] != 0) continue;
      const FaceRecord& face = adjacency.face(point.face);
      const bool is_low = face.vertex[c] < face.vertex[next_corner(c)];
      const double part = point.bary[is_low ? next_corner(c) : c];
      const auto step = static_cast<std::uint32_t>(std::lround(part * steps));
      crossings.push_back({kNone, least_in_ring(adjacency, halfedge(point.face, c)),
                           std::clamp(step, 1U, steps - 1)});
      break;
    }
  }
  return crossings;
}

// The places of one point of the path in all the faces it lies in.
std::vector<SurfacePoint> places_of(const Adjacency& adjacency, const Crossing& crossing,
                                    std::uint32_t steps) {
  if (crossing.vertex != kNone) {
    return in_all_faces(adjacency, point_at_vertex(adjacency, crossing.vertex));
  }
  const FaceRecord& face = adjacency.face(face_of(crossing.edge));
  const std::uint32_t c = corner_of(crossing.edge);
  const std::uint32_t n = next_corner(c);
  const bool is_low = face.vertex[c] < face.vertex[n];
  SurfacePoint point{face_of(crossing.edge), {0, 0, 0}, kNone};
  point.bary[is_low ? n : c] = double(crossing.step) / steps;
  point.bary[is_low ? c : n] = double(steps - crossing.step) / steps;
  return in_all_faces(adjacency, point);
}

// The polyline: each of its segments lies in a face that both its ends lie in. Of no bounded length
// where two points one after the other have no face in common.
Path assemble(const Adjacency& adjacency, const SurfacePoint& from, const SurfacePoint& to,
              const std::vector<Crossing>& crossings, std::uint32_t steps, Poll& poll) {
  const Mesh& mesh = adjacency.mesh();
  Path path;
  std::vector<SurfacePoint> here = in_all_faces(adjacency, from);
  path.points.push_back({from, position_of(mesh, from)});
  for (std::size_t i = 0; i <= crossings.size(); ++i) {
    std::vector<SurfacePoint> there = i < crossings.size()
                                          ? places_of(adjacency, crossings[i], steps)
                                          : in_all_faces(adjacency, to);
    std::sort(there.begin(), there.end(),
              [](const SurfacePoint& a, const SurfacePoint& b) { return a.face < b.face; });
    bool meet = false;
    for (const SurfacePoint& place : here) {
      if (poll.cancelled()) return path;
      const auto arrives = std::lower_bound(
          there.begin(), there.end(), place,
          [](const SurfacePoint& a, const SurfacePoint& b) { return a.face < b.face; });
      if (arrives == there.end() || arrives->face != place.face) continue;
      meet = true;
      path.points.back().point = place;
      const Vec3 position = position_of(mesh, *arrives);
      const double leg = distance(path.points.back().position, position);
      path.length += leg;
      // Where source or target lies on one of the points, the leg has no length.
      if (leg > 0) {
        path.points.push_back({*arrives, position});
      } else {
        path.points.back().point = *arrives;
      }
      break;
    }
    if (!meet) path.length = kUnreached;
    here = std::move(there);
  }
  return path;
}

}  // namespace

Result<std::optional<Path>> steiner_path(const Adjacency& adjacency, const Source& from,
                                         const SurfacePoint& to, const MethodOptions& options,
                                         WavefrontScratch& scratch, const Cancel& cancel) {
  if (!(options.tolerance >= 0)) {
    return fail(ErrorCode::value_out_of_range, "a tolerance is a number from zero up", "tolerance");
  }
  // The offset only delays; without it no length is lost to rounding.
  const auto field = steiner_field_towards(adjacency, {from.point, 0}, to, options.points_per_edge,
                                           scratch, cancel.part(0, kSearch));
  if (!field) return fail(field.error());
  auto trace = trace_path(adjacency, *field, to, cancel);
  if (!trace) return fail(std::move(trace.error()));
  std::optional<Path>& traced = *trace;
  // What lies in one face is straight already.
  if (!traced || traced->points.size() <= 2) return traced;

  std::uint32_t steps = options.points_per_edge + 1;
  std::vector<Crossing> crossings = crossings_of(adjacency, *traced, from.point, to, steps);
  double length = traced->length;
  Poll poll(cancel);
  std::vector<Crossing> shorter;
  for (int round = 0; round < kMostRounds && steps <= kFinest / 2; ++round) {
    steps *= 2;
    for (Crossing& crossing : crossings) crossing.step *= 2;
    const double before = length;
    for (int pass = 0; pass < kMostPasses; ++pass) {
      if (cancel.requested()) return fail_stopped(cancel);
      StripGraph graph(adjacency, from.point, to, crossings, steps, poll);
      const double found =
          poll.stopped() ? kUnreached : graph.shortest(shorter, scratch.heap, poll);
      if (poll.stopped()) return fail_stopped(cancel);
      if (!(found < length)) break;
      const double gain = length - found;
      std::swap(crossings, shorter);
      length = found;
      if (gain < options.tolerance * length) break;
    }
    if (before - length < options.tolerance * before) break;
  }
  Path refined = assemble(adjacency, from.point, to, crossings, steps, poll);
  if (poll.stopped()) return fail_stopped(poll);
  return refined.length < traced->length ? std::move(refined) : std::move(*traced);
}

}  // namespace geodesic
