// The lower envelope of windows on one edge: sorted, not overlapping, at each place
// the nearest of all that have arrived. No shortest path lies outside it, so what it
// drops need not be passed on (Mitchell, Mount and Papadimitriou 1987, section 4.2).
//
// Epsilons are parts of a distance or of an edge's length, never lengths. A window
// must be nearer by more than rounding to take a place from another: of equally near ones it goes
// to the one that was there, so the same distance coming round again ends there.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "core/base/tolerances.h"
#include "core/windows/window.h"

namespace geodesic::exact {

using PseudoSources = std::span<const PseudoSource>;

// Near a source rays may be so short that a window on a long edge is not too narrow for them, and
// yet narrower than an overlap must be to count. It would lie over others and find a place each
// time that it comes round, and with the windows that it sends out the lists would grow for ever.
// Its place on the edge says no more than rounding.
[[nodiscard]] inline bool is_within_rounding(const Window& window, double length) {
  return !(window.end - window.begin > 4 * tolerance::kTouch * length);
}

// Whether the window is too narrow to matter on an edge of this length.
[[nodiscard]] inline bool too_narrow(const Window& window, double length, double offset) {
  const double rays = window.at_begin - offset + (window.at_end - offset);
  return !(window.end - window.begin > tolerance::kLeastWidth * std::min(length, rays)) ||
         is_within_rounding(window, length);
}

// By how much a fresh window must be nearer than an old one to take its place, where that has so
// much of a distance. One that has crossed more faces from the same pseudo-source has gone round
// something: where that is thin, rounding alone makes each round seem nearer.
[[nodiscard]] inline double rounding_of(const Window& old, const Window& fresh, double distance) {
  const bool goes_round = old.pseudo_source == fresh.pseudo_source && fresh.faces > old.faces;
  return (goes_round ? tolerance::kWindows : tolerance::kSameDistance) * distance;
}

// Whether two windows are one, cut in two by a vertex that it passed on
// one side and on the other.
[[nodiscard]] inline bool is_continued_by(const Window& left, const Window& right, double offset,
                                          double length) {
  if (left.pseudo_source != right.pseudo_source || left.from != right.from ||
      left.propagated != right.propagated) {
    return false;
  }
  if (std::abs(right.begin - left.end) > tolerance::kTouch * length) return false;
  const double same = tolerance::kSameSource * (left.at_end - offset);
  return std::abs(left.x - right.x) <= same && std::abs(left.y - right.y) <= same;
}

// Whether a line from the left window's source is as good as the right one's own over its
// interval, which begins where the left one ends: as where a vertex that it passed on both
// sides is flat but for rounding. In first order the distances' difference depends on
// nothing but a ray's direction, so it does not grow on the way.
[[nodiscard]] inline bool is_as_good(const Window& left, double begin, double end, double at_begin,
                                     double at_end, double offset) {
  const double y2 = left.y * left.y;
  const double to_begin = begin - left.x;
  const double to_end = end - left.x;
  return std::abs(offset + std::sqrt(to_begin * to_begin + y2) - at_begin) <=
             tolerance::kSameDistance * at_begin &&
         std::abs(offset + std::sqrt(to_end * to_end + y2) - at_end) <=
             tolerance::kSameDistance * at_end;
}

// Cuts off what is nearer along the edge from its tail or its head, as far as that
// is so for all of the interval's beginning or end.
void cut_begin(Window& window, double offset, double along_edge);
void cut_end(Window& window, double offset, double along_edge);

// Leaves of a window what is not nearer along the edge from one of its ends, given the
// ends' distances, which must be lengths of real ways. Surazhsky et al. 2005, section
// 3.3; Xin and Wang 2009, section 3.2. False when nothing is left.
[[nodiscard]] inline bool clip_at_ends(Window& window, double offset, double length, double at_tail,
                                       double at_head) {
  if (at_tail + window.end <= window.at_end) return false;
  if (at_head + (length - window.begin) <= window.at_begin) return false;
  const double by_tail = at_tail + window.begin;
  if (by_tail < window.at_begin * (1 - tolerance::kSameDistance))
    cut_begin(window, offset, by_tail);
  const double by_head = at_head + (length - window.end);
  if (by_head < window.at_end * (1 - tolerance::kSameDistance)) cut_end(window, offset, by_head);
  return !too_narrow(window, length, offset);
}

// Adds a window to a list that it overlaps; see append.
void append_overlapping(std::vector<Window>& list, const Window& window,
                        PseudoSources pseudo_sources, double length, std::vector<Window>& scratch);

// Adds a window to a list of windows that do not overlap. Any order is right; fast is
// the order in which they lie on the edge.
inline void append(std::vector<Window>& list, const Window& window, PseudoSources pseudo_sources,
                   double length, std::vector<Window>& scratch) {
  if (!list.empty()) {
    if (list.back().end > window.begin + tolerance::kTouch * length) {
      append_overlapping(list, window, pseudo_sources, length, scratch);
      return;
    }
    if (is_continued_by(list.back(), window, pseudo_sources[window.pseudo_source].offset, length)) {
      list.back().end = window.end;
      list.back().at_end = window.at_end;
      list.back().faces = std::max(list.back().faces, window.faces);
      return;
    }
  }
  list.push_back(window);
}

// Writes the lower envelope of two lists to `merged`, behind what is there already. In a
// equally near ones those of `old` stay.
void append_merged(std::span<const Window> old, std::span<const Window> fresh,
                   PseudoSources pseudo_sources, double length, std::vector<Window>& merged);

// The same into an empty list.
inline void merge(std::span<const Window> old, std::span<const Window> fresh,
                  PseudoSources pseudo_sources, double length, std::vector<Window>& merged) {
  merged.clear();
  append_merged(old, fresh, pseudo_sources, length, merged);
}

}  // namespace geodesic::exact
