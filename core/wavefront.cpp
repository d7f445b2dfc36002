#include "core/wavefront.h"

#include <algorithm>

#include "core/wavefront_kernel.h"

namespace geodesic {
namespace {

constexpr std::uint32_t kPopsBetweenPolls = 4096;

// Counts down the targets that are still to be accepted.
class RemainingTargets {
 public:
  RemainingTargets(std::span<const std::uint32_t> targets, std::size_t vertex_count,
                   std::vector<std::uint8_t>& marks)
      : marks_(marks), all_(targets.empty()) {
    if (all_) return;
    marks_.assign(vertex_count, 0);
    for (const std::uint32_t v : targets) {
      if (marks_[v] == 0) ++left_;
      marks_[v] = 1;
    }
  }
  void accept(std::uint32_t v) {
    if (!all_ && marks_[v] != 0) --left_;
  }
  [[nodiscard]] bool done() const { return !all_ && left_ == 0; }

 private:
  std::vector<std::uint8_t>& marks_;
  bool all_;  // no targets: every vertex is wanted
  std::size_t left_ = 0;
};

// Polls now and then across all the waves of a query.
class Poll {
 public:
  explicit Poll(const Cancel& cancel) : cancel_(cancel) {}
  bool cancelled() {
    if (--until_poll_ != 0) return false;
    until_poll_ = kPopsBetweenPolls;
    return cancel_.requested();
  }

 private:
  const Cancel& cancel_;
  std::uint32_t until_poll_ = kPopsBetweenPolls;
};

// Runs one source's wave into `distance` and `parents`, which it finds unreached.
// It goes no further from vertices that are clearly nearer to an earlier source
// (`earlier`, empty for none). Tells every vertex it accepted; others stay unreached.
template <class Accepted>
Result<void> run_wave(const Adjacency& adjacency, const Source& source, std::uint32_t number,
                      std::span<const double> earlier, double max, RemainingTargets& targets,
                      VertexHeap& heap, std::span<double> distance, std::span<Parents> parents,
                      Poll& poll, Accepted accepted) {
  const auto forget = [&](std::uint32_t v) {
    distance[v] = kUnreached;
    parents[v] = {};
  };
  // A vertex just inside this source's region needs its neighbours outside: go on
  // for a few edges into the other's.
  const double overlap = 3 * adjacency.report().mean_edge;
  const auto worthwhile = [&](std::uint32_t v) {
    return earlier.empty() || distance[v] < earlier[v] + overlap;
  };

  detail::Wavefront<VertexHeap> front(adjacency, heap, distance, parents);
  const std::vector<std::uint32_t> first_ring = front.start(source, number);
  for (const std::uint32_t v : first_ring) {
    targets.accept(v);
    if (worthwhile(v)) front.spread_from(v);
  }
  bool cancelled = false;
  while (!heap.empty() && !targets.done() && !cancelled) {
    cancelled = poll.cancelled();
    const VertexHeap::Entry next = heap.pop();
    if (next.key > max) {
      forget(next.vertex);
      break;
    }
    targets.accept(next.vertex);
    accepted(next.vertex);
    if (worthwhile(next.vertex)) front.spread_from(next.vertex);
  }
  // What is still considered is not final.
  for (const VertexHeap::Entry& entry : heap.entries()) forget(entry.vertex);
  heap.clear();
  for (const std::uint32_t v : first_ring) {
    if (distance[v] > max) forget(v);
    accepted(v);
  }
  if (cancelled) return fail(ErrorCode::cancelled, "the computation was cancelled");
  return {};
}

// One wave after another, each merged into the field where it is nearer.
Result<void> run_waves(const Adjacency& adjacency, const WavefrontLimits& limits, Field& field,
                       WavefrontScratch& scratch, Poll& poll) {
  const std::size_t vertex_count = field.distance.size();
  field.nearest_source.assign(vertex_count, kNone);
  scratch.distance.assign(vertex_count, kUnreached);
  scratch.parents.assign(vertex_count, {});
  double max = limits.max;
  std::vector<std::uint32_t> visited;
  for (std::uint32_t s = 0; s < field.sources.size(); ++s) {
    visited.clear();
    RemainingTargets targets(limits.targets, vertex_count, scratch.is_target);
    auto wave = run_wave(adjacency, field.sources[s], s, field.distance, max, targets, scratch.heap,
                         scratch.distance, scratch.parents, poll,
                         [&](std::uint32_t v) { visited.push_back(v); });
    if (!wave) return wave;
    for (const std::uint32_t v : visited) {
      if (scratch.distance[v] < field.distance[v]) {
        field.distance[v] = scratch.distance[v];
        field.parents[v] = scratch.parents[v];
        field.nearest_source[v] = s;
      }
      scratch.distance[v] = kUnreached;
      scratch.parents[v] = {};
      scratch.heap.make_far(v);
    }
    if (!limits.targets.empty()) {
      double farthest = 0;
      for (const std::uint32_t v : limits.targets) farthest = std::max(farthest, field.distance[v]);
      max = std::min(limits.max, farthest);
    }
  }
  // An early wave may have been where a later one, stopped by the targets, was not.
  for (std::uint32_t v = 0; v < vertex_count; ++v) {
    if (field.distance[v] <= max) continue;
    field.distance[v] = kUnreached;
    field.parents[v] = {};
    field.nearest_source[v] = kNone;
  }
  return {};
}

}  // namespace

Result<Field> wavefront_field(const Adjacency& adjacency, std::span<const Source> sources,
                              const WavefrontLimits& limits, WavefrontScratch& scratch,
                              const Cancel& cancel) {
  const std::size_t vertex_count = adjacency.mesh().vertex_count();
  Field field;
  field.sources.assign(sources.begin(), sources.end());
  field.distance.assign(vertex_count, kUnreached);
  field.parents.assign(vertex_count, {});
  scratch.heap.reset(vertex_count);
  Poll poll(cancel);
  if (sources.size() == 1) {
    RemainingTargets targets(limits.targets, vertex_count, scratch.is_target);
    auto wave = run_wave(adjacency, sources[0], 0, {}, limits.max, targets, scratch.heap,
                         field.distance, field.parents, poll, [](std::uint32_t) {});
    if (!wave) return fail(wave.error());
  } else if (auto waves = run_waves(adjacency, limits, field, scratch, poll); !waves) {
    return fail(waves.error());
  }

  for (std::uint32_t v = 0; v < vertex_count; ++v) {
    if (field.distance[v] == kUnreached) continue;
    ++field.reached;
    if (field.farthest == kNone || field.distance[v] > field.max) {
      field.max = field.distance[v];
      field.farthest = v;
    }
  }
  return field;
}

}  // namespace geodesic
