#include "core/windows/trim_windows.h"

#include <algorithm>

#include "core/base/tolerances.h"
#include "core/windows/window_comparison.h"

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

Trimming trim(Window& old, Window& fresh, bool fresh_ends, PseudoSources pseudo_sources,
              double length) {
  const double low = std::max(old.begin, fresh.begin);
  const double high = std::min(old.end, fresh.end);
  const double offset_old = pseudo_sources[old.pseudo_source].offset;
  const double offset_fresh = pseudo_sources[fresh.pseudo_source].offset;
  const double at_low_old = low == old.begin ? old.at_begin : old.at(low, offset_old);
  const double at_high_old = high == old.end ? old.at_end : old.at(high, offset_old);
  const double at_low_fresh = low == fresh.begin ? fresh.at_begin : fresh.at(low, offset_fresh);
  const double at_high_fresh = high == fresh.end ? fresh.at_end : fresh.at(high, offset_fresh);
  const WindowComparison comparison{old,
                                    fresh,
                                    offset_old,
                                    offset_fresh,
                                    low,
                                    high,
                                    at_low_old,
                                    at_high_old,
                                    at_low_fresh,
                                    at_high_fresh,
                                    rounding_of(old, fresh, std::max(at_low_old, at_high_old))};
  const double g_low = at_low_fresh - at_low_old;
  const double g_high = at_high_fresh - at_high_old;
  // Whether the window has no more to it than the overlap on the other one's side.
  const bool old_ends_here = fresh_ends ? high == old.end : low == old.begin;
  const bool fresh_ends_here = fresh_ends ? low == fresh.begin : high == fresh.end;
  TwoPlaces inside{};
  if (g_low >= -comparison.rounding && g_high >= -comparison.rounding) {
    if (!fresh_ends_here || is_nearer_inside(comparison, 1, inside)) return Trimming::not_plain;
    if (fresh_ends) {
      begin_at(fresh, high, at_high_fresh);
    } else {
      end_at(fresh, low, at_low_fresh);
    }
  } else if (g_low <= comparison.rounding && g_high <= comparison.rounding) {
    if (!old_ends_here || is_nearer_inside(comparison, -1, inside)) return Trimming::not_plain;
    if (fresh_ends) {
      end_at(old, low, at_low_old);
    } else {
      begin_at(old, high, at_high_old);
    }
  } else {
    if (!old_ends_here || !fresh_ends_here || (g_low > 0) != fresh_ends) return Trimming::not_plain;
    const auto [place, at_old, at_fresh] =
        find_equidistant_point(comparison, low, high, g_low, g_high);
    if (fresh_ends) {
      end_at(old, place, at_old);
      begin_at(fresh, place, at_fresh);
    } else {
      begin_at(old, place, at_old);
      end_at(fresh, place, at_fresh);
    }
  }
  if (too_narrow(fresh, length, offset_fresh)) return Trimming::fresh_gone;
  return too_narrow(old, length, offset_old) ? Trimming::old_gone : Trimming::cut;
}

Trimmed trim(std::span<Window> old, std::span<Window> fresh, PseudoSources pseudo_sources,
             double length) {
  const double touch = tolerance::kTouch * length;
  const bool ends = fresh.front().begin >= old.front().begin && fresh.back().end >= old.back().end;
  const bool begins =
      fresh.front().begin <= old.front().begin && fresh.back().end <= old.back().end;
  Trimmed trimmed{old, fresh, ends, ends || begins};
  while (trimmed.plain && !trimmed.old.empty() && !trimmed.fresh.empty()) {
    Window& was = ends ? trimmed.old.back() : trimmed.old.front();
    Window& came = ends ? trimmed.fresh.front() : trimmed.fresh.back();
    if (ends && was.end <= came.begin + touch) {
      came.begin = std::max(came.begin, was.end);
      break;
    }
    if (!ends && came.end <= was.begin + touch) {
      came.end = std::min(came.end, was.begin);
      break;
    }
    const Trimming trimming = trim(was, came, ends, pseudo_sources, length);
    trimmed.plain = trimming != Trimming::not_plain;
    if (trimming == Trimming::old_gone) {
      trimmed.old = ends ? trimmed.old.first(trimmed.old.size() - 1) : trimmed.old.subspan(1);
    } else if (trimming == Trimming::fresh_gone) {
      trimmed.fresh =
          ends ? trimmed.fresh.subspan(1) : trimmed.fresh.first(trimmed.fresh.size() - 1);
    }
  }
  return trimmed;
}

}  // namespace geodesic::exact
