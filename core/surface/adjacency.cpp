#include "core/surface/adjacency.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "core/base/polled_fill.h"
#include "core/base/polled_sort.h"
#include "core/base/tolerances.h"
#include "core/surface/corner_lists.h"
#include "core/surface/intrinsic_delaunay.h"
#include "core/surface/unfold_rounding.h"

namespace geodesic {
namespace {

// Union by the smaller root, with path halving: enough for counting.
class DisjointSets {
 public:
  // Of no use if the poll says to stop.
  DisjointSets(std::size_t size, Poll& poll) {
    polled_assign(parent_, size, std::uint32_t{0}, poll);
    for (std::uint32_t i = 0; i < parent_.size() && !poll.cancelled(); ++i) parent_[i] = i;
  }
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    if (a != b) parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace

Adjacency Adjacency::build(std::shared_ptr<const Mesh> mesh) {
  return std::move(*build(std::move(mesh), Cancel()));
}

Result<Adjacency> Adjacency::build(std::shared_ptr<const Mesh> mesh, const Cancel& cancel) {
  Adjacency adjacency;
  adjacency.mesh_ = std::move(mesh);
  adjacency.identity_ = std::make_shared<const char>();
  Poll poll(cancel);
  int done = 0;
  for (const auto step : {&Adjacency::fill_geometry, &Adjacency::fill_corners,
                          &Adjacency::fill_rings, &Adjacency::find_pinched_vertices,
                          &Adjacency::count_components, &Adjacency::count_boundary_loops}) {
    (adjacency.*step)(poll);
    if (poll.ask()) return fail_stopped(cancel);
    cancel.report(++done / 7.0);
  }
  auto delaunay =
      IntrinsicDelaunay::build(adjacency.triangulation(), adjacency.mesh_->positions(), cancel);
  if (!delaunay) return fail(std::move(delaunay.error()));
  if (delaunay->flips() != 0) {
    adjacency.delaunay_ = std::make_shared<const IntrinsicDelaunay>(std::move(*delaunay));
  }
  return adjacency;
}

void Adjacency::fill_geometry(Poll& poll) {
  const auto positions = mesh_->positions();
  const auto faces = mesh_->faces();
  polled_assign(faces_, faces.size(), FaceRecord{}, poll);
  for (std::size_t f = 0; f < faces.size() && !poll.cancelled(); ++f) {
    const Vec3 a = positions[faces[f][0]];
    const Vec3 b = positions[faces[f][1]];
    const Vec3 c = positions[faces[f][2]];
    const std::array<Vec3, 3> side{b - a, c - b, a - c};
    FaceRecord& record = faces_[f];
    record.vertex = faces[f];
    record.dot = {-dot(side[0], side[2]), -dot(side[1], side[0]), -dot(side[2], side[1])};
    // The area comes from the two shorter sides: the longest one's rounding would be a
    // large part of a needle's.
    const std::uint32_t longest = record.longest_side();
    record.area2 = norm(cross(side[next_corner(longest)], side[previous_corner(longest)]));
    const bool is_flat = is_lower_than(tolerance::kFlat, record);
    has_flat_faces_ = has_flat_faces_ || is_flat;
    has_lines_ = has_lines_ || (is_flat && is_line(record));
  }
  is_even_ = is_even(faces_, poll);
}

void Adjacency::fill_corners(Poll& poll) {
  list_corners(faces_, mesh_->vertex_count(), corner_begin_, corners_, poll);
  if (poll.stopped()) return;
  for (std::uint32_t v = 0; v < mesh_->vertex_count(); ++v) {
    if (corners(v).empty()) ++report_.vertices_isolated;
  }
}

// Halfedges are gathered per vertex at their smaller end and sorted by the other
// end; each run of equal ends is one edge and becomes one ring.
void Adjacency::fill_rings(Poll& poll) {
  struct EdgeSide {
    std::uint32_t far_end;
    std::uint32_t opposite;
    Halfedge h;
  };
  const auto earlier = [](const EdgeSide& a, const EdgeSide& b) {
    return std::tie(a.far_end, a.opposite, a.h) < std::tie(b.far_end, b.opposite, b.h);
  };
  std::vector<EdgeSide> sides;
  std::vector<EdgeSide> spare;
  double total_length = 0;
  std::uint64_t duplicate_sides = 0;
  for (std::uint32_t v = 0; v < mesh_->vertex_count() && !poll.cancelled(); ++v) {
    sides.clear();
    for (const std::uint32_t corner : corners(v)) {
      if (poll.cancelled()) return;
      const std::uint32_t f = face_of(corner);
      const std::uint32_t c = corner_of(corner);
      const std::uint32_t ahead = faces_[f].vertex[next_corner(c)];
      const std::uint32_t behind = faces_[f].vertex[previous_corner(c)];
      if (ahead > v) sides.push_back({ahead, behind, corner});
      if (behind > v) sides.push_back({behind, ahead, halfedge(f, previous_corner(c))});
    }
    polled_sort(sides, 0, sides.size(), earlier, spare, poll);
    if (poll.stopped()) return;
    for (std::size_t begin = 0; begin < sides.size();) {
      std::size_t end = begin + 1;
      while (end < sides.size() && sides[end].far_end == sides[begin].far_end) {
        if (sides[end].opposite == sides[end - 1].opposite) ++duplicate_sides;
        ++end;
      }
      for (std::size_t i = begin; i < end; ++i) {
        const Halfedge h = sides[i].h;
        faces_[face_of(h)].ring[corner_of(h)] = sides[i + 1 < end ? i + 1 : begin].h;
      }
      const Halfedge first = sides[begin].h;
      total_length += std::sqrt(std::max(0.0, faces_[face_of(first)].length2(corner_of(first))));
      ++report_.edges;
      if (end - begin == 1) ++report_.edges_boundary;
      if (end - begin > 2) ++report_.edges_non_manifold;
      is_crowded_ = is_crowded_ || end - begin > Triangulation::kCrowd;
      const auto goes_out = [&](std::size_t i) {
        return faces_[face_of(sides[i].h)].vertex[corner_of(sides[i].h)] == v;
      };
      if (end - begin > 2 || (end - begin == 2 && goes_out(begin) == goes_out(begin + 1))) {
        is_oriented_ = false;
      }
      begin = end;
    }
  }
  // Each duplicate face repeats all three of its sides.
  report_.faces_duplicate = duplicate_sides / 3;
  report_.mean_edge = total_length / static_cast<double>(report_.edges);
}

// The faces that can be reached from the vertex's first face by crossing edges
// that end in the vertex.
std::size_t Adjacency::faces_in_first_fan(std::uint32_t vertex, Poll& poll) const {
  const auto all = corners(vertex);
  const auto other_side = [&](Halfedge side) {
    // The other edge of the same face that ends in the vertex.
    const std::uint32_t f = face_of(side);
    const std::uint32_t c = corner_of(side);
    return faces_[f].vertex[c] == vertex ? halfedge(f, previous_corner(c))
                                         : halfedge(f, next_corner(c));
  };
  // Nearly always one turn round a fan of manifold edges, one way and then the other.
  std::size_t count = 1;
  bool manifold = true;
  const Halfedge first = all.front();
  for (Halfedge side : {first, other_side(first)}) {
    while (!poll.cancelled()) {
      const Halfedge across = ring(side);
      if (across == side) break;  // boundary
      if (ring(across) != side) {
        manifold = false;
        break;
      }
      if (face_of(across) == face_of(first)) return count;  // all the way round
      ++count;
      side = other_side(across);
    }
  }
  if (manifold || count == all.size()) return count;

  // Fans that branch at non-manifold edges. One step along each ring is enough:
  // its faces lead on to each other.
  std::vector<bool> seen(all.size(), false);
  std::vector<std::size_t> reached;
  const auto reach = [&](std::uint32_t face) {
    const auto it = std::lower_bound(all.begin(), all.end(), halfedge(face, 0));
    const auto i = static_cast<std::size_t>(it - all.begin());
    if (!seen[i]) reached.push_back(i);
    seen[i] = true;
  };
  reach(face_of(first));
  for (std::size_t i = 0; i < reached.size() && !poll.cancelled(); ++i) {
    const Halfedge side = all[reached[i]];
    reach(face_of(ring(side)));
    reach(face_of(ring(other_side(side))));
  }
  return reached.size();
}

void Adjacency::find_pinched_vertices(Poll& poll) {
  for (std::uint32_t v = 0; v < mesh_->vertex_count() && !poll.cancelled(); ++v) {
    const std::size_t all = corners(v).size();
    if (all < 2 || faces_in_first_fan(v, poll) == all) continue;
    if (poll.stopped()) return;
    if (pinched_.empty()) pinched_.assign(mesh_->vertex_count(), false);
    pinched_[v] = true;
    ++report_.vertices_pinched;
  }
}

void Adjacency::count_components(Poll& poll) {
  DisjointSets sets(mesh_->vertex_count(), poll);
  if (poll.stopped()) return;
  for (const FaceRecord& record : faces_) {
    if (poll.cancelled()) return;
    sets.join(record.vertex[0], record.vertex[1]);
    sets.join(record.vertex[1], record.vertex[2]);
  }
  for (std::uint32_t v = 0; v < mesh_->vertex_count() && !poll.cancelled(); ++v) {
    if (!corners(v).empty() && sets.find(v) == v) ++report_.components;
  }
}

// A loop is a cycle of boundary edges, where each is followed by the one that
// ends the same fan of faces. Turning round a vertex needs no winding: across
// each inner edge lies one other face. A fan that ends at a non-manifold edge
// has no successor; its chain counts as a loop of its own.
void Adjacency::count_boundary_loops(Poll& poll) {
  if (report_.edges_boundary == 0) return;
  DisjointSets chains(4 * faces_.size(), poll);
  if (poll.stopped()) return;
  const auto on_boundary = [this](Halfedge h) { return ring(h) == h; };
  const auto follow = [&](Halfedge boundary, std::uint32_t pivot) {
    Halfedge h = boundary;
    while (!poll.cancelled()) {
      // The other edge at the pivot in the same face.
      const std::uint32_t f = face_of(h);
      const std::uint32_t c = corner_of(h);
      h = faces_[f].vertex[c] == pivot ? halfedge(f, previous_corner(c))
                                       : halfedge(f, next_corner(c));
      if (on_boundary(h)) {
        chains.join(boundary, h);
        return;
      }
      const Halfedge across = ring(h);
      if (ring(across) != h) return;  // non-manifold
      h = across;
    }
  };
  for (std::uint32_t f = 0; f < faces_.size() && !poll.cancelled(); ++f) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      const Halfedge h = halfedge(f, c);
      if (!on_boundary(h)) continue;
      follow(h, faces_[f].vertex[c]);
      follow(h, faces_[f].vertex[next_corner(c)]);
    }
  }
  for (std::uint32_t f = 0; f < faces_.size() && !poll.cancelled(); ++f) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      const Halfedge h = halfedge(f, c);
      if (on_boundary(h) && chains.find(h) == h) ++report_.boundary_loops;
    }
  }
}

Triangulation Adjacency::delaunay() const {
  if (!delaunay_) return triangulation();
  Triangulation delaunay = delaunay_->triangulation();
  // Flips make none.
  delaunay.has_lines = has_lines_;
  return delaunay;
}

Halfedge Adjacency::find_edge(std::uint32_t a, std::uint32_t b) const {
  for (const std::uint32_t corner : corners(a)) {
    const std::uint32_t f = face_of(corner);
    const std::uint32_t c = corner_of(corner);
    if (faces_[f].vertex[next_corner(c)] == b) return corner;
    if (faces_[f].vertex[previous_corner(c)] == b) return halfedge(f, previous_corner(c));
  }
  return kNone;
}

std::size_t Adjacency::bytes() const {
  return sizeof(Adjacency) + faces_.capacity() * sizeof(FaceRecord) +
         sizeof(std::uint32_t) * (corner_begin_.capacity() + corners_.capacity()) +
         pinched_.capacity() / 8 + (delaunay_ ? delaunay_->bytes() : 0);
}

}  // namespace geodesic
