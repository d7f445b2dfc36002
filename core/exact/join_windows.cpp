// The third part of sending out: what has crossed the side of a face becomes a list for its edge.
#include <algorithm>
#include <cmath>

#include "core/base/tolerances.h"
#include "core/exact/domain.h"

namespace geodesic::exact {
namespace {

// Of a list that comes to an edge, so many without a question.
constexpr std::size_t kPlainAtOnce = 1024;

}  // namespace

// The propagated windows of a list, for the edge that they come to.
void Domain::hand_on(const ListOverSide& list) {
  PropagatedOrder order{list.first, list.last, list.upwards};
  FreshList fresh{&memory_.sent_windows, memory_.sent, 0, kUnreached};
  for (;;) {
    const bool is_plain = add_plain(list, order, fresh);
    if (poll_->stopped()) return;
    if (order.left() == 0) break;
    if (is_plain) {
      if (cancelled_after(kPlainAtOnce)) return;
      continue;
    }
    add_with_care(list, order, fresh);
    // What it overlapped has been taken apart, and room is made anew for those to come.
    if (cancelled_after(memory_.scratch.size() + std::min(order.left(), kPlainAtOnce))) return;
  }
  hand_list(list.side.edge, 4 * std::uint64_t{list.side.from} + (list.on_right ? 1 : 0), fresh);
}

// Adds windows in the order on the edge, as long as they can be trimmed to those before:
// nearly all of them can, and most come whole and meet none but the one before. False at one that
// cannot; true after some, or the last.
bool Domain::add_plain(const ListOverSide& list, PropagatedOrder& order, FreshList& fresh) {
  const Side& side = list.side;
  const std::size_t count = std::min(order.left(), kPlainAtOnce);
  const std::size_t most = fresh.first + fresh.size + count;
  if (fresh.list->size() < most) {
    if (!may_hold(*fresh.list, most)) return false;
    fresh.list->resize(most);
  }
  const PropagatedWindows& beyond = memory_.beyond[list.on_right];
  const EquidistantPoints& equidistant = memory_.equidistant[list.on_right];
  const double* const begins = beyond.begin.data();
  const double* const ends = beyond.end.data();
  const double* const xs = beyond.x.data();
  const double* const ys = beyond.y.data();
  const double* const at_begins = beyond.at_begin.data();
  const double* const at_ends = beyond.at_end.data();
  const double* const leasts = beyond.least.data();
  const std::int64_t* const passes = beyond.passes.data();
  const std::int64_t* const overlaps = beyond.overlaps.data();
  const std::uint32_t* const pseudo_sources = memory_.entering.pseudo_source.data();
  const std::uint32_t* const faces = memory_.entering.faces.data();
  const double touch = tolerance::kTouch * side.length;
  const double narrow = tolerance::kLeastWidth * side.length;
  const double nearly = tolerance::kNearlyTouch * side.length;
  const std::size_t step = order.upwards ? 1 : static_cast<std::size_t>(-1);
  // The one before a window on the edge is numbered before it, or it before that one.
  const std::size_t to_pair = order.upwards ? 0 : 1;
  std::size_t i = order.next();
  std::size_t left = count;
  double least = fresh.least;
  Window* const begin = fresh.list->data() + fresh.first;
  Window* out = begin + fresh.size;
  double reached = out == begin ? -kUnreached : out[-1].end;
  double last_x = out == begin ? 0 : out[-1].x;
  std::uint32_t last_pseudo_source = out == begin ? kNone : out[-1].pseudo_source;
  for (; left > 0; --left, i += step) {
    if (passes[i] == kMisses) continue;
    const bool whole = passes[i] == kWhole;
    double from = begins[i];
    double at_from = at_begins[i];
    const bool maybe_same =
        (static_cast<int>(last_pseudo_source == pseudo_sources[i]) &
         static_cast<int>(std::abs(xs[i] - last_x) <= tolerance::kNearSource * at_from) &
         static_cast<int>(std::abs(from - reached) <= nearly)) != 0;
    if (whole && maybe_same && reached == ends[i - step] &&
        is_as_good(out[-1], from, ends[i], at_from, at_ends[i], memory_.entering.offset[i])) {
      reached = out[-1].end = ends[i];
      out[-1].at_end = at_ends[i];
      out[-1].faces = std::max(out[-1].faces, faces[i] + 1);
      least = std::min(least, leasts[i]);
      continue;
    }
    if (out != begin && overlaps[i + to_pair] != 0) {
      const std::size_t pair = beyond.pair[i + to_pair];
      const double place = equidistant.place[pair];
      const bool clear = equidistant.found[pair] != 0 && reached == ends[i - step] &&
                         place - out[-1].begin > narrow && ends[i] - place > narrow;
      if (clear) {
        out[-1].end = reached = place;
        out[-1].at_end = equidistant.at_left[pair];
        from = place;
        at_from = equidistant.at_right[pair];
      }
    }
    out->begin = from;
    out->end = ends[i];
    out->x = xs[i];
    out->y = ys[i];
    out->at_begin = at_from;
    out->at_end = at_ends[i];
    out->pseudo_source = pseudo_sources[i];
    out->from = side.from;
    out->faces = faces[i] + 1;
    out->propagated = false;
    double least_here = leasts[i];
    if (!whole) {
      if (!is_of_use(*out, side)) continue;
      least_here = out->least(memory_.entering.offset[i]);
    }
    if (!(reached <= out->begin + touch)) {
      const Trimming trimming = trim_last(begin, out, side.length);
      if (trimming == Trimming::not_plain) break;
      if (trimming == Trimming::fresh_gone) {
        reached = out[-1].end;
        continue;
      }
    }
    ++out;
    last_pseudo_source = pseudo_sources[i];
    last_x = xs[i];
    reached = out[-1].end;
    least = std::min(least, least_here);
  }
  order.skip(count - left);
  fresh.size = static_cast<std::size_t>(out - begin);
  fresh.least = least;
  return left == 0;
}

// Trims the last of the windows from `first` on, which is not counted in yet, to those before
// it that it overlaps.
Trimming Domain::trim_last(Window* first, Window*& last, double length) {
  Window* before = last;
  Trimming trimming = Trimming::old_gone;
  while (trimming == Trimming::old_gone && before != first && before[-1].end > last->begin) {
    trimming = trim(before[-1], *last, true, pseudo_sources(), length);
    if (trimming == Trimming::old_gone) --before;
  }
  if (before != last) {
    *before = *last;
    last = before;
  }
  return trimming;
}

// Adds the next window, whatever is the matter with it. From the first such on, a list grows apart
// from those that are sent already.
void Domain::add_with_care(const ListOverSide& list, PropagatedOrder& order, FreshList& fresh) {
  const Side& side = list.side;
  const PropagatedWindows& beyond = memory_.beyond[list.on_right];
  const std::size_t i = order.next();
  order.skip(1);
  Window window{beyond.begin[i],
                beyond.end[i],
                beyond.x[i],
                beyond.y[i],
                beyond.at_begin[i],
                beyond.at_end[i],
                memory_.entering.pseudo_source[i],
                side.from,
                memory_.entering.faces[i] + 1,
                false};
  if (beyond.passes[i] != kWhole && !is_of_use(window, side)) return;
  fresh.least = std::min(fresh.least, window.least(memory_.entering.offset[i]));
  std::vector<Window>& apart = memory_.fresh;
  if (fresh.list != &apart) {
    const auto begin = fresh.list->begin() + static_cast<std::ptrdiff_t>(fresh.first);
    apart.assign(begin, begin + static_cast<std::ptrdiff_t>(fresh.size));
    fresh.list = &apart;
    fresh.first = 0;
  }
  apart.resize(fresh.size);
  memory_.scratch.clear();
  append(apart, window, pseudo_sources(), side.length, memory_.scratch);
  fresh.size = apart.size();
}

// A side of a face, for windows counted from the halfedge's tail or from its head.
Side Domain::side(Halfedge h, bool from_tail) const {
  const std::uint32_t e = frames().edge_of(h);
  const Edge& edge = state_.edges[e];
  return {h,
          e,
          frames().is_reversed(h) == from_tail,
          edge.on_boundary(),
          edge.length,
          state_.distance[edge.tail],
          state_.distance[edge.head],
          edge.upper_bound};
}

// Whether something of a window that comes over a side is nearer than other ways; clips it.
bool Domain::is_of_use(Window& window, const Side& side) const {
  const double offset = pseudo_sources()[window.pseudo_source].offset;
  if (!clip_at_ends(window, offset, side.length, side.at_tail, side.at_head)) return false;
  const double least = window.least(offset);
  return least < side.upper_bound && least <= state_.max;
}

// To the domain of the edge.
void Domain::hand_list(std::uint32_t e, std::uint64_t order, const FreshList& fresh) {
  if (fresh.size == 0) return;
  std::vector<Window>& sent = memory_.sent_windows;
  if (fresh.list != &sent) {
    const std::size_t most = memory_.sent + fresh.size;
    if (sent.size() < most) {
      if (!may_hold(sent, most)) return;
      sent.resize(most);
    }
    const auto begin = fresh.list->begin() + static_cast<std::ptrdiff_t>(fresh.first);
    std::copy_n(begin, fresh.size, sent.begin() + static_cast<std::ptrdiff_t>(memory_.sent));
  }
  add(memory_.lists_for[state_.domain_of_edge(e)],
      HandedList{e, 0, order, memory_.sent, fresh.size, fresh.least});
  memory_.sent += fresh.size;
}

// To the domain of the vertex.
void Domain::hand_way(std::uint32_t v, double distance, const ArrivalAtVertex& arrival) {
  if (!(distance <= state_.distance[v]) || distance > state_.max) return;
  add(memory_.ways_for[state_.domain_of_vertex(v)], HandedWay{v, distance, arrival});
}

}  // namespace geodesic::exact
