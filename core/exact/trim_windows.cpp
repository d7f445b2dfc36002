#include "core/exact/trim_windows.h"

#include <algorithm>

#include "core/exact/window_comparison.h"

namespace geodesic::exact {
namespace {

void begin_at(Window& window, double place, double distance) {
  window.begin = place;
  window.at_begin = distance;
}

void end_at(Window& window, double place, double distance) {
  window.end = place;
  window.at_end = distance;
}

}  // namespace

Seam sew(Window& old, Window& fresh, bool fresh_ends, PseudoSources roots, double length) {
  const double low = std::max(old.begin, fresh.begin);
  const double high = std::min(old.end, fresh.end);
  const double offset_old = roots[old.root].offset;
  const double offset_fresh = roots[fresh.root].offset;
  const double at_low_old = low == old.begin ? old.at_begin : old.at(low, offset_old);
  const double at_high_old = high == old.end ? old.at_end : old.at(high, offset_old);
  const double at_low_fresh = low == fresh.begin ? fresh.at_begin : fresh.at(low, offset_fresh);
  const double at_high_fresh = high == fresh.end ? fresh.at_end : fresh.at(high, offset_fresh);
  const Duel duel{old,
                  fresh,
                  offset_old,
                  offset_fresh,
                  low,
                  high,
                  at_low_old,
                  at_high_old,
                  at_low_fresh,
                  at_high_fresh,
                  kTie * std::max(at_low_old, at_high_old)};
  const double g_low = at_low_fresh - at_low_old;
  const double g_high = at_high_fresh - at_high_old;
  // Whether the window has no more to it than the overlap on the other one's side.
  const bool old_ends_here = fresh_ends ? high == old.end : low == old.begin;
  const bool fresh_ends_here = fresh_ends ? low == fresh.begin : high == fresh.end;
  Roots inside{};
  if (g_low >= -duel.tie && g_high >= -duel.tie) {
    if (!fresh_ends_here || wins_inside(duel, 1, inside)) return Seam::not_plain;
    if (fresh_ends) {
      begin_at(fresh, high, at_high_fresh);
    } else {
      end_at(fresh, low, at_low_fresh);
    }
  } else if (g_low <= duel.tie && g_high <= duel.tie) {
    if (!old_ends_here || wins_inside(duel, -1, inside)) return Seam::not_plain;
    if (fresh_ends) {
      end_at(old, low, at_low_old);
    } else {
      begin_at(old, high, at_high_old);
    }
  } else {
    if (!old_ends_here || !fresh_ends_here || (g_low > 0) != fresh_ends) return Seam::not_plain;
    const auto [place, at_old, at_fresh] = find_tie(duel, low, high, g_low, g_high);
    if (fresh_ends) {
      end_at(old, place, at_old);
      begin_at(fresh, place, at_fresh);
    } else {
      begin_at(old, place, at_old);
      end_at(fresh, place, at_fresh);
    }
  }
  if (too_narrow(fresh, length, offset_fresh)) return Seam::fresh_gone;
  return too_narrow(old, length, offset_old) ? Seam::old_gone : Seam::cut;
}

Sewn sew(std::span<Window> old, std::span<Window> fresh, PseudoSources roots, double length) {
  const double touch = kTouch * length;
  const bool ends = fresh.front().begin >= old.front().begin && fresh.back().end >= old.back().end;
  const bool begins =
      fresh.front().begin <= old.front().begin && fresh.back().end <= old.back().end;
  Sewn sewn{old, fresh, ends, ends || begins};
  while (sewn.plain && !sewn.old.empty() && !sewn.fresh.empty()) {
    Window& was = ends ? sewn.old.back() : sewn.old.front();
    Window& came = ends ? sewn.fresh.front() : sewn.fresh.back();
    if (ends && was.end <= came.begin + touch) {
      came.begin = std::max(came.begin, was.end);
      break;
    }
    if (!ends && came.end <= was.begin + touch) {
      came.end = std::min(came.end, was.begin);
      break;
    }
    const Seam seam = sew(was, came, ends, roots, length);
    sewn.plain = seam != Seam::not_plain;
    if (seam == Seam::old_gone) {
      sewn.old = ends ? sewn.old.first(sewn.old.size() - 1) : sewn.old.subspan(1);
    } else if (seam == Seam::fresh_gone) {
      sewn.fresh = ends ? sewn.fresh.subspan(1) : sewn.fresh.first(sewn.fresh.size() - 1);
    }
  }
  return sewn;
}

}  // namespace geodesic::exact
