#include "core/back_traced/relax_edges.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "core/base/team.h"
#include "core/base/tolerances.h"

namespace geodesic {
namespace {

class EdgeRelaxer {
 public:
  EdgeRelaxer(const Adjacency& adjacency, double max, bool reaches_more, Field& field)
      : adjacency_(adjacency),
        positions_(adjacency.mesh().positions()),
        max_(max),
        reaches_more_(reaches_more),
        field_(field),
        distance_(field.distance.doubles()) {}

  // By positions: all the faces' records would be twice as much to read.
  [[nodiscard]] unsigned is_above(std::uint32_t u, std::uint32_t v) const {
    const Vec3 edge = positions_[v] - positions_[u];
    const double difference = distance_[v] - distance_[u];  // no number between unreached ones
    return difference * difference > (1 + tolerance::kSameWay) * dot(edge, edge) ? 1 : 0;
  }

  void relax(std::uint32_t u, std::uint32_t v) {
    if (is_above(u, v) == 0) return;
    if (distance_[u] > distance_[v]) std::swap(u, v);
    const double along = distance_[u] + geodesic::distance(positions_[u], positions_[v]);
    if (!(along < distance_[v]) || along > max_) return;
    if (distance_[v] == kUnreached && !reaches_more_) return;
    distance_[v] = along;
    if (!field_.nearest_source.empty()) field_.nearest_source[v] = field_.nearest_source[u];
    lowered_.push_back({along, v});
    std::push_heap(lowered_.begin(), lowered_.end(), std::greater());
  }

  // What is above those that were lowered, the nearest first, as Dijkstra does: in any
  // other order a vertex could be lowered again and again.
  void go_on(Poll& poll) {
    while (!lowered_.empty() && !poll.cancelled()) {
      std::pop_heap(lowered_.begin(), lowered_.end(), std::greater());
      const auto [distance, v] = lowered_.back();
      lowered_.pop_back();
      if (distance > distance_[v]) continue;  // lowered once more since
      for (const std::uint32_t corner : adjacency_.corners(v)) {
        const FaceRecord& face = adjacency_.face(face_of(corner));
        const std::uint32_t c = corner_of(corner);
        relax(v, face.vertex[next_corner(c)]);
        relax(v, face.vertex[previous_corner(c)]);
      }
    }
  }

 private:
  const Adjacency& adjacency_;
  std::span<const Vec3> positions_;
  double max_;
  bool reaches_more_;
  Field& field_;
  std::span<double> distance_;
  std::vector<std::pair<double, std::uint32_t>> lowered_;  // a heap
};

}  // namespace

void relax_edges(const Adjacency& adjacency, double max, Field& field, Poll& poll) {
  EdgeRelaxer relaxer(adjacency, max, true, field);
  // First which faces are to be looked at, which changes nothing: there are few.
  const std::span<const Triangle> faces = adjacency.mesh().faces();
  std::vector<std::vector<std::uint32_t>> above(count_ranges(faces.size(), poll));
  run_in_ranges(faces.size(), poll,
                [&](std::size_t range, std::size_t begin, std::size_t end, Poll& asked) {
                  for (std::size_t f = begin; f < end && !asked.cancelled(); ++f) {
                    const auto& [a, b, c] = faces[f];
                    // Without a branch each.
                    const unsigned sides =
                        relaxer.is_above(a, b) | relaxer.is_above(b, c) | relaxer.is_above(c, a);
                    if (sides != 0) above[range].push_back(static_cast<std::uint32_t>(f));
                  }
                });
  for (const std::vector<std::uint32_t>& listed : above) {
    for (const std::uint32_t f : listed) {
      if (poll.cancelled()) return;
      const auto& [a, b, c] = faces[f];
      relaxer.relax(a, b);
      relaxer.relax(b, c);
      relaxer.relax(c, a);
    }
  }
  relaxer.go_on(poll);
}

void relax_edges_among(std::span<const std::uint32_t> vertices, const Adjacency& adjacency,
                       double max, Field& field, Poll& poll) {
  EdgeRelaxer relaxer(adjacency, max, false, field);
  const std::span<const Triangle> faces = adjacency.mesh().faces();
  // In the order of their numbers, for what is near in number is near in memory.
  constexpr std::uint32_t kWord = 64;
  std::vector<std::uint64_t> among(adjacency.mesh().vertex_count() / kWord + 1);
  for (const std::uint32_t v : vertices) among[v / kWord] |= std::uint64_t{1} << (v % kWord);
  for (std::uint32_t word = 0; word < among.size(); ++word) {
    for (std::uint64_t left = among[word]; left != 0; left &= left - 1) {
      if (poll.cancelled()) return;
      const std::uint32_t v = kWord * word + static_cast<std::uint32_t>(std::countr_zero(left));
      // A face's three sides go out from one of its vertices each.
      unsigned above = 0;
      for (const std::uint32_t corner : adjacency.corners(v)) {
        above |= relaxer.is_above(v, faces[face_of(corner)][next_corner(corner_of(corner))]);
      }
      if (above == 0) continue;
      for (const std::uint32_t corner : adjacency.corners(v)) {
        relaxer.relax(v, faces[face_of(corner)][next_corner(corner_of(corner))]);
      }
    }
  }
  relaxer.go_on(poll);
}

}  // namespace geodesic
