// Two windows over one interval of an edge: which of them is nearer, and where that changes.
#pragma once

#include "core/exact/window.h"

namespace geodesic::exact {

// `g`, the second's distance less the first's, is what everything here is about.
struct Duel {
  const Window& a;
  const Window& b;
  double offset_a;
  double offset_b;
  double low;
  double high;
  double at_low_a, at_high_a;
  double at_low_b, at_high_b;
  double tie;  // less than this is none

  [[nodiscard]] double g(double place) const {
    return b.at(place, offset_b) - a.at(place, offset_a);
  }
  // The sign of the slope of g: that of cos(b) - cos(a), over a common denominator.
  [[nodiscard]] double slope(double place, double at_a, double at_b) const {
    return (place - b.x) * (at_a - offset_a) - (place - a.x) * (at_b - offset_b);
  }
};

// Where two windows are equally far, and how far.
struct Tie {
  double place;
  double at_a;
  double at_b;
};

// The one place between `low` and `high` where g changes sign, which it does.
[[nodiscard]] Tie find_tie(const Duel& duel, double low, double high, double g_low, double g_high);

struct Roots {
  double first;
  double second;
};

// Whether one window is nearer in the middle of an interval at whose ends it is not,
// and where. `sign` is 1 when that is the second, -1 when it is the first.
[[nodiscard]] bool meets_twice(const Duel& duel, double sign, Roots& inside);
[[nodiscard]] inline bool wins_inside(const Duel& duel, double sign, Roots& inside) {
  // By the slopes of g it mostly cannot be.
  return sign * duel.slope(duel.low, duel.at_low_a, duel.at_low_b) < 0 &&
         sign * duel.slope(duel.high, duel.at_high_a, duel.at_high_b) > 0 &&
         meets_twice(duel, sign, inside);
}

}  // namespace geodesic::exact
