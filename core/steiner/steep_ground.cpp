#include "core/steiner/steep_ground.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace geodesic {
namespace {

// Of the slopes that are tried, each of the one before.
constexpr double kStep = 1.02;
constexpr double kLeastSlope = 1e-3;
constexpr double kMostSlope = 1e3;

}  // namespace

double steepest_resolved(const TravelCost& cost, std::uint32_t points_per_edge) {
  const double level = (1 + kMostAboveLevel) * cost.rate_at(0);
  const double between = 1 / (2.0 * points_per_edge + 2);
  for (double slope = kLeastSlope; slope <= kMostSlope; slope *= kStep) {
    const double turn = slope * between;
    const double rate = 0.5 * (cost.rate_at(turn) + cost.rate_at(-turn)) * std::hypot(1, turn);
    if (turn > cost.steepest() || (cost.has_rate() && rate > level)) return slope;
  }
  return std::numeric_limits<double>::infinity();
}

double steep_part(const Adjacency& adjacency, Vec3 up, double slope, Poll& poll) {
  const auto positions = adjacency.mesh().positions();
  double steep = 0;
  double all = 0;
  for (const Triangle& t : adjacency.mesh().faces()) {
    if (poll.cancelled()) return 0;
    const Vec3 normal = cross(positions[t[1]] - positions[t[0]], positions[t[2]] - positions[t[0]]);
    const double area2 = norm(normal);
    const double upright = std::abs(dot(normal, up));
    all += area2;
    // The slope of a face is the tangent of the angle between its normal and up.
    const double aside = std::sqrt(std::max(area2 * area2 - upright * upright, 0.0));
    if (aside > slope * upright) steep += area2;
  }
  return all > 0 ? steep / all : 0;
}

}  // namespace geodesic
