#include "core/landmarks/landmark_group.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace geodesic {
namespace {

constexpr std::array<double, LandmarkGroup::kCutoffs> kParts{1e-2, 1e-3, 3e-4, 1e-4};
// What floats have lost of a bound.
constexpr float kRounding = 1e-6F;

}  // namespace

void LandmarkGroup::decompose(std::span<const double> squares, Poll& poll) {
  const std::size_t count = landmarks_.size();
  const std::size_t width = points_.size();
  for (std::size_t p = 0; p < width; ++p) {
    if (poll.cancelled_after(count)) return;
    float nearest = distances_[p];
    for (std::size_t l = 1; l < count; ++l) {
      nearest = std::min(nearest, distances_[l * width + p]);
    }
    cover_ = std::max(cover_, nearest / scale_);
  }
  if (!is_to_estimate()) return;
  const auto rows = static_cast<Eigen::Index>(count);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(
      Eigen::Map<const Eigen::MatrixXd>(squares.data(), rows, rows));
  if (poll.ask()) return;
  const Eigen::VectorXd& values = solver.eigenvalues();
  std::vector<Eigen::Index> order(count);
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::stable_sort(order.begin(), order.end(), [&](Eigen::Index a, Eigen::Index b) {
    return std::abs(values[a]) > std::abs(values[b]);
  });
  for (const double part : kParts) {
    std::size_t rank = 0;
    while (rank < count && std::abs(values[order[rank]]) > part * std::abs(values[order[0]])) {
      ++rank;
    }
    ranks_.push_back(rank);
  }
  vectors_.reserve(ranks_.back() * count);
  factors_.reserve(ranks_.back() * width);
  std::vector<double> factor(width);
  for (std::size_t k = 0; k < ranks_.back(); ++k) {
    const auto vector = solver.eigenvectors().col(order[k]);
    std::fill(factor.begin(), factor.end(), 0);
    for (std::size_t l = 0; l < count; ++l) {
      if (poll.cancelled_after(width)) return;
      const double part = vector[static_cast<Eigen::Index>(l)];
      vectors_.push_back(part / values[order[k]]);
      for (std::size_t p = 0; p < width; ++p) {
        const double d = distances_[l * width + p];
        factor[p] += part * d * d;
      }
    }
    factors_.insert(factors_.end(), factor.begin(), factor.end());
  }
}

double LandmarkGroup::middle_of_bounds(std::span<const double> to_landmarks,
                                       std::size_t place) const {
  double low = 0;
  double high = kUnreached;
  for (std::size_t l = 0; l < landmarks_.size(); ++l) {
    const double one = to_landmarks[landmarks_[l]];
    const double other = distances_[l * points_.size() + place] / scale_;
    low = std::max(low, std::abs(one - other));
    high = std::min(high, one + other);
  }
  return low + (high - low) / 2;
}

void LandmarkGroup::estimate(std::span<const double> to_landmarks, std::size_t cutoff, double least,
                             std::span<double> row, Poll& poll) const {
  const std::size_t count = landmarks_.size();
  const std::size_t width = points_.size();
  const std::size_t rank = ranks_[cutoff];
  std::vector<float> own(rank);
  for (std::size_t k = 0; k < rank; ++k) {
    double sum = 0;
    for (std::size_t l = 0; l < count; ++l) {
      const double d = scale_ * to_landmarks[landmarks_[l]];
      sum += vectors_[k * count + l] * d * d;
    }
    own[k] = static_cast<float>(sum);
  }
  // So many points at once that what is known of them stays in the cache.
  constexpr std::size_t kAtOnce = 512;
  std::array<float, kAtOnce> square;
  std::array<float, kAtOnce> low;
  std::array<float, kAtOnce> high;
  for (std::size_t begin = 0; begin < width; begin += kAtOnce) {
    const std::size_t size = std::min(kAtOnce, width - begin);
    if (poll.cancelled_after(size * count)) return;
    square.fill(0);
    for (std::size_t k = 0; k < rank; ++k) {
      const float* const factor = &factors_[k * width + begin];
      for (std::size_t i = 0; i < size; ++i) square[i] += own[k] * factor[i];
    }
    low.fill(0);
    high.fill(std::numeric_limits<float>::max());
    for (std::size_t l = 0; l < count; ++l) {
      const auto d = static_cast<float>(scale_ * to_landmarks[landmarks_[l]]);
      const float* const other = &distances_[l * width + begin];
      for (std::size_t i = 0; i < size; ++i) {
        low[i] = std::max(low[i], std::abs(d - other[i]));
        high[i] = std::min(high[i], d + other[i]);
      }
    }
    for (std::size_t i = 0; i < size; ++i) {
      double& entry = row[points_[begin + i]];
      if (entry != kUnreached) continue;
      // The row's point may be so far from all others that its squares are no floats.
      if (!std::isfinite(square[i]) || !std::isfinite(low[i])) {
        entry = std::max(middle_of_bounds(to_landmarks, begin + i), least);
        continue;
      }
      const float distance = std::sqrt(std::max(square[i], 0.0F));
      const float bounded = std::clamp(distance, std::min(low[i] * (1 - kRounding), high[i]),
                                       high[i] * (1 + kRounding));
      entry = std::max(bounded / scale_, least);
    }
  }
}

}  // namespace geodesic
