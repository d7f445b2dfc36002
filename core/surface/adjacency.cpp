#include "core/surface/adjacency.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "core/base/large_array.h"
#include "core/base/polled_sort.h"
#include "core/base/team.h"
#include "core/base/tolerances.h"
#include "core/surface/corner_lists.h"
#include "core/surface/count_parts.h"
#include "core/surface/intrinsic_delaunay.h"
#include "core/surface/refined_surface.h"
#include "core/surface/roughness.h"
#include "core/surface/unfold_rounding.h"

namespace geodesic {
namespace {

// An adjacency that is being built. Each step leaves off when the poll says to stop.
struct AdjacencyBuilder {
  void fill_geometry(Poll& poll);
  void fill_corners(Poll& poll);
  void fill_rings(Poll& poll);
  // What the edges of some vertices, whose smaller ends these are, add to the whole.
  struct Edges {
    std::uint64_t count = 0;
    std::uint64_t boundary = 0;
    std::uint64_t non_manifold = 0;
    std::uint64_t duplicate_sides = 0;
    double length = 0;
    bool are_crowded = false;
    bool are_oriented = true;
  };
  // Joins the edges whose smaller end is from `from` to `to` - 1.
  [[nodiscard]] Edges join_edges(std::uint32_t from, std::uint32_t to, Poll& poll);
  void find_pinched_vertices(Poll& poll);
  [[nodiscard]] std::size_t faces_in_first_fan(std::uint32_t vertex, Poll& poll) const;
  void count_parts(Poll& poll);

  [[nodiscard]] std::span<const std::uint32_t> corners_at(std::uint32_t vertex) const {
    return {corners.data() + corner_begin[vertex], corner_begin[vertex + 1] - corner_begin[vertex]};
  }
  [[nodiscard]] Halfedge ring(Halfedge h) const { return faces[face_of(h)].ring[corner_of(h)]; }

  const Mesh& mesh;
  LargeArray<FaceRecord> faces = {};
  std::vector<std::uint32_t> corner_begin = {};
  std::vector<std::uint32_t> corners = {};
  std::vector<std::uint64_t> pinched = {};
  bool is_oriented = true;
  bool is_even = false;
  bool has_flat_faces = false;
  bool has_lines = false;
  bool is_crowded = false;
  bool has_large_faces = false;
  double longest2 = 0;
  TopologyReport report = {};
};

void AdjacencyBuilder::fill_geometry(Poll& poll) {
  const auto positions = mesh.positions();
  const auto triangles = mesh.faces();
  faces = LargeArray<FaceRecord>(triangles.size(), poll);
  if (poll.stopped()) return;
  struct Shapes {
    bool has_flat_faces = false;
    bool has_lines = false;
    double large_area2 = 0;  // twice the area of large faces
  };
  std::vector<Shapes> found(count_blocks(faces.size()));
  constexpr double kLargeSide = 0.2;  // of the box's diagonal
  constexpr double kLargeShare = 0.05;
  const double large = kLargeSide * norm(mesh.box().max - mesh.box().min);
  run_in_blocks(
      faces.size(), poll, [&](std::size_t block, std::size_t begin, std::size_t end, Poll& asked) {
        Shapes shapes;
        for (std::size_t f = begin; f < end && !asked.cancelled(); ++f) {
          const Vec3 a = positions[triangles[f][0]];
          const Vec3 b = positions[triangles[f][1]];
          const Vec3 c = positions[triangles[f][2]];
          const std::array<Vec3, 3> side{b - a, c - b, a - c};
          FaceRecord& record = faces[f];
          record = {};
          record.vertex = triangles[f];
          record.dot = {-dot(side[0], side[2]), -dot(side[1], side[0]), -dot(side[2], side[1])};
          // The area comes from the two shorter sides: the longest one's rounding would be a
          // large part of a needle's.
          const std::uint32_t longest = record.longest_side();
          record.area2 = norm(cross(side[next_corner(longest)], side[previous_corner(longest)]));
          const bool is_flat = is_lower_than(tolerance::kFlat, record);
          shapes.has_flat_faces = shapes.has_flat_faces || is_flat;
          shapes.has_lines = shapes.has_lines || (is_flat && is_line(record));
          if (record.length2(longest) > large * large) shapes.large_area2 += record.area2;
        }
        found[block] = shapes;
      });
  double large_area2 = 0;
  for (const Shapes& shapes : found) {
    has_flat_faces = has_flat_faces || shapes.has_flat_faces;
    has_lines = has_lines || shapes.has_lines;
    large_area2 += shapes.large_area2;
  }
  has_large_faces = large_area2 > kLargeShare * 2 * mesh.area();
  if (poll.stopped()) return;
  const SideExtent sides = extent_of_sides(faces.all(), poll);
  is_even = sides.is_even();
  longest2 = sides.longest2;
}

void AdjacencyBuilder::fill_corners(Poll& poll) {
  list_corners(faces.all(), mesh.vertex_count(), corner_begin, corners, poll);
  if (poll.stopped()) return;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (corners_at(v).empty()) ++report.vertices_isolated;
  }
}

// Halfedges are gathered per vertex at their smaller end and sorted by the other
// end; each run of equal ends is one edge and becomes one ring.
void AdjacencyBuilder::fill_rings(Poll& poll) {
  std::vector<Edges> edges(count_blocks(mesh.vertex_count()));
  run_in_blocks(mesh.vertex_count(), poll,
                [&](std::size_t block, std::size_t begin, std::size_t end, Poll& asked) {
                  edges[block] = join_edges(static_cast<std::uint32_t>(begin),
                                            static_cast<std::uint32_t>(end), asked);
                });
  Edges all;
  for (const Edges& some : edges) {
    all.count += some.count;
    all.boundary += some.boundary;
    all.non_manifold += some.non_manifold;
    all.duplicate_sides += some.duplicate_sides;
    all.length += some.length;
    all.are_crowded = all.are_crowded || some.are_crowded;
    all.are_oriented = all.are_oriented && some.are_oriented;
  }
  is_crowded = all.are_crowded;
  is_oriented = all.are_oriented;
  report.edges = all.count;
  report.edges_boundary = all.boundary;
  report.edges_non_manifold = all.non_manifold;
  // Each duplicate face repeats all three of its sides.
  report.faces_duplicate = all.duplicate_sides / 3;
  report.mean_edge = all.length / static_cast<double>(all.count);
}

AdjacencyBuilder::Edges AdjacencyBuilder::join_edges(std::uint32_t from, std::uint32_t to,
                                                     Poll& poll) {
  struct EdgeSide {
    std::uint32_t far_end;
    std::uint32_t opposite;
    Halfedge h;
  };
  const auto earlier = [](const EdgeSide& a, const EdgeSide& b) {
    return std::tie(a.far_end, a.opposite, a.h) < std::tie(b.far_end, b.opposite, b.h);
  };
  Edges edges;
  std::vector<EdgeSide> sides;
  std::vector<EdgeSide> spare;
  for (std::uint32_t v = from; v < to && !poll.cancelled(); ++v) {
    sides.clear();
    for (const std::uint32_t corner : corners_at(v)) {
      if (poll.cancelled()) return edges;
      const std::uint32_t f = face_of(corner);
      const std::uint32_t c = corner_of(corner);
      const std::uint32_t ahead = faces[f].vertex[next_corner(c)];
      const std::uint32_t behind = faces[f].vertex[previous_corner(c)];
      if (ahead > v) sides.push_back({ahead, behind, corner});
      if (behind > v) sides.push_back({behind, ahead, halfedge(f, previous_corner(c))});
    }
    polled_sort(sides, 0, sides.size(), earlier, spare, poll);
    if (poll.stopped()) return edges;
    for (std::size_t begin = 0; begin < sides.size();) {
      std::size_t end = begin + 1;
      while (end < sides.size() && sides[end].far_end == sides[begin].far_end) {
        if (sides[end].opposite == sides[end - 1].opposite) ++edges.duplicate_sides;
        ++end;
      }
      for (std::size_t i = begin; i < end; ++i) {
        const Halfedge h = sides[i].h;
        faces[face_of(h)].ring[corner_of(h)] = sides[i + 1 < end ? i + 1 : begin].h;
      }
      const Halfedge first = sides[begin].h;
      edges.length += std::sqrt(std::max(0.0, faces[face_of(first)].length2(corner_of(first))));
      ++edges.count;
      if (end - begin == 1) ++edges.boundary;
      if (end - begin > 2) ++edges.non_manifold;
      edges.are_crowded = edges.are_crowded || end - begin > Triangulation::kCrowd;
      const auto goes_out = [&](std::size_t i) {
        return faces[face_of(sides[i].h)].vertex[corner_of(sides[i].h)] == v;
      };
      if (end - begin > 2 || (end - begin == 2 && goes_out(begin) == goes_out(begin + 1))) {
        edges.are_oriented = false;
      }
      begin = end;
    }
  }
  return edges;
}

// The faces that can be reached from the vertex's first face by crossing edges
// that end in the vertex.
std::size_t AdjacencyBuilder::faces_in_first_fan(std::uint32_t vertex, Poll& poll) const {
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

void AdjacencyBuilder::find_pinched_vertices(Poll& poll) {
  // A block of vertices has words of its own.
  constexpr std::size_t kBits = 64;
  static_assert(kBlock % kBits == 0);
  pinched.assign(mesh.vertex_count() / kBits + 1, 0);
  run_in_blocks(
      mesh.vertex_count(), poll, [&](std::size_t, std::size_t begin, std::size_t end, Poll& asked) {
        for (auto v = static_cast<std::uint32_t>(begin); v < end && !asked.cancelled(); ++v) {
          const std::size_t all = corners_at(v).size();
          if (all < 2 || faces_in_first_fan(v, asked) == all || asked.stopped()) continue;
          pinched[v / kBits] |= std::uint64_t{1} << (v % kBits);
        }
      });
  for (const std::uint64_t word : pinched) {
    report.vertices_pinched += static_cast<std::uint64_t>(std::popcount(word));
  }
  if (report.vertices_pinched == 0) pinched = {};
}

void AdjacencyBuilder::count_parts(Poll& poll) {
  const Triangulation surface{faces.all(), corner_begin, corners};
  const auto [components, boundary_loops] =
      geodesic::count_parts(surface, report.edges_boundary, poll);
  report.components = components;
  report.boundary_loops = boundary_loops;
}

Triangulation view_of(const Adjacency::Parts& parts) {
  return {parts.faces,       parts.corner_begin, parts.corners,
          parts.is_oriented, parts.is_even,      parts.has_flat_faces,
          parts.is_crowded,  parts.has_lines,    parts.longest2};
}

// All but the refined surface.
Result<Adjacency::Parts> build_parts(const Mesh& mesh, const Cancel& cancel) {
  AdjacencyBuilder building{mesh};
  Poll poll(cancel);
  int done = 0;
  for (const auto step : {&AdjacencyBuilder::fill_geometry, &AdjacencyBuilder::fill_corners,
                          &AdjacencyBuilder::fill_rings, &AdjacencyBuilder::find_pinched_vertices,
                          &AdjacencyBuilder::count_parts}) {
    (building.*step)(poll);
    if (poll.ask()) return fail_stopped(cancel);
    cancel.report(++done / 10.0);
  }
  const bool is_rough = geodesic::is_rough(building.faces.all(), mesh.positions());
  Adjacency::Parts parts{.faces = std::move(building.faces).share(),
                         .corner_begin = SharedArray(std::move(building.corner_begin)),
                         .corners = SharedArray(std::move(building.corners)),
                         .pinched = SharedArray(std::move(building.pinched)),
                         .is_oriented = building.is_oriented,
                         .is_even = building.is_even,
                         .has_flat_faces = building.has_flat_faces,
                         .has_lines = building.has_lines,
                         .is_crowded = building.is_crowded,
                         .is_rough = is_rough,
                         .has_large_faces = building.has_large_faces,
                         .longest2 = building.longest2,
                         .delaunay = nullptr,
                         .refined = nullptr,
                         .report = building.report};
  auto delaunay = IntrinsicDelaunay::build(view_of(parts), mesh.positions(), cancel);
  if (!delaunay) return fail(std::move(delaunay.error()));
  if (delaunay->flips() != 0) {
    parts.delaunay = std::make_shared<const IntrinsicDelaunay>(std::move(*delaunay));
  }
  return parts;
}

}  // namespace

Adjacency Adjacency::build(std::shared_ptr<const Mesh> mesh) {
  return std::move(*build(std::move(mesh), Cancel()));
}

Result<Adjacency> Adjacency::build(std::shared_ptr<const Mesh> mesh, const Cancel& cancel) {
  auto parts = build_parts(*mesh, cancel);
  if (!parts) return fail(std::move(parts.error()));
  const Triangulation own = view_of(*parts);
  const Triangulation flipped = parts->delaunay ? parts->delaunay->triangulation() : own;
  auto refined = RefinedSurface::build(own, flipped, mesh->positions(), cancel);
  if (!refined) return fail(std::move(refined.error()));
  parts->refined = std::move(*refined);
  return Adjacency(std::move(mesh), std::move(*parts));
}

Result<Adjacency> build_unrefined(std::shared_ptr<const Mesh> mesh, const Cancel& cancel) {
  auto parts = build_parts(*mesh, cancel);
  if (!parts) return fail(std::move(parts.error()));
  return Adjacency(std::move(mesh), std::move(*parts));
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
         (parts_.delaunay ? parts_.delaunay->bytes() : 0) +
         (parts_.refined ? parts_.refined->bytes() : 0);
}

}  // namespace geodesic
