#include "core/curves/source_lines.h"

#include <algorithm>
#include <array>
#include <set>
#include <tuple>
#include <unordered_set>
#include <utility>

#include "core/base/polled_fill.h"
#include "core/surface/point.h"

namespace geodesic {
namespace {

bool is_on_boundary(const Adjacency& adjacency, Halfedge h) { return adjacency.ring(h) == h; }

std::uint32_t other_end(const Adjacency& adjacency, Halfedge h, std::uint32_t vertex) {
  return adjacency.tail(h) == vertex ? adjacency.head(h) : adjacency.tail(h);
}

// The boundary edge that ends the fan of faces about `pivot` that h begins; kNone where the fan
// ends at a non-manifold edge.
Halfedge next_on_boundary(const Adjacency& adjacency, Halfedge h, std::uint32_t pivot, Poll& poll) {
  while (!poll.cancelled()) {
    // The other edge at the pivot in the same face.
    const std::uint32_t f = face_of(h);
    const std::uint32_t c = corner_of(h);
    h = adjacency.face(f).vertex[c] == pivot ? halfedge(f, previous_corner(c))
                                             : halfedge(f, next_corner(c));
    const Halfedge across = adjacency.ring(h);
    if (across == h) return h;
    if (adjacency.ring(across) != h) return kNone;
    h = across;
  }
  return kNone;
}

std::uint64_t least_source_vertex(const Adjacency& adjacency, const BoundaryLoop& loop) {
  const Mesh& mesh = adjacency.mesh();
  std::uint64_t least = kNone;
  for (const Halfedge h : loop.edges) {
    least = std::min<std::uint64_t>(least, mesh.source_of_vertex(adjacency.tail(h)));
    least = std::min<std::uint64_t>(least, mesh.source_of_vertex(adjacency.head(h)));
  }
  return least;
}

void add_end(const Adjacency& adjacency, std::uint32_t vertex, std::uint32_t item,
             std::unordered_set<std::uint32_t>& known, SourceLines& lines,
             std::vector<Source>& sources) {
  if (!known.insert(vertex).second) return;
  sources.push_back({point_at_vertex(adjacency, vertex), 0});
  lines.item_of_source.push_back(item);
}

LineSegment whole_edge(Halfedge h, std::uint32_t item) {
  LineSegment segment;
  segment.face = face_of(h);
  segment.from[corner_of(h)] = 1;
  segment.to[next_corner(corner_of(h))] = 1;
  segment.item = item;
  return segment;
}

// What two segments that are the same have in common: the face, or the vertices of the edge that
// they run along, and where the ends are.
struct SegmentKey {
  std::array<std::uint32_t, 2> place;  // a face and kNone, or an edge's vertices, ascending
  std::array<double, 6> ends;
  std::uint32_t number;

  [[nodiscard]] bool is_same(const SegmentKey& other) const {
    return place == other.place && ends == other.ends;
  }
  friend bool operator<(const SegmentKey& a, const SegmentKey& b) {
    return std::tie(a.place, a.ends, a.number) < std::tie(b.place, b.ends, b.number);
  }
};

SegmentKey key_of(const Adjacency& adjacency, const LineSegment& segment, std::uint32_t number) {
  const Halfedge along = segment.along();
  std::array<double, 3> from = segment.from;
  std::array<double, 3> to = segment.to;
  std::array<std::uint32_t, 2> place{segment.face, kNone};
  if (along != kNone) {
    place = {adjacency.tail(along), adjacency.head(along)};
    std::uint32_t low = corner_of(along);
    if (place[1] < place[0]) {
      std::swap(place[0], place[1]);
      low = next_corner(low);
    }
    // By the weight of the lower vertex.
    from = {segment.from[low], 0, 0};
    to = {segment.to[low], 0, 0};
  }
  if (to < from) std::swap(from, to);
  return {place, {from[0], from[1], from[2], to[0], to[1], to[2]}, number};
}

// Keeps the elements that are marked.
template <class Value>
void keep_marked(std::vector<Value>& values, const std::vector<bool>& marked) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (marked[i]) values[kept++] = values[i];
  }
  values.resize(kept);
}

// The edges between these faces and those that no item has, each once, as the first of its
// halfedges here. An edge is gone round once, however many of these faces are on it. Of no use if
// the poll says to stop.
std::vector<Halfedge> border_of(const Adjacency& adjacency, std::span<const std::uint32_t> faces,
                                const SourceLines& lines, Poll& poll) {
  std::vector<Halfedge> border;
  if (!poll.may_take(adjacency.faces().size() / 2)) return border;
  std::vector<bool> passed(4 * adjacency.faces().size(), false);
  for (const std::uint32_t f : faces) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      const Halfedge h = halfedge(f, c);
      if (passed[h]) continue;
      bool is_border = false;
      Halfedge g = h;
      do {
        if (poll.cancelled()) return border;
        passed[g] = true;
        is_border = is_border || !lines.has_face(face_of(g));
        g = adjacency.ring(g);
      } while (g != h);
      if (is_border) border.push_back(h);
    }
  }
  return border;
}

// Tells `found` of one loop after the other, which it may take.
template <class Found>
void walk_boundaries(const Adjacency& adjacency, Poll& poll, const Found& found) {
  if (adjacency.report().edges_boundary == 0) return;
  std::vector<bool> passed(4 * adjacency.faces().size(), false);
  const auto positions = adjacency.mesh().positions();
  BoundaryLoop loop;
  for (std::uint32_t f = 0; f < adjacency.faces().size() && !poll.cancelled(); ++f) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      const Halfedge start = halfedge(f, c);
      if (passed[start] || !is_on_boundary(adjacency, start)) continue;
      loop.edges.clear();
      loop.length = 0;
      // On from one end, until it comes round; if it does not, from the other end, too.
      const auto walk = [&](std::uint32_t pivot) {
        for (Halfedge h = start; h != kNone && !poll.cancelled();) {
          h = next_on_boundary(adjacency, h, pivot, poll);
          if (h == start) return true;
          if (h == kNone || passed[h]) return false;
          passed[h] = true;
          loop.edges.push_back(h);
          pivot = other_end(adjacency, h, pivot);
        }
        return false;
      };
      passed[start] = true;
      loop.edges.push_back(start);
      loop.is_closed = walk(adjacency.head(start));
      if (!loop.is_closed) {
        std::reverse(loop.edges.begin(), loop.edges.end());
        (void)walk(adjacency.tail(start));
      }
      for (const Halfedge h : loop.edges) {
        loop.length += distance(positions[adjacency.tail(h)], positions[adjacency.head(h)]);
      }
      found(loop);
    }
  }
}

}  // namespace

std::vector<BoundaryLoop> boundary_loops(const Adjacency& adjacency, Poll& poll) {
  std::vector<BoundaryLoop> loops;
  walk_boundaries(adjacency, poll, [&](BoundaryLoop& loop) { loops.push_back(std::move(loop)); });
  if (poll.stopped()) return loops;
  std::vector<std::pair<double, std::uint64_t>> key;
  key.reserve(loops.size());
  for (const BoundaryLoop& loop : loops) {
    if (poll.cancelled_after(loop.edges.size())) return loops;
    key.emplace_back(-loop.length, least_source_vertex(adjacency, loop));
  }
  std::vector<std::uint32_t> order(loops.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return key[a] < key[b]; });
  std::vector<BoundaryLoop> sorted;
  sorted.reserve(loops.size());
  for (const std::uint32_t i : order) sorted.push_back(std::move(loops[i]));
  return sorted;
}

std::vector<BoundarySize> longest_boundaries(const Adjacency& adjacency, std::size_t most,
                                             Poll& poll) {
  struct Numbered {
    BoundarySize size;
    std::uint64_t number;
  };
  // As boundary_loops has them.
  const auto is_before = [](const Numbered& a, const Numbered& b) {
    return std::tuple(-a.size.length, a.size.vertex, a.number) <
           std::tuple(-b.size.length, b.size.vertex, b.number);
  };
  std::vector<Numbered> first;  // a heap with the last of them on top
  std::uint64_t number = 0;
  walk_boundaries(adjacency, poll, [&](const BoundaryLoop& loop) {
    if (poll.cancelled_after(loop.edges.size())) return;
    first.push_back(
        {{loop.length, loop.edges.size(), least_source_vertex(adjacency, loop), loop.is_closed},
         number++});
    std::push_heap(first.begin(), first.end(), is_before);
    if (first.size() <= most) return;
    std::pop_heap(first.begin(), first.end(), is_before);
    first.pop_back();
  });
  std::sort_heap(first.begin(), first.end(), is_before);
  std::vector<BoundarySize> sizes;
  sizes.reserve(first.size());
  for (const Numbered& loop : first) sizes.push_back(loop.size);
  return sizes;
}

void add_edges(const Adjacency& adjacency, std::span<const Halfedge> edges, std::uint32_t item,
               SourceLines& lines, std::vector<Source>& sources, Poll& poll) {
  constexpr std::size_t kOfEdge = sizeof(LineSegment) + sizeof(Source) + 8 * sizeof(std::uint32_t);
  if (!poll.may_take(2 * edges.size() * kOfEdge)) return;
  std::unordered_set<std::uint32_t> known;
  for (const Halfedge h : edges) {
    if (poll.cancelled()) return;
    lines.segments.push_back(whole_edge(h, item));
    add_end(adjacency, adjacency.tail(h), item, known, lines, sources);
    add_end(adjacency, adjacency.head(h), item, known, lines, sources);
  }
}

void add_faces(const Adjacency& adjacency, std::span<const std::uint32_t> faces, std::uint32_t item,
               SourceLines& lines, std::vector<Source>& sources, Poll& poll) {
  if (lines.item_of_face.empty()) {
    polled_assign(lines.item_of_face, adjacency.faces().size(), kNone, poll);
  }
  if (poll.stopped()) return;
  for (const std::uint32_t f : faces) {
    if (lines.item_of_face[f] == kNone) lines.item_of_face[f] = item;
  }
  const std::vector<Halfedge> border = border_of(adjacency, faces, lines, poll);
  if (poll.stopped()) return;
  constexpr std::size_t kOfEdge = sizeof(LineSegment) + sizeof(Source) + 8 * sizeof(std::uint32_t);
  if (!poll.may_take(2 * border.size() * kOfEdge)) return;
  for (const Halfedge h : border) lines.segments.push_back(whole_edge(h, item));
  // Faces that share no edge with the set may share a vertex. Of a set that is all of a component,
  // any vertex is a source as well as another.
  std::unordered_set<std::uint32_t> known;
  std::vector<bool> seen(adjacency.mesh().vertex_count(), false);
  for (const std::uint32_t f : faces) {
    for (const std::uint32_t v : adjacency.face(f).vertex) {
      if (poll.cancelled()) return;
      if (seen[v]) continue;
      seen[v] = true;
      for (const std::uint32_t corner : adjacency.corners(v)) {
        if (poll.cancelled()) return;
        if (lines.item_of_face[face_of(corner)] != kNone) continue;
        add_end(adjacency, v, item, known, lines, sources);
        break;
      }
    }
  }
  if (!known.empty() || faces.empty()) return;
  add_end(adjacency, adjacency.face(faces.front()).vertex[0], item, known, lines, sources);
}

void merge_repeated(const Adjacency& adjacency, SourceLines& lines, std::vector<Source>& sources,
                    Poll& poll) {
  const std::size_t count = lines.segments.size();
  using Place = std::tuple<std::uint32_t, std::array<double, 3>, double>;
  constexpr std::size_t kOfPlace = sizeof(Place) + 6 * sizeof(void*);
  if (!poll.may_take(count * sizeof(SegmentKey) + sources.size() * kOfPlace)) return;
  std::vector<SegmentKey> keys;
  keys.reserve(count);
  for (std::uint32_t s = 0; s < count && !poll.cancelled(); ++s) {
    keys.push_back(key_of(adjacency, lines.segments[s], s));
  }
  if (poll.stopped()) return;
  std::sort(keys.begin(), keys.end());
  std::vector<bool> is_first(count, true);
  for (std::size_t i = 1; i < keys.size() && !poll.cancelled(); ++i) {
    if (keys[i].is_same(keys[i - 1])) is_first[keys[i].number] = false;
  }
  keep_marked(lines.segments, is_first);
  std::vector<bool> is_kept(sources.size(), true);
  std::set<Place> places;
  for (std::size_t i = 0; i < sources.size() && !poll.cancelled(); ++i) {
    const SurfacePoint& at = sources[i].point;
    is_kept[i] =
        at.at_vertex()
            ? places.emplace(at.vertex, std::array{0.0, 0.0, 0.0}, sources[i].offset).second
            : places.emplace(at.face, at.bary, sources[i].offset).second;
  }
  if (poll.stopped()) return;
  keep_marked(sources, is_kept);
  keep_marked(lines.item_of_source, is_kept);
}

}  // namespace geodesic
