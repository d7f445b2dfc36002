#include "core/wavefront/edge_dijkstra.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "core/field/remaining_targets.h"
#include "core/field/vertex_front.h"

namespace geodesic {
namespace {

// Of the mean edge. Twice or half of it take the same time.
constexpr double kBucketOfMeanEdge = 0.5;

// Vertices wait in buckets and are settled in no order within one: a vertex that is lowered after
// it was settled is settled again. On most meshes one in a thousand is. Where short edges are many
// times shorter than a bucket is wide, a heap takes over, of which each vertex comes once.
class EdgeDijkstra {
 public:
  EdgeDijkstra(const Adjacency& adjacency, const FieldLimits& limits, Field& field,
               WavefrontScratch& scratch, Poll& poll)
      : adjacency_(adjacency),
        positions_(adjacency.mesh().positions()),
        faces_(adjacency.mesh().faces()),
        is_oriented_(adjacency.triangulation().is_oriented),
        detour_(field.sources.size() == 1 ? limits.detour : Detour{}),
        max_(limits.max),
        field_(field),
        distance_(field.distance.doubles()),
        parents_(field.parents),
        buckets_(scratch.buckets),
        heap_(scratch.heap),
        poll_(poll),
        targets_(limits.targets, distance_.size(), scratch.is_target) {
    buckets_.reset(kBucketOfMeanEdge * adjacency.report().mean_edge);
  }

  // Errors: cancelled.
  Result<void> run(std::vector<std::uint32_t>& round) {
    for (std::uint32_t s = 0; s < field_.sources.size(); ++s) {
      // Each may be in all faces.
      if (s > 0 && poll_.ask()) return fail_stopped(poll_);
      start(field_.sources[s], s);
    }
    while (!buckets_.empty() && !targets_.done()) {
      do {
        round.clear();
        buckets_.take(round);
        for (std::size_t i = 0; i < round.size(); ++i) {
          const std::uint32_t v = round[i];
          if (i + kAhead < round.size()) expect(round[i + kAhead]);
          // It was settled from an earlier bucket, after it had come to this one.
          if (!buckets_.is_now(distance_[v])) continue;
          if (is_stopped()) return fail_stopped(poll_);
          if (++settled_ > 2 * reached_ + kSettledAtLeast) {
            return run_by_heap(std::span(round).subspan(i));
          }
          settle(v, [this](std::uint32_t w, double d, double before) {
            buckets_.push_or_again(w, d, before);
          });
        }
      } while (buckets_.has_more_now());
    }
    return {};
  }

  // The greatest distance of a target: what is farther may not be final.
  [[nodiscard]] double farthest_final(std::span<const std::uint32_t> targets) const {
    double farthest = 0;
    for (const std::uint32_t v : targets) farthest = std::max(farthest, distance_[v]);
    return farthest;
  }

 private:
  static constexpr std::uint64_t kSettledAtLeast = 1000;
  static constexpr std::size_t kAtOnce = 16;  // corners of a vertex

  static constexpr std::size_t kAhead = 4;  // vertices whose faces are fetched before their turn

  // Inlined by force: GCC takes out calls of functions that do nothing but fetch.
  __attribute__((always_inline)) void expect(std::uint32_t v) const {
    const std::span<const std::uint32_t> corners = adjacency_.corners(v);
    for (const std::uint32_t corner : corners.first(left(corners, 0))) {
      __builtin_prefetch(&faces_[face_of(corner)]);
    }
  }

  bool is_stopped() { return poll_.cancelled(settled_, distance_.size()); }

  void start(const Source& source, std::uint32_t number) {
    const auto begin_at = [&](std::uint32_t v, double d) {
      const double before = distance_[v];
      if (!(d < before) || d > max_) return;
      if (before == kUnreached) ++reached_;
      distance_[v] = d;
      parents_[v] = {kNone, number};
      buckets_.push(v, d, before);
    };
    if (source.point.at_vertex()) begin_at(source.point.vertex, source.offset);
    for (const SurfacePoint& place : in_all_faces(adjacency_, source.point)) {
      for (std::uint32_t c = 0; c < 3; ++c) {
        begin_at(adjacency_.face(place.face).vertex[c],
                 source.offset + distance_to_corner(adjacency_.mesh(), place, c));
      }
    }
  }

  // Those that wait go on by a heap: the rest of a round, and what is in the buckets.
  Result<void> run_by_heap(std::span<const std::uint32_t> round) {
    heap_.reset(distance_.size());
    const auto push = [this](std::uint32_t v, double d, double) {
      if (!heap_.accepted(v)) heap_.push_or_lower(v, d);
    };
    const auto push_all = [&](std::span<const std::uint32_t> vertices) {
      for (const std::uint32_t v : vertices) push(v, distance_[v], 0);
    };
    push_all(round);
    std::vector<std::uint32_t> waiting;
    while (!buckets_.empty()) {
      waiting.clear();
      buckets_.take(waiting);
      push_all(waiting);
    }
    while (!heap_.empty() && !targets_.done()) {
      if (is_stopped()) return fail_stopped(poll_);
      ++settled_;
      settle(heap_.pop().vertex, push);
    }
    return {};
  }

  // Gives the neighbours of a vertex their distances by way of it. `push(w, d, before)` is told of
  // each that is lowered.
  template <class Push>
  void settle(std::uint32_t v, const Push& push) {
    targets_.accept(v);
    const double here = distance_[v];
    if (detour_.is_bounded() &&
        detour_.is_too_far(here - field_.sources[0].offset, positions_[v])) {
      return;
    }
    const std::span<const std::uint32_t> corners = adjacency_.corners(v);
    // Where all faces turn one way and close round the vertex, each neighbour is the next corner
    // of one face and the previous one of another.
    std::uint32_t unpaired = 0;
    for (std::size_t i = 0; i < corners.size(); i += kAtOnce) {
      unpaired ^= lower<&next_corner>(v, here, corners.subspan(i, left(corners, i)), push);
    }
    if (unpaired == 0 && is_oriented_ && !adjacency_.is_pinched(v)) return;
    for (std::size_t i = 0; i < corners.size(); i += kAtOnce) {
      (void)lower<&previous_corner>(v, here, corners.subspan(i, left(corners, i)), push);
    }
  }
  static std::size_t left(std::span<const std::uint32_t> corners, std::size_t i) {
    return std::min(kAtOnce, corners.size() - i);
  }

  // One neighbour in each of these faces. Returns the faces' neighbours of both sides, xored.
  template <std::uint32_t (*kSide)(std::uint32_t), class Push>
  std::uint32_t lower(std::uint32_t v, double here, std::span<const std::uint32_t> corners,
                      const Push& push) {
    std::array<std::uint32_t, kAtOnce> neighbour;
    std::array<double, kAtOnce> x, y, z, d;
    const Vec3* const positions = positions_.data();
    const Triangle* const faces = faces_.data();
    double* const distance = distance_.data();
    const Vec3 from = positions[v];
    std::uint32_t both = 0;
    std::size_t count = 0;
    for (const std::uint32_t corner : corners) {
      const Triangle& face = faces[face_of(corner)];
      const std::uint32_t w = face[kSide(corner_of(corner))];
      both ^= face[next_corner(corner_of(corner))] ^ face[previous_corner(corner_of(corner))];
      const Vec3 to = positions[w] - from;
      neighbour[count] = w;
      x[count] = to.x;
      y[count] = to.y;
      z[count] = to.z;
      ++count;
    }
    if (count % 2 != 0) x[count] = y[count] = z[count] = 0;
    for (std::size_t i = 0; i < count; i += 2) {
      for (std::size_t j = i; j < i + 2; ++j) {  // two at once
        d[j] = here + std::sqrt(x[j] * x[j] + y[j] * y[j] + z[j] * z[j]);
      }
    }
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t w = neighbour[i];
      const double before = distance[w];
      if (!(d[i] <= before) || d[i] > max_) continue;
      if (d[i] == before) {
        // Of two ways of one length, that over the lesser number: so parents do not depend on the
        // order in which they came. Not where this would lead in a circle.
        Parents& parents = parents_[w];
        if (here < before && parents.first != kNone && v < parents.first) parents = {v, v};
        continue;
      }
      if (before == kUnreached) {
        ++reached_;
        // Long before its turn: to find its faces, their list is waited for.
        __builtin_prefetch(adjacency_.corners(w).data());
      }
      distance[w] = d[i];
      parents_[w] = {v, v};
      push(w, d[i], before);
    }
    return both;
  }

  const Adjacency& adjacency_;
  const std::span<const Vec3> positions_;
  const std::span<const Triangle> faces_;
  const bool is_oriented_;
  const Detour detour_;
  const double max_;
  Field& field_;
  const std::span<double> distance_;
  const std::span<Parents> parents_;
  VertexBuckets& buckets_;
  VertexHeap& heap_;
  Poll& poll_;
  RemainingTargets targets_;
  std::uint64_t reached_ = 0;
  std::uint64_t settled_ = 0;
};

// Of each vertex, the source that its parents lead to.
void name_sources(Field& field) {
  std::vector<std::uint32_t> way;
  for (std::uint32_t v = 0; v < field.distance.size(); ++v) {
    if (field.distance[v] == kUnreached) continue;
    way.clear();
    std::uint32_t u = v;
    while (field.nearest_source[u] == kNone && !field.parents[u].from_source()) {
      way.push_back(u);
      u = field.parents[u].first;
    }
    std::uint32_t& source = field.nearest_source[u];
    if (source == kNone) source = field.parents[u].second;
    for (const std::uint32_t w : way) field.nearest_source[w] = source;
  }
}

}  // namespace

Result<Field> edge_dijkstra_field(const Adjacency& adjacency, std::span<const Source> sources,
                                  const FieldLimits& limits, WavefrontScratch& scratch,
                                  const Cancel& cancel) {
  const std::size_t vertex_count = adjacency.mesh().vertex_count();
  Field field = unreached_field(Method::dijkstra, sources, vertex_count);
  field.parents.assign(vertex_count, {});
  Poll poll(cancel);
  EdgeDijkstra front(adjacency, limits, field, scratch, poll);
  if (auto done = front.run(scratch.round); !done) return fail(std::move(done.error()));
  if (!limits.targets.empty()) field.forget_beyond(front.farthest_final(limits.targets));
  if (sources.size() > 1) name_sources(field);
  field.count_reached();
  return field;
}

}  // namespace geodesic
