// How far distances are from the true ones.
#pragma once

#include <cstddef>
#include <span>

namespace geodesic::bench {

// Relative errors are |d - t| / t over the vertices with a finite true distance
// t > 0; absolute ones, in mesh units, include those with t = 0.
struct Errors {
  std::size_t compared = 0;   // vertices with a finite true distance
  std::size_t unreached = 0;  // … of which the method has no distance
  std::size_t invented = 0;   // vertices without a true distance that have one all the same
  double mean = 0;
  double rms = 0;
  double p999 = 0;  // the 99.9th percentile: at most 0.1 % of vertices are worse
  double max = 0;
  double share_below = 0;  // of vertices with d < t by more than kRounding of t
  double max_absolute = 0;
  double mean_square = 0;  // of the absolute error

  // What is nearer to the truth than this part of it is taken for the truth.
  static constexpr double kRounding = 1e-9;
};

// `distance` and `truth` have one entry a vertex; not finite: no distance.
[[nodiscard]] Errors errors_of(std::span<const double> distance, std::span<const double> truth);

}  // namespace geodesic::bench
