// Two windows over one interval of an edge: which of them is nearer, and where that changes.
#pragma once

#include "core/windows/window.h"

namespace geodesic::exact {

// `g`, the second's distance less the first's, is what everything here is about.
struct WindowComparison {
  const Window& a;
  const Window& b;
  double offset_a;
  double offset_b;
  double low;
  double high;
  double at_low_a, at_high_a;
  double at_low_b, at_high_b;
  double rounding;  // g below this is nought

  [[nodiscard]] double g(double place) const {
    return b.at(place, offset_b) - a.at(place, offset_a);
  }
  // The sign of the slope of g: that of cos(b) - cos(a), over a common denominator.
  [[nodiscard]] double slope(double place, double at_a, double at_b) const {
    return (place - b.x) * (at_a - offset_a) - (place - a.x) * (at_b - offset_b);
  }
};

// Where two windows are equally far, and how far.
struct EquidistantPoint {
  double place;
  double at_a;
  double at_b;
};

// The one place between `low` and `high` where g changes sign, which it does.
[[nodiscard]] EquidistantPoint find_equidistant_point(const WindowComparison& comparison,
                                                      double low, double high, double g_low,
                                                      double g_high);

struct TwoPlaces {
  double first;
  double second;
};

// Whether one window is nearer in the middle of an interval at whose ends it is not,
// and where. `sign` is 1 when that is the second, -1 when it is the first.
[[nodiscard]] bool meets_twice(const WindowComparison& comparison, double sign, TwoPlaces& inside);
[[nodiscard]] inline bool is_nearer_inside(const WindowComparison& comparison, double sign,
                                           TwoPlaces& inside) {
  // By the slopes of g it mostly cannot be.
  return sign * comparison.slope(comparison.low, comparison.at_low_a, comparison.at_low_b) < 0 &&
         sign * comparison.slope(comparison.high, comparison.at_high_a, comparison.at_high_b) > 0 &&
         meets_twice(comparison, sign, inside);
}

}  // namespace geodesic::exact
