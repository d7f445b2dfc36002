#include "core/refine/cut_along.h"

#include <algorithm>
#include <cstddef>
#include <map>
#include <numeric>
#include <tuple>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "core/base/edge_key.h"
#include "core/base/polled_fill.h"
#include "core/refine/refined_numbers.h"
#include "core/surface/line_gaps.h"

namespace geodesic {
namespace {

// Of an edge of a wall among the edges, and of its end with the faces there.
constexpr std::uint64_t kBytesOfWallEdge = 256;

// Which are joined.
class Groups {
 public:
  explicit Groups(std::size_t count) : first_(count) {
    std::iota(first_.begin(), first_.end(), 0U);
  }
  std::uint32_t find(std::uint32_t i) {
    while (first_[i] != i) i = first_[i] = first_[first_[i]];
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = find(a);
    b = find(b);
    first_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> first_;
};

class Cutter {
 public:
  Cutter(const RefinedMesh& refined, std::span<const std::uint32_t> walls,
         std::span<const std::uint8_t> is_left, const Cancel& cancel)
      : mesh_(refined.mesh),
        refinement_(refined.refinement),
        is_left_(is_left),
        cancel_(cancel),
        poll_(cancel) {
    for (const std::uint32_t wall : walls) {
      const auto& chain = refined.chains[wall];
      if (!poll_.may_take(kBytesOfWallEdge * chain.size())) return;
      for (std::size_t i = 1; i < chain.size() && !poll_.cancelled(); ++i) {
        edges_.insert(edge_key(chain[i - 1], chain[i]));
        for (const std::uint32_t v : {chain[i - 1], chain[i]}) faces_at_.try_emplace(v);
      }
    }
  }

  Result<CutMesh> run() {
    list_faces();
    for (const auto& [vertex, faces] : faces_at_) {
      if (poll_.stopped()) break;
      part_vertex(vertex, faces);
    }
    if (poll_.ask()) return fail_stopped(poll_);
    if (order_.empty()) return fail(ErrorCode::no_triangles, "no face is left");
    return assemble();
  }

 private:
  // In the order of the file: whole faces, and the parts of one in their own order.
  void list_faces() {
    std::uint64_t count = 0;
    for (std::uint32_t f = 0; f < mesh_.face_count() && !poll_.cancelled(); ++f) {
      if (is_left_[f] != 0) ++count;
    }
    std::vector<std::vector<std::uint32_t>> parts;  // by place in `place`
    std::unordered_map<std::uint32_t, std::size_t> place;
    for (const FacePiece& piece : refinement_.pieces()) {
      if (poll_.cancelled()) return;
      const auto [at, is_new] = place.try_emplace(piece.parent, parts.size());
      if (is_new) parts.emplace_back();
      parts[at->second].push_back(piece.face);
    }
    if (!poll_.may_take(count * sizeof(std::uint32_t))) return;
    order_.reserve(count);
    const auto take = [&](std::uint32_t face) {
      if (is_left_[face] == 0) return;
      for (const std::uint32_t v : mesh_.faces()[face]) {
        const auto at = faces_at_.find(v);
        if (at != faces_at_.end()) at->second.push_back(face);
      }
      order_.push_back(face);
    };
    for (std::uint32_t s = 0; s < mesh_.source_face_count() && !poll_.cancelled(); ++s) {
      const std::uint32_t first = mesh_.face_of_source(s);
      if (first == kNone) continue;
      const auto split = place.find(s);
      if (split == place.end()) {
        take(first);
      } else {
        for (const std::uint32_t face : parts[split->second]) take(face);
      }
    }
  }

  // Finds which copy of a vertex each of its faces has.
  void part_vertex(std::uint32_t vertex, const std::vector<std::uint32_t>& faces) {
    const auto count = static_cast<std::uint32_t>(faces.size());
    // By the other end of an edge at the vertex, the place of the first face there.
    std::map<std::uint32_t, std::uint32_t> first_over;
    Groups uncut(count);  // as the mesh joins them
    Groups cut(count);
    for (std::uint32_t i = 0; i < count && !poll_.cancelled(); ++i) {
      for (const std::uint32_t other : mesh_.faces()[faces[i]]) {
        if (other == vertex) continue;
        const auto [at, is_new] = first_over.try_emplace(other, i);
        if (is_new) continue;
        uncut.join(at->second, i);
        if (!edges_.contains(edge_key(vertex, other))) cut.join(at->second, i);
      }
    }
    // A group's first face has its name. Those that a cut divides:
    std::map<std::uint32_t, std::uint32_t> parts;
    for (std::uint32_t i = 0; i < count; ++i) {
      if (cut.find(i) == i) ++parts[uncut.find(i)];
    }
    std::map<std::uint32_t, std::uint32_t> copy_of;
    std::uint32_t copies = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
      if (cut.find(i) != i) continue;
      const bool is_divided = parts[uncut.find(i)] > 1;
      copy_of[i] = is_divided ? copies++ : 0;
    }
    if (copies < 2) return;
    for (std::uint32_t i = 0; i < count && !poll_.cancelled(); ++i) {
      const std::uint32_t copy = copy_of[cut.find(i)];
      if (copy > 0) copies_[{vertex, faces[i]}] = copy;
    }
  }

  Result<CutMesh> assemble() {
    RefinedSoup soup;
    std::vector<std::uint32_t> number;  // by vertex, of its first copy
    polled_assign(number, mesh_.vertex_count(), kNone, poll_);
    if (poll_.stopped() ||
        !soup.reserve(mesh_.vertex_count() + copies_.size(), order_.size(), poll_)) {
      return fail_stopped(poll_);
    }
    constexpr std::uint32_t kUsed = 0;
    for (const std::uint32_t face : order_) {
      if (poll_.cancelled()) return fail_stopped(poll_);
      for (const std::uint32_t v : mesh_.faces()[face]) number[v] = kUsed;
    }
    const auto add = [&](std::uint32_t v) {
      number[v] = soup.add_vertex(mesh_.positions()[v], mesh_.source_of_vertex(v));
    };
    for (std::uint32_t s = 0; s < mesh_.source_vertex_count() && !poll_.cancelled(); ++s) {
      const std::uint32_t v = mesh_.vertex_of_source()[s];
      if (v != kNone && number[v] == kUsed && mesh_.source_of_vertex(v) == s) add(v);
    }
    std::vector<std::pair<std::uint32_t, std::uint32_t>> made;  // source and vertex
    for (std::uint32_t v = 0; v < mesh_.vertex_count() && !poll_.cancelled(); ++v) {
      const std::uint32_t s = mesh_.source_of_vertex(v);
      if (number[v] == kUsed && s >= mesh_.source_vertex_count()) made.emplace_back(s, v);
    }
    std::sort(made.begin(), made.end());
    for (const auto& [source, v] : made) add(v);
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> copy_number;
    const auto corner = [&](std::uint32_t face, std::uint32_t v) {
      const auto copy = copies_.find({v, face});
      if (copy == copies_.end()) return number[v];
      const auto [at, is_new] = copy_number.try_emplace({v, copy->second}, 0);
      if (is_new) {
        at->second = soup.add_vertex(mesh_.positions()[v], mesh_.source_of_vertex(v));
      }
      return at->second;
    };
    for (const std::uint32_t face : order_) {
      if (poll_.cancelled()) return fail_stopped(poll_);
      const Triangle& t = mesh_.faces()[face];
      const Triangle corners{corner(face, t[0]), corner(face, t[1]), corner(face, t[2])};
      if (const FacePiece* piece = refinement_.piece(face)) {
        soup.add_piece(corners, piece->parent, piece->corners);
      } else {
        soup.add_face(corners, mesh_.source_of_face(face));
      }
    }
    auto built = soup.build(mesh_, cancel_);
    if (!built) return fail(std::move(built.error()));
    return CutMesh{std::move(built->mesh), std::move(built->refinement)};
  }

  const Mesh& mesh_;
  const Refinement& refinement_;
  std::span<const std::uint8_t> is_left_;
  const Cancel& cancel_;
  Poll poll_;
  std::unordered_set<std::uint64_t> edges_;                       // of the walls
  std::map<std::uint32_t, std::vector<std::uint32_t>> faces_at_;  // that are left, by wall vertex
  std::vector<std::uint32_t> order_;                              // of the faces that are left
  // By vertex and face, the copy of the vertex that the face has, if it is not the first.
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> copies_;
};

}  // namespace

SurfacePolyline as_wall(const Adjacency& adjacency, const SurfacePolyline& given, Poll& poll) {
  SurfacePolyline wall;
  const SurfacePolyline line = close_gaps(adjacency, given, Gaps::at_vertices, poll);
  if (line.empty() || !poll.may_take(2 * line.size() * sizeof(SurfacePoint))) return wall;
  wall.reserve(2 * line.size() - 1);
  for (std::size_t i = 0; i < line.size() && !poll.cancelled(); ++i) {
    if (i > 0) {
      const std::uint32_t face = face_in_common(adjacency, line[i - 1], line[i], poll);
      if (face != kNone) {
        const Weights a = seen_from_face(adjacency, line[i - 1], face)->bary;
        const Weights b = seen_from_face(adjacency, line[i], face)->bary;
        wall.push_back(point_on_face(adjacency, face, {a[0] + b[0], a[1] + b[1], a[2] + b[2]}));
      }
    }
    wall.push_back(line[i]);
  }
  return wall;
}

Result<CutMesh> cut_along(const RefinedMesh& refined, std::span<const std::uint32_t> walls,
                          std::span<const std::uint8_t> is_left, const Cancel& cancel) {
  return Cutter(refined, walls, is_left, cancel).run();
}

}  // namespace geodesic
