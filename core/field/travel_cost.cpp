#include "core/field/travel_cost.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/tolerances.h"

namespace geodesic {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

double size_of(Vec3 p) { return std::abs(p.x) + std::abs(p.y) + std::abs(p.z); }

// The rise for each unit of length on the ground.
double sine_of(double slope) {
  return std::isinf(slope) ? std::copysign(1, slope) : slope / std::hypot(1, slope);
}

// Joules a kilogram and metre.
double energy_at(double slope) {
  constexpr double kSteepestMeasured = 0.45;
  const double i = std::clamp(slope, -kSteepestMeasured, kSteepestMeasured);
  const double rate = ((((280.5 * i - 58.7) * i - 76.8) * i + 51.9) * i + 19.6) * i + 2.5;
  return i == slope ? rate : rate * sine_of(slope) / sine_of(i);
}

}  // namespace

TravelCost::TravelCost(Parts parts) : parts_(std::move(parts)) {
  parts_.up = 1 / norm(parts_.up) * parts_.up;
}

double TravelCost::slope_of(Vec3 from, Vec3 to) const {
  const Vec3 along = to - from;
  // What rounding leaves between two names of one place has any slope.
  const double rounding = tolerance::kSameDistance * (size_of(from) + size_of(to));
  if (dot(along, along) <= rounding * rounding) return 0;
  const double rise = dot(along, parts_.up);
  const double run = norm(along - rise * parts_.up);
  if (rise == 0) return 0;
  return rise / run;
}

double TravelCost::rate_at(double slope) const {
  if (parts_.rate == Rate::none) return 1;
  if (parts_.rate == Rate::tobler) {
    constexpr double kSecondsPerMetre = 3.6 / 6;
    return kSecondsPerMetre * std::exp(3.5 * std::abs(slope + 0.05));
  }
  if (parts_.rate == Rate::energy) return energy_at(slope);
  const auto above =
      std::upper_bound(parts_.table.begin(), parts_.table.end(), slope,
                       [](double s, const SlopeRate& entry) { return s < entry.slope; });
  if (above == parts_.table.begin()) return above->rate;
  const SlopeRate& below = *(above - 1);
  if (above == parts_.table.end()) return below.rate;
  const double part = (slope - below.slope) / (above->slope - below.slope);
  return (1 - part) * below.rate + part * above->rate;
}

double TravelCost::of_walked(std::uint32_t face, Vec3 from, Vec3 to) const {
  const double length = distance(from, to);
  const double flat = weight(face) * length;
  return parts_.rate == Rate::none ? flat : flat * rate_at(slope_of(from, to));
}

// Ground that is just as steep as may be is walked, between all places on it. So the slope may be
// greater by what rounding adds to it, and to where the two ends are.
bool TravelCost::is_too_steep(double slope, Vec3 from, Vec3 to) const {
  const double steepest = parts_.steepest;
  if (slope <= steepest) return false;
  const double off = std::numeric_limits<double>::epsilon() * (size_of(from) + size_of(to));
  const double run = distance(from, to) / std::hypot(1, steepest);
  // Both the rise and the run are off by that.
  return !(slope <= steepest * (1 + tolerance::kSamePath) + (1 + steepest) * off / run);
}

double TravelCost::of(std::uint32_t face, Vec3 from, Vec3 to) const {
  if (parts_.steepest < kInfinite && is_too_steep(std::abs(slope_of(from, to)), from, to)) {
    return kInfinite;
  }
  return of_walked(face, from, to);
}

}  // namespace geodesic
