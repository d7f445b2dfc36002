#include "core/chen_han/seen.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/base/polled_fill.h"
#include "core/base/tolerances.h"

namespace geodesic::chen_han {
namespace {

// Where a nearer window ends to be nearer, to this many bits of its length.
constexpr int kHalvings = 24;

// In heaps of faces along a line all windows are as near as each other, and would double with each
// face. Such an edge has more than this many before the last one.
constexpr std::uint32_t kCrowd = 16;

// Comparisons of windows of branched strips: about half a second for 200 faces.
constexpr std::uint64_t kComparisons = 10'000'000;
constexpr std::uint64_t kComparisonsOfFace = 50'000;

}  // namespace

void SeenWindows::reset(const Adjacency& adjacency, Poll& poll) {
  const std::size_t count = 4 * adjacency.faces().size();
  windows_.clear();
  compared_ = 0;
  most_compared_ = kComparisons + kComparisonsOfFace * adjacency.faces().size();
  polled_assign(first_, count, kNone, poll);
  constexpr std::uint64_t kNotYet = ~std::uint64_t{0};
  polled_assign(frames_, count, kNotYet, poll);
  for (Halfedge least = 0; least < count && !poll.cancelled(); ++least) {
    if (corner_of(least) > 2 || frames_[least] != kNotYet) continue;
    const std::uint32_t tail = adjacency.face(face_of(least)).vertex[corner_of(least)];
    Halfedge h = least;
    do {
      const bool same_way = adjacency.face(face_of(h)).vertex[corner_of(h)] == tail;
      frames_[h] = (std::uint64_t{least} << 1U) | (same_way ? 0U : 1U);
      h = adjacency.ring(h);
    } while (h != least && !poll.cancelled());
  }
}

bool SeenWindows::cut_where_nearer(const Seen& seen, bool may_be_equal, Window& window,
                                   double base) {
  const double narrow = tolerance::kLeastWidth * base;
  const double begin = std::max(seen.begin, window.begin);
  const double end = std::min(seen.end, window.end);
  const bool from_begin = begin <= window.begin + narrow;
  const bool to_end = end >= window.end - narrow;
  // At the window's own ends as near will do: there both may pass a vertex, from which on one of
  // them falls behind. Where thin faces meet in a vertex, windows go round it hundreds of times, a
  // little farther each time, but for that end.
  const auto nearer_between = [&](double a, double b) {
    if (may_be_equal) return as_near_along(seen.x, seen.y, seen.offset, window, a, b);
    return nearer_along(seen.x, seen.y, seen.offset, window, a, b, from_begin && a == window.begin,
                        to_end && b == window.end);
  };
  if (from_begin && to_end && nearer_between(window.begin, window.end)) return false;
  // The longest stretch from `fixed` towards `far`, found from below.
  const auto stretch = [&](double fixed, double far) {
    double good = fixed;
    double bad = far;
    if (clearly_less(window.at(fixed), seen.offset + length(fixed - seen.x, seen.y))) return fixed;
    if (nearer_between(std::min(fixed, far), std::max(fixed, far))) return far;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = 0.5 * (good + bad);
      const bool nearer = nearer_between(std::min(fixed, middle), std::max(fixed, middle));
      (nearer ? good : bad) = middle;
    }
    return good;
  };
  if (from_begin) window.begin = stretch(window.begin, std::min(end, window.end));
  if (to_end) window.end = stretch(window.end, std::max(begin, window.begin));
  return window.begin < window.end;
}

// The ways of `seen` are its straight lines, and outside its interval those from its ends along the
// edge. In a heap of faces about one vertex there are as many windows on an edge as there are
// choices of faces, and each is seen where none of the others is, or a little farther on either
// side.
bool SeenWindows::is_no_farther(const Seen& seen, bool may_be_equal, const Window& window) {
  const auto at = [&](double p) { return seen.offset + length(p - seen.x, seen.y); };
  const double near = std::max(window.begin - window.x, window.x - window.end);
  const bool runs_along = window.y <= tolerance::kAlongEdge * near;
  const auto is_no_farther_at = [&](double p, double end) {
    const double along = at(end) + std::abs(p - end);
    return may_be_equal && runs_along ? !clearly_less(window.at(p), along)
                                      : clearly_less(along, window.at(p));
  };
  if (window.end > seen.end && !is_no_farther_at(window.end, seen.end)) return false;
  if (window.begin < seen.begin && !is_no_farther_at(window.begin, seen.begin)) return false;
  const double begin = std::max(seen.begin, window.begin);
  const double end = std::min(seen.end, window.end);
  if (!(begin < end)) return true;
  return may_be_equal ? as_near_along(seen.x, seen.y, seen.offset, window, begin, end)
                      : nearer_along(seen.x, seen.y, seen.offset, window, begin, end, false, false);
}

bool SeenWindows::trim(Halfedge edge, Window& window, double base, Poll& poll) {
  const double narrow = tolerance::kLeastWidth * base;
  // Rounding moves by more than kSamePlace what is a million edges away.
  const double same =
      std::max(tolerance::kSamePlace * base, tolerance::kSameDistance * window.least());
  // Of two that are as near, the earlier one stays. Not where few have come: what is as near as the
  // way along an edge may be the only one that goes on along the same line.
  const bool is_crowded = first_[edge] != kNone && windows_[first_[edge]].before > kCrowd;
  for (std::uint32_t i = first_[edge]; i != kNone; i = windows_[i].next) {
    if (poll.cancelled()) return false;
    ++compared_;
    const Seen& seen = windows_[i];
    if (i == window.seen) continue;
    const bool is_earlier = i < window.seen;
    const bool may_be_equal = is_earlier && is_crowded;
    if (is_no_farther(seen, may_be_equal, window)) return false;
    if (seen.end <= window.begin || seen.begin >= window.end) continue;
    const bool same_place = std::abs(seen.x - window.x) <= same &&
                            std::abs(seen.y - window.y) <= same &&
                            std::abs(seen.offset - window.offset) <= same;
    if (!same_place) {
      if (!cut_where_nearer(seen, may_be_equal, window, base)) return false;
      continue;
    }
    // Of two that see the same, the earlier one does.
    if (!is_earlier) continue;
    const bool from_begin = seen.begin <= window.begin + narrow;
    const bool to_end = seen.end >= window.end - narrow;
    if (from_begin && to_end) return false;
    if (from_begin) window.begin = seen.end;
    if (to_end) window.end = seen.begin;
  }
  return true;
}

bool SeenWindows::enter(Window& window, double base, Poll& poll) {
  const Frame frame = frame_of(window.into);
  window.seen = static_cast<std::uint32_t>(windows_.size());
  if (frame.mirrored) window.mirror(base);
  if (window.branched != 0 && !trim(frame.edge, window, base, poll)) return false;
  const std::uint32_t last = first_[frame.edge];
  const std::uint32_t before = last == kNone ? 0 : windows_[last].before + 1;
  windows_.push_back({window.begin, window.end, window.x, window.y, window.offset, last, before});
  first_[frame.edge] = window.seen;
  if (frame.mirrored) window.mirror(base);
  return true;
}

bool SeenWindows::trim_again(Window& window, double base, Poll& poll) {
  const Frame frame = frame_of(window.into);
  if (frame.mirrored) window.mirror(base);
  if (!trim(frame.edge, window, base, poll)) return false;
  if (frame.mirrored) window.mirror(base);
  return window.begin < window.end;
}

}  // namespace geodesic::chen_han
