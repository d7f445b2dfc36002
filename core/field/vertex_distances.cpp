#include "core/field/vertex_distances.h"

#include <algorithm>
#include <bit>
#include <cstdint>

namespace geodesic {
namespace {

// Below the least of them floats have fewer digits.
bool is_in_range(double distance) {
  constexpr double kLeast = std::numeric_limits<float>::min();
  constexpr double kGreatest = std::numeric_limits<float>::max();
  return (distance >= kLeast && distance <= kGreatest) || distance == 0 || distance == kUnreached;
}

float to_nearest(double distance) { return static_cast<float>(distance); }

// The floats from zero to infinity are in the order of their bits.
float not_below(double distance) {
  const auto nearest = static_cast<float>(distance);
  const std::uint32_t step = nearest < distance ? 1 : 0;
  return std::bit_cast<float>(std::bit_cast<std::uint32_t>(nearest) + step);
}

}  // namespace

double as_float(double distance, Bound bound) {
  if (!is_in_range(distance)) return distance;
  return bound == Bound::upper ? not_below(distance) : to_nearest(distance);
}

std::vector<double> VertexDistances::values() const {
  return are_floats() ? std::vector<double>(floats_.begin(), floats_.end()) : doubles_;
}

void VertexDistances::forget(std::size_t vertex) {
  if (are_floats()) {
    floats_[vertex] = std::numeric_limits<float>::infinity();
  } else {
    doubles_[vertex] = kUnreached;
  }
}

void VertexDistances::round_to_floats(Bound bound) {
  if (!std::all_of(doubles_.begin(), doubles_.end(), is_in_range)) return;
  floats_.resize(doubles_.size());
  std::transform(doubles_.begin(), doubles_.end(), floats_.begin(),
                 bound == Bound::upper ? not_below : to_nearest);
  doubles_ = std::vector<double>();
}

void VertexDistances::round_to_floats(Bound bound, std::span<const std::uint32_t> among) {
  if (!std::all_of(among.begin(), among.end(),
                   [&](std::uint32_t v) { return is_in_range(doubles_[v]); })) {
    return;
  }
  floats_.assign(doubles_.size(), std::numeric_limits<float>::infinity());
  for (const std::uint32_t v : among) {
    floats_[v] = bound == Bound::upper ? not_below(doubles_[v]) : to_nearest(doubles_[v]);
  }
  doubles_ = std::vector<double>();
}

}  // namespace geodesic
