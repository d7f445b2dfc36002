#include "core/exact_frames.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "core/polled_fill.h"
#include "core/rough_angle.h"

namespace geodesic::exact {
namespace {

// Angles are not told apart by less. Where a shortest path bends by an angle of this
// size, going straight past the vertex is longer by its square.
constexpr double kAngle = 1e-9;
// A face lower than this part of its longest side is too thin to measure angles in.
constexpr double kThin = 1e-10;
// The length of side c of a face that need not be one of the mesh. Where it is lost in the face's
// products, the face is one of the mesh.
double length_of(const FaceRecord& face, std::uint32_t c, std::span<const Vec3> positions) {
  if (!face.loses_length(c)) return std::sqrt(face.length2(c));
  return distance(positions[face.vertex[c]], positions[face.vertex[next_corner(c)]]);
}

}  // namespace

void Frames::build(const Adjacency& adjacency, const Triangulation& surface, Poll& poll) {
  const std::weak_ptr<const void> identity = adjacency.identity();
  const bool same = !identity.owner_before(built_for_) && !built_for_.owner_before(identity);
  const bool is_mesh = surface.faces.data() == adjacency.faces().data();
  surface_ = surface;
  if (same && is_mesh == is_mesh_) {
    forget_arrivals(poll);
    return;
  }
  built_for_.reset();
  is_mesh_ = is_mesh;
  // Every face is written below: what the last query left is as good as new.
  const std::size_t face_count = surface.faces.size();
  if (faces_.size() != face_count) polled_assign(faces_, face_count, FaceFrame{}, poll);
  edges_.clear();
  const std::size_t edge_count = adjacency.report().edges;
  if (edge_count > edges_.capacity() && !poll.may_take(edge_count * sizeof(Edge))) return;
  edges_.reserve(adjacency.report().edges);
  bends_.assign(adjacency.mesh().vertex_count(), Bends::nowhere);
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

// An edge gets its number from the first of its halfedges.
void Frames::number_edges(const Adjacency& adjacency, Poll& poll) {
  const auto positions = adjacency.mesh().positions();
  for (std::uint32_t f = 0; f < faces_.size() && !poll.cancelled(); ++f) {
    const FaceRecord& record = surface_.faces[f];
    FaceFrame& frame = faces_[f];
    frame.reversed = 0;
    for (std::uint32_t c = 0; c < 3; ++c) {
      const Halfedge h = halfedge(f, c);
      const std::uint32_t tail = record.vertex[c];
      const std::uint32_t head = record.vertex[next_corner(c)];
      Halfedge first = h;
      for (Halfedge i = record.ring[c]; i != h; i = surface_.ring(i)) first = std::min(first, i);
      if (first == h) {
        frame.edge[c] = static_cast<std::uint32_t>(edges_.size());
        const double length =
            is_mesh_ ? distance(positions[tail], positions[head]) : length_of(record, c, positions);
        edges_.push_back({length, tail, head, h, record.ring[c]});
      } else {
        frame.edge[c] = edge_of(first);
        if (edges_[frame.edge[c]].tail != tail) frame.reversed |= 1U << c;
      }
    }
    if (has_a_twin_before(f)) frame.reversed |= FaceFrame::kCopy;
  }
}

bool Frames::has_a_twin_before(std::uint32_t f) const {
  // A sum first: on an edge with thousands of faces each is asked of all.
  const auto sum = [](const auto& e) { return std::uint64_t{e[0]} + e[1] + e[2]; };
  const auto& edge = faces_[f].edge;
  const Halfedge h = halfedge(f, 0);
  for (Halfedge i = surface_.ring(h); i != h; i = surface_.ring(i)) {
    const std::uint32_t g = face_of(i);
    if (g >= f || sum(faces_[g].edge) != sum(edge)) continue;
    if (std::is_permutation(edge.begin(), edge.end(), faces_[g].edge.begin())) return true;
  }
  return false;
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
    if (!(record.area2 > kThin * longest_length * longest_length)) {
      for (const std::uint32_t v : record.vertex) bends_[v] = Bends::everywhere;
    }
    sum += std::min(length(f, next_corner(longest)), length(f, previous_corner(longest)));
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
      bends_[edge.tail] = bends_[edge.head] = Bends::everywhere;
    }
  }
  for (std::uint32_t v = 0; v < bends_.size() && !poll.cancelled(); ++v) {
    if (bends_[v] == Bends::everywhere) continue;
    if (adjacency.is_pinched(v)) {
      bends_[v] = Bends::everywhere;
      continue;
    }
    const double straight = on_boundary[v] ? kPi - kAngle : 2 * kPi + kAngle;
    const auto corners = surface_.corners(v);
    // Angles are added up roughly; only where that leaves a doubt, exactly.
    double sum = angle_sum[v];
    if (std::abs(sum - straight) < kRoughAngle * static_cast<double>(corners.size())) {
      sum = 0;
      for (const std::uint32_t corner : corners) {
        const FaceRecord& record = surface_.faces[face_of(corner)];
        sum += std::atan2(record.area2, record.dot[corner_of(corner)]);
      }
    }
    if (sum > straight) bends_[v] = Bends::beyond;
  }
}

}  // namespace geodesic::exact
