// Distances between many points, estimated by those from a few of them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/landmarks/landmark_group.h"

namespace geodesic {

// A point whose distances are known, from all landmarks and to all points. kUnreached where there
// is no way.
struct KnownRow {
  std::vector<double> to_landmarks;
  std::vector<double> to_points;
};

// How far estimates are off, relative to the known distances.
struct EstimateErrors {
  double mean = 0;
  double percentile99 = 0;
  double max = 0;
  std::uint64_t entries = 0;  // that were compared
};

class LandmarkDistances {
 public:
  // `landmarks` are numbers of points, each once, and `to_points` the distances of all points from
  // each, kUnreached where there is no way. Errors: cancelled.
  [[nodiscard]] static Result<LandmarkDistances> make(
      std::vector<std::uint32_t> landmarks, std::span<const std::vector<double>> to_points,
      const Cancel& cancel);

  [[nodiscard]] std::span<const std::uint32_t> landmarks() const { return landmarks_; }

  // Entries up to this distance must be computed: estimates of near points are poor. kUnreached:
  // the whole row must, for there are too few landmarks.
  [[nodiscard]] double near(std::span<const double> to_landmarks) const;

  // Sets those of a row's entries that are kUnreached and in its component. The row must have every
  // distance up to `near`. Of no use if the poll says to stop.
  void estimate(std::span<const double> to_landmarks, std::span<double> row, Poll& poll) const;

  // Chooses how many eigenvalues count, those with which these rows are the least off on average,
  // and says by how much they then are. What is near counts as known. Errors: cancelled.
  [[nodiscard]] Result<EstimateErrors> choose(std::span<const KnownRow> rows, const Cancel& cancel);

 private:
  [[nodiscard]] const LandmarkGroup* group_of(std::span<const double> to_landmarks) const;

  std::vector<std::uint32_t> landmarks_;
  std::vector<LandmarkGroup> groups_;
  std::size_t cutoff_ = 0;
};

}  // namespace geodesic
