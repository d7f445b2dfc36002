#include "core/refine/refine_along.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "core/base/polled_fill.h"
#include "core/mesh/triangle_soup.h"
#include "core/refine/refined_numbers.h"
#include "core/surface/line_gaps.h"

namespace geodesic {
namespace {

// What a new vertex takes here, about, with the pieces about it.
constexpr std::uint64_t kBytesOfVertex = 1000;

// Two points of a line in a face of both, by their weights there.
struct Segment {
  std::uint32_t line;
  std::uint32_t number;  // in its line
  Weights a;
  Weights b;
};

struct EdgePlace {
  std::uint32_t low;  // the edge's vertices
  std::uint32_t high;
  double t;  // from low to high
  friend bool operator<(const EdgePlace& a, const EdgePlace& b) {
    return std::tie(a.low, a.high, a.t) < std::tie(b.low, b.high, b.t);
  }
};

// The same point, with weights that are next to nothing left out.
SurfacePoint snapped(const Adjacency& adjacency, const SurfacePoint& point) {
  if (point.at_vertex()) return point;
  Weights bary = point.bary;
  for (double& weight : bary) {
    if (weight < kSnap) weight = 0;
  }
  return point_on_face(adjacency, point.face, bary);
}

// The side on which weights lie, from its corner on; 3 for none, and at a corner.
std::uint32_t side_under(const Weights& weights) {
  std::uint32_t zeros = 0;
  std::uint32_t side = 3;
  for (std::uint32_t c = 0; c < 3; ++c) {
    if (weights[(c + 2) % 3] != 0) continue;
    ++zeros;
    side = c;
  }
  return zeros == 1 ? side : 3;
}

using VertexPair = std::pair<std::uint32_t, std::uint32_t>;  // the lesser first

// Of a face that is split.
struct Part {
  Triangle vertices;
  std::array<Weights, 3> corners;
};

class Refiner {
 public:
  Refiner(const Adjacency& whole, std::span<const SurfacePolyline> lines,
          std::uint64_t most_vertices, const Cancel& cancel)
      : whole_(whole),
        mesh_(whole.mesh()),
        lines_(lines),
        most_vertices_(most_vertices),
        cancel_(cancel),
        poll_(cancel),
        chains_(lines.size()) {}

  Result<RefinedMesh> run() {
    for (std::uint32_t i = 0; i < lines_.size(); ++i) {
      if (auto placed = place(i); !placed) return fail(std::move(placed.error()));
    }
    for (const auto& [face, segments] : faces_) {
      if (auto split = split_face(face, segments); !split) return fail(std::move(split.error()));
    }
    if (auto apart = keep_edges_apart(); !apart) return fail(std::move(apart.error()));
    if (poll_.ask()) return fail_stopped(poll_);
    return assemble();
  }

 private:
  // Finds the faces of a line's segments, and the points on edges.
  Result<void> place(std::uint32_t line) {
    SurfacePolyline points;
    if (!poll_.may_take(lines_[line].size() * sizeof(SurfacePoint))) return fail_stopped(poll_);
    points.reserve(lines_[line].size());
    for (const SurfacePoint& point : lines_[line]) points.push_back(snapped(whole_, point));
    if (points.empty()) return fail(ErrorCode::value_out_of_range, "a line has no points");
    if (points.size() == 1) {
      const SurfacePoint& point = points.front();
      if (point.face != kNone) return add_segment(line, point, point, point.face);
      chains_[line] = {{point.vertex}};
      return {};
    }
    points = close_gaps(whole_, points, Gaps::at_vertices, poll_);
    for (std::size_t i = 1; i < points.size(); ++i) {
      const std::uint32_t face = face_in_common(whole_, points[i - 1], points[i], poll_);
      if (poll_.stopped()) return fail_stopped(poll_);
      if (face == kNone) {
        return fail(ErrorCode::value_out_of_range, "two points in a row are in no face together");
      }
      auto added = add_segment(line, points[i - 1], points[i], face);
      if (!added) return added;
    }
    return {};
  }

  Result<void> add_segment(std::uint32_t line, const SurfacePoint& a, const SurfacePoint& b,
                           std::uint32_t face) {
    if (poll_.cancelled() || !poll_.may_take(kBytesOfSegment)) return fail_stopped(poll_);
    const auto number = static_cast<std::uint32_t>(chains_[line].size());
    chains_[line].emplace_back();
    const std::uint32_t first = first_copy(face);
    const auto weights_of = [&](const SurfacePoint& point) {
      return in_copy(face, first, seen_from_face(whole_, point, face)->bary);
    };
    const Segment segment{line, number, weights_of(a), weights_of(b)};
    faces_[first].push_back(segment);
    for (const Weights& weights : {segment.a, segment.b}) {
      if (auto noted = note_on_edge(first, weights); !noted) return noted;
    }
    return {};
  }

  // The first of the faces that have this one's corners, where a file has a face several times,
  // such as once for each side. Lines split all of them alike, with the same new vertices: so what
  // cuts one cuts all. Of no use if the poll says to stop.
  std::uint32_t first_copy(std::uint32_t face) {
    if (whole_.report().faces_duplicate == 0) return face;
    if (const auto known = first_copies_.find(face); known != first_copies_.end()) {
      return known->second;
    }
    // All copies are at each corner: the one with the fewest faces is looked at.
    const auto& corners = whole_.face(face).vertex;
    const std::uint32_t vertex =
        *std::min_element(corners.begin(), corners.end(), [&](std::uint32_t a, std::uint32_t b) {
          return whole_.corners(a).size() < whole_.corners(b).size();
        });
    std::vector<std::uint32_t> copies;  // ascending, as the corners at a vertex are
    for (const std::uint32_t corner : whole_.corners(vertex)) {
      const std::uint32_t other = face_of(corner);
      const auto& others = whole_.face(other).vertex;
      if (poll_.cancelled()) return face;
      if (!std::is_permutation(corners.begin(), corners.end(), others.begin())) continue;
      if (!poll_.may_take(kBytesOfCopy)) return face;
      copies.push_back(other);
    }
    for (const std::uint32_t copy : copies) first_copies_[copy] = copies.front();
    return copies.front();
  }

  // Weights in a face as those in another one with the same corners.
  [[nodiscard]] Weights in_copy(std::uint32_t face, std::uint32_t other,
                                const Weights& weights) const {
    if (face == other) return weights;
    const auto& from = whole_.face(face).vertex;
    const auto& to = whole_.face(other).vertex;
    Weights same{};
    for (std::size_t c = 0; c < 3; ++c) {
      same[static_cast<std::size_t>(std::find(to.begin(), to.end(), from[c]) - to.begin())] =
          weights[c];
    }
    return same;
  }

  // A part of a face as that of another one with the same corners, wound as that is.
  [[nodiscard]] Part in_copy(std::uint32_t face, std::uint32_t other, const Part& part) const {
    Part same = part;
    for (Weights& weights : same.corners) weights = in_copy(face, other, weights);
    const auto& from = whole_.face(face).vertex;
    const auto& to = whole_.face(other).vertex;
    const auto at = std::find(to.begin(), to.end(), from[0]) - to.begin();
    const bool is_turned_over = to[(static_cast<std::size_t>(at) + 1) % 3] != from[1];
    if (is_turned_over) {
      std::swap(same.vertices[1], same.vertices[2]);
      std::swap(same.corners[1], same.corners[2]);
    }
    return same;
  }

  // All faces on the edge are split at this point, also those that no line enters.
  Result<void> note_on_edge(std::uint32_t face, const Weights& weights) {
    const std::uint32_t side = side_under(weights);
    if (side == 3) return {};
    const EdgePlace edge = on_edge(face, side, weights);
    if (find_on_edge(edge) != kNone) return {};
    const Vec3 low = mesh_.positions()[edge.low];
    const Vec3 high = mesh_.positions()[edge.high];
    const auto made = add_vertex(low + edge.t * (high - low));
    if (!made) return fail(made.error());
    on_edges_.emplace(edge, *made);
    const Halfedge under = halfedge(face, side);
    Halfedge h = under;
    do {
      if (poll_.cancelled()) return fail_stopped(poll_);
      faces_.try_emplace(first_copy(face_of(h)));
      h = whole_.ring(h);
    } while (h != under);
    return {};
  }

  [[nodiscard]] EdgePlace on_edge(std::uint32_t face, std::uint32_t side,
                                  const Weights& weights) const {
    const auto& corners = whole_.face(face).vertex;
    const std::uint32_t next = next_corner(side);
    if (corners[side] < corners[next]) return {corners[side], corners[next], weights[next]};
    return {corners[next], corners[side], weights[side]};
  }

  // The new vertex there, the nearer of two; kNone if there is none.
  [[nodiscard]] std::uint32_t find_on_edge(const EdgePlace& edge) const {
    std::uint32_t found = kNone;
    double nearest = 0;
    auto at = on_edges_.lower_bound({edge.low, edge.high, edge.t - kSnap});
    for (; at != on_edges_.end(); ++at) {
      const auto& [place, vertex] = *at;
      if (place.low != edge.low || place.high != edge.high) break;
      if (place.t > edge.t + kSnap) break;
      const double off = std::abs(place.t - edge.t);
      if (found != kNone && off >= nearest) continue;
      nearest = off;
      found = vertex;
    }
    return found;
  }

  Result<std::uint32_t> add_vertex(Vec3 position) {
    if (new_positions_.size() >= most_vertices_) {
      return fail_limit(ErrorCode::too_large, "lines that cross so many edges split too many faces",
                        most_vertices_, new_positions_.size() + 1);
    }
    if (new_positions_.size() % kAtOnce == 0 && !poll_.may_take(kAtOnce * kBytesOfVertex)) {
      return fail_stopped(poll_);
    }
    new_positions_.push_back(position);
    return static_cast<std::uint32_t>(mesh_.vertex_count() + new_positions_.size() - 1);
  }

  Result<void> split_face(std::uint32_t face, const std::vector<Segment>& segments) {
    FacePieces pieces;
    const auto& corners = whole_.face(face).vertex;
    std::vector<std::uint32_t> global(corners.begin(), corners.end());
    std::map<std::uint32_t, std::uint32_t> local;  // of new vertices on sides
    for (std::uint32_t side = 0; side < 3; ++side) {
      const bool forward = corners[side] < corners[next_corner(side)];
      const std::uint32_t low = std::min(corners[side], corners[next_corner(side)]);
      const std::uint32_t high = std::max(corners[side], corners[next_corner(side)]);
      for (auto at = on_edges_.lower_bound({low, high, 0});
           at != on_edges_.end() && at->first.low == low && at->first.high == high; ++at) {
        if (poll_.cancelled()) return fail_stopped(poll_);
        const double t = at->first.t;
        local[at->second] = pieces.add_on_side(side, forward ? t : 1 - t);
        global.push_back(at->second);
      }
    }
    const auto point = [&](const Weights& weights) {
      const std::uint32_t side = side_under(weights);
      if (side < 3) return local[find_on_edge(on_edge(face, side, weights))];
      for (std::uint32_t c = 0; c < 3; ++c) {
        if (weights[next_corner(c)] == 0 && weights[previous_corner(c)] == 0) return c;
      }
      return pieces.add_inside(weights, poll_);
    };
    std::vector<std::vector<std::uint32_t>> chains(segments.size());
    // Where the last segment ended, the next one goes on.
    std::uint32_t end = kNone;
    for (std::size_t i = 0; i < segments.size(); ++i) {
      const Segment& segment = segments[i];
      const bool goes_on = i > 0 && segments[i - 1].line == segment.line &&
                           segments[i - 1].number + 1 == segment.number;
      const std::uint32_t begin = goes_on ? end : point(segment.a);
      end = point(segment.b);
      chains[i] = pieces.join(begin, end, poll_);
      if (poll_.ask()) return fail_stopped(poll_);
      if (auto grown = take_over_points(face, pieces, global); !grown) return grown;
    }
    for (std::size_t i = 0; i < segments.size(); ++i) {
      auto& chain = chains_[segments[i].line][segments[i].number];
      for (const std::uint32_t p : pieces.with_splits(chains[i])) chain.push_back(global[p]);
    }
    if (pieces.triangles().size() == 1) return {};
    auto& parts = parts_[face];
    for (const auto& triangle : pieces.triangles()) {
      Part part;
      for (std::size_t c = 0; c < 3; ++c) {
        part.vertices[c] = global[triangle[c]];
        part.corners[c] = pieces.points()[triangle[c]];
      }
      parts.push_back(part);
    }
    return {};
  }

  // Gives the points that a face has got inside numbers of the whole.
  Result<void> take_over_points(std::uint32_t face, const FacePieces& pieces,
                                std::vector<std::uint32_t>& global) {
    const Triangle& t = mesh_.faces()[face];
    const Vec3 origin = mesh_.positions()[t[0]];
    while (global.size() < pieces.points().size()) {
      const Weights& weights = pieces.points()[global.size()];
      const auto made = add_vertex(origin + weights[1] * (mesh_.positions()[t[1]] - origin) +
                                   weights[2] * (mesh_.positions()[t[2]] - origin));
      if (!made) return fail(made.error());
      global.push_back(*made);
    }
    return {};
  }

  [[nodiscard]] Vec3 position(std::uint32_t vertex) const {
    return vertex < mesh_.vertex_count() ? mesh_.positions()[vertex]
                                         : new_positions_[vertex - mesh_.vertex_count()];
  }

  // Corners of one face at the same position become one vertex, even under Weld::off. So a new
  // vertex on the long side of a face without width merges with that face's own corner. Then an
  // edge inside one face and an edge of another may have the same two ends. Mesh::build would make
  // one edge of them, and paths would cross it, though the faces only touch. A new vertex in the
  // middle of the inside edge keeps the two apart.
  Result<void> keep_edges_apart() {
    const std::set<std::uint32_t> merged = merged_vertices();
    if (merged.empty()) return {};
    for (auto& [face, parts] : parts_) {
      if (auto split = split_inside_edges(face, parts, merged); !split) return split;
    }
    return {};
  }

  // Those that share their position with another corner of a part. Of no use if the poll says to
  // stop.
  std::set<std::uint32_t> merged_vertices() {
    std::set<std::uint32_t> merged;
    for (const auto& [face, parts] : parts_) {
      for (const Part& part : parts) {
        if (poll_.cancelled()) return merged;
        for (std::uint32_t c = 0; c < 3; ++c) {
          const std::uint32_t a = part.vertices[c];
          const std::uint32_t b = part.vertices[next_corner(c)];
          if (position(a) == position(b)) merged.insert({a, b});
        }
      }
    }
    return merged;
  }

  // Splits the edges between two parts of a face that have an end in `merged`.
  Result<void> split_inside_edges(std::uint32_t face, std::vector<Part>& parts,
                                  const std::set<std::uint32_t>& merged) {
    std::map<VertexPair, std::uint32_t> uses;
    for (const Part& part : parts) {
      if (poll_.cancelled()) return fail_stopped(poll_);
      for (std::uint32_t c = 0; c < 3; ++c) {
        const std::uint32_t a = part.vertices[c];
        const std::uint32_t b = part.vertices[next_corner(c)];
        if (merged.contains(a) || merged.contains(b)) ++uses[std::minmax({a, b})];
      }
    }
    for (const auto& [edge, count] : uses) {
      const bool is_inside = count > 1;
      if (!is_inside) continue;
      const auto middle = add_vertex(0.5 * (position(edge.first) + position(edge.second)));
      if (!middle) return fail(middle.error());
      split_parts(parts, edge, *middle);
      put_into_chains(face, edge, *middle);
      if (poll_.stopped()) return fail_stopped(poll_);
    }
    return {};
  }

  // A line along the edge goes on through its middle.
  void put_into_chains(std::uint32_t face, const VertexPair& edge, std::uint32_t middle) {
    for (const Segment& segment : faces_.at(face)) {
      auto& chain = chains_[segment.line][segment.number];
      for (std::size_t i = 1; i < chain.size(); ++i) {
        if (poll_.cancelled()) return;
        if (VertexPair(std::minmax({chain[i - 1], chain[i]})) != edge) continue;
        chain.insert(chain.begin() + static_cast<std::ptrdiff_t>(i), middle);
        ++i;
      }
    }
  }

  // Of no use if the poll says to stop.
  void split_parts(std::vector<Part>& parts, const VertexPair& edge, std::uint32_t middle) {
    std::vector<Part> split;
    for (const Part& part : parts) {
      if (poll_.cancelled()) return;
      std::uint32_t side = 0;
      const auto is_edge = [&](std::uint32_t c) {
        return VertexPair(std::minmax({part.vertices[c], part.vertices[next_corner(c)]})) == edge;
      };
      while (side < 3 && !is_edge(side)) ++side;
      if (side == 3) {
        split.push_back(part);
        continue;
      }
      const std::uint32_t next = next_corner(side);
      Weights weights{};
      for (std::size_t k = 0; k < 3; ++k) {
        weights[k] = 0.5 * (part.corners[side][k] + part.corners[next][k]);
      }
      for (const std::uint32_t moved : {next, side}) {
        Part half = part;
        half.vertices[moved] = middle;
        half.corners[moved] = weights;
        split.push_back(half);
      }
    }
    parts = std::move(split);
  }

  Result<RefinedMesh> assemble() {
    RefinedSoup soup;
    std::vector<std::uint32_t> number;  // in the soup
    polled_assign(number, mesh_.vertex_count() + new_positions_.size(), kNone, poll_);
    std::uint64_t face_count = mesh_.face_count();
    for (const auto& [face, parts] : parts_) face_count += parts.size() - 1;
    // Copies of a face are split as it is.
    for (const auto& [face, first] : first_copies_) {
      const auto parts = parts_.find(first);
      if (face != first && parts != parts_.end()) face_count += parts->second.size() - 1;
    }
    if (poll_.stopped() || !soup.reserve(number.size(), face_count, poll_)) {
      return fail_stopped(poll_);
    }
    // In the order of the file, so that a mesh that is not split stays the same.
    for (std::uint32_t s = 0; s < mesh_.source_vertex_count() && !poll_.cancelled(); ++s) {
      const std::uint32_t v = mesh_.vertex_of_source()[s];
      if (v == kNone || mesh_.source_of_vertex(v) != s) continue;
      number[v] = soup.add_vertex(mesh_.positions()[v], s);
    }
    for (std::uint32_t i = 0; i < new_positions_.size() && !poll_.cancelled(); ++i) {
      number[mesh_.vertex_count() + i] =
          soup.add_vertex(new_positions_[i], mesh_.source_vertex_count() + i);
    }
    for (std::uint32_t s = 0; s < mesh_.source_face_count() && !poll_.cancelled(); ++s) {
      const std::uint32_t face = mesh_.face_of_source(s);
      if (face == kNone) continue;
      const std::uint32_t first = first_copy(face);
      const auto parts = parts_.find(first);
      if (parts == parts_.end()) {
        const Triangle& t = mesh_.faces()[face];
        soup.add_face({number[t[0]], number[t[1]], number[t[2]]}, s);
        continue;
      }
      for (const Part& of_first : parts->second) {
        const Part part = in_copy(first, face, of_first);
        soup.add_piece(
            {number[part.vertices[0]], number[part.vertices[1]], number[part.vertices[2]]}, s,
            part.corners);
      }
    }
    if (poll_.ask()) return fail_stopped(poll_);
    auto built = soup.build(mesh_, cancel_);
    if (!built) return fail(std::move(built.error()));
    RefinedMesh refined{std::move(built->mesh), std::move(built->refinement), {}};
    for (const auto& segments : chains_) {
      auto& chain = refined.chains.emplace_back();
      for (const auto& segment : segments) {
        for (const std::uint32_t id : segment) {
          if (poll_.cancelled()) return fail_stopped(poll_);
          const std::uint32_t v = built->vertex_of_soup[number[id]];
          if (chain.empty() || chain.back() != v) chain.push_back(v);
        }
      }
    }
    return refined;
  }

  static constexpr std::size_t kAtOnce = 1024;
  static constexpr std::uint64_t kBytesOfCopy = 64;  // in first_copies_, and on the way there
  // In its face's list, which doubles, and its chain with the vertices on it.
  static constexpr std::uint64_t kBytesOfSegment =
      2 * sizeof(Segment) + sizeof(std::vector<std::uint32_t>) + 32;

  const Adjacency& whole_;
  const Mesh& mesh_;
  std::span<const SurfacePolyline> lines_;
  std::uint64_t most_vertices_;
  const Cancel& cancel_;
  Poll poll_;
  std::map<std::uint32_t, std::vector<Segment>> faces_;  // of first copies
  std::map<EdgePlace, std::uint32_t> on_edges_;
  std::vector<Vec3> new_positions_;  // of vertices from the whole's vertex_count() on
  std::map<std::uint32_t, std::vector<Part>> parts_;             // of first copies
  std::map<std::uint32_t, std::uint32_t> first_copies_;          // by face, of those asked about
  std::vector<std::vector<std::vector<std::uint32_t>>> chains_;  // by line and segment
};

}  // namespace

Result<RefinedMesh> refine_along(const Adjacency& whole, std::span<const SurfacePolyline> lines,
                                 std::uint64_t most_vertices, const Cancel& cancel) {
  return Refiner(whole, lines, most_vertices, cancel).run();
}

}  // namespace geodesic
