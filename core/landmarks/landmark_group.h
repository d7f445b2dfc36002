// The landmarks of one component of the surface, and what they say of the points there.
//
// With b the squared distances of a point from the landmarks, and W those between these, the
// squared distance of two points is about b_i^T W^+ b_j: the Nystrom method (Williams, Seeger 2001,
// "Using the Nystrom method to speed up kernel machines", section 2). Squared distances over a
// surface have few eigenvalues that matter, and of those near zero the inverse would make noise:
// Shamai, Zibulevsky, Kimmel 2020, "Efficient inter-geodesic distance computation and fast
// classical scaling", sections 3 and 4.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/base/cancel.h"
#include "core/field/field.h"

namespace geodesic {

class LandmarkGroup {
 public:
  // `landmarks` are places in a list of landmarks, `points` are numbers of points, both ascending.
  // `to_points(l, p)` is the distance from a landmark of that list to a point, `between(l, k)` that
  // between two; all are finite. Of no use if the poll says to stop.
  template <class ToPoints, class Between>
  LandmarkGroup(std::vector<std::uint32_t> landmarks, std::vector<std::uint32_t> points,
                ToPoints to_points, Between between, Poll& poll)
      : landmarks_(std::move(landmarks)), points_(std::move(points)) {
    double greatest = 0;
    for (const std::uint32_t l : landmarks_) {
      for (const std::uint32_t p : points_) {
        if (poll.cancelled()) return;
        greatest = std::max(greatest, to_points(l, p));
      }
    }
    // Squares of other units might be no floats.
    if (greatest > 0 && 1 / greatest < kUnreached) scale_ = 1 / greatest;
    std::vector<double> squares;
    squares.reserve(landmarks_.size() * landmarks_.size());
    distances_.reserve(landmarks_.size() * points_.size());
    for (const std::uint32_t l : landmarks_) {
      // The way there may be a little longer than the way back.
      for (const std::uint32_t k : landmarks_) {
        const double mean = scale_ * (between(l, k) + between(k, l)) / 2;
        squares.push_back(mean * mean);
      }
      for (const std::uint32_t p : points_) {
        if (poll.cancelled()) return;
        distances_.push_back(static_cast<float>(scale_ * to_points(l, p)));
      }
    }
    decompose(squares, poll);
  }

  // With fewer nothing is to be estimated.
  static constexpr std::size_t kFewest = 8;
  // How many choices there are of which eigenvalues count: those whose absolute value is above some
  // part of the greatest.
  static constexpr std::size_t kCutoffs = 4;

  [[nodiscard]] std::span<const std::uint32_t> landmarks() const { return landmarks_; }
  [[nodiscard]] bool is_to_estimate() const { return landmarks_.size() >= kFewest; }
  // The covering radius: each point is within that distance of a landmark. Mesh units.
  [[nodiscard]] double cover() const { return cover_; }

  // Sets those of the row's entries that are kUnreached and have one of the points, to an estimate
  // that is not below `least`. `to_landmarks`: the distances of the row's own point from all
  // landmarks of the list. Of no use if the poll says to stop.
  void estimate(std::span<const double> to_landmarks, std::size_t cutoff, double least,
                std::span<double> row, Poll& poll) const;

 private:
  void decompose(std::span<const double> squares, Poll& poll);
  // Of what the triangle inequality leaves for the distance to the point at a place in `points_`.
  // Mesh units.
  [[nodiscard]] double middle_of_bounds(std::span<const double> to_landmarks,
                                        std::size_t place) const;

  std::vector<std::uint32_t> landmarks_;
  std::vector<std::uint32_t> points_;
  // What distances in mesh units are multiplied by, so that the greatest is 1.
  double scale_ = 1;
  std::vector<float> distances_;  // a row of points for each landmark; scaled
  double cover_ = 0;              // mesh units
  // With V the eigenvectors that count, ordered by the absolute values of their eigenvalues L, the
  // greatest first, and B the squared distances from landmarks to points: L^-1 V^T, and V^T B.
  // Rows by eigenvector.
  std::vector<double> vectors_;
  std::vector<float> factors_;
  std::vector<std::size_t> ranks_;  // how many count, by cutoff
};

}  // namespace geodesic
