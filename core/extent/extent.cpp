#include "core/extent/extent.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "core/extent/mean_distances.h"
#include "core/extent/part_by_area.h"
#include "core/field/field.h"
#include "core/solve/solve_field.h"

namespace geodesic {

bool are_met(double lower, double upper) {
  constexpr double kEqualBounds = 1e-9;  // what rounding leaves of sums
  return std::isfinite(upper) && upper - lower <= kEqualBounds * upper;
}

namespace {

// What is known of all vertices of the part, by their places in it, from the fields so far.
class Survey {
 public:
  explicit Survey(const PartByArea& part)
      : part_(part),
        is_done_(part.size()),
        least_(part.size(), 0),
        most_(part.size(), std::numeric_limits<double>::infinity()),
        least_mean_(part.size(), 0),
        sum_(part.size(), 0) {}

  // A field of the vertex at a place. Whether it came to the end.
  bool add(std::size_t place, const Field& field, Poll& poll) {
    farthest_ = place;
    double mean = 0;
    double greatest = 0;
    for (std::size_t i = 0; i < part_.size(); ++i) {
      if (poll.cancelled()) return false;
      const double d = field.distance[part_.vertices[i]];
      if (d == kUnreached) continue;  // past what is no surface
      mean += part_.share_of(i) * d;
      if (d > greatest) {
        greatest = d;
        farthest_ = i;
      }
    }
    for (std::size_t i = 0; i < part_.size(); ++i) {
      if (poll.cancelled()) return false;
      const double d = field.distance[part_.vertices[i]];
      if (d == kUnreached) continue;
      sum_[i] += d;
      if (is_done_[i]) continue;
      least_[i] = std::max({least_[i], d, greatest - d});
      most_[i] = std::min(most_[i], greatest + d);
      least_mean_[i] = std::max(least_mean_[i], mean - d);
    }
    least_[place] = most_[place] = greatest;
    least_mean_[place] = mean;
    is_done_[place] = true;
    ++done_;
    if (greatest > greatest_) {
      greatest_ = greatest;
      ends_ = {part_.vertices[place], part_.vertices[farthest_]};
    }
    if (greatest < center_value_) {
      center_value_ = greatest;
      center_ = part_.vertices[place];
    }
    if (mean < median_value_) {
      median_value_ = mean;
      median_ = part_.vertices[place];
    }
    return true;
  }

  [[nodiscard]] std::size_t size() const { return part_.size(); }
  [[nodiscard]] std::uint32_t vertex(std::size_t place) const { return part_.vertices[place]; }
  [[nodiscard]] const PartByArea& part() const { return part_; }
  [[nodiscard]] bool is_done(std::size_t place) const { return is_done_[place]; }
  [[nodiscard]] std::size_t count_done() const { return done_; }
  // Of the last field.
  [[nodiscard]] std::size_t farthest() const { return farthest_; }

  // Of those without a field the one with the least of a number, or the greatest.
  [[nodiscard]] std::size_t most_promising(const std::vector<double>& of, bool is_least) const {
    std::size_t best = size();
    for (std::size_t i = 0; i < size(); ++i) {
      if (is_done_[i]) continue;
      if (best == size() || (is_least ? of[i] < of[best] : of[i] > of[best])) best = i;
    }
    return best;
  }
  [[nodiscard]] std::size_t highest() const { return most_promising(most_, false); }
  [[nodiscard]] std::size_t lowest() const { return most_promising(least_, true); }
  // By the mean over the fields so far.
  [[nodiscard]] std::size_t lowest_sum() const { return most_promising(sum_, true); }

  // What is known of the measure; its bounds close in from field to field.
  [[nodiscard]] Extent found(ExtentOf what) const {
    Extent extent;
    extent.fields = count_done();
    extent.part_vertices = size();
    const auto least = [](const std::vector<double>& of) {
      return *std::min_element(of.begin(), of.end());
    };
    switch (what) {
      case ExtentOf::diameter:
        extent.vertices = ends_;
        extent.value = extent.lower = greatest_;
        extent.upper = std::max(greatest_, *std::max_element(most_.begin(), most_.end()));
        break;
      case ExtentOf::center:
        extent.vertices = {center_};
        extent.value = extent.upper = center_value_;
        extent.lower = std::min(center_value_, least(least_));
        break;
      case ExtentOf::median:
        extent.vertices = {median_};
        extent.value = extent.upper = median_value_;
        extent.lower = std::min(median_value_, least(least_mean_));
        break;
      case ExtentOf::mean:
        break;
    }
    if (are_met(extent.lower, extent.upper) || count_done() == size()) {
      extent.lower = extent.upper = extent.value;
    }
    return extent;
  }

 private:
  const PartByArea& part_;
  std::vector<bool> is_done_;
  std::vector<double> least_;       // that the greatest distance from the vertex can be
  std::vector<double> most_;        // and at most
  std::vector<double> least_mean_;  // that the mean distance from the vertex can be
  std::vector<double> sum_;         // of its distances from all that have a field
  std::size_t done_ = 0;
  std::size_t farthest_ = 0;
  double greatest_ = -1;
  std::vector<std::uint32_t> ends_;
  double center_value_ = std::numeric_limits<double>::infinity();
  std::uint32_t center_ = kNone;
  double median_value_ = std::numeric_limits<double>::infinity();
  std::uint32_t median_ = kNone;
};

// Computes the fields.
class Surveyor {
 public:
  Surveyor(Method method, const MethodOptions& options, const Adjacency& adjacency,
           std::uint64_t fields, SolveScratch& scratch, const Cancel& cancel, Survey& survey)
      : method_(method),
        options_(options),
        adjacency_(adjacency),
        fields_(std::min<std::uint64_t>(fields, survey.size())),
        scratch_(scratch),
        cancel_(cancel),
        survey_(survey) {}

  [[nodiscard]] bool has_left() const { return survey_.count_done() < fields_; }

  Result<void> compute(std::size_t place) {
    // A field may be too small to ask on its own.
    if (cancel_.requested()) return fail_stopped(cancel_);
    const auto all = static_cast<double>(fields_);
    const auto done = static_cast<double>(survey_.count_done());
    FieldLimits limits;
    limits.keep_details = false;
    const Source source{point_at_vertex(adjacency_, survey_.vertex(place)), 0};
    const auto field = solve_field(method_, options_, adjacency_, {&source, 1}, limits, scratch_,
                                   cancel_.part(done / all, (done + 1) / all));
    if (!field) return fail(field.error());
    Poll poll(cancel_);
    if (!survey_.add(place, *field, poll)) return fail_stopped(poll);
    return {};
  }

 private:
  Method method_;
  const MethodOptions& options_;
  const Adjacency& adjacency_;
  std::uint64_t fields_;
  SolveScratch& scratch_;
  const Cancel& cancel_;
  Survey& survey_;
};

// The vertex to compute next, by turns one that may lie in the middle and one that may be far off.
std::size_t next_place(ExtentOf what, const Survey& survey) {
  const std::size_t done = survey.count_done();
  if (done == 0) return 0;
  if (what == ExtentOf::median) return survey.lowest_sum();
  const bool is_to_be_far = done <= 2 || done % 2 == 0;
  if (!is_to_be_far) return survey.lowest();
  const bool is_new = !survey.is_done(survey.farthest());
  return is_new && (done <= 2 || what == ExtentOf::center) ? survey.farthest() : survey.highest();
}

Result<Extent> bounded(ExtentOf what, Survey& survey, Surveyor& surveyor, bool metric) {
  // Where the mean is small is told by vertices that are spread by chance. One in two is: which
  // they are does not depend on how many fields there may be, so that more are never worse.
  DrawByArea draw(survey.part());
  Extent found;
  while (surveyor.has_left()) {
    const bool is_drawn = what == ExtentOf::median && survey.count_done() % 2 == 0;
    std::size_t place = is_drawn ? draw.next() : next_place(what, survey);
    if (survey.is_done(place)) place = next_place(what, survey);
    if (auto computed = surveyor.compute(place); !computed) return fail(computed.error());
    found = survey.found(what);
    found.is_exact = (metric && found.lower == found.upper) || survey.count_done() == survey.size();
    if (found.is_exact) break;
  }
  return found;
}

// What is told is a vertex of the file. Means are over the area about these.
void keep_those_of_file(PartByArea& part, const Mesh& mesh) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < part.size(); ++i) {
    if (!is_of_file(mesh, part.vertices[i])) continue;
    part.vertices[kept] = part.vertices[i];
    part.weights[kept++] = part.weights[i];
  }
  part.vertices.resize(kept);
  part.weights.resize(kept);
  part.sum_weights();
}

Extent mean_of(const MeanDistances& means) {
  Extent found;
  found.value = means.overall;
  found.lower = means.lower;
  found.upper = means.upper;
  found.is_exact = means.is_exact;
  found.fields = means.fields;
  found.part_vertices = means.part_vertices;
  return found;
}

}  // namespace

Result<Extent> extent(ExtentOf what, Method method, const MethodOptions& options,
                      const Adjacency& adjacency, std::uint64_t fields, SolveScratch& scratch,
                      const Cancel& cancel) {
  if (what == ExtentOf::mean) {
    const auto means = mean_distances(method, options, adjacency, fields, scratch, cancel);
    if (!means) return fail(means.error());
    return mean_of(*means);
  }
  Poll poll(cancel);
  // Ten numbers for each vertex.
  if (!poll.may_take(std::uint64_t{80} * adjacency.mesh().vertex_count())) {
    return fail_stopped(poll);
  }
  PartByArea part = largest_part(adjacency, poll);
  if (poll.stopped()) return fail_stopped(poll);
  if (part.size() == 0) return no_vertex_of_file();
  keep_those_of_file(part, adjacency.mesh());
  Survey survey(part);
  fields = std::max<std::uint64_t>(1, fields);
  Surveyor surveyor(method, options, adjacency, fields, scratch, cancel, survey);
  return bounded(what, survey, surveyor, traits_of(method).are_metric);
}

}  // namespace geodesic
