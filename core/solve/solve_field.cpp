#include "core/solve/solve_field.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>

#include "core/back_traced/slivers.h"
#include "core/base/team.h"
#include "core/base/tolerances.h"
#include "core/field/straight_floor.h"
#include "core/solve/near_sources.h"
#include "core/solve/scratch_parts.h"
#include "core/steiner/steiner.h"
#include "core/wavefront/edge_dijkstra.h"
#include "core/wavefront/novotni.h"

namespace geodesic {
namespace {

bool is_even(const Adjacency& adjacency) {
  return adjacency.triangulation().is_even && adjacency.delaunay().is_even;
}

Result<Field> traced_field(const Adjacency& adjacency, std::span<const Source> sources,
                           const FieldLimits& limits, Bound bound, SolveScratch::Parts& scratch,
                           const Cancel& cancel) {
  const auto near = field_near_sources(adjacency, sources, bound, scratch.exact, cancel);
  if (!near) return fail(near.error());
  return back_traced_field(adjacency, sources, limits, bound, *near ? &**near : nullptr,
                           scratch.back_traced, cancel);
}

// What rounding may take of a distance by windows is nothing beyond this: for a bound, beside what
// rounding to a float takes; otherwise, no more than that.
double farthest_to_trace(double extent, Bound bound) {
  constexpr double kBesideFloat = 5e-10;  // of the distance
  return extent * tolerance::kWindows /
         (bound == Bound::upper ? kBesideFloat : tolerance::kSinglePrecision);
}

// Whether vertices that are no sources are as near. Windows may say 0 of one.
bool has_others_within(double farthest, const Field& field) {
  for (std::uint32_t v = 0; v < field.distance.size(); ++v) {
    if (!(field.distance[v] < farthest)) continue;
    if (std::none_of(field.sources.begin(), field.sources.end(),
                     [v](const Source& source) { return source.point.vertex == v; })) {
      return true;
    }
  }
  return false;
}

// Distances by windows, for a bound made longer by what rounding may have taken. Near the sources
// that may be much of them: there, where ways that were traced are shorter, which keep an account,
// those. Both with the same limits.
Result<Field> lesser_of_both(Field by_windows, Bound bound, const Adjacency& adjacency,
                             std::span<const Source> sources, const FieldLimits& limits,
                             SolveScratch::Parts& scratch, const Cancel& cancel) {
  const auto& box = adjacency.mesh().box();
  const double extent = norm(box.max - box.min);
  const double farthest = farthest_to_trace(extent, bound);
  const std::span<double> distance = by_windows.distance.doubles();
  std::optional<Field> traced;
  if (has_others_within(farthest, by_windows)) {
    FieldLimits near = limits;
    near.max = std::min(limits.max, farthest);
    auto field = back_traced_field(adjacency, sources, near, Bound::upper, nullptr,
                                   scratch.back_traced, cancel);
    if (!field) return field;
    traced = std::move(*field);
  }
  for (std::size_t v = 0; v < distance.size(); ++v) {
    if (distance[v] == kUnreached) continue;
    const double rounding = tolerance::kWindows * (extent + distance[v]);
    const double shortest = distance[v];
    if (!traced && shortest < farthest) continue;  // a source
    if (bound == Bound::upper || shortest < farthest) distance[v] += rounding;
    // Below what windows allow, the account was wrong; also where it is below what they say by
    // less.
    if (!traced ||
        !(traced->distance[v] <= distance[v] && traced->distance[v] >= shortest - rounding)) {
      continue;
    }
    distance[v] = std::max(traced->distance[v], shortest);
    if (sources.size() > 1) by_windows.nearest_source[v] = traced->nearest_source[v];
  }
  return by_windows;
}

// Most parts take one question for four vertices, the worst of some hundred two for each. More than
// the most of all take some seconds.
constexpr std::uint64_t kQuestionsOfAny = 1000;
constexpr std::uint64_t kQuestionsOfVertex = 4;
constexpr std::uint64_t kMostQuestions = 60'000;
constexpr std::size_t kMostBytes = std::size_t{256} << 20U;
// With windows kept for points inside faces and for paths: they take up to twenty times as much.
constexpr std::size_t kMostBytesKept = std::size_t{128} << 20U;

// Distances by windows, as long as they are not too many: counted in questions, and always of the
// whole field, so that the answer depends on nothing else.
class BoundedWindows {
 public:
  BoundedWindows(const Adjacency& adjacency, std::span<const Source> sources, ExactScratch& scratch,
                 const Cancel& cancel)
      : adjacency_(adjacency), sources_(sources), scratch_(scratch), cancel_(cancel) {}

  // Those that are given up with windows kept may do without. What is kept took half the questions
  // at the most, so that the same field is not given up without.
  Result<Field> field(bool keep_details) {
    const std::uint64_t most = std::min(
        kQuestionsOfAny + kQuestionsOfVertex * adjacency_.mesh().vertex_count(), kMostQuestions);
    if (keep_details) {
      auto kept = run(true, most / 2, kMostBytesKept);
      if (!is_given_up()) return kept;
    }
    return run(false, most, kMostBytes);
  }
  [[nodiscard]] bool is_given_up() const { return is_too_much_ && !cancel_.requested(); }

 private:
  Result<Field> run(bool keep_details, std::uint64_t most, std::size_t most_bytes) {
    is_too_much_ = false;
    std::uint64_t questions = 0;
    const auto ask = [&] {
      is_too_much_ = is_too_much_ || ++questions > most || scratch_.window_bytes() > most_bytes;
      return is_too_much_ || cancel_.requested();
    };
    const Cancel bounded(
        ask, [&](double done) { cancel_.report(done); }, cancel_.memory());
    return field_with_kept_windows(adjacency_, sources_, keep_details, scratch_, bounded, cancel_);
  }

  const Adjacency& adjacency_;
  std::span<const Source> sources_;
  ExactScratch& scratch_;
  const Cancel& cancel_;
  bool is_too_much_ = false;
};

// Leaves what a field of these limits has of one that went everywhere, and what may come to lie
// within them once it is rounded.
void restrict_to(const FieldLimits& limits, Field& field) {
  double farthest = limits.max * (1 + tolerance::kSinglePrecision);
  if (!limits.targets.empty()) {
    double last = 0;
    for (const std::uint32_t v : limits.targets) last = std::max(last, field.distance[v]);
    // Ways to points inside faces by windows lead over other vertices than the corners of theirs.
    farthest = std::min(farthest, field.kept_windows ? last + limits.beyond_targets : last);
  }
  if (farthest < kUnreached) field.forget_beyond(farthest);
}

// Where no trace comes to a vertex near the way. Paths along such are from 1 to 20 % too long, or
// many times, and what is traced without a bound is off by as much. The sides of slivers have few
// windows, so these are computed. Rounded as other distances by `auto` are.
Result<Field> field_across_slivers(Bound bound, const Adjacency& adjacency,
                                   std::span<const Source> sources, const FieldLimits& asked,
                                   SolveScratch::Parts& scratch, const Cancel& cancel) {
  // Of sides of any scale windows may become too many: then traces alone have to do.
  FieldLimits limits;
  limits.keep_details = false;
  const auto ready = make_ready_for_windows(adjacency, sources, scratch.exact, cancel);
  if (!ready) return fail(ready.error());
  BoundedWindows windows(adjacency, sources, scratch.exact, cancel);
  auto field = windows.field(asked.keep_details);
  const auto by_traces = [&] {
    return traced_field(adjacency, sources, asked, bound, scratch, cancel);
  };
  if (!field && windows.is_given_up()) return by_traces();
  if (field && !is_even(adjacency)) {
    field = lesser_of_both(std::move(*field), bound, adjacency, sources, limits, scratch, cancel);
  }
  if (!field) return field;
  Poll poll(cancel);
  const bool is_any_below = raise_to_straight_lines(adjacency.mesh(), *field, poll);
  if (poll.stopped()) return fail_stopped(cancel);
  if (is_any_below && bound == Bound::upper) return by_traces();
  restrict_to(asked, *field);
  field->distance.round_to_floats(bound);
  if (asked.max < kUnreached) field->forget_beyond(asked.max);
  field->count_reached();
  return field;
}

}  // namespace

bool goes_by_windows(Method method, const MethodOptions& options, const Adjacency& adjacency,
                     std::span<const Source> sources) {
  if (traits_of(method).has_windows) return true;
  if (method != Method::back_traced) return false;
  if (options.error_at_most) return true;
  // Few faces as long as the surface, as the flat sides of machine parts: no vertex is near ways
  // across them. On larger meshes windows would take a second, and such faces are mostly a floor.
  constexpr std::uint32_t kMostVerticesOfPart = 20'000;
  if (adjacency.has_large_faces() && adjacency.mesh().vertex_count() <= kMostVerticesOfPart &&
      !adjacency.triangulation().is_crowded) {
    return true;
  }
  constexpr std::size_t kOneIn = 20;
  if (leads_across_slivers(adjacency, sources, kOneIn)) return true;
  // Where sides differ by many powers of ten, few edges can be flipped, and slivers on which
  // straight ways from the source lead along are crossed by those to other vertices.
  return options.bound == Bound::upper && !is_even(adjacency) &&
         is_of_slivers(adjacency.delaunay());
}

bool can_be_helped(Method method, const MethodOptions& options, const Adjacency& adjacency,
                   std::span<const Source> sources) {
  const std::size_t vertices = adjacency.mesh().vertex_count();
  const bool is_exact = method == Method::exact;
  if (is_exact || (method == Method::back_traced && options.error_at_most)) {
    return kTimesAsLongByWindows * vertices >= Team::kFewestVertices;
  }
  // What `auto` computes by windows it may give up, by a count that has to be the same always.
  return method == Method::back_traced && sources.size() == 1 &&
         vertices >= Team::kFewestVertices && !goes_by_windows(method, options, adjacency, sources);
}

namespace {

Result<Field> solve(Method method, const MethodOptions& options, const Adjacency& adjacency,
                    std::span<const Source> sources, const FieldLimits& limits,
                    SolveScratch::Parts& scratch, const Cancel& cancel) {
  switch (method) {
    case Method::wavefront:
      return wavefront_field(adjacency, sources, limits, scratch.wavefront, cancel);
    case Method::novotni:
      return novotni_field(adjacency, sources, limits, scratch.wavefront, cancel);
    case Method::dijkstra:
      return edge_dijkstra_field(adjacency, sources, limits, scratch.wavefront, cancel);
    case Method::exact:
      return exact_field(adjacency, sources, limits, scratch.exact, cancel);
    case Method::chen_han:
      return chen_han_field(adjacency, sources, limits, scratch.chen_han, cancel);
    case Method::fast_marching:
      return fast_marching_field(adjacency, sources, limits, scratch.fast_marching, cancel);
    case Method::steiner:
      return steiner_field(adjacency, sources, options.points_per_edge, limits, scratch.wavefront,
                           cancel);
    case Method::back_traced:
      if (options.error_at_most) {
        return not_below_straight_lines(
            adjacency.mesh(),
            field_within(*options.error_at_most, adjacency, sources, limits, scratch.exact, cancel),
            limits, cancel);
      }
      if (goes_by_windows(method, options, adjacency, sources)) {
        return field_across_slivers(options.bound, adjacency, sources, limits, scratch, cancel);
      }
      return traced_field(adjacency, sources, limits, options.bound, scratch, cancel);
  }
  return fail(ErrorCode::internal, "a method without an implementation");
}

}  // namespace

Result<Field> solve_field(Method method, const MethodOptions& options, const Adjacency& adjacency,
                          std::span<const Source> sources, const FieldLimits& limits,
                          SolveScratch& scratch, const Cancel& cancel) {
  auto field = solve(method, options, adjacency, sources, limits, scratch.parts(), cancel);
  const bool is_bound = options.bound == Bound::upper || options.error_at_most;
  if (field && method == Method::back_traced && is_bound) field->bound = Bound::upper;
  return field;
}

}  // namespace geodesic
