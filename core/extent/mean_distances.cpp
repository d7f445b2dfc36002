#include "core/extent/mean_distances.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "core/base/polled_fill.h"
#include "core/extent/part_by_area.h"
#include "core/field/field.h"
#include "core/solve/solve_field.h"

namespace geodesic {
namespace {

// Which vertices' fields are added up, and with which weight each: a share of the whole.
struct Sources {
  std::vector<std::pair<std::size_t, double>> places;  // ascending, each once
  bool are_all = false;
  std::uint64_t draws = 0;
};

Sources choose_sources(const PartByArea& part, std::uint64_t fields, Poll& poll) {
  Sources sources;
  if (fields >= part.size()) {
    sources.are_all = true;
    for (std::size_t i = 0; i < part.size() && !poll.cancelled(); ++i) {
      // A vertex without area about it counts for nothing.
      if (part.share_of(i) > 0) sources.places.push_back({i, part.share_of(i)});
    }
    return sources;
  }
  // What comes twice is computed once, and counts twice.
  DrawByArea draw(part);
  sources.draws = fields;
  std::vector<std::size_t> drawn;
  for (std::uint64_t i = 0; i < fields && !poll.cancelled(); ++i) drawn.push_back(draw.next());
  std::sort(drawn.begin(), drawn.end());
  for (const std::size_t place : drawn) {
    if (sources.places.empty() || sources.places.back().first != place) {
      sources.places.push_back({place, 0});
    }
    sources.places.back().second += 1 / static_cast<double>(fields);
  }
  return sources;
}

// Mean and variance of numbers that come one by one, by weights that add up to 1: West 1979,
// "Updating mean and variance estimates: an improved method".
struct RunningMean {
  double mean = 0;
  double variance = 0;

  // `part`: of the weight so far, this one included.
  void add(double value, double weight, double part) {
    const double deviation = value - mean;
    mean += deviation * part;
    variance += weight * deviation * deviation * (1 - part);
  }
};

// Of each vertex's distances from the sources so far, and of the sources' own means.
struct Means {
  std::vector<RunningMean> of_vertices;  // by place
  RunningMean overall;
  double weight = 0;

  void add(const Field& field, double share, const PartByArea& part, Poll& poll) {
    weight += share;
    double mean = 0;
    for (std::size_t i = 0; i < part.size(); ++i) {
      if (poll.cancelled()) return;
      // Past what is no surface a vertex of the part may be out of reach, and then stays so.
      const double d = field.distance[part.vertices[i]];
      of_vertices[i].add(d, share, share / weight);
      if (d != kUnreached) mean += part.share_of(i) * d;
    }
    overall.add(mean, share, share / weight);
  }
};

// What is to be added to either side of a mean for a confidence of 95 %. Of one vertex, however
// often it was drawn, nothing is known of how distances scatter.
double margin_of(const RunningMean& running, const Sources& sources) {
  if (sources.are_all) return 0;
  if (sources.places.size() < 2) return std::numeric_limits<double>::infinity();
  return standard_errors_of_interval(sources.draws) *
         std::sqrt(running.variance / static_cast<double>(sources.draws - 1));
}

}  // namespace

Result<MeanDistances> mean_distances(Method method, const MethodOptions& options,
                                     const Adjacency& adjacency, std::uint64_t fields,
                                     SolveScratch& scratch, const Cancel& cancel) {
  Poll poll(cancel);
  // The part with its chances, and three numbers for each field.
  const std::uint64_t count = adjacency.mesh().vertex_count();
  if (!poll.may_take(32 * count + 24 * std::min(fields, count))) return fail_stopped(poll);
  const PartByArea part = largest_part(adjacency, poll);
  if (poll.stopped()) return fail_stopped(poll);
  if (part.size() == 0) return no_vertex_of_file();
  const Sources sources = choose_sources(part, std::max<std::uint64_t>(1, fields), poll);
  Means means;
  polled_assign(means.of_vertices, part.size(), RunningMean(), poll);
  if (poll.stopped()) return fail_stopped(poll);

  const auto all = static_cast<double>(sources.places.size());
  double done = 0;
  FieldLimits limits;
  limits.keep_details = false;
  for (const auto& [place, share] : sources.places) {
    // A field may be too small to ask on its own.
    if (cancel.requested()) return fail_stopped(cancel);
    const Source source{point_at_vertex(adjacency, part.vertices[place]), 0};
    const auto field = solve_field(method, options, adjacency, {&source, 1}, limits, scratch,
                                   cancel.part(done / all, (done + 1) / all));
    if (!field) return fail(field.error());
    means.add(*field, share, part, poll);
    if (poll.stopped()) return fail_stopped(poll);
    ++done;
  }

  MeanDistances found;
  found.is_exact = sources.are_all;
  found.fields = sources.places.size();
  for (const std::uint32_t v : part.vertices) {
    if (poll.cancelled()) return fail_stopped(poll);
    if (is_of_file(adjacency.mesh(), v)) ++found.part_vertices;
  }
  polled_assign(found.mean, count, kUnreached, poll);
  polled_assign(found.margin, count, std::numeric_limits<double>::infinity(), poll);
  for (std::size_t i = 0; i < part.size(); ++i) {
    if (poll.cancelled()) return fail_stopped(poll);
    const std::uint32_t v = part.vertices[i];
    const RunningMean& running = means.of_vertices[i];
    if (!std::isfinite(running.mean)) continue;
    found.mean[v] = running.mean;
    found.margin[v] = margin_of(running, sources);
  }
  if (poll.stopped()) return fail_stopped(poll);
  found.overall = means.overall.mean;
  double margin = margin_of(means.overall, sources);
  // Nor of several sources that are as far in the middle as each other, but for rounding.
  constexpr double kRounding = 1e-9;
  if (!sources.are_all && !(margin > kRounding * found.overall)) {
    margin = std::numeric_limits<double>::infinity();
  }
  found.lower = std::max(0.0, found.overall - margin);
  found.upper = found.overall + margin;
  return found;
}

}  // namespace geodesic
