#include "core/refine/faces_inside.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <unordered_set>

#include "core/base/edge_key.h"
#include "core/base/polled_fill.h"

namespace geodesic {
namespace {

struct PartBeside {
  double area = 0;
  std::uint32_t least = kNone;  // source face
};

// Whether that part is outside rather than this one.
bool is_larger(const PartBeside& part, const PartBeside& than) {
  // What rounding leaves of sums of equal areas.
  constexpr double kRounding = 1e-9;
  if (std::abs(part.area - than.area) > kRounding * than.area) return part.area > than.area;
  return part.least > than.least;
}

}  // namespace

Result<std::vector<std::uint8_t>> faces_inside(const Adjacency& adjacency,
                                               std::span<const std::uint32_t> chain,
                                               const Cancel& cancel) {
  Poll poll(cancel);
  const Mesh& mesh = adjacency.mesh();
  std::unordered_set<std::uint64_t> edges;
  for (std::size_t i = 1; i < chain.size(); ++i) edges.insert(edge_key(chain[i - 1], chain[i]));
  std::vector<std::uint32_t> part_of;  // by face
  polled_assign(part_of, mesh.face_count(), kNone, poll);
  std::vector<PartBeside> parts;
  std::vector<std::uint32_t> queue;
  if (poll.stopped() || !poll.may_take(mesh.face_count() * sizeof(std::uint32_t))) {
    return fail_stopped(poll);
  }
  const auto fill_from = [&](std::uint32_t start) {
    if (part_of[start] != kNone) return;
    const auto number = static_cast<std::uint32_t>(parts.size());
    PartBeside& part = parts.emplace_back();
    queue.assign(1, start);
    part_of[start] = number;
    for (std::size_t i = 0; i < queue.size() && !poll.cancelled(); ++i) {
      const std::uint32_t face = queue[i];
      const Triangle& t = mesh.faces()[face];
      const Vec3 a = mesh.positions()[t[0]];
      part.area += 0.5 * norm(cross(mesh.positions()[t[1]] - a, mesh.positions()[t[2]] - a));
      part.least = std::min(part.least, mesh.source_of_face(face));
      for (std::uint32_t c = 0; c < 3; ++c) {
        const Halfedge side = halfedge(face, c);
        if (edges.contains(edge_key(adjacency.tail(side), adjacency.head(side)))) continue;
        for (Halfedge h = adjacency.ring(side); h != side; h = adjacency.ring(h)) {
          if (poll.cancelled()) return;
          if (part_of[face_of(h)] != kNone) continue;
          part_of[face_of(h)] = number;
          queue.push_back(face_of(h));
        }
      }
    }
  };
  for (std::size_t i = 1; i < chain.size() && !poll.cancelled(); ++i) {
    const Halfedge first = adjacency.find_edge(chain[i - 1], chain[i]);
    if (first == kNone) continue;
    Halfedge h = first;
    do {
      fill_from(face_of(h));
      h = adjacency.ring(h);
    } while (h != first && !poll.cancelled());
  }
  if (poll.ask()) return fail_stopped(poll);
  if (parts.size() < 2) {
    return fail(ErrorCode::value_out_of_range,
                "this line has no inside: it does not separate the surface");
  }
  std::uint32_t outside = 0;
  for (std::uint32_t i = 1; i < parts.size(); ++i) {
    if (is_larger(parts[i], parts[outside])) outside = i;
  }
  std::vector<std::uint8_t> is_inside;
  polled_assign(is_inside, mesh.face_count(), std::uint8_t{0}, poll);
  for (std::uint32_t f = 0; f < is_inside.size() && !poll.cancelled(); ++f) {
    is_inside[f] = part_of[f] != kNone && part_of[f] != outside ? 1 : 0;
  }
  if (poll.ask()) return fail_stopped(poll);
  return is_inside;
}

}  // namespace geodesic
