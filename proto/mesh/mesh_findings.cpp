// The counts are known from building; examples are searched for only where there is
// something to find, each search linear or a sort.
#include "proto/mesh/mesh_findings.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

namespace geodesic::proto {
namespace {

constexpr std::size_t kMostExamples = 5;

using Of = MeshExample::Of;

// Keeps the first few in source order of what is offered in any order.
class FirstFew {
 public:
  explicit FirstFew(Of of) : of_(of) {}

  void offer(std::vector<std::uint32_t> numbers) {
    if (kept_.size() == kMostExamples && numbers >= kept_.back()) return;
    const auto place = std::ranges::lower_bound(kept_, numbers);
    if (place != kept_.end() && *place == numbers) return;
    kept_.insert(place, std::move(numbers));
    if (kept_.size() > kMostExamples) kept_.pop_back();
  }

  [[nodiscard]] std::vector<MeshExample> taken() {
    std::vector<MeshExample> examples;
    for (auto& numbers : kept_) examples.push_back({of_, std::move(numbers)});
    return examples;
  }

 private:
  Of of_;
  std::vector<std::vector<std::uint32_t>> kept_;
};

std::vector<MeshExample> welded(const Mesh& mesh) {
  FirstFew few(Of::vertices);
  for (std::uint32_t source = 0; source < mesh.source_vertex_count(); ++source) {
    const std::uint32_t first = mesh.source_of_vertex(mesh.vertex_of_source()[source]);
    if (first != source) few.offer({first, source});
  }
  return few.taken();
}

std::vector<MeshExample> dropped(const Mesh& mesh) {
  FirstFew few(Of::face);
  for (const auto& face :
       mesh.dropped_faces().first(std::min(kMostExamples, mesh.dropped_faces().size()))) {
    few.offer({face.source_face});
  }
  return few.taken();
}

std::vector<MeshExample> without_area(const Mesh& mesh) {
  FirstFew few(Of::face);
  for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
    const Triangle& t = mesh.faces()[f];
    if (Mesh::is_without_area(mesh.positions()[t[0]], mesh.positions()[t[1]],
                              mesh.positions()[t[2]])) {
      few.offer({mesh.source_of_face(f)});
    }
  }
  return few.taken();
}

std::vector<MeshExample> duplicates(const Mesh& mesh) {
  std::vector<std::pair<Triangle, std::uint32_t>> sorted;
  sorted.reserve(mesh.face_count());
  for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
    Triangle t = mesh.faces()[f];
    std::ranges::sort(t);
    sorted.emplace_back(t, mesh.source_of_face(f));
  }
  std::ranges::sort(sorted);
  FirstFew few(Of::face);
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    if (sorted[i].first == sorted[i - 1].first) few.offer({sorted[i].second});
  }
  return few.taken();
}

std::vector<MeshExample> non_manifold_edges(const Adjacency& adjacency) {
  const Mesh& mesh = adjacency.mesh();
  FirstFew few(Of::vertices);
  for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      const Halfedge h = halfedge(f, c);
      const Halfedge next = adjacency.ring(h);
      if (next == h || adjacency.ring(next) == h) continue;
      const std::uint32_t a = mesh.source_of_vertex(mesh.faces()[f][c]);
      const std::uint32_t b = mesh.source_of_vertex(mesh.faces()[f][next_corner(c)]);
      few.offer({std::min(a, b), std::max(a, b)});
    }
  }
  return few.taken();
}

template <class Test>
std::vector<MeshExample> vertices_that(const Mesh& mesh, const Test& test) {
  FirstFew few(Of::vertex);
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (test(v)) few.offer({mesh.source_of_vertex(v)});
  }
  return few.taken();
}

// The first source vertex of each component.
std::vector<MeshExample> first_of_components(const Adjacency& adjacency) {
  const Mesh& mesh = adjacency.mesh();
  std::vector<std::uint32_t> parent(mesh.vertex_count());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto find = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const Triangle& t : mesh.faces()) {
    parent[find(t[1])] = find(t[0]);
    parent[find(t[2])] = find(t[0]);
  }
  std::vector<std::uint32_t> first(mesh.vertex_count(), kNone);
  for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
    if (adjacency.corners(v).empty()) continue;
    std::uint32_t& least = first[find(v)];
    least = std::min(least, mesh.source_of_vertex(v));
  }
  FirstFew few(Of::vertex);
  for (const std::uint32_t source : first) {
    if (source != kNone) few.offer({source});
  }
  return few.taken();
}

}  // namespace

std::vector<MeshFinding> examine(const Adjacency& adjacency) {
  const Mesh& mesh = adjacency.mesh();
  const TopologyReport& topology = adjacency.report();
  std::vector<MeshFinding> findings;
  const auto add = [&](const char* code, std::uint64_t count, const char* one, const char* many,
                       const char* meaning, const auto& search) {
    if (count == 0) return;
    findings.push_back({code, count, search(),
                        std::to_string(count) + (count == 1 ? one : many) + ": " + meaning + "."});
  };
  add("vertices_welded", mesh.source_vertex_count() - mesh.vertex_count(),
      " vertex is where an earlier one is", " vertices are where earlier ones are",
      "welded, so that surfaces meet there and fields have equal values",
      [&] { return welded(mesh); });
  add("faces_dropped", mesh.dropped_face_count(), " face has two corners in one place",
      " faces have two corners in one place", "left out, their other edges joined",
      [&] { return dropped(mesh); });
  add("faces_without_area", mesh.zero_area_face_count(), " face has no area", " faces have no area",
      "kept, paths may run along them", [&] { return without_area(mesh); });
  add("faces_duplicate", topology.faces_duplicate, " face repeats another", " faces repeat others",
      "kept: its area counts again, its edges are no boundary, distances between points are the "
      "same",
      [&] { return duplicates(mesh); });
  add("edges_non_manifold", topology.edges_non_manifold, " edge has more than two faces",
      " edges have more than two faces", "kept, distances pass to all of them",
      [&] { return non_manifold_edges(adjacency); });
  add("vertices_pinched", topology.vertices_pinched, " vertex joins faces that share no edge",
      " vertices join faces that share no edge", "kept, distances pass through them", [&] {
        return vertices_that(mesh, [&](std::uint32_t v) { return adjacency.is_pinched(v); });
      });
  add("vertices_isolated", topology.vertices_isolated, " vertex is in no face",
      " vertices are in no face", "kept, nothing reaches them", [&] {
        return vertices_that(mesh, [&](std::uint32_t v) { return adjacency.corners(v).empty(); });
      });
  add("boundaries", topology.boundary_loops, " boundary", " boundaries",
      "nothing passes beyond, shortest paths bend round",
      [] { return std::vector<MeshExample>{}; });
  add("components", topology.components > 1 ? topology.components : 0, "", " components",
      "distances between them are infinite", [&] { return first_of_components(adjacency); });
  return findings;
}

}  // namespace geodesic::proto
