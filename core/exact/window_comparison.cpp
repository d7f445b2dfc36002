#include "core/exact/window_comparison.h"

#include <algorithm>
#include <cmath>

namespace geodesic::exact {
namespace {

// The places where g is nought, from the overlap's start. With u counted from there,
// r the start's distances from the unfolded sources, k the difference of offsets and
// g0 that of distances:
//   2 k sqrt(u^2 - 2 x_b u + r_b^2) = 2 k r_b - g0 (r_a + r_b + k) - 2 (x_a - x_b) u
// squared. Relative to the start there is little to cancel.
Roots ties_from_start(const Duel& duel) {
  const double k = duel.offset_b - duel.offset_a;
  const double ra = duel.at_low_a - duel.offset_a;
  const double rb = duel.at_low_b - duel.offset_b;
  const double xb = duel.b.x - duel.low;
  const double apart = duel.a.x - duel.b.x;
  const double g0s = (duel.at_low_b - duel.at_low_a) * (ra + rb + k);
  const double m = 2 * k * rb - g0s;
  // quadratic a u^2 + 2 b u + c
  const double a = 4 * (apart - k) * (apart + k);
  const double b = 4 * k * k * xb - 2 * apart * m;
  const double c = g0s * (g0s - 4 * k * rb);
  const double root = std::sqrt(std::max(b * b - a * c, 0.0));
  const double q = -(b + std::copysign(root, b));
  const double u1 = a != 0 ? q / a : duel.high - duel.low;
  const double u2 = q != 0 ? c / q : 0;
  return {duel.low + std::min(u1, u2), duel.low + std::max(u1, u2)};
}

// The one place between `low` and `high` where g changes sign, which it does.
double tie_between(const Duel& duel, double low, double high, double g_low) {
  const Roots roots = ties_from_start(duel);
  double best = 0.5 * (low + high);
  double residual = std::abs(duel.g(best));
  for (const double root : {roots.first, roots.second}) {
    if (!(root > low && root < high)) continue;
    const double g = std::abs(duel.g(root));
    if (g <= residual) {
      best = root;
      residual = g;
    }
  }
  if (residual <= 0.1 * duel.tie) return best;
  // The formula has lost too much to cancellation.
  for (int i = 0; i < 100 && high - low > 1e-16 * (duel.high - duel.low); ++i) {
    const double g = duel.g(best);
    if (std::abs(g) <= 0.1 * duel.tie) break;
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
Tie find_tie(const Duel& duel, double low, double high, double g_low, double g_high) {
  double left = low;
  double right = high;
  double g_left = g_low;
  double g_right = g_high;
  for (int i = 0; i < 4; ++i) {
    const double place = left + (right - left) * (g_left / (g_left - g_right));
    const double at_a = duel.a.at(place, duel.offset_a);
    const double at_b = duel.b.at(place, duel.offset_b);
    const double g = at_b - at_a;
    if (std::abs(g) <= 0.1 * duel.tie) return {place, at_a, at_b};
    const bool on_left = (g > 0) == (g_low > 0);
    (on_left ? left : right) = place;
    (on_left ? g_left : g_right) = g;
  }
  const double place = tie_between(duel, low, high, g_low);
  return {place, duel.a.at(place, duel.offset_a), duel.b.at(place, duel.offset_b)};
}

// A line meets a hyperbola in two places at most, so the middle is between them.
bool meets_twice(const Duel& duel, double sign, Roots& inside) {
  const Roots ties = ties_from_start(duel);
  if (!(ties.first < duel.high && ties.second > duel.low && ties.first < ties.second)) return false;
  const double first = std::max(ties.first, duel.low);
  const double second = std::min(ties.second, duel.high);
  const double middle = 0.5 * (first + second);
  if (!(sign * duel.g(middle) < -duel.tie)) return false;
  inside.first = tie_between(duel, duel.low, middle, sign);
  inside.second = tie_between(duel, middle, duel.high, -sign);
  return true;
}

}  // namespace geodesic::exact
