#include "core/solve/extent.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <limits>
#include <random>
#include <utility>

#include "core/field/field.h"
#include "core/solve/solve_field.h"

namespace geodesic {
namespace {

// Bounds that are as near as this are equal: what rounding leaves of sums.
constexpr double kRounding = 1e-9;
// So many deviations of the mean of a sample to either side are 95 %: Student's t for one draw
// fewer. From eleven degrees of freedom on by Fisher's expansion about the normal distribution
// (Abramowitz and Stegun 1964, 26.7.5), off by less than 2e-4 there.
double deviations_of(std::uint64_t draws) {
  constexpr std::array<double, 10> kFew{12.706, 4.303, 3.182, 2.776, 2.571,
                                        2.447,  2.365, 2.306, 2.262, 2.228};
  constexpr double z = 1.959963984540054;
  const std::uint64_t freedom = draws - 1;
  if (freedom <= kFew.size()) return kFew[freedom - 1];
  const auto n = static_cast<double>(freedom);
  return z + (z * z * z + z) / (4 * n) +
         (5 * std::pow(z, 5) + 16 * z * z * z + 3 * z) / (96 * n * n) +
         (3 * std::pow(z, 7) + 19 * std::pow(z, 5) + 17 * z * z * z - 15 * z) / (384 * n * n * n);
}

// The vertices of the part that has most; of the first of several. Empty if the poll says to stop.
std::vector<std::uint32_t> largest_part(const Adjacency& adjacency, Poll& poll) {
  const std::uint32_t count = adjacency.mesh().vertex_count();
  std::vector<bool> is_known(count);
  std::vector<std::uint32_t> largest;
  for (std::uint32_t start = 0; start < count; ++start) {
    if (poll.cancelled()) return {};
    if (is_known[start] || adjacency.corners(start).empty()) continue;
    std::vector<std::uint32_t> part{start};
    is_known[start] = true;
    for (std::size_t i = 0; i < part.size(); ++i) {
      for (const std::uint32_t corner : adjacency.corners(part[i])) {
        if (poll.cancelled()) return {};
        for (const std::uint32_t v : adjacency.face(face_of(corner)).vertex) {
          if (is_known[v]) continue;
          is_known[v] = true;
          part.push_back(v);
        }
      }
    }
    if (part.size() > largest.size()) largest = std::move(part);
  }
  std::sort(largest.begin(), largest.end());
  return largest;
}

// What is known of all vertices of the part, by their places in it, from the fields so far.
class Survey {
 public:
  Survey(const Adjacency& adjacency, std::vector<std::uint32_t> part)
      : part_(std::move(part)),
        is_done_(part_.size()),
        least_(part_.size(), 0),
        most_(part_.size(), std::numeric_limits<double>::infinity()),
        least_mean_(part_.size(), 0),
        sum_(part_.size(), 0),
        weight_(part_.size(), 0) {
    for (std::size_t i = 0; i < part_.size(); ++i) {
      for (const std::uint32_t corner : adjacency.corners(part_[i])) {
        weight_[i] += std::max(0.0, adjacency.face(face_of(corner)).area2);
      }
      all_weight_ += weight_[i];
    }
    if (all_weight_ > 0) return;
    weight_.assign(part_.size(), 1);
    all_weight_ = static_cast<double>(part_.size());
  }

  // A field of the vertex at a place. Whether it came to the end.
  bool add(std::size_t place, const Field& field, Poll& poll) {
    farthest_ = place;
    double mean = 0;
    double greatest = 0;
    for (std::size_t i = 0; i < part_.size(); ++i) {
      if (poll.cancelled()) return false;
      const double d = field.distance[part_[i]];
      if (d == kUnreached) continue;  // past what is no surface
      mean += weight_[i] / all_weight_ * d;
      if (d > greatest) {
        greatest = d;
        farthest_ = i;
      }
    }
    for (std::size_t i = 0; i < part_.size(); ++i) {
      if (poll.cancelled()) return false;
      const double d = field.distance[part_[i]];
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
    means_.push_back({place, mean});
    if (greatest > greatest_) {
      greatest_ = greatest;
      ends_ = {part_[place], part_[farthest_]};
    }
    if (greatest < center_value_) {
      center_value_ = greatest;
      center_ = part_[place];
    }
    if (mean < median_value_) {
      median_value_ = mean;
      median_ = part_[place];
    }
    return true;
  }

  [[nodiscard]] std::size_t size() const { return part_.size(); }
  [[nodiscard]] std::uint32_t vertex(std::size_t place) const { return part_[place]; }
  [[nodiscard]] const std::vector<double>& weights() const { return weight_; }
  [[nodiscard]] double all_weight() const { return all_weight_; }
  [[nodiscard]] bool is_done(std::size_t place) const { return is_done_[place]; }
  [[nodiscard]] std::size_t count_done() const { return means_.size(); }
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
    if (extent.upper - extent.lower <= kRounding * extent.upper || count_done() == size()) {
      extent.lower = extent.upper = extent.value;
    }
    return extent;
  }

  // The mean from all vertices.
  [[nodiscard]] double whole_mean() const {
    double mean = 0;
    for (const auto& [place, of] : means_) mean += weight_[place] / all_weight_ * of;
    return mean;
  }
  [[nodiscard]] double last_mean() const { return means_.back().second; }

 private:
  std::vector<std::uint32_t> part_;
  std::vector<bool> is_done_;
  std::vector<double> least_;       // that the greatest distance from the vertex can be
  std::vector<double> most_;        // and at most
  std::vector<double> least_mean_;  // that the mean distance from the vertex can be
  std::vector<double> sum_;         // of its distances from all that have a field
  std::vector<double> weight_;      // the area of its faces
  double all_weight_ = 0;
  std::vector<std::pair<std::size_t, double>> means_;
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

// Places drawn by their weights, each as often as it comes: the same each time, so that an answer
// is, but others on another surface.
class Draw {
 public:
  explicit Draw(const Survey& survey)
      : random_(std::bit_cast<std::uint64_t>(survey.all_weight())),
        chances_(survey.weights().begin(), survey.weights().end()) {}
  std::size_t next() { return chances_(random_); }

 private:
  std::mt19937_64 random_;
  std::discrete_distribution<std::size_t> chances_;
};

Result<Extent> bounded(ExtentOf what, Survey& survey, Surveyor& surveyor, bool metric) {
  // Where the mean is small is told by vertices that are spread by chance. One in two is: which
  // they are does not depend on how many fields there may be, so that more are never worse.
  Draw draw(survey);
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

Result<Extent> mean_of(Survey& survey, Surveyor& surveyor, std::uint64_t fields) {
  Extent found;
  found.part_vertices = survey.size();
  if (fields >= survey.size()) {
    for (std::size_t i = 0; i < survey.size(); ++i) {
      if (auto computed = surveyor.compute(i); !computed) return fail(computed.error());
    }
    found.value = found.lower = found.upper = survey.whole_mean();
    found.is_exact = true;
    found.fields = survey.count_done();
    return found;
  }
  Draw draw(survey);
  std::vector<double> means(survey.size(), -1);  // of those that were drawn
  double sum = 0;
  double squares = 0;
  std::uint64_t drawn = 0;
  // As many draws as fields: what comes twice is not computed again.
  for (; drawn < fields; ++drawn) {
    const std::size_t place = draw.next();
    if (!survey.is_done(place)) {
      if (auto computed = surveyor.compute(place); !computed) return fail(computed.error());
      means[place] = survey.last_mean();
    }
    sum += means[place];
    squares += means[place] * means[place];
  }
  const auto count = static_cast<double>(drawn);
  found.value = sum / count;
  found.fields = survey.count_done();
  const double variance = std::max(0.0, squares / count - found.value * found.value);
  // Of one vertex, however often it was drawn, nothing is known of how they scatter; nor of several
  // that are as far in the middle as each other, but for rounding.
  if (found.fields < 2 || !(variance > kRounding * kRounding * found.value * found.value)) {
    found.upper = std::numeric_limits<double>::infinity();
    return found;
  }
  const double margin = deviations_of(drawn) * std::sqrt(variance / (count - 1));
  found.lower = std::max(0.0, found.value - margin);
  found.upper = found.value + margin;
  return found;
}

}  // namespace

Result<Extent> extent(ExtentOf what, Method method, const MethodOptions& options,
                      const Adjacency& adjacency, std::uint64_t fields, SolveScratch& scratch,
                      const Cancel& cancel) {
  Poll poll(cancel);
  // Ten numbers for each vertex.
  if (!poll.may_take(std::uint64_t{80} * adjacency.mesh().vertex_count())) {
    return fail_stopped(poll);
  }
  std::vector<std::uint32_t> part = largest_part(adjacency, poll);
  if (poll.stopped()) return fail_stopped(poll);
  Survey survey(adjacency, std::move(part));
  fields = std::max<std::uint64_t>(1, fields);
  Surveyor surveyor(method, options, adjacency, fields, scratch, cancel, survey);
  if (what == ExtentOf::mean) return mean_of(survey, surveyor, fields);
  return bounded(what, survey, surveyor, traits_of(method).are_metric);
}

}  // namespace geodesic
