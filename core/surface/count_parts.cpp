#include "core/surface/count_parts.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/base/polled_fill.h"
#include "core/base/team.h"
#include "core/surface/face_record.h"

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

std::uint64_t count_components(const Triangulation& surface, DisjointSets& sets, Poll& poll) {
  for (const FaceRecord& face : surface.faces) {
    if (poll.cancelled()) return 0;
    sets.join(face.vertex[0], face.vertex[1]);
    sets.join(face.vertex[1], face.vertex[2]);
  }
  std::uint64_t components = 0;
  for (std::uint32_t v = 0; v + 1 < surface.corner_begin.size() && !poll.cancelled(); ++v) {
    if (!surface.corners(v).empty() && sets.find(v) == v) ++components;
  }
  return components;
}

// An edge is known by its place in the list `boundary`, which is filled here. Turning round a
// vertex needs no winding: across each inner edge lies one other face.
std::uint64_t count_boundary_loops(const Triangulation& surface, std::vector<Halfedge>& boundary,
                                   DisjointSets& chains, Poll& poll) {
  if (boundary.empty()) return 0;
  std::size_t count = 0;
  for (std::uint32_t f = 0; f < surface.faces.size() && !poll.cancelled(); ++f) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      const Halfedge h = halfedge(f, c);
      if (surface.ring(h) == h) boundary[count++] = h;
    }
  }
  if (poll.stopped()) return 0;
  const auto number_of = [&](Halfedge h) {
    return static_cast<std::uint32_t>(std::lower_bound(boundary.begin(), boundary.end(), h) -
                                      boundary.begin());
  };
  const auto follow = [&](std::uint32_t number, std::uint32_t pivot) {
    Halfedge h = boundary[number];
    while (!poll.cancelled()) {
      // The other edge at the pivot in the same face.
      const std::uint32_t f = face_of(h);
      const std::uint32_t c = corner_of(h);
      h = surface.faces[f].vertex[c] == pivot ? halfedge(f, previous_corner(c))
                                              : halfedge(f, next_corner(c));
      const Halfedge across = surface.ring(h);
      if (across == h) return chains.join(number, number_of(h));
      if (surface.ring(across) != h) return;  // non-manifold
      h = across;
    }
  };
  for (std::uint32_t i = 0; i < boundary.size() && !poll.cancelled(); ++i) {
    const FaceRecord& face = surface.faces[face_of(boundary[i])];
    const std::uint32_t c = corner_of(boundary[i]);
    follow(i, face.vertex[c]);
    follow(i, face.vertex[next_corner(c)]);
  }
  std::uint64_t loops = 0;
  for (std::uint32_t i = 0; i < boundary.size() && !poll.cancelled(); ++i) {
    if (chains.find(i) == i) ++loops;
  }
  return loops;
}

}  // namespace

// One by each of two threads. What they need is taken before, where it counts as the caller's.
SurfaceParts count_parts(const Triangulation& surface, std::uint64_t boundary_edges, Poll& poll) {
  SurfaceParts parts;
  DisjointSets vertices(surface.corner_begin.size() - 1, poll);
  if (poll.stopped()) return parts;
  DisjointSets edges(boundary_edges, poll);
  if (poll.stopped()) return parts;
  std::vector<Halfedge> boundary;
  polled_assign(boundary, boundary_edges, Halfedge{0}, poll);
  if (poll.stopped()) return parts;
  run_parts(2, poll, [&](std::size_t part, Poll& asked) {
    if (part == 0) {
      parts.components = count_components(surface, vertices, asked);
    } else {
      parts.boundary_loops = count_boundary_loops(surface, boundary, edges, asked);
    }
  });
  return parts;
}

}  // namespace geodesic
