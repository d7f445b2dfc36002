#include "tests/bench/errors.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <vector>

namespace geodesic::bench {

Errors errors_of(std::span<const double> distance, std::span<const double> truth) {
  assert(distance.size() == truth.size());
  Errors errors;
  std::vector<double> relative;
  relative.reserve(truth.size());
  double sum = 0;
  double squares = 0;
  double absolute_squares = 0;
  std::size_t below = 0;
  for (std::size_t v = 0; v < truth.size(); ++v) {
    if (!std::isfinite(truth[v])) {
      if (std::isfinite(distance[v])) ++errors.invented;
      continue;
    }
    ++errors.compared;
    if (!std::isfinite(distance[v])) {
      ++errors.unreached;
      continue;
    }
    const double difference = distance[v] - truth[v];
    errors.max_absolute = std::max(errors.max_absolute, std::abs(difference));
    absolute_squares += difference * difference;
    if (!(truth[v] > 0)) continue;
    const double error = std::abs(difference) / truth[v];
    relative.push_back(error);
    sum += error;
    squares += error * error;
    if (-difference > Errors::kRounding * truth[v]) ++below;
  }
  if (relative.empty()) return errors;
  const auto count = static_cast<double>(relative.size());
  errors.mean = sum / count;
  errors.rms = std::sqrt(squares / count);
  errors.share_below = static_cast<double>(below) / count;
  errors.mean_square = absolute_squares / static_cast<double>(errors.compared - errors.unreached);
  const auto rank = static_cast<std::size_t>(std::ceil(0.999 * count)) - 1;
  const auto at = relative.begin() + static_cast<std::ptrdiff_t>(rank);
  std::nth_element(relative.begin(), at, relative.end());
  errors.p999 = *at;
  errors.max = *std::max_element(at, relative.end());
  return errors;
}

}  // namespace geodesic::bench
