#include "core/surface/adjacency.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

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

// An adjacency that is being built. Each step leaves off when the poll says to stop.
struct Building {
  void fill_geometry(Poll& poll);
  void fill_corners(Poll& poll);
  void fill_rings(Poll& poll);
  void find_pinched_vertices(Poll& poll);
  [[nodiscard]] std::size_t faces_in_first_fan(std::uint32_t vertex, Poll& poll) const;
  void count_components(Poll& poll);
  void count_boundary_loops(Poll& poll);

  [[nodiscard]] std::span<const std::uint32_t> corners_at(std::uint32_t vertex) const {
    return {corners.data() + corner_begin[vertex], corner_begin[vertex + 1] - corner_begin[vertex]};
  }
  [[nodiscard]] Halfedge ring(Halfedge h) const { return faces[face_of(h)].ring[corner_of(h)]; }

  const Mesh& mesh;
  std::vector<FaceRecord> faces = {};
  std::vector<std::uint32_t> corner_begin = {};
  std::vector<std::uint32_t> corners = {};
  std::vector<std::uint64_t> pinched = {};
  bool is_oriented = true;
  bool is_even = false;
  bool has_flat_faces = false;
  bool has_lines = false;
  bool is_crowded = false;
  TopologyReport report = {};
};

void Building::fill_geometry(Poll& poll) {
  const auto positions = mesh.positions();
  const auto triangles = mesh.faces();
  polled_assign(faces, triangles.size(), FaceRecord{}, poll);
  for (std::size_t f = 0; f < faces.size() && !poll.cancelled(); ++f) {
    const Vec3 a = positions[triangles[f][0]];
    const Vec3 b = positions[triangles[f][1]];
    const Vec3 c = positions[triangles[f][2]];
    const std::array<Vec3, 3> side{b - a, c - b, a - c};
    FaceRecord& record = faces[f];
    record.vertex = triangles[f];
    record.dot = {-dot(side[0], side[2]), -dot(side[1], side[0]), -dot(side[2], side[1])};
    // The area comes from the two shorter sides: the longest one's rounding would be a
    // large part of a needle's.
    const std::uint32_t longest = record.longest_side();
    record.area2 = norm(cross(side[next_corner(longest)], side[previous_corner(longest)]));
    const bool is_flat = is_lower_than(tolerance::kFlat, record);
    has_flat_faces = has_flat_faces || is_flat;
    has_lines = has_lines || (is_flat && is_line(record));
  }
  is_even = geodesic::is_even(faces, poll);
}

void Building::fill_corners(Poll& poll) {
  list_corners(faces, mesh.vertex_count(), corner_begin, corners, poll);
  if (poll.stopped()) return;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (corners_at(v).empty()) ++report.vertices_isolated;
  }
}

// Halfedges are gathered per vertex at their smaller end and sorted by the other
// end; each run of equal ends is one edge and becomes one ring.
void Building::fill_rings(Poll& poll) {
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
  for (std::uint32_t v = 0; v < mesh.vertex_count() && !poll.cancelled(); ++v) {
    sides.clear();
    for (const std::uint32_t corner : corners_at(v)) {
      if (poll.cancelled()) return;
      const std::uint32_t f = face_of(corner);
      const std::uint32_t c = corner_of(corner);
      const std::uint32_t ahead = faces[f].vertex[next_corner(c)];
      const std::uint32_t behind = faces[f].vertex[previous_corner(c)];
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
        faces[face_of(h)].ring[corner_of(h)] = sides[i + 1 < end ? i + 1 : begin].h;
      }
      const Halfedge first = sides[begin].h;
      total_length += std::sqrt(std::max(0.0, faces[face_of(first)].length2(corner_of(first))));
      ++report.edges;
      if (end - begin == 1) ++report.edges_boundary;
      if (end - begin > 2) ++report.edges_non_manifold;
      is_crowded = is_crowded || end - begin > Triangulation::kCrowd;
      const auto goes_out = [&](std::size_t i) {
        return faces[face_of(sides[i].h)].vertex[corner_of(sides[i].h)] == v;
      };
      if (end - begin > 2 || (end - begin == 2 && goes_out(begin) == goes_out(begin + 1))) {
        is_oriented = false;
      }
      begin = end;
    }
  }
  // Each duplicate face repeats all three of its sides.
  report.faces_duplicate = duplicate_sides / 3;
  report.mean_edge = total_length / static_cast<double>(report.edges);
}

// The faces that can be reached from the vertex's first face by crossing edges
// that end in the vertex.
std::size_t Building::faces_in_first_fan(std::uint32_t vertex, Poll& poll) const {
  const auto all = corners_at(vertex);
  const auto other_side = [&](Halfedge side) {
    // The other edge of the same face that ends in the vertex.
    const std::uint32_t f = face_of(side);
    const std::uint32_t c = corner_of(side);
    return faces[f].vertex[c] == vertex ? halfedge(f, previous_corner(c))
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

void Building::find_pinched_vertices(Poll& poll) {
  for (std::uint32_t v = 0; v < mesh.vertex_count() && !poll.cancelled(); ++v) {
    const std::size_t all = corners_at(v).size();
    if (all < 2 || faces_in_first_fan(v, poll) == all) continue;
    if (poll.stopped()) return;
    if (pinched.empty()) pinched.assign(mesh.vertex_count() / 64 + 1, 0);
    pinched[v / 64] |= std::uint64_t{1} << (v % 64);
    ++report.vertices_pinched;
  }
}

void Building::count_components(Poll& poll) {
  DisjointSets sets(mesh.vertex_count(), poll);
  if (poll.stopped()) return;
  for (const FaceRecord& record : faces) {
    if (poll.cancelled()) return;
    sets.join(record.vertex[0], record.vertex[1]);
    sets.join(record.vertex[1], record.vertex[2]);
  }
  for (std::uint32_t v = 0; v < mesh.vertex_count() && !poll.cancelled(); ++v) {
    if (!corners_at(v).empty() && sets.find(v) == v) ++report.components;
  }
}

// A loop is a cycle of boundary edges, where each is followed by the one that
// ends the same fan of faces. Turning round a vertex needs no winding: across
// each inner edge lies one other face. A fan that ends at a non-manifold edge
// has no successor; its chain counts as a loop of its own.
void Building::count_boundary_loops(Poll& poll) {
  if (report.edges_boundary == 0) return;
  DisjointSets chains(4 * faces.size(), poll);
  if (poll.stopped()) return;
  const auto on_boundary = [this](Halfedge h) { return ring(h) == h; };
  const auto follow = [&](Halfedge boundary, std::uint32_t pivot) {
    Halfedge h = boundary;
    while (!poll.cancelled()) {
      // The other edge at the pivot in the same face.
      const std::uint32_t f = face_of(h);
      const std::uint32_t c = corner_of(h);
      h = faces[f].vertex[c] == pivot ? halfedge(f, previous_corner(c))
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
  for (std::uint32_t f = 0; f < faces.size() && !poll.cancelled(); ++f) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      const Halfedge h = halfedge(f, c);
      if (!on_boundary(h)) continue;
      follow(h, faces[f].vertex[c]);
      follow(h, faces[f].vertex[next_corner(c)]);
    }
  }
  for (std::uint32_t f = 0; f < faces.size() && !poll.cancelled(); ++f) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      const Halfedge h = halfedge(f, c);
      if (on_boundary(h) && chains.find(h) == h) ++report.boundary_loops;
    }
  }
}

Triangulation view_of(const Adjacency::Parts& parts) {
  return {parts.faces,   parts.corner_begin,   parts.corners,    parts.is_oriented,
          parts.is_even, parts.has_flat_faces, parts.is_crowded, parts.has_lines};
}

}  // namespace

Adjacency Adjacency::build(std::shared_ptr<const Mesh> mesh) {
  return std::move(*build(std::move(mesh), Cancel()));
}

Result<Adjacency> Adjacency::build(std::shared_ptr<const Mesh> mesh, const Cancel& cancel) {
  Building building{*mesh};
  Poll poll(cancel);
  int done = 0;
  for (const auto step : {&Building::fill_geometry, &Building::fill_corners, &Building::fill_rings,
                          &Building::find_pinched_vertices, &Building::count_components,
                          &Building::count_boundary_loops}) {
    (building.*step)(poll);
    if (poll.ask()) return fail_stopped(cancel);
    cancel.report(++done / 7.0);
  }
  Parts parts{.faces = SharedArray(std::move(building.faces)),
              .corner_begin = SharedArray(std::move(building.corner_begin)),
              .corners = SharedArray(std::move(building.corners)),
              .pinched = SharedArray(std::move(building.pinched)),
              .is_oriented = building.is_oriented,
              .is_even = building.is_even,
              .has_flat_faces = building.has_flat_faces,
              .has_lines = building.has_lines,
              .is_crowded = building.is_crowded,
              .delaunay = nullptr,
              .report = building.report};
  auto delaunay = IntrinsicDelaunay::build(view_of(parts), mesh->positions(), cancel);
  if (!delaunay) return fail(std::move(delaunay.error()));
  if (delaunay->flips() != 0) {
    parts.delaunay = std::make_shared<const IntrinsicDelaunay>(std::move(*delaunay));
  }
  return Adjacency(std::move(mesh), std::move(parts));
}

Adjacency::Adjacency(std::shared_ptr<const Mesh> mesh, Parts parts)
    : mesh_(std::move(mesh)), identity_(std::make_shared<const char>()), parts_(std::move(parts)) {}

Triangulation Adjacency::triangulation() const { return view_of(parts_); }

Triangulation Adjacency::delaunay() const {
  if (!parts_.delaunay) return triangulation();
  Triangulation delaunay = parts_.delaunay->triangulation();
  // Flips make none.
  delaunay.has_lines = parts_.has_lines;
  return delaunay;
}

Halfedge Adjacency::find_edge(std::uint32_t a, std::uint32_t b) const {
  for (const std::uint32_t corner : corners(a)) {
    const std::uint32_t f = face_of(corner);
    const std::uint32_t c = corner_of(corner);
    if (face(f).vertex[next_corner(c)] == b) return corner;
    if (face(f).vertex[previous_corner(c)] == b) return halfedge(f, previous_corner(c));
  }
  return kNone;
}

std::size_t Adjacency::bytes() const {
  return sizeof(Adjacency) + parts_.faces.bytes() + parts_.corner_begin.bytes() +
         parts_.corners.bytes() + parts_.pinched.bytes() +
         (parts_.delaunay ? parts_.delaunay->bytes() : 0);
}

}  // namespace geodesic
