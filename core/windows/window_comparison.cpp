#include "core/windows/window_comparison.h"

#include <algorithm>
#include <cmath>

namespace geodesic::exact {
namespace {

// The places where g is nought, from the overlap's start. With u counted from there,
// r the start's distances from the unfolded sources, k the difference of offsets and
// g0 that of distances:
//   2 k sqrt(u^2 - 2 x_b u + r_b^2) = 2 k r_b - g0 (r_a + r_b + k) - 2 (x_a - x_b) u
// squared. Relative to the start there is little to cancel.
TwoPlaces equidistant_from_start(const WindowComparison& comparison) {
  const double k = comparison.offset_b - comparison.offset_a;
  const double ra = comparison.at_low_a - comparison.offset_a;
  const double rb = comparison.at_low_b - comparison.offset_b;
  const double xb = comparison.b.x - comparison.low;
  const double apart = comparison.a.x - comparison.b.x;
  const double g0s = (comparison.at_low_b - comparison.at_low_a) * (ra + rb + k);
  const double m = 2 * k * rb - g0s;
  // quadratic a u^2 + 2 b u + c
  const double a = 4 * (apart - k) * (apart + k);
  const double b = 4 * k * k * xb - 2 * apart * m;
  const double c = g0s * (g0s - 4 * k * rb);
  const double root = std::sqrt(std::max(b * b - a * c, 0.0));
  const double q = -(b + std::copysign(root, b));
  const double u1 = a != 0 ? q / a : comparison.high - comparison.low;
  const double u2 = q != 0 ? c / q : 0;
  return {comparison.low + std::min(u1, u2), comparison.low + std::max(u1, u2)};
}

// The one place between `low` and `high` where g changes sign, which it does.
double equidistant_between(const WindowComparison& comparison, double low, double high,
                           double g_low) {
  const TwoPlaces places = equidistant_from_start(comparison);
  double best = 0.5 * (low + high);
  double residual = std::abs(comparison.g(best));
  for (const double place : {places.first, places.second}) {
    if (!(place > low && place < high)) continue;
    const double g = std::abs(comparison.g(place));
    if (g <= residual) {
      best = place;
      residual = g;
    }
  }
  if (residual <= 0.1 * comparison.rounding) return best;
  // The formula has lost too much to cancellation.
  for (int i = 0; i < 100 && high - low > 1e-16 * (comparison.high - comparison.low); ++i) {
    const double g = comparison.g(best);
    if (std::abs(g) <= 0.1 * comparison.rounding) break;
    ((g > 0) == (g_low > 0) ? low : high) = best;
    const double middle = 0.5 * (low + high);
    if (!(middle > low && middle < high)) break;
    best = middle;
  }
  return best;
}

}  // namespace

// Over an overlap, which is short against the distances, g is nearly straight: two secants
// mostly meet it.
EquidistantPoint find_equidistant_point(const WindowComparison& comparison, double low, double high,
                                        double g_low, double g_high) {
  double left = low;
  double right = high;
  double g_left = g_low;
  double g_right = g_high;
  for (int i = 0; i < 4; ++i) {
    const double place = left + (right - left) * (g_left / (g_left - g_right));
    const double at_a = comparison.a.at(place, comparison.offset_a);
    const double at_b = comparison.b.at(place, comparison.offset_b);
    const double g = at_b - at_a;
    if (std::abs(g) <= 0.1 * comparison.rounding) return {place, at_a, at_b};
    const bool on_left = (g > 0) == (g_low > 0);
    (on_left ? left : right) = place;
    (on_left ? g_left : g_right) = g;
  }
  const double place = equidistant_between(comparison, low, high, g_low);
  return {place, comparison.a.at(place, comparison.offset_a),
          comparison.b.at(place, comparison.offset_b)};
}

// A line meets a hyperbola in two places at most, so the middle is between them.
bool meets_twice(const WindowComparison& comparison, double sign, TwoPlaces& inside) {
  const TwoPlaces places = equidistant_from_start(comparison);
  if (!(places.first < comparison.high && places.second > comparison.low &&
        places.first < places.second))
    return false;
  const double first = std::max(places.first, comparison.low);
  const double second = std::min(places.second, comparison.high);
  const double middle = 0.5 * (first + second);
  if (!(sign * comparison.g(middle) < -comparison.rounding)) return false;
  inside.first = equidistant_between(comparison, comparison.low, middle, sign);
  inside.second = equidistant_between(comparison, middle, comparison.high, -sign);
  return true;
}

}  // namespace geodesic::exact
