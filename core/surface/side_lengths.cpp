#include "core/surface/side_lengths.h"

#include <algorithm>
#include <cmath>

#include "core/base/polled_fill.h"
#include "core/base/tolerances.h"
#include "core/surface/point.h"

namespace geodesic {
namespace {

DoubleDouble squared_distance(Vec3 p, Vec3 q) {
  const DoubleDouble x = DoubleDouble::sum(p.x, -q.x);
  const DoubleDouble y = DoubleDouble::sum(p.y, -q.y);
  const DoubleDouble z = DoubleDouble::sum(p.z, -q.z);
  return x * x + y * y + z * z;
}

// The dot product of two sides, from the squares of them and of the third.
DoubleDouble dot_of(DoubleDouble side2, DoubleDouble other2, DoubleDouble opposite2) {
  return (side2 + other2 - opposite2) * 0.5;
}

struct Area {
  DoubleDouble twice;
  double product2;  // of the squares of the two sides that it was computed from

  [[nodiscard]] double rounding() const {
    const double of_square = tolerance::kDoubleDouble * product2;
    return std::min(std::sqrt(of_square), of_square / twice.high);
  }
};

// From the two shorter sides: the longest one's rounding would be a large part of a needle's.
Area area_of(DoubleDouble a, DoubleDouble b, DoubleDouble c) {
  if (a.high > c.high) std::swap(a, c);
  if (b.high > c.high) std::swap(b, c);
  const DoubleDouble dot = dot_of(a, b, c);
  return {square_root(a * b - dot * dot), a.high * b.high};
}

}  // namespace

SideLengths::SideLengths(std::span<const Vec3> positions, std::size_t face_count, Poll& poll)
    : positions_(positions) {
  polled_assign(place_, face_count, kNone, poll);
}

SquaredSides SideLengths::squared(std::uint32_t face, const FaceRecord& record) const {
  if (place_[face] != kNone) return sides_[place_[face]];
  SquaredSides sides;
  for (std::uint32_t c = 0; c < 3; ++c) {
    sides[c] =
        squared_distance(positions_[record.vertex[c]], positions_[record.vertex[next_corner(c)]]);
  }
  return sides;
}

void SideLengths::set(std::uint32_t face, const SquaredSides& sides) {
  if (place_[face] == kNone) {
    place_[face] = static_cast<std::uint32_t>(sides_.size());
    sides_.push_back(sides);
  } else {
    sides_[place_[face]] = sides;
  }
}

// With a at the origin and b on the x axis, c and d are at (dot / |ab|, area / |ab|) on either side
// of it, where the dot products are those at a.
Flipped flip_diagonal(const Quad& quad) {
  const Area one = area_of(quad.ab2, quad.bc2, quad.ca2);
  const Area other = area_of(quad.ab2, quad.bd2, quad.ad2);
  const DoubleDouble at_a1 = dot_of(quad.ab2, quad.ca2, quad.bc2);
  const DoubleDouble at_a2 = dot_of(quad.ab2, quad.ad2, quad.bd2);
  const DoubleDouble at_b1 = quad.ab2 - at_a1;
  const DoubleDouble at_b2 = quad.ab2 - at_a2;
  // The angles of both faces add up at a, and at b. The nearer of the two says more.
  const bool from_a = quad.ca2.high * quad.ad2.high <= quad.bc2.high * quad.bd2.high;
  const DoubleDouble dot1 = from_a ? at_a1 : at_b1;
  const DoubleDouble dot2 = from_a ? at_a2 : at_b2;
  const DoubleDouble to_c2 = from_a ? quad.ca2 : quad.bc2;
  const DoubleDouble to_d2 = from_a ? quad.ad2 : quad.bd2;
  const DoubleDouble across = (dot1 * dot2 - one.twice * other.twice) / quad.ab2;
  Flipped flipped;
  flipped.cd2 = to_c2 + to_d2 - across * 2;
  flipped.area_a = ((at_a1 * other.twice + one.twice * at_a2) / quad.ab2).high;
  flipped.area_b = ((at_b1 * other.twice + one.twice * at_b2) / quad.ab2).high;

  // What c - d may be off by turns what is beyond it, the more the thinner the new faces are.
  const double longest2 =
      std::max({quad.bc2.high, quad.ca2.high, quad.ad2.high, quad.bd2.high, flipped.cd2.high});
  const double least = std::min(flipped.area_a, flipped.area_b);
  const double of_cd2 = tolerance::kDoubleDouble * (to_c2.high + to_d2.high) +
                        (tolerance::kDoubleDouble * std::abs(dot1.high * dot2.high) +
                         one.rounding() * other.twice.high + one.twice.high * other.rounding()) /
                            quad.ab2.high;
  flipped.error = of_cd2 / (2 * std::sqrt(flipped.cd2.high)) * (std::sqrt(longest2) / least);
  return flipped;
}

std::array<double, 3> corner_products(const SquaredSides& sides) {
  return {dot_of(sides[0], sides[2], sides[1]).high, dot_of(sides[1], sides[0], sides[2]).high,
          dot_of(sides[2], sides[1], sides[0]).high};
}

}  // namespace geodesic
