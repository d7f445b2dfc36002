// What it costs to walk over a surface, where that is not the length: a weight for each face, and a
// rate that depends on the slope of the segment, up or down.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/base/vec3.h"

namespace geodesic {

// What a unit of length costs on ground that rises by `slope` for each unit of length on the map:
// positive uphill, negative downhill.
struct SlopeRate {
  double slope;  // -1e9 to 1e9
  double rate;   // above 0
};

// A segment of length l inside face f costs weight(f) * rate(slope) * l. Along an edge that is the
// least of what its faces ask. The weighted region problem: Mitchell, Papadimitriou, "The weighted
// region problem: finding shortest paths through a weighted planar subdivision", J. ACM 38, 1991.
class TravelCost {
 public:
  enum class Rate : std::uint8_t {
    none,    // 1 on every slope
    table,   // linear between entries, constant beyond the first and the last
    tobler,  // seconds a metre, by the hiking function
    energy,  // joules a kilogram and metre, walking
  };
  struct Parts {
    std::vector<double> weights = {};  // by face, above 0; empty: all are 1
    Rate rate = Rate::none;
    std::vector<SlopeRate> table = {};  // ascending, at least one if it is the rate
    // Steeper segments are not walked, neither up nor down. What rounding may add is not steeper.
    double steepest = std::numeric_limits<double>::infinity();
    Vec3 up{0, 1, 0};  // not zero
  };
  explicit TravelCost(Parts parts);

  // The cost of a segment that is walked from `from` to `to`; infinite if it is too steep. Not the
  // same the other way where the rate depends on the slope.
  [[nodiscard]] double of(std::uint32_t face, Vec3 from, Vec3 to) const;
  // The same without the limit `steepest`, for paths that are found already.
  [[nodiscard]] double of_walked(std::uint32_t face, Vec3 from, Vec3 to) const;

  [[nodiscard]] double weight(std::uint32_t face) const {
    return parts_.weights.empty() ? 1 : parts_.weights[face];
  }
  [[nodiscard]] bool has_weights() const { return !parts_.weights.empty(); }
  [[nodiscard]] bool has_rate() const { return parts_.rate != Rate::none; }
  [[nodiscard]] double steepest() const { return parts_.steepest; }
  [[nodiscard]] Vec3 up() const { return parts_.up; }

  // The cost of a unit of length on this slope, without the face's weight. W. Tobler, "Three
  // presentations on geographical analysis and modeling", NCGIA Technical Report 93-1, 1993: one
  // walks 6 exp(-3.5 |slope + 0.05|) kilometres an hour. Energy: A. E. Minetti et al., "Energy cost
  // of walking and running at extreme uphill and downhill slopes", J. Appl. Physiol. 93, 2002: the
  // polynomial for walking, which was fitted to slopes i from -0.45 to 0.45,
  // 280.5 i^5 - 58.7 i^4 - 76.8 i^3 + 51.9 i^2 + 19.6 i + 2.5. Beyond these,
  // the cost for each metre of height is that at -0.45 or 0.45.
  [[nodiscard]] double rate_at(double slope) const;

  [[nodiscard]] std::size_t bytes() const {
    return sizeof(TravelCost) + parts_.weights.capacity() * sizeof(double) +
           parts_.table.capacity() * sizeof(SlopeRate);
  }

 private:
  [[nodiscard]] double slope_of(Vec3 from, Vec3 to) const;
  [[nodiscard]] bool is_too_steep(double slope, Vec3 from, Vec3 to) const;

  Parts parts_;
};

}  // namespace geodesic
