// Taking in: an edge's list takes in the windows that come to it and gets an upper bound, and a
// vertex keeps the nearest way.
#include <algorithm>
#include <cstring>
#include <utility>

#include "core/base/polled_sort.h"
#include "core/base/tolerances.h"
#include "core/exact/domain.h"

namespace geodesic::exact {

// The lists for the domain's edges. Those that come to one edge one after another, in their order.
void Domain::take_lists(std::span<Domain> all) {
  std::vector<ComingList>& coming = memory_.coming;
  coming.clear();
  for (Domain& other : all) {
    DomainMemory& from = other.memory_;
    for (HandedList& list : from.lists_for[number_]) {
      add(coming, ComingList{&list, from.sent_windows.data() + list.first});
    }
  }
  std::vector<std::uint32_t>& first_list = state_.memory.first_list;
  for (std::uint32_t i = 0; i < coming.size(); ++i) {
    HandedList& list = *coming[i].list;
    list.next = first_list[list.edge];
    first_list[list.edge] = i + 1;
  }
  std::vector<ComingList>& to_edge = memory_.to_edge;
  for (const ComingList& any : coming) {
    const std::uint32_t e = any.list->edge;
    to_edge.clear();
    for (std::uint32_t number = std::exchange(first_list[e], 0); number != 0;
         number = to_edge.back().list->next) {
      to_edge.push_back(coming[number - 1]);
    }
    if (to_edge.size() > 1) {
      const auto is_before = [](const ComingList& a, const ComingList& b) {
        return a.list->order < b.list->order;
      };
      polled_sort(to_edge, 0, to_edge.size(), is_before, memory_.sorting, *poll_);
    }
    for (const ComingList& next : to_edge) {
      if (poll_->stopped()) return;
      commit(e, {next.windows, next.list->size}, next.list->least);
    }
  }
}

// The fresh windows, none of which is nearer than `least`, join what is on the edge.
void Domain::commit(std::uint32_t e, std::span<Window> fresh, double least) {
  if (fresh.empty()) return;
  Edge& edge = state_.edges[e];
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
          trim({edge.windows + first, last - first}, fresh, pseudo_sources(), length);
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
          least = std::min(least, w.least(pseudo_sources()[w.pseudo_source].offset));
      }
    }
    replace(edge, first, last, windows);
    join_at(edge, first + static_cast<std::uint32_t>(windows.size()), length);
    join_at(edge, first, length);
  }
  edge.pending = std::min(edge.pending, least);
  if (edge.pending < edge.queued) {
    edge.queued = edge.pending;
    memory_.edges_waiting.push({edge.pending, e, Waiting::What::edge});
  }
}

// Without those that are as narrow as rounding. Over faces that are lines windows keep their
// widths, however often they are cut, and come to the same.
std::span<Window> Domain::without_narrow(std::span<Window> fresh, double length) const {
  const auto end = std::remove_if(fresh.begin(), fresh.end(),
                                  [&](const Window& w) { return is_within_rounding(w, length); });
  return fresh.first(static_cast<std::size_t>(end - fresh.begin()));
}

// Old windows and fresh ones, in `scratch`. Only where they overlap does it take a merge.
void Domain::merge_in(std::span<const Window> old, std::span<const Window> fresh, double length) {
  std::vector<Window>& all = memory_.scratch;
  const double begin = old.front().begin + tolerance::kTouch * length;
  const double end = old.back().end - tolerance::kTouch * length;
  std::size_t from = 0;
  while (from < fresh.size() && fresh[from].end <= begin) ++from;
  std::size_t to = fresh.size();
  while (to > from && fresh[to - 1].begin >= end) --to;
  all.assign(fresh.begin(), fresh.begin() + static_cast<std::ptrdiff_t>(from));
  append_merged(old, fresh.subspan(from, to - from), pseudo_sources(), length, all);
  all.insert(all.end(), fresh.begin() + static_cast<std::ptrdiff_t>(to), fresh.end());
}

// Puts windows in the place of those from `first` to before `last`.
void Domain::replace(Edge& edge, std::uint32_t first, std::uint32_t last,
                     std::span<const Window> windows) {
  const std::uint32_t behind = edge.size - last;
  const auto size = static_cast<std::uint32_t>(first + windows.size() + behind);
  Window* place = edge.windows;
  if (size > edge.capacity) {
    const std::uint32_t capacity = WindowPool::capacity_for(size);
    place = memory_.pool.take(capacity, *poll_);
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
void Domain::join_at(Edge& edge, std::uint32_t i, double length) {
  if (i == 0 || i >= edge.size) return;
  Window& left = edge.windows[i - 1];
  const Window& right = edge.windows[i];
  if (!is_continued_by(left, right, pseudo_sources()[left.pseudo_source].offset, length)) return;
  left.end = right.end;
  left.at_end = right.at_end;
  left.faces = std::max(left.faces, right.faces);
  std::copy(edge.windows + i + 1, edge.windows + edge.size, edge.windows + i);
  --edge.size;
}

// From now on nothing that arrives farther than `farthest` matters, and in the end the
// edge's windows are of no use to anybody but the details.
void Domain::bound_edge(std::uint32_t e, double farthest) {
  Edge& edge = state_.edges[e];
  if (edge.let_go || !(farthest < edge.upper_bound)) return;
  edge.upper_bound = farthest;
  if (!state_.keeps_windows_on(e))
    memory_.edges_waiting.push({farthest, e, Waiting::What::bounded_edge});
}

void Domain::relax(std::uint32_t v, double distance, const PseudoSource& pseudo_source,
                   const ArrivalAtVertex& arrival) {
  SharedMemory& shared = state_.memory;
  double& known = state_.distance[v];
  ArrivalAtVertex& known_arrival = shared.arrivals[v];
  // Unless the vertex has sent out windows as what it is.
  const bool is_preferred =
      distance == known && distance < shared.emitted[v] && state_.is_before(arrival, known_arrival);
  if (!(distance < known || is_preferred) || distance > state_.max) return;
  if (known == kUnreached) ++reached_;
  known = distance;
  known_arrival = arrival;
  if (!state_.nearest_source.empty()) state_.nearest_source[v] = pseudo_source.source;
  const bool is_early = state_.tolerance > 0;
  if (is_early) shared.allowance[v] = pseudo_source.allowance;
  if (shared.bends[v] != Bends::nowhere || is_early) memory_.shorter.push_back(v);
}

// By their last distances, for the order in which ways come depends on the domains. A vertex that
// came nearer twice may wait twice in the same bucket, and sends out windows once.
void Domain::queue_vertices() {
  const SharedMemory& shared = state_.memory;
  for (const std::uint32_t v : memory_.shorter) {
    if (shared.bends[v] == Bends::nowhere && !(state_.early_by(v) > 0)) continue;
    const double distance = state_.distance[v];
    if (!(distance < shared.emitted[v] * (1 - tolerance::kLeastGain))) continue;
    memory_.vertices_waiting.push({distance, v, Waiting::What::vertex});
  }
  memory_.shorter.clear();
}

}  // namespace geodesic::exact
