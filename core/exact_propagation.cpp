#include "core/exact_propagation.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>

#include "core/polled_fill.h"

namespace geodesic::exact {
namespace {

// Distances that a vertex is lowered by below this part send out nothing new.
constexpr double kNews = 1e-14;

}  // namespace

Propagation::Propagation(const Adjacency& adjacency, PropagationMemory& memory, Field& field,
                         double max, double tolerance, bool keep_windows, Poll& poll)
    : adjacency_(adjacency),
      memory_(memory),
      frames_(memory.frames),
      field_(field),
      max_(max * (1 + tolerance) * (1 + tolerance)),
      tolerance_(tolerance),
      keep_windows_(keep_windows) {
  memory.frames.build(adjacency, poll);
  if (poll.stopped()) return;
  memory.pool.reset(poll);
  if (poll.stopped()) return;
  double least = kUnreached;
  for (const Source& source : field.sources) least = std::min(least, source.offset);
  memory.queue.reset(least, 0.25 * frames_.mean_shortest_side());
  polled_assign(memory.edges, frames_.edges().size(),
                {nullptr, 0, 0, kUnreached, kUnreached, kUnreached, false}, poll);
  memory.roots.clear();
  const std::size_t vertex_count = adjacency.mesh().vertex_count();
  memory.arrivals.assign(vertex_count, {kNone, false, 0});
  memory.bends.assign(frames_.bends().begin(), frames_.bends().end());
  memory.emitted.assign(vertex_count, kUnreached);
  memory.above.assign(tolerance > 0 ? vertex_count : 0, 0);
}

bool Propagation::step() {
  Waiting next{};
  if (!memory_.queue.pop(next)) return false;
  switch (next.what) {
    case Waiting::What::edge:
      memory_.edges[next.number].queued = kUnreached;
      pass_on(next.number);
      break;
    case Waiting::What::vertex:
      bend_at(next.number);
      break;
    case Waiting::What::settled_edge:
      let_go(next.number);
      break;
  }
  return true;
}

// All that waits on an edge goes over to the faces it did not come from. Meanwhile
// the edge's farthest place is found: nothing that arrives later, and farther, can be
// nearer anywhere on it.
void Propagation::pass_on(std::uint32_t e) {
  EdgeWindows& edge = memory_.edges[e];
  if (edge.pending == kUnreached) return;
  edge.pending = kUnreached;
  const EdgeFrame& frame = frames_.edge(e);
  const double at_tail = field_.distance[frame.tail];
  const double at_head = field_.distance[frame.head];
  double farthest = 0;
  double covered = 0;
  const auto gap = [&](double begin, double end) {
    farthest = std::max(farthest, std::min(at_tail + end, at_head + (frame.length - begin)));
  };
  const std::span<Window> windows(edge.windows, edge.size);
  Halfedge from = kNone;  // of those that wait
  bool from_one = true;
  for (const Window& w : windows) {
    if (covered < w.begin) gap(covered, w.begin);
    farthest = std::max({farthest, w.at_begin, w.at_end});
    covered = w.end;
    if (w.propagated) continue;
    from_one = from_one && (from == kNone || w.from == from);
    from = w.from;
  }
  if (covered < frame.length) gap(covered, frame.length);
  // No face has two sides on one edge, so the list stays as it is.
  Halfedge h = frame.first;
  do {
    if (!from_one || h != from) {
      load_beams(windows, h);
      if (memory_.beams.size != 0) cross_face(h);
    }
    h = adjacency_.ring(h);
  } while (h != frame.first);
  for (Window& w : windows) w.propagated = true;
  settle(e, farthest);
}

// The windows on the edge of h that wait and did not come from its face, in its frame.
void Propagation::load_beams(std::span<const Window> windows, Halfedge h) {
  Beams& beams = memory_.beams;
  beams.make_room(windows.size());
  const PseudoSource* const roots = memory_.roots.data();
  double* const begin = beams.begin.data();
  double* const end = beams.end.data();
  double* const x = beams.x.data();
  double* const y = beams.y.data();
  double* const offset = beams.offset.data();
  std::uint32_t* const root = beams.root.data();
  std::size_t size = 0;
  if (!frames_.is_reversed(h)) {
    for (const Window& w : windows) {
      if (w.propagated || w.from == h) continue;
      begin[size] = w.begin;
      end[size] = w.end;
      x[size] = w.x;
      y[size] = w.y;
      offset[size] = roots[w.root].offset;
      root[size++] = w.root;
    }
  } else {
    const double length = frames_.edge(frames_.edge_of(h)).length;
    for (std::size_t i = windows.size(); i-- > 0;) {
      const Window& w = windows[i];
      if (w.propagated || w.from == h) continue;
      begin[size] = length - w.end;
      end[size] = length - w.begin;
      x[size] = length - w.x;
      y[size] = w.y;
      offset[size] = roots[w.root].offset;
      root[size++] = w.root;
    }
  }
  beams.size = size;
}

// The beams cross the face of h from its base a -> b; the sides are those from the far
// corner to a and from b to it.
void Propagation::cross_face(Halfedge h) {
  const std::size_t count = memory_.beams.size;
  propagated_ += count;
  const std::size_t best = reach_apex(h);
  const std::uint32_t f = face_of(h);
  const std::uint32_t c = corner_of(h);
  const FaceFrame& face = frames_.face(f);
  const double base = frames_.edge(face.edge[c]).length;
  const Side left = side(halfedge(f, previous_corner(c)), false);
  if (!left.on_boundary) {
    cross_to(left,
             {false, left.flipped, base, face.cosine[c], face.sine[c], left.length, left.at_tail,
              left.at_head, left.settled, max_},
             0, best + 1);
  }
  const Side right = side(halfedge(f, next_corner(c)), true);
  if (!right.on_boundary) {
    const std::uint32_t n = next_corner(c);
    cross_to(right,
             {true, right.flipped, base, face.cosine[n], face.sine[n], right.length, right.at_tail,
              right.at_head, right.settled, max_},
             best, count);
  }
}

// The beams from `first` to before `last` over one side of their face. Nearly all of them
// come there whole and meet none but the next one, and where is computed for all at once.
void Propagation::cross_to(const Side& side, const SideFrame& frame, std::size_t first,
                           std::size_t last) {
  Children& children = memory_.children;
  Ties& ties = memory_.ties;
  std::vector<Window>& fresh = memory_.fresh;
  children.make_room(last);
  cross_to_side(vectors_, memory_.beams, first, last, frame, children);
  // On the left side t grows with the place on the base.
  const bool upwards = frame.on_right == frame.flipped;
  pair_overlaps(first, last, upwards, side.length);
  find_ties(vectors_, memory_.beams, children, ties);

  fresh.clear();
  fresh.reserve(last - first);
  const double* const begins = children.begin.data();
  const double* const ends = children.end.data();
  const std::int64_t* const passes = children.passes.data();
  const std::uint32_t* const roots = memory_.beams.root.data();
  const double touch = kTouch * side.length;
  const double narrow = kLeastWidth * side.length;
  const auto add = [&](std::size_t i, double begin, double at_begin) {
    fresh.emplace_back(begin, ends[i], children.x[i], children.y[i], at_begin, children.at_end[i],
                       roots[i], side.from, false);
  };
  double least = kUnreached;
  std::size_t tie = upwards ? 0 : ties.size;  // the next one, or the one after it
  std::size_t newest = last;                  // whose end is the list's
  double reached = -kUnreached;               // the list's end
  std::size_t i = upwards ? first : last - 1;
  for (std::size_t left = last - first; left > 0; --left, i += upwards ? 1 : std::size_t(-1)) {
    if (passes[i] == kMisses) continue;
    std::size_t with_last = ties.size;
    if (upwards ? tie < ties.size && ties.right[tie] == i : tie > 0 && ties.right[tie - 1] == i) {
      with_last = upwards ? tie++ : --tie;
    }
    if (passes[i] == kWhole) {
      least = std::min(least, children.least[i]);
      if (reached <= begins[i] + touch) {
        if (newest != last && roots[newest] == roots[i] && continues(i, side)) {
          fresh.back().end = ends[i];
          fresh.back().at_end = children.at_end[i];
        } else {
          add(i, begins[i], children.at_begin[i]);
        }
        newest = i;
        reached = ends[i];
        continue;
      }
      if (with_last < ties.size && ties.found[with_last] != 0 && ties.left[with_last] == newest) {
        const double place = ties.place[with_last];
        Window& before = fresh.back();
        if (place - before.begin > narrow && ends[i] - place > narrow) {
          before.end = place;
          before.at_end = ties.at_left[with_last];
          add(i, place, ties.at_right[with_last]);
          newest = i;
          reached = ends[i];
          continue;
        }
      }
    }
    Window window{begins[i],          ends[i],  children.x[i], children.y[i], children.at_begin[i],
                  children.at_end[i], roots[i], side.from,     false};
    if (!is_of_use(window, side)) continue;
    const double offset = memory_.roots[window.root].offset;
    least = std::min(least, window.least(offset));
    append(fresh, window, memory_.roots, side.length, memory_.scratch);
    reached = fresh.empty() ? -kUnreached : fresh.back().end;
    const bool ends_it =
        reached == ends[i] && fresh.back().x == children.x[i] && fresh.back().root == roots[i];
    newest = ends_it ? i : last;
  }
  commit(side.edge, least);
}

// Whether the list's last window and the child are the same light.
bool Propagation::continues(std::size_t i, const Side& side) const {
  const Children& children = memory_.children;
  const Window window{
      children.begin[i],  children.end[i],       children.x[i], children.y[i], children.at_begin[i],
      children.at_end[i], memory_.beams.root[i], side.from,     false};
  return is_continued_by(memory_.fresh.back(), window, memory_.beams.offset[i], side.length);
}

// Which children overlap the next one on the edge, so that each is nearer on its side.
void Propagation::pair_overlaps(std::size_t first, std::size_t last, bool upwards, double length) {
  const Children& children = memory_.children;
  Ties& ties = memory_.ties;
  ties.make_room(last - first);
  const double* const begin = children.begin.data();
  const double* const end = children.end.data();
  const std::int64_t* const passes = children.passes.data();
  std::uint32_t* const lefts = ties.left.data();
  std::uint32_t* const rights = ties.right.data();
  const double touch = kTouch * length;
  std::size_t size = 0;
  for (std::size_t i = first + 1; i < last; ++i) {
    const std::size_t left = upwards ? i - 1 : i;
    const std::size_t right = upwards ? i : i - 1;
    lefts[size] = static_cast<std::uint32_t>(left);
    rights[size] = static_cast<std::uint32_t>(right);
    // Without branches: which pairs overlap is anybody's guess.
    const int overlap = static_cast<int>((passes[left] & passes[right]) == kWhole) &
                        static_cast<int>(end[left] > begin[right] + touch) &
                        static_cast<int>(begin[left] < begin[right]) &
                        static_cast<int>(end[left] < end[right]);
    size += static_cast<std::size_t>(overlap);
  }
  ties.size = size;
}

// Finds for every beam where the line to the far corner crosses the base, and lowers
// that corner. Returns the beam by which it is nearest. A beam that the line misses
// leads there round its end; that matters only where there is a gap.
std::size_t Propagation::reach_apex(Halfedge h) {
  const std::uint32_t f = face_of(h);
  const std::uint32_t c = corner_of(h);
  const std::uint32_t apex_corner = previous_corner(c);
  const FaceFrame& frame = frames_.face(f);
  const double left_length = frames_.edge(frame.edge[apex_corner]).length;
  const double apex_x = left_length * frame.cosine[c];
  const double apex_y = left_length * frame.sine[c];
  Beams& beams = memory_.beams;
  const std::size_t best =
      find_crossings(vectors_, beams, apex_x, apex_y, frames_.edge(frame.edge[c]).length);
  const double crossing = std::clamp(beams.crossing[best], beams.begin[best], beams.end[best]);
  const double run = crossing - beams.x[best];
  const double rest = apex_x - crossing;
  const double distance = beams.offset[best] +
                          std::sqrt(run * run + beams.y[best] * beams.y[best]) +
                          std::sqrt(rest * rest + apex_y * apex_y);
  lower(adjacency_.face(f).vertex[apex_corner], distance, memory_.roots[beams.root[best]],
        {halfedge(f, apex_corner), beams.size >= crowd_, crossing});
  return best;
}

// A side of a face, for windows counted from the halfedge's tail or from its head.
Side Propagation::side(Halfedge h, bool from_tail) const {
  const std::uint32_t e = frames_.edge_of(h);
  const EdgeFrame& frame = frames_.edge(e);
  return {h,
          e,
          frames_.is_reversed(h) == from_tail,
          adjacency_.ring(h) == h,
          frame.length,
          field_.distance[frame.tail],
          field_.distance[frame.head],
          memory_.edges[e].settled};
}

// Whether something of a window that comes over a side is nearer than other ways; clips it.
bool Propagation::is_of_use(Window& window, const Side& side) const {
  const double offset = memory_.roots[window.root].offset;
  if (!clip_at_ends(window, offset, side.length, side.at_tail, side.at_head)) return false;
  const double least = window.least(offset);
  return least < side.settled && least <= max_;
}

// The fresh windows, none of which is nearer than `least`, join what is on the edge.
void Propagation::commit(std::uint32_t e, double least) {
  const std::vector<Window>& fresh = memory_.fresh;
  if (fresh.empty()) return;
  EdgeWindows& edge = memory_.edges[e];
  if (edge.size == 0) {
    replace(edge, 0, 0, fresh);
  } else {
    const double length = frames_.edge(e).length;
    // Those from `first` to `last` overlap them.
    const double begin = fresh.front().begin + kTouch * length;
    const double end = fresh.back().end - kTouch * length;
    std::uint32_t first = 0;
    while (first < edge.size && edge.windows[first].end <= begin) ++first;
    std::uint32_t last = edge.size;
    while (last > first && edge.windows[last - 1].begin >= end) --last;
    std::span<const Window> windows = fresh;
    if (first < last) {
      merge_in(edge, first, last, length);
      windows = memory_.scratch;
      least = kUnreached;
      for (const Window& w : windows) {
        if (!w.propagated) least = std::min(least, w.least(memory_.roots[w.root].offset));
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

// The fresh windows and those of the edge from `first` to before `last`, in `scratch`. Only
// where they overlap does it take a merge; most often that is at one end.
void Propagation::merge_in(const EdgeWindows& edge, std::uint32_t first, std::uint32_t last,
                           double length) {
  const std::vector<Window>& fresh = memory_.fresh;
  std::vector<Window>& all = memory_.scratch;
  const double begin = edge.windows[first].begin + kTouch * length;
  const double end = edge.windows[last - 1].end - kTouch * length;
  std::size_t from = 0;
  while (from < fresh.size() && fresh[from].end <= begin) ++from;
  std::size_t to = fresh.size();
  while (to > from && fresh[to - 1].begin >= end) --to;
  all.assign(fresh.begin(), fresh.begin() + static_cast<std::ptrdiff_t>(from));
  append_merged({edge.windows + first, last - first}, {fresh.data() + from, to - from},
                memory_.roots, length, all);
  all.insert(all.end(), fresh.begin() + static_cast<std::ptrdiff_t>(to), fresh.end());
}

// Puts windows in the place of those from `first` to before `last`.
void Propagation::replace(EdgeWindows& edge, std::uint32_t first, std::uint32_t last,
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

// Makes one of windows i - 1 and i if they are the same light.
void Propagation::join_at(EdgeWindows& edge, std::uint32_t i, double length) {
  if (i == 0 || i >= edge.size) return;
  Window& left = edge.windows[i - 1];
  const Window& right = edge.windows[i];
  if (!is_continued_by(left, right, memory_.roots[left.root].offset, length)) return;
  left.end = right.end;
  left.at_end = right.at_end;
  std::copy(edge.windows + i + 1, edge.windows + edge.size, edge.windows + i);
  --edge.size;
}

// From now on nothing that arrives farther than `farthest` matters, and in the end the
// edge's windows are of no use to anybody but the details.
void Propagation::settle(std::uint32_t e, double farthest) {
  EdgeWindows& edge = memory_.edges[e];
  if (edge.let_go || !(farthest < edge.settled)) return;
  edge.settled = farthest;
  if (!keep_windows_) memory_.queue.push({farthest, e, Waiting::What::settled_edge});
}

void Propagation::let_go(std::uint32_t e) {
  EdgeWindows& edge = memory_.edges[e];
  if (edge.pending != kUnreached || edge.size == 0) return;
  memory_.pool.give_back(edge.windows, edge.capacity);
  edge.windows = nullptr;
  edge.size = edge.capacity = 0;
  edge.let_go = true;
}

void Propagation::lower(std::uint32_t v, double distance, const PseudoSource& root,
                        const ArrivalAtVertex& arrival) {
  if (!(distance < field_.distance[v]) || distance > max_) return;
  if (field_.distance[v] == kUnreached) ++reached_;
  field_.distance[v] = distance;
  if (!field_.nearest_source.empty()) field_.nearest_source[v] = root.source;
  if (tolerance_ > 0) memory_.above[v] = root.above;
  if (memory_.bends[v] == Bends::nowhere && !(tolerance_ > 0)) return;
  memory_.arrivals[v] = arrival;
  if (memory_.bends[v] == Bends::nowhere && head_start(v) == 0) return;
  if (distance < memory_.emitted[v] * (1 - kNews)) {
    memory_.queue.push({distance, v, Waiting::What::vertex});
  }
}

void Propagation::drop_windows(Poll& poll) {
  memory_.edges.clear();
  memory_.pool.reset(poll);
}

LitWindows Propagation::lit_windows(Poll& poll) const {
  LitWindows lit;
  for (std::uint32_t e = 0; e < memory_.edges.size() && !poll.stopped(); ++e) {
    const EdgeWindows& edge = memory_.edges[e];
    const double length = frames_.edge(e).length;
    for (std::uint32_t i = 0; i < edge.size && !poll.cancelled(); ++i) {
      const Window& w = edge.windows[i];
      const PseudoSource& root = memory_.roots[w.root];
      for (Halfedge h = adjacency_.ring(w.from); h != w.from; h = adjacency_.ring(h)) {
        if (frames_.is_reversed(h)) {
          lit.add(h, {length - w.end, length - w.begin, length - w.x, w.y, root.offset, root.vertex,
                      root.source});
        } else {
          lit.add(h, {w.begin, w.end, w.x, w.y, root.offset, root.vertex, root.source});
        }
      }
    }
  }
  return lit;
}

}  // namespace geodesic::exact
