// The distances of a field, a number for each vertex: doubles while they are computed,
// and floats from then on where a method is no more exact than these.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/field/method.h"

namespace geodesic {

inline constexpr double kUnreached = std::numeric_limits<double>::infinity();

// Rounds a distance to the nearest float, or with Bound::upper to the least float that is not below
// it. The result differs by at most 1.2e-7 of the distance. Zero and infinity stay the same. So
// does a distance for which no float is that close, because it is too great or too small.
[[nodiscard]] double as_float(double distance, Bound bound = Bound::none);

class VertexDistances {
 public:
  void assign(std::size_t vertex_count, double value) { doubles_.assign(vertex_count, value); }

  [[nodiscard]] std::size_t size() const { return are_floats() ? floats_.size() : doubles_.size(); }
  [[nodiscard]] double operator[](std::size_t vertex) const {
    return are_floats() ? static_cast<double>(floats_[vertex]) : doubles_[vertex];
  }
  // All of them, whatever they are held in.
  [[nodiscard]] std::vector<double> values() const;

  // To be computed in. Empty once they are floats.
  [[nodiscard]] std::vector<double>& doubles() { return doubles_; }

  void forget(std::size_t vertex);

  // Each becomes as_float of it, at half the memory. Or they all stay what they are, if one
  // is out of the floats' range.
  void round_to_floats(Bound bound);
  // The same where `among` are all that are reached.
  void round_to_floats(Bound bound, std::span<const std::uint32_t> among);
  [[nodiscard]] bool are_floats() const { return !floats_.empty(); }

  [[nodiscard]] std::size_t bytes() const {
    return doubles_.capacity() * sizeof(double) + floats_.capacity() * sizeof(float);
  }

  [[nodiscard]] friend bool operator==(const VertexDistances&, const VertexDistances&) = default;

 private:
  // One of them is empty.
  std::vector<double> doubles_;
  std::vector<float> floats_;
};

}  // namespace geodesic
