#include "core/surface/side_lengths.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/polled_fill.h"
#include "core/base/team.h"
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

// The dot product of two sides, from the squares of them and of the third. Off by some 2^-104 of
// the largest of them, which is what the products that it goes into are off by anyway.
DoubleDouble dot_of(DoubleDouble side2, DoubleDouble other2, DoubleDouble opposite2) {
  const DoubleDouble both = DoubleDouble::sum(side2.high, other2.high);
  const DoubleDouble rest = DoubleDouble::sum(both.high, -opposite2.high);
  const double low = (rest.low + both.low) + ((side2.low + other2.low) - opposite2.low);
  return DoubleDouble::sum(0.5 * rest.high, 0.5 * low);
}

// Twice the area, squared.
struct Area {
  DoubleDouble squared;
  double rounding2;  // what that may be off by

  // Twice the area, and what that may be off by.
  [[nodiscard]] double twice() const { return std::sqrt(std::max(squared.high, 0.0)); }
  [[nodiscard]] double rounding() const {
    return std::min(std::sqrt(rounding2), rounding2 / twice());
  }
};

// From the two shorter sides: the longest one's rounding would be a large part of a needle's.
Area area_of(DoubleDouble a, DoubleDouble b, DoubleDouble c) {
  if (a.high > c.high) std::swap(a, c);
  if (b.high > c.high) std::swap(b, c);
  const DoubleDouble dot = dot_of(a, b, c);
  return {a * b - dot * dot, tolerance::kDoubleDouble * a.high * b.high};
}

// At each corner, the dot product of the two sides that leave it (FaceRecord::dot).
std::array<double, 3> corner_products(const SquaredSides& sides) {
  return {dot_of(sides[0], sides[2], sides[1]).high, dot_of(sides[1], sides[0], sides[2]).high,
          dot_of(sides[2], sides[1], sides[0]).high};
}

// The same, as a face record has it: mostly no digits are lost between plain doubles.
double area_of(const std::array<double, 3>& dot, const SquaredSides& sides) {
  const auto [p, q, w] = dot;
  const double squared = p * q + p * w + q * w;
  const double of_terms = std::abs(p * q) + std::abs(p * w) + std::abs(q * w);
  constexpr double kLost = 0.25;  // two bits
  if (squared > kLost * of_terms) return std::sqrt(squared);
  return area_of(sides[0], sides[1], sides[2]).twice();
}

}  // namespace

SideLengths::SideLengths(std::span<const Vec3> positions, std::size_t face_count, Poll& poll)
    : positions_(positions), sides_(count_blocks(face_count)) {
  polled_assign(place_, face_count, kNone, poll);
  // Of scans, four faces in ten are changed.
  if (!poll.may_take(face_count / 2 * sizeof(SquaredSides))) return;
  for (std::vector<SquaredSides>& block : sides_) block.reserve(std::min(kBlock, face_count) / 2);
}

SquaredSides SideLengths::squared(std::uint32_t face, const FaceRecord& record) const {
  if (place_[face] != kNone) return sides_[face / kBlock][place_[face]];
  SquaredSides sides;
  for (std::uint32_t c = 0; c < 3; ++c) {
    sides[c] =
        squared_distance(positions_[record.vertex[c]], positions_[record.vertex[next_corner(c)]]);
  }
  return sides;
}

void SideLengths::set(std::uint32_t face, const SquaredSides& sides) {
  std::vector<SquaredSides>& block = sides_[face / kBlock];
  if (place_[face] == kNone) {
    place_[face] = static_cast<std::uint32_t>(block.size());
    block.push_back(sides);
  } else {
    block[place_[face]] = sides;
  }
}

// With a at the origin and b on the x axis, c and d are at (dot / |ab|, area / |ab|) on either side
// of it, where the dot products are those at a. Or from b, if the four lengths there are less.
Flipped flip_diagonal(const Quad& quad) {
  const Area one = area_of(quad.ab2, quad.bc2, quad.ca2);
  const Area other = area_of(quad.ab2, quad.bd2, quad.ad2);
  const DoubleDouble at_a1 = dot_of(quad.ab2, quad.ca2, quad.bc2);
  const DoubleDouble at_a2 = dot_of(quad.ab2, quad.ad2, quad.bd2);
  const bool from_a = quad.ca2.high * quad.ad2.high <= quad.bc2.high * quad.bd2.high;
  const DoubleDouble dot1 = from_a ? at_a1 : quad.ab2 - at_a1;
  const DoubleDouble dot2 = from_a ? at_a2 : quad.ab2 - at_a2;
  const DoubleDouble to_c2 = from_a ? quad.ca2 : quad.bc2;
  const DoubleDouble to_d2 = from_a ? quad.ad2 : quad.bd2;
  // By a power of two, so that the product of four squares stays within range.
  const double scale = std::ldexp(1.0, -std::ilogb(quad.ab2.high));
  const DoubleDouble areas =
      square_root((one.squared * scale) * (other.squared * scale)) * (1 / scale);
  const DoubleDouble across = (dot1 * dot2 - areas) / quad.ab2;
  Flipped flipped;
  flipped.cd2 = (to_c2 + to_d2) - across * 2;

  const double area1 = one.twice();
  const double area2 = other.twice();
  const SquaredSides left{quad.ad2, flipped.cd2, quad.ca2};
  const SquaredSides right{quad.bc2, flipped.cd2, quad.bd2};
  flipped.dot_a = corner_products(left);
  flipped.dot_b = corner_products(right);
  flipped.area_a = area_of(flipped.dot_a, left);
  flipped.area_b = area_of(flipped.dot_b, right);
  // The angles at a add up to less than pi, and those at b.
  flipped.is_convex =
      at_a1.high * area2 + area1 * at_a2.high > 0 &&
      (quad.ab2.high - at_a1.high) * area2 + area1 * (quad.ab2.high - at_a2.high) > 0;

  // What c - d may be off by turns what is beyond it, the more the thinner the new faces are.
  const double longest2 =
      std::max({quad.bc2.high, quad.ca2.high, quad.ad2.high, quad.bd2.high, flipped.cd2.high});
  const double least = std::min(flipped.area_a, flipped.area_b);
  const double of_cd2 = tolerance::kDoubleDouble * (to_c2.high + to_d2.high) +
                        (tolerance::kDoubleDouble * std::abs(dot1.high * dot2.high) +
                         one.rounding() * area2 + area1 * other.rounding()) /
                            quad.ab2.high;
  flipped.error = of_cd2 / (2 * std::sqrt(flipped.cd2.high)) * (std::sqrt(longest2) / least);
  return flipped;
}

}  // namespace geodesic
