#include "core/landmarks/landmark_distances.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/field/field.h"

namespace geodesic {
namespace {

// In multiples of the covering radius. With less, the greatest errors grow;
// with more, rows take longer: tests/bench/large_tables.py measures both.
constexpr double kNear = 1.5;

EstimateErrors errors_of(std::vector<double>& errors) {
  EstimateErrors result;
  result.entries = errors.size();
  if (errors.empty()) return result;
  const auto percentile = errors.begin() + static_cast<std::ptrdiff_t>(errors.size() * 99 / 100);
  std::nth_element(errors.begin(), percentile, errors.end());
  result.percentile99 = *percentile;
  result.max = *std::max_element(errors.begin(), errors.end());
  result.mean =
      std::accumulate(errors.begin(), errors.end(), 0.0) / static_cast<double>(errors.size());
  return result;
}

}  // namespace

Result<LandmarkDistances> LandmarkDistances::make(std::vector<std::uint32_t> landmarks,
                                                  std::span<const std::vector<double>> to_points,
                                                  const Cancel& cancel) {
  Poll poll(cancel);
  LandmarkDistances made;
  made.landmarks_ = std::move(landmarks);
  std::vector<bool> is_grouped(made.landmarks_.size());
  for (std::size_t first = 0; first < made.landmarks_.size(); ++first) {
    if (is_grouped[first]) continue;
    std::vector<std::uint32_t> members;
    for (std::uint32_t l = 0; l < made.landmarks_.size(); ++l) {
      const bool are_joined = to_points[first][made.landmarks_[l]] != kUnreached &&
                              to_points[l][made.landmarks_[first]] != kUnreached;
      if (is_grouped[l] || !(are_joined || l == first)) continue;
      is_grouped[l] = true;
      members.push_back(l);
    }
    std::vector<std::uint32_t> points;
    for (std::uint32_t p = 0; p < to_points[first].size(); ++p) {
      if (poll.cancelled_after(members.size())) break;
      const auto is_reached = [&](std::uint32_t l) { return to_points[l][p] != kUnreached; };
      if (std::all_of(members.begin(), members.end(), is_reached)) points.push_back(p);
    }
    made.groups_.emplace_back(
        std::move(members), std::move(points),
        [&](std::uint32_t l, std::uint32_t p) { return to_points[l][p]; },
        [&](std::uint32_t l, std::uint32_t k) { return to_points[l][made.landmarks_[k]]; }, poll);
    if (poll.stopped()) return fail_stopped(poll);
  }
  return made;
}

const LandmarkGroup* LandmarkDistances::group_of(std::span<const double> to_landmarks) const {
  for (const LandmarkGroup& group : groups_) {
    const auto is_reached = [&](std::uint32_t l) { return to_landmarks[l] != kUnreached; };
    if (std::all_of(group.landmarks().begin(), group.landmarks().end(), is_reached)) return &group;
  }
  return nullptr;
}

double LandmarkDistances::near(std::span<const double> to_landmarks) const {
  const LandmarkGroup* const group = group_of(to_landmarks);
  if (group == nullptr || !group->is_to_estimate()) return kUnreached;
  return kNear * group->cover();
}

void LandmarkDistances::estimate(std::span<const double> to_landmarks, std::span<double> row,
                                 Poll& poll) const {
  const LandmarkGroup* const group = group_of(to_landmarks);
  if (group == nullptr || !group->is_to_estimate()) return;
  for (const std::uint32_t l : group->landmarks()) {
    if (row[landmarks_[l]] == kUnreached) row[landmarks_[l]] = to_landmarks[l];
  }
  group->estimate(to_landmarks, cutoff_, kNear * group->cover(), row, poll);
}

Result<EstimateErrors> LandmarkDistances::choose(std::span<const KnownRow> rows,
                                                 const Cancel& cancel) {
  EstimateErrors best;
  std::size_t chosen = 0;
  Poll poll(cancel);
  for (std::size_t cutoff = 0; cutoff < LandmarkGroup::kCutoffs; ++cutoff) {
    cutoff_ = cutoff;
    std::vector<double> errors;
    for (const KnownRow& known : rows) {
      const double within = near(known.to_landmarks);
      std::vector<double> row = known.to_points;
      for (double& d : row) {
        if (!(d <= within)) d = kUnreached;
      }
      estimate(known.to_landmarks, row, poll);
      if (poll.stopped()) return fail_stopped(poll);
      for (std::size_t p = 0; p < row.size(); ++p) {
        const double d = known.to_points[p];
        if (d == kUnreached || d == 0) continue;
        // Where no way is known there is no estimate.
        errors.push_back(row[p] == kUnreached ? 1 : std::abs(row[p] / d - 1));
      }
    }
    const EstimateErrors found = errors_of(errors);
    if (cutoff != 0 && !(found.mean < best.mean)) continue;
    best = found;
    chosen = cutoff;
  }
  cutoff_ = chosen;
  return best;
}

}  // namespace geodesic
