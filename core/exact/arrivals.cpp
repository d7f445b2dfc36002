// What becomes of windows and ways where they arrive: an edge's list takes the fresh ones in,
// gets an upper bound and is let go of in the end, and a vertex keeps the nearest way.
#include <algorithm>
#include <cstring>

#include "core/base/tolerances.h"
#include "core/exact/propagation.h"

namespace geodesic::exact {
// The fresh windows, none of which is nearer than `least`, join what is on the edge.
void Propagation::commit(std::uint32_t e, std::span<Window> fresh, double least) {
  if (fresh.empty()) return;
  Edge& edge = edges_[e];
  fresh = without_narrow(fresh, edge.length);
  if (fresh.empty() || cancelled_after(edge.size)) return;
  if (edge.size == 0) {
    replace(edge, 0, 0, fresh);
  } else {
    const double length = edge.length;
    // Those from `first` to `last` overlap them.
    const double begin = fresh.front().begin + tolerance::kTouch * length;
    const double end = fresh.back().end - tolerance::kTouch * length;
    std::uint32_t first = 0;
    while (first < edge.size && edge.windows[first].end <= begin) ++first;
    std::uint32_t last = edge.size;
    while (last > first && edge.windows[last - 1].begin >= end) --last;
    std::span<const Window> windows = fresh;
    if (first < last) {
      const Trimmed trimmed =
          trim({edge.windows + first, last - first}, fresh, memory_.pseudo_sources, length);
      if (trimmed.plain) {
        windows = trimmed.fresh;
        const auto left = static_cast<std::uint32_t>(trimmed.old.size());
        trimmed.fresh_ends ? first += left : last -= left;
      } else {
        // Each may be cut by each end of those that it meets, and in between.
        if (!may_hold(memory_.scratch, 3 * (trimmed.old.size() + trimmed.fresh.size()))) return;
        merge_in(trimmed.old, trimmed.fresh, length);
        windows = memory_.scratch;
      }
      least = kUnreached;
      for (const Window& w : windows) {
        if (!w.propagated)
          least = std::min(least, w.least(memory_.pseudo_sources[w.pseudo_source].offset));
      }
    }
    replace(edge, first, last, windows);
    join_at(edge, first + static_cast<std::uint32_t>(windows.size()), length);
    join_at(edge, first, length);
  }
  edge.pending = std::min(edge.pending, least);
  if (edge.pending < edge.queued) {
    edge.queued = edge.pending;
    memory_.queue.push({edge.pending, e, Waiting::What::edge});
  }
}

// Without those that are as narrow as rounding. Over faces that are lines windows keep their
// widths, however often they are cut, and come to the same.
std::span<Window> Propagation::without_narrow(std::span<Window> fresh, double length) const {
  const auto end = std::remove_if(fresh.begin(), fresh.end(),
                                  [&](const Window& w) { return is_within_rounding(w, length); });
  return fresh.first(static_cast<std::size_t>(end - fresh.begin()));
}

// Old windows and fresh ones, in `scratch`. Only where they overlap does it take a merge.
void Propagation::merge_in(std::span<const Window> old, std::span<const Window> fresh,
                           double length) {
  std::vector<Window>& all = memory_.scratch;
  const double begin = old.front().begin + tolerance::kTouch * length;
  const double end = old.back().end - tolerance::kTouch * length;
  std::size_t from = 0;
  while (from < fresh.size() && fresh[from].end <= begin) ++from;
  std::size_t to = fresh.size();
  while (to > from && fresh[to - 1].begin >= end) --to;
  all.assign(fresh.begin(), fresh.begin() + static_cast<std::ptrdiff_t>(from));
  append_merged(old, fresh.subspan(from, to - from), memory_.pseudo_sources, length, all);
  all.insert(all.end(), fresh.begin() + static_cast<std::ptrdiff_t>(to), fresh.end());
}

// Puts windows in the place of those from `first` to before `last`.
void Propagation::replace(Edge& edge, std::uint32_t first, std::uint32_t last,
                          std::span<const Window> windows) {
  const std::uint32_t behind = edge.size - last;
  const auto size = static_cast<std::uint32_t>(first + windows.size() + behind);
  Window* place = edge.windows;
  if (size > edge.capacity) {
    const std::uint32_t capacity = WindowPool::capacity_for(size);
    place = memory_.pool.take(capacity);
    std::copy_n(edge.windows, first, place);
    std::copy_n(edge.windows + last, behind, place + (size - behind));
    memory_.pool.give_back(edge.windows, edge.capacity);
    edge.windows = place;
    edge.capacity = capacity;
  } else if (behind > 0 && size != edge.size) {
    std::memmove(place + (size - behind), place + last, behind * sizeof(Window));
  }
  std::copy(windows.begin(), windows.end(), place + first);
  edge.size = size;
}

// Makes one of windows i - 1 and i if one source sees both, unfolded over the same faces.
void Propagation::join_at(Edge& edge, std::uint32_t i, double length) {
  if (i == 0 || i >= edge.size) return;
  Window& left = edge.windows[i - 1];
  const Window& right = edge.windows[i];
  if (!is_continued_by(left, right, memory_.pseudo_sources[left.pseudo_source].offset, length))
    return;
  left.end = right.end;
  left.at_end = right.at_end;
  left.faces = std::max(left.faces, right.faces);
  std::copy(edge.windows + i + 1, edge.windows + edge.size, edge.windows + i);
  --edge.size;
}

// From now on nothing that arrives farther than `farthest` matters, and in the end the
// edge's windows are of no use to anybody but the details.
void Propagation::bound_edge(std::uint32_t e, double farthest) {
  Edge& edge = edges_[e];
  if (edge.let_go || !(farthest < edge.upper_bound)) return;
  edge.upper_bound = farthest;
  if (!keeps_windows_on(e)) memory_.queue.push({farthest, e, Waiting::What::bounded_edge});
}

void Propagation::let_go(std::uint32_t e) {
  Edge& edge = edges_[e];
  if (edge.pending != kUnreached || edge.size == 0) return;
  memory_.pool.give_back(edge.windows, edge.capacity);
  edge.windows = nullptr;
  edge.size = edge.capacity = 0;
  edge.let_go = true;
}

void Propagation::relax(std::uint32_t v, double distance, const PseudoSource& pseudo_source,
                        const ArrivalAtVertex& arrival) {
  if (!(distance < distance_[v]) || distance > max_) return;
  if (distance_[v] == kUnreached) ++reached_;
  distance_[v] = distance;
  if (!field_.nearest_source.empty()) field_.nearest_source[v] = pseudo_source.source;
  if (tolerance_ > 0) memory_.allowance[v] = pseudo_source.allowance;
  if (memory_.bends[v] == Bends::nowhere && !(tolerance_ > 0)) return;
  memory_.arrivals[v] = arrival;
  if (memory_.bends[v] == Bends::nowhere && early_by(v) == 0) return;
  if (distance < memory_.emitted[v] * (1 - tolerance::kLeastGain)) {
    memory_.queue.push({distance, v, Waiting::What::vertex});
  }
}

void Propagation::drop_windows(Poll& poll) { memory_.pool.reset(poll); }

VisibleIntervals Propagation::visible_intervals(Poll& poll) const {
  VisibleIntervals intervals(poll.memory());
  for (std::uint32_t e = 0; e < edges_.size() && !poll.stopped(); ++e) {
    if (!keeps_windows_on(e)) continue;
    const Edge& edge = edges_[e];
    const double length = frames_.edge(e).length;
    for (std::uint32_t i = 0; i < edge.size && !poll.cancelled(); ++i) {
      const Window& w = edge.windows[i];
      const PseudoSource& pseudo_source = memory_.pseudo_sources[w.pseudo_source];
      // What a window leads along is the length of a path, as raise_to_paths makes vertices'.
      const double offset = pseudo_source.offset + pseudo_source.allowance;
      for (Halfedge h = surface_.ring(w.from); h != w.from && !poll.cancelled();
           h = surface_.ring(h)) {
        if (keeps_some_ && !keep_of_[face_of(h)]) continue;
        if (frames_.is_reversed(h)) {
          intervals.add(h, {length - w.end, length - w.begin, length - w.x, w.y, offset,
                            pseudo_source.vertex, pseudo_source.source});
        } else {
          intervals.add(
              h, {w.begin, w.end, w.x, w.y, offset, pseudo_source.vertex, pseudo_source.source});
        }
      }
    }
  }
  return intervals;
}

}  // namespace geodesic::exact
