#include "core/back_traced/relax_edges.h"

#include <algorithm>
#include <array>
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
  // `reached`: where those are inserted that had no distance; or null.
  EdgeRelaxer(const Adjacency& adjacency, double max, Reaching reaching, VertexSet* reached,
              Field& field)
      : adjacency_(adjacency),
        positions_(adjacency.mesh().positions()),
        max_(max),
        reaching_(reaching),
        reached_(reached),
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
    if (distance_[v] == kUnreached) {
      if (reaching_ == Reaching::nothing_more) return;
      if (reached_ != nullptr) reached_->insert(v);
    }
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
  Reaching reaching_;
  VertexSet* reached_;
  Field& field_;
  std::span<double> distance_;
  std::vector<std::pair<double, std::uint32_t>> lowered_;  // a heap
};

}  // namespace

void relax_edges(const Adjacency& adjacency, double max, Field& field, Poll& poll) {
  EdgeRelaxer relaxer(adjacency, max, Reaching::more, nullptr, field);
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

void relax_edges_among(VertexSet& vertices, Reaching reaching, const Adjacency& adjacency,
                       double max, Field& field, Poll& poll) {
  EdgeRelaxer relaxer(adjacency, max, reaching, &vertices, field);
  const std::span<const Triangle> faces = adjacency.mesh().faces();
  vertices.for_each_ascending([&](std::uint32_t v) {
    if (poll.cancelled()) return;
    // A face's three sides go out from one of its vertices each, if these all have a distance.
    const auto ends = [&](std::uint32_t corner) {
      const Triangle& face = faces[face_of(corner)];
      return std::array{face[next_corner(corner_of(corner))],
                        face[previous_corner(corner_of(corner))]};
    };
    unsigned above = 0;
    for (const std::uint32_t corner : adjacency.corners(v)) {
      const auto [next, previous] = ends(corner);
      above |= relaxer.is_above(v, next);
      if (reaching == Reaching::more) above |= relaxer.is_above(v, previous);
    }
    if (above == 0) return;
    for (const std::uint32_t corner : adjacency.corners(v)) {
      const auto [next, previous] = ends(corner);
      relaxer.relax(v, next);
      if (reaching == Reaching::more) relaxer.relax(v, previous);
    }
  });
  relaxer.go_on(poll);
}

}  // namespace geodesic
