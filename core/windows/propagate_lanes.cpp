#include "core/windows/propagate_lanes.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/base/lane_arithmetic.h"
#include "core/base/tolerances.h"
#include "core/field/field.h"
#include "core/windows/envelope.h"

namespace geodesic::exact {
namespace {

template <class Reals>
GEODESIC_LANES_INLINE void read(Reals& to, const double* from) {
  std::memcpy(&to, from, sizeof to);
}
template <class Reals>
GEODESIC_LANES_INLINE void write(double* to, const Reals& from) {
  std::memcpy(to, &from, sizeof from);
}

template <std::size_t kWide>
GEODESIC_LANES_INLINE std::size_t crossings(EnteringWindows& entering, std::size_t first,
                                            std::size_t last, double apex_x, double apex_y,
                                            double base) {
  using Lane = lanes::Lanes<kWide>;
  using Reals = typename Lane::Reals;
  using Flags = typename Lane::Flags;
  const double near = tolerance::kNearlyMet * base;
  Reals least = Reals{} + kUnreached;
  Reals where{};
  Reals number;
  for (std::size_t i = 0; i < kWide; ++i) number[i] = static_cast<double>(i);
  const auto count = static_cast<double>(last - first);
  for (std::size_t i = first; i < last; i += kWide, number = number + double{kWide}) {
    Reals begin, end, x, y, offset;
    read(begin, entering.begin.data() + i);
    read(end, entering.end.data() + i);
    read(x, entering.x.data() + i);
    read(y, entering.y.data() + i);
    read(offset, entering.offset.data() + i);
    const Reals rise = y + apex_y;
    // On one line with the face anything between will do.
    Reals crossing = (x * apex_y + apex_x * y) / rise;
    crossing = rise > 0 ? crossing : Reals{} + apex_x;
    write(entering.crossing.data() + i, crossing);
    const Flags straight = (crossing >= begin - near) & (crossing <= end + near);
    Reals at = crossing > begin ? crossing : begin;
    at = at < end ? at : end;
    const Reals run = at - x;
    const Reals rest = apex_x - at;
    Reals there, on;
    Lane::root(there, run * run + y * y);
    Lane::root(on, rest * rest + apex_y * apex_y);
    Reals distance = offset + there + on;
    Lane::choose(distance, straight, distance, distance * tolerance::kBent);
    const Flags better = (distance < least) & (number < count);
    Lane::choose(least, better, distance, least);
    Lane::choose(where, better, number, where);
  }
  std::size_t best = 0;
  for (std::size_t i = 1; i < kWide; ++i) {
    if (least[i] < least[best] || (least[i] == least[best] && where[i] < where[best])) best = i;
  }
  return first + static_cast<std::size_t>(where[best]);
}

// A line from the unfolded source (x, -y) through (p, 0) of the base meets the side, which
// rises from the base's tail at an angle A, at
//   t = p y / (y cos A + (x - p) sin A),
// and seen from the side the source is at (x cos A - y sin A, -(y cos A + x sin A)).
template <std::size_t kWide>
GEODESIC_LANES_INLINE void to_side(const EnteringWindows& entering, std::size_t first,
                                   std::size_t last, const SideFrame& side,
                                   PropagatedWindows& beyond) {
  using Lane = lanes::Lanes<kWide>;
  using Reals = typename Lane::Reals;
  using Flags = typename Lane::Flags;
  const double cosine = side.cosine;
  const double sine = side.sine;
  const double length = side.length;
  const Reals none{};
  const Reals whole = none + length;
  // In a face that is a line rays go over a side where they come over the base, though their source
  // may lie on the line too.
  const bool is_line = sine == 0;
  const Reals one = none + 1;
  // From the base's tail to its head is the same as back again, mirrored.
  const double shift = side.on_right ? side.base_length : 0;
  const double sign = side.on_right ? -1 : 1;
  const double* const near_ends = side.on_right ? entering.end.data() : entering.begin.data();
  const double* const far_ends = side.on_right ? entering.begin.data() : entering.end.data();
  const double edge_shift = side.flipped ? length : 0;
  const double edge_sign = side.flipped ? -1 : 1;
  for (std::size_t i = first; i < last; i += kWide) {
    Reals near, far, x, y, offset, crossing;
    read(near, near_ends + i);
    read(far, far_ends + i);
    read(x, entering.x.data() + i);
    read(y, entering.y.data() + i);
    read(offset, entering.offset.data() + i);
    read(crossing, entering.crossing.data() + i);
    near = shift + sign * near;
    far = shift + sign * far;
    x = shift + sign * x;
    crossing = shift + sign * crossing;
    const Reals lift = is_line ? one : y;
    const Reals below_near = lift * cosine + (x - near) * sine;
    const Reals below_far = lift * cosine + (x - far) * sine;
    Reals low = near * lift / below_near;
    Reals high = far * lift / below_far;
    low = low < whole ? low : whole;
    low = below_near > 0 ? low : (near > 0 ? whole : none);
    high = high < whole ? high : whole;
    high = below_far > 0 ? high : (far > 0 ? whole : none);
    high = far < crossing ? high : whole;
    const Reals along = x * cosine - y * sine;
    const Reals depth = y * cosine + x * sine;
    // Seen from above the side, the source is not at its end but for rounding: where the side is
    // as short as that, the window came there by rounding.
    const Reals run = along > 0 ? along : -along;
    const Flags comes =
        (near < crossing) & (low < high) & (depth >= -tolerance::kOnUnfoldedLine * run);

    const Reals beyond_y = depth > 0 ? depth : none;
    const Reals beyond_x = edge_shift + edge_sign * along;
    const Reals begin = side.flipped ? length - high : low;
    const Reals end = side.flipped ? length - low : high;
    Reals ray_begin, ray_end;
    const Reals to_begin = begin - beyond_x;
    const Reals to_end = end - beyond_x;
    Lane::root(ray_begin, to_begin * to_begin + beyond_y * beyond_y);
    Lane::root(ray_end, to_end * to_end + beyond_y * beyond_y);
    const Reals at_begin = offset + ray_begin;
    const Reals at_end = offset + ray_end;
    Reals least = at_begin < at_end ? at_begin : at_end;
    Lane::choose(least, (beyond_x > begin) & (beyond_x < end), offset + beyond_y, least);

    // As in clip_at_ends and too_narrow: nothing to cut.
    const Reals rays = ray_begin + ray_end;
    const Reals scale = rays < whole ? rays : whole;
    const Reals to_head = length - end;
    const Flags clear = (side.at_tail + end > at_end) &
                        (side.at_head + (length - begin) > at_begin) &
                        (side.at_tail + begin >= at_begin * (1 - tolerance::kSameDistance)) &
                        (side.at_head + to_head >= at_end * (1 - tolerance::kSameDistance)) &
                        (end - begin > tolerance::kLeastWidth * scale) &
                        (least < side.upper_bound) & (least <= side.max);
    Flags passes;
    Lane::choose(passes, clear, Flags{} + kWhole, Flags{} + kDoubtful);
    passes &= comes;

    write(beyond.begin.data() + i, begin);
    write(beyond.end.data() + i, end);
    write(beyond.x.data() + i, beyond_x);
    write(beyond.y.data() + i, beyond_y);
    write(beyond.at_begin.data() + i, at_begin);
    write(beyond.at_end.data() + i, at_end);
    write(beyond.least.data() + i, least);
    std::memcpy(beyond.passes.data() + i, &passes, sizeof passes);
  }
}

template <std::size_t kWide>
GEODESIC_LANES_INLINE void pair(std::size_t first, std::size_t last, bool upwards, double length,
                                PropagatedWindows& beyond, EquidistantPoints& equidistant) {
  using Lane = lanes::Lanes<kWide>;
  using Reals = typename Lane::Reals;
  using Flags = typename Lane::Flags;
  const double touch = tolerance::kTouch * length;
  // Windows i and i + 1, or i + 1 and i, the way that they lie on the edge.
  const std::size_t to_left = upwards ? 0 : 1;
  const std::size_t to_right = upwards ? 1 : 0;
  for (std::size_t i = first; i + 1 < last; i += kWide) {
    Reals left_begin, left_end, right_begin, right_end;
    Flags left_passes, right_passes;
    read(left_begin, beyond.begin.data() + i + to_left);
    read(left_end, beyond.end.data() + i + to_left);
    read(right_begin, beyond.begin.data() + i + to_right);
    read(right_end, beyond.end.data() + i + to_right);
    std::memcpy(&left_passes, beyond.passes.data() + i + to_left, sizeof left_passes);
    std::memcpy(&right_passes, beyond.passes.data() + i + to_right, sizeof right_passes);
    const Flags overlap = (left_passes == kWhole) & (right_passes == kWhole) &
                          (left_end > right_begin + touch) & (left_begin < right_begin) &
                          (left_end < right_end);
    std::memcpy(beyond.overlaps.data() + i + 1, &overlap, sizeof overlap);
  }
  beyond.overlaps[first] = 0;
  beyond.overlaps[last] = 0;
  std::size_t size = equidistant.size;
  std::uint32_t* const left = equidistant.left.data();
  std::uint32_t* const right = equidistant.right.data();
  std::uint32_t* const pairs = beyond.pair.data();
  const std::int64_t* const overlaps = beyond.overlaps.data();
  for (std::size_t i = first; i + 1 < last; ++i) {
    // Without a branch: which of them overlap is anybody's guess.
    left[size] = static_cast<std::uint32_t>(i + to_left);
    right[size] = static_cast<std::uint32_t>(i + to_right);
    pairs[i + 1] = static_cast<std::uint32_t>(size);
    size += static_cast<std::size_t>(overlaps[i + 1] & 1);
  }
  equidistant.size = size;
}

// Over an overlap, which is short against the distances, the difference of two distances is
// nearly straight: a secant or two mostly meet the place where it is nought. Where they come
// from the same side again and again, the other end counts for half (the Illinois rule: Dowell
// and Jarratt 1971).
template <std::size_t kWide>
GEODESIC_LANES_INLINE void meet(const EnteringWindows& entering, const PropagatedWindows& beyond,
                                EquidistantPoints& equidistant) {
  using Lane = lanes::Lanes<kWide>;
  using Reals = typename Lane::Reals;
  using Flags = typename Lane::Flags;
  constexpr int kSecants = 8;
  for (std::size_t i = 0; i < equidistant.size; i += kWide) {
    Reals ax, ay, a_offset, bx, by, b_offset, low, high, at_high_a, at_low_b;
    for (std::size_t lane = 0; lane < kWide; ++lane) {
      const std::uint32_t a = equidistant.left[i + lane];
      const std::uint32_t b = equidistant.right[i + lane];
      ax[lane] = beyond.x[a];
      ay[lane] = beyond.y[a];
      a_offset[lane] = entering.offset[a];
      bx[lane] = beyond.x[b];
      by[lane] = beyond.y[b];
      b_offset[lane] = entering.offset[b];
      low[lane] = beyond.begin[b];
      high[lane] = beyond.end[a];
      at_low_b[lane] = beyond.at_begin[b];
      at_high_a[lane] = beyond.at_end[a];
    }
    const Reals ay2 = ay * ay;
    const Reals by2 = by * by;
    Reals ray_low_a, ray_high_b;
    Lane::root(ray_low_a, (low - ax) * (low - ax) + ay2);
    Lane::root(ray_high_b, (high - bx) * (high - bx) + by2);
    const Reals at_low_a = a_offset + ray_low_a;
    const Reals at_high_b = b_offset + ray_high_b;
    const Reals rounding = tolerance::kSameDistance * at_high_a;
    const Reals enough = 0.1 * rounding;
    Reals g_left = at_low_b - at_low_a;
    Reals g_right = at_high_b - at_high_a;
    const Flags crosses = (g_left > rounding) & (g_right < -rounding);
    // One of them nowhere nearer: by the signs of the slopes of the difference it is not so
    // in the middle either.
    const Reals slope_low = (low - bx) * ray_low_a - (low - ax) * (at_low_b - b_offset);
    const Reals slope_high = (high - bx) * (at_high_a - a_offset) - (high - ax) * ray_high_b;
    const Flags only_a =
        (g_left >= -rounding) & (g_right >= -rounding) & ~((slope_low < 0) & (slope_high > 0));
    const Flags only_b =
        (g_left < -rounding) & (g_right <= rounding) & ~((slope_low > 0) & (slope_high < 0));
    Reals left = low;
    Reals right = high;
    Reals place{}, at_a{}, at_b{}, end_at_a, end_at_b;
    Flags found{};
    Flags was_left{};
    Flags was_right{};
    for (int secant = 0; secant < kSecants; ++secant) {
      const Reals next = left + (right - left) * (g_left / (g_left - g_right));
      Reals ray_a, ray_b;
      Lane::root(ray_a, (next - ax) * (next - ax) + ay2);
      Lane::root(ray_b, (next - bx) * (next - bx) + by2);
      const Reals next_at_a = a_offset + ray_a;
      const Reals next_at_b = b_offset + ray_b;
      Lane::choose(place, found, place, next);
      Lane::choose(at_a, found, at_a, next_at_a);
      Lane::choose(at_b, found, at_b, next_at_b);
      const Reals g = next_at_b - next_at_a;
      found = found | ((g <= enough) & (g >= -enough));
      if (!Lane::any(crosses & ~found)) break;
      const Flags on_left = g > 0;
      const Flags on_right = ~on_left;
      Lane::choose(left, on_left, next, left);
      Lane::choose(right, on_right, next, right);
      Lane::choose(g_left, on_right & was_right, 0.5 * g_left, g_left);
      Lane::choose(g_left, on_left, g, g_left);
      Lane::choose(g_right, on_left & was_left, 0.5 * g_right, g_right);
      Lane::choose(g_right, on_right, g, g_right);
      was_left = on_left;
      was_right = on_right;
    }
    Lane::choose(low, only_a, high, low);
    Lane::choose(place, crosses, place, low);
    Lane::choose(end_at_a, only_a, at_high_a, at_low_a);
    Lane::choose(at_a, crosses, at_a, end_at_a);
    Lane::choose(end_at_b, only_a, at_high_b, at_low_b);
    Lane::choose(at_b, crosses, at_b, end_at_b);
    found = (found & crosses) | only_a | only_b;
    write(equidistant.place.data() + i, place);
    write(equidistant.at_left.data() + i, at_a);
    write(equidistant.at_right.data() + i, at_b);
    std::memcpy(equidistant.found.data() + i, &found, sizeof found);
  }
}

std::size_t crossings_plain(EnteringWindows& entering, std::size_t first, std::size_t last,
                            double x, double y, double base) {
  return crossings<lanes::kPlain>(entering, first, last, x, y, base);
}
void to_side_plain(const EnteringWindows& entering, std::size_t first, std::size_t last,
                   const SideFrame& side, PropagatedWindows& beyond) {
  to_side<lanes::kPlain>(entering, first, last, side, beyond);
}
void pair_plain(std::size_t first, std::size_t last, bool upwards, double length,
                PropagatedWindows& beyond, EquidistantPoints& equidistant) {
  pair<lanes::kPlain>(first, last, upwards, length, beyond, equidistant);
}
void meet_plain(const EnteringWindows& entering, const PropagatedWindows& beyond,
                EquidistantPoints& equidistant) {
  meet<lanes::kPlain>(entering, beyond, equidistant);
}

#ifdef __x86_64__
__attribute__((target("avx2"))) std::size_t crossings_avx2(EnteringWindows& entering,
                                                           std::size_t first, std::size_t last,
                                                           double x, double y, double base) {
  return crossings<lanes::kWithAvx2>(entering, first, last, x, y, base);
}
__attribute__((target("avx2"))) void to_side_avx2(const EnteringWindows& entering,
                                                  std::size_t first, std::size_t last,
                                                  const SideFrame& side,
                                                  PropagatedWindows& beyond) {
  to_side<lanes::kWithAvx2>(entering, first, last, side, beyond);
}
__attribute__((target("avx2"))) void pair_avx2(std::size_t first, std::size_t last, bool upwards,
                                               double length, PropagatedWindows& beyond,
                                               EquidistantPoints& equidistant) {
  pair<lanes::kWithAvx2>(first, last, upwards, length, beyond, equidistant);
}
__attribute__((target("avx2"))) void meet_avx2(const EnteringWindows& entering,
                                               const PropagatedWindows& beyond,
                                               EquidistantPoints& equidistant) {
  meet<lanes::kWithAvx2>(entering, beyond, equidistant);
}
#endif

}  // namespace

std::size_t find_crossings(Vectors vectors, EnteringWindows& entering, std::size_t first,
                           std::size_t last, double x, double y, double base_length) {
#ifdef __x86_64__
  if (vectors != Vectors::plain) return crossings_avx2(entering, first, last, x, y, base_length);
#endif
  (void)vectors;
  return crossings_plain(entering, first, last, x, y, base_length);
}

void cross_to_side(Vectors vectors, const EnteringWindows& entering, std::size_t first,
                   std::size_t last, const SideFrame& side, PropagatedWindows& beyond) {
#ifdef __x86_64__
  if (vectors != Vectors::plain) return to_side_avx2(entering, first, last, side, beyond);
#endif
  (void)vectors;
  to_side_plain(entering, first, last, side, beyond);
}

void pair_overlaps(Vectors vectors, std::size_t first, std::size_t last, bool upwards,
                   double length, PropagatedWindows& beyond, EquidistantPoints& equidistant) {
#ifdef __x86_64__
  if (vectors != Vectors::plain) {
    return pair_avx2(first, last, upwards, length, beyond, equidistant);
  }
#endif
  (void)vectors;
  pair_plain(first, last, upwards, length, beyond, equidistant);
}

void find_equidistant_points(Vectors vectors, const EnteringWindows& entering,
                             const PropagatedWindows& beyond, EquidistantPoints& equidistant) {
#ifdef __x86_64__
  if (vectors != Vectors::plain) return meet_avx2(entering, beyond, equidistant);
#endif
  (void)vectors;
  meet_plain(entering, beyond, equidistant);
}

}  // namespace geodesic::exact
