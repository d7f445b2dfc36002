#include "core/exact/frames.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <tuple>

#include "core/base/polled_fill.h"
#include "core/base/polled_sort.h"
#include "core/base/rough_angle.h"
#include "core/base/tolerances.h"
#include "core/exact/surface.h"
#include "core/surface/walk_over_faces.h"

namespace geodesic::exact {
namespace {

// The length of side c of a face that need not be one of the mesh. Where it is lost in the face's
// products, it is the length of an edge of the mesh, or of one that is hardly there.
double length_of(const FaceRecord& face, std::uint32_t c, std::span<const Vec3> positions) {
  const std::uint32_t tail = face.vertex[c];
  const std::uint32_t head = face.vertex[next_corner(c)];
  const bool are_of_mesh = std::max(tail, head) < positions.size();
  if (!face.loses_length(c) || !are_of_mesh) return std::sqrt(std::max(face.length2(c), 0.0));
  return distance(positions[tail], positions[head]);
}

}  // namespace

void Frames::build(const Adjacency& adjacency, const Triangulation& surface, Poll& poll) {
  const std::weak_ptr<const void> identity = adjacency.identity();
  const bool same = !identity.owner_before(built_for_) && !built_for_.owner_before(identity);
  const bool is_same_surface = same && surface.faces.data() == surface_.faces.data();
  surface_ = surface;
  if (is_same_surface) {
    forget_arrivals(poll);
    return;
  }
  built_for_.reset();
  is_mesh_ = surface.faces.data() == adjacency.faces().data();
  has_flat_ = false;
  // Every face is written below: what the last query left is as good as new.
  const std::size_t face_count = surface.faces.size();
  if (faces_.size() != face_count) polled_assign(faces_, face_count, FaceFrame{}, poll);
  edges_.clear();
  const std::size_t vertex_count = surface.corner_begin.size() - 1;
  const std::size_t edge_count = count_edges(adjacency, surface);
  if (edge_count > edges_.capacity() && !poll.may_take(edge_count * sizeof(Edge))) return;
  edges_.reserve(edge_count);
  bends_.assign(vertex_count, Bends::nowhere);
  number_edges(adjacency, poll);
  if (poll.stopped()) return;
  const std::vector<double> angle_sum = measure_faces(poll);
  if (poll.stopped()) return;
  classify_vertices(adjacency, angle_sum, poll);
  if (!poll.stopped()) built_for_ = identity;
}

void Frames::forget_arrivals(Poll& poll) {
  for (Edge& edge : edges_) {
    if (poll.cancelled()) return;
    edge.forget_arrivals();
  }
}

// An edge gets its number from the first of its halfedges, which gives it to the others: a ring
// is gone round once, however many faces it has.
void Frames::number_edges(const Adjacency& adjacency, Poll& poll) {
  const auto positions = adjacency.mesh().positions();
  for (FaceFrame& frame : faces_) {
    if (poll.cancelled()) return;
    frame = {{kNone, kNone, kNone}, 0};
  }
  for (std::uint32_t f = 0; f < faces_.size() && !poll.cancelled(); ++f) {
    const FaceRecord& record = surface_.faces[f];
    for (std::uint32_t c = 0; c < 3; ++c) {
      if (faces_[f].edge[c] != kNone) continue;
      const Halfedge h = halfedge(f, c);
      const std::uint32_t tail = record.vertex[c];
      const std::uint32_t head = record.vertex[next_corner(c)];
      const auto number = static_cast<std::uint32_t>(edges_.size());
      faces_[f].edge[c] = number;
      for (Halfedge i = record.ring[c]; i != h && !poll.cancelled(); i = surface_.ring(i)) {
        FaceFrame& frame = faces_[face_of(i)];
        frame.edge[corner_of(i)] = number;
        if (surface_.faces[face_of(i)].vertex[corner_of(i)] != tail) {
          frame.reversed |= 1U << corner_of(i);
        }
      }
      const double length =
          is_mesh_ ? distance(positions[tail], positions[head]) : length_of(record, c, positions);
      edges_.push_back({length, tail, head, h, record.ring[c]});
    }
  }
  if (!poll.stopped()) mark_copies(poll);
}

// Faces with the same edges meet on each of them. On most edges two faces meet; on one of
// thousands, they are sorted by their edges.
void Frames::mark_copies(Poll& poll) {
  struct Sides {
    std::array<std::uint32_t, 3> edges;  // ascending
    std::uint32_t face;
    bool operator<(const Sides& other) const {
      return std::tie(edges, face) < std::tie(other.edges, other.face);
    }
  };
  const auto sides_of = [this](Halfedge h) {
    Sides sides{faces_[face_of(h)].edge, face_of(h)};
    std::sort(sides.edges.begin(), sides.edges.end());
    return sides;
  };
  const auto sum_of = [this](Halfedge h) {
    const auto& edge = faces_[face_of(h)].edge;
    return std::uint64_t{edge[0]} + edge[1] + edge[2];
  };
  std::vector<Sides> around;
  std::vector<Sides> spare;
  for (const Edge& edge : edges_) {
    if (poll.cancelled()) return;
    if (edge.on_boundary()) continue;
    const bool are_two = surface_.ring(edge.second) == edge.first;
    if (are_two && sum_of(edge.first) != sum_of(edge.second)) continue;
    around.clear();
    Halfedge h = edge.first;
    do {
      // Each face once, on its least edge.
      const Sides sides = sides_of(h);
      if (&edges_[sides.edges[0]] == &edge) around.push_back(sides);
      h = surface_.ring(h);
    } while (h != edge.first && !poll.cancelled());
    polled_sort(around, 0, around.size(), std::less<>(), spare, poll);
    if (poll.stopped()) return;
    for (std::size_t i = 1; i < around.size(); ++i) {
      if (around[i].edges == around[i - 1].edges) {
        faces_[around[i].face].reversed |= FaceFrame::kCopy;
      }
    }
  }
}

// Returns the rough sums of the angles at the vertices.
std::vector<double> Frames::measure_faces(Poll& poll) {
  std::vector<double> angle_sum(bends_.size(), 0);
  double sum = 0;
  for (std::uint32_t f = 0; f < faces_.size() && !poll.cancelled(); ++f) {
    const FaceRecord& record = surface_.faces[f];
    for (std::uint32_t i = 0; i < 3; ++i) {
      angle_sum[record.vertex[i]] += rough_angle(record.dot[i], record.area2);
    }
    const std::uint32_t longest = record.longest_side();
    const double longest_length = length(f, longest);
    if (!(record.area2 > tolerance::kThin * longest_length * longest_length)) {
      for (const std::uint32_t v : record.vertex) bends_[v] = Bends::everywhere;
    }
    const double shortest =
        std::min(length(f, next_corner(longest)), length(f, previous_corner(longest)));
    if (!(record.area2 > tolerance::kLine * longest_length * shortest)) {
      faces_[f].reversed |= FaceFrame::kFlat;
      has_flat_ = true;
    }
    sum += shortest;
  }
  mean_shortest_side_ = sum / static_cast<double>(faces_.size());
  return angle_sum;
}

void Frames::classify_vertices(const Adjacency& adjacency, std::span<const double> angle_sum,
                               Poll& poll) {
  constexpr double kPi = std::numbers::pi;
  std::vector<bool> on_boundary(bends_.size(), false);
  for (const Edge& edge : edges_) {
    if (poll.cancelled()) return;
    if (edge.on_boundary()) {
      on_boundary[edge.tail] = on_boundary[edge.head] = true;
    } else if (surface_.ring(edge.second) != edge.first) {
      for (const std::uint32_t v : {edge.tail, edge.head}) {
        if (v < adjacency.mesh().vertex_count()) bends_[v] = Bends::everywhere;
      }
    }
  }
  // Where the surface was given more vertices it is flat.
  for (std::uint32_t v = 0; v < adjacency.mesh().vertex_count() && !poll.cancelled(); ++v) {
    if (bends_[v] == Bends::everywhere) continue;
    if (adjacency.is_pinched(v)) {
      bends_[v] = Bends::everywhere;
      continue;
    }
    const double straight = on_boundary[v] ? kPi - tolerance::kAngle : 2 * kPi + tolerance::kAngle;
    const auto corners = surface_.corners(v);
    // Angles are added up roughly; only where that leaves a doubt, exactly.
    double sum = angle_sum[v];
    if (std::abs(sum - straight) < kRoughAngle * static_cast<double>(corners.size())) {
      sum = 0;
      for (const std::uint32_t corner : corners) {
        if (poll.cancelled()) return;
        sum += corner_angle(surface_.faces[face_of(corner)], corner_of(corner));
      }
    }
    if (sum > straight) bends_[v] = Bends::beyond;
  }
}

}  // namespace geodesic::exact
