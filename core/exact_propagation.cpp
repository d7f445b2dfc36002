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
  std::vector<Beam>& waiting = memory_.waiting;
  waiting.clear();
  for (std::uint32_t i = 0; i < edge.size; ++i) {
    Window& w = edge.windows[i];
    if (covered < w.begin) gap(covered, w.begin);
    farthest = std::max({farthest, w.at_begin, w.at_end});
    covered = w.end;
    if (w.propagated) continue;
    w.propagated = true;
    waiting.push_back({w.begin, w.end, w.x, w.y, memory_.roots[w.root].offset, 0, w.root, w.from});
  }
  if (covered < frame.length) gap(covered, frame.length);
  Halfedge h = frame.first;
  do {
    const std::span<Beam> beams = beams_over(h);
    if (!beams.empty()) cross_face(h, beams);
    h = adjacency_.ring(h);
  } while (h != frame.first);
  settle(e, farthest);
}

// The waiting ones that did not come from the face of h, in the frame of h.
std::span<Beam> Propagation::beams_over(Halfedge h) {
  std::vector<Beam>& waiting = memory_.waiting;
  const auto comes_from_here = [h](const Beam& beam) { return beam.from == h; };
  const bool reversed = frames_.is_reversed(h);
  if (!reversed && std::none_of(waiting.begin(), waiting.end(), comes_from_here)) return waiting;
  std::vector<Beam>& beams = memory_.beams;
  beams.clear();
  if (!reversed) {
    std::remove_copy_if(waiting.begin(), waiting.end(), std::back_inserter(beams), comes_from_here);
    return beams;
  }
  const double length = frames_.edge(frames_.edge_of(h)).length;
  for (std::size_t i = waiting.size(); i-- > 0;) {
    const Beam& b = waiting[i];
    if (comes_from_here(b)) continue;
    beams.push_back(
        {length - b.end, length - b.begin, length - b.x, b.y, b.offset, 0, b.root, b.from});
  }
  return beams;
}

// The beams cross the face of h from its base a -> b; C is the corner opposite. On
// the side a - C, t is counted from a, on b - C from b. A line from the unfolded
// source (x, -y) through (p, 0) meets a - C at
//   t = p y / (y cos A + (x - p) sin A),
// and seen from that side the source is at (x cos A - y sin A, -(y cos A + x sin A)).
void Propagation::cross_face(Halfedge h, std::span<Beam> beams) {
  propagated_ += beams.size();
  const std::size_t best = reach_apex(h, beams);
  const std::uint32_t f = face_of(h);
  const std::uint32_t c = corner_of(h);
  const FaceFrame& frame = frames_.face(f);

  const Side left = side(halfedge(f, previous_corner(c)), false);
  if (!left.on_boundary) {
    const double cosine = frame.cosine[c];
    const double sine = frame.sine[c];
    const auto over_left = [&](const Beam& beam) {
      if (!(beam.begin < beam.crossing)) return;
      const auto meets = [&](double p) {
        const double below = beam.y * cosine + (beam.x - p) * sine;
        return below > 0 ? std::min(p * beam.y / below, left.length) : (p > 0 ? left.length : 0);
      };
      add_child(left, beam.offset, beam.root, meets(beam.begin),
                beam.end < beam.crossing ? meets(beam.end) : left.length,
                beam.x * cosine - beam.y * sine, std::max(beam.y * cosine + beam.x * sine, 0.0));
    };
    // The list goes from the edge's tail to its head.
    memory_.children.clear();
    if (left.flipped) {
      for (std::size_t i = best + 1; i-- > 0;) over_left(beams[i]);
    } else {
      for (std::size_t i = 0; i <= best; ++i) over_left(beams[i]);
    }
    commit(left.edge);
  }

  const Side right = side(halfedge(f, next_corner(c)), true);
  if (!right.on_boundary) {
    const double base = frames_.edge(frame.edge[c]).length;
    const double cosine = frame.cosine[next_corner(c)];
    const double sine = frame.sine[next_corner(c)];
    const auto over_right = [&](const Beam& beam) {
      if (!(beam.end > beam.crossing)) return;
      const double x = base - beam.x;
      const auto meets = [&](double p) {
        const double below = beam.y * cosine + (x - p) * sine;
        return below > 0 ? std::min(p * beam.y / below, right.length) : (p > 0 ? right.length : 0);
      };
      add_child(right, beam.offset, beam.root, meets(base - beam.end),
                beam.begin > beam.crossing ? meets(base - beam.begin) : right.length,
                x * cosine - beam.y * sine, std::max(beam.y * cosine + x * sine, 0.0));
    };
    memory_.children.clear();
    if (right.flipped) {
      for (std::size_t i = best; i < beams.size(); ++i) over_right(beams[i]);
    } else {
      for (std::size_t i = beams.size(); i-- > best;) over_right(beams[i]);
    }
    commit(right.edge);
  }
}

// Finds for every beam where the line to the far corner crosses the base, and lowers
// that corner. Returns the beam by which it is nearest. A beam that the line misses
// leads there round its end; that matters only where there is a gap.
std::size_t Propagation::reach_apex(Halfedge h, std::span<Beam> beams) {
  constexpr double kNearlyMet = 1e-9;
  const std::uint32_t f = face_of(h);
  const std::uint32_t c = corner_of(h);
  const std::uint32_t apex_corner = previous_corner(c);
  const FaceFrame& frame = frames_.face(f);
  const double left_length = frames_.edge(frame.edge[previous_corner(c)]).length;
  const double apex_x = left_length * frame.cosine[c];
  const double apex_y = left_length * frame.sine[c];
  const double near = kNearlyMet * frames_.edge(frame.edge[c]).length;

  std::size_t best = 0;
  double best_distance = kUnreached;
  const auto try_beam = [&](std::size_t i) {
    const Beam& beam = beams[i];
    const double crossing = std::clamp(beam.crossing, beam.begin, beam.end);
    const double run = crossing - beam.x;
    const double rest = apex_x - crossing;
    const double distance = beam.offset + std::sqrt(run * run + beam.y * beam.y) +
                            std::sqrt(rest * rest + apex_y * apex_y);
    if (!(distance < best_distance)) return;
    best = i;
    best_distance = distance;
  };
  for (std::size_t i = 0; i < beams.size(); ++i) {
    Beam& beam = beams[i];
    const double rise = beam.y + apex_y;
    // On one line with the face anything between will do.
    beam.crossing = rise > 0 ? (beam.x * apex_y + apex_x * beam.y) / rise : apex_x;
    if (beam.crossing >= beam.begin - near && beam.crossing <= beam.end + near) try_beam(i);
  }
  // All those to the left go left and those to the right go right, unless one leads to
  // the corner by a shorter way than the best.
  bool in_order = best_distance != kUnreached;
  for (std::size_t i = 0; i < best; ++i) in_order &= beams[i].crossing >= beams[i].begin;
  for (std::size_t i = best + 1; i < beams.size(); ++i) {
    in_order &= beams[i].crossing <= beams[i].end;
  }
  if (!in_order) {
    for (std::size_t i = 0; i < beams.size(); ++i) try_beam(i);
  }
  const Beam& beam = beams[best];
  lower(adjacency_.face(f).vertex[apex_corner], best_distance, memory_.roots[beam.root],
        {halfedge(f, apex_corner), beams.size() >= crowd_,
         std::clamp(beam.crossing, beam.begin, beam.end)});
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

// A window that came over a side, counted from the end that the side says.
void Propagation::add_child(const Side& side, double offset, std::uint32_t root, double begin,
                            double end, double x, double y) {
  if (!(begin < end)) return;
  Window w{};
  w.begin = side.flipped ? side.length - end : begin;
  w.end = side.flipped ? side.length - begin : end;
  w.x = side.flipped ? side.length - x : x;
  w.y = y;
  w.at_begin = w.at(w.begin, offset);
  w.at_end = w.at(w.end, offset);
  w.root = root;
  w.from = side.from;
  w.propagated = false;
  if (!clip_at_ends(w, offset, side.length, side.at_tail, side.at_head)) return;
  const double least = w.least(offset);
  if (least >= side.settled || least > max_) return;
  append(memory_.children, w, memory_.roots, side.length, memory_.scratch);
}

// The children join what is on the edge.
void Propagation::commit(std::uint32_t e) {
  const std::vector<Window>& fresh = memory_.children;
  if (fresh.empty()) return;
  EdgeWindows& edge = memory_.edges[e];
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
    merge({edge.windows + first, last - first}, fresh, memory_.roots, length, memory_.scratch);
    windows = memory_.scratch;
  }
  for (const Window& w : windows) {
    if (!w.propagated) edge.pending = std::min(edge.pending, w.least(memory_.roots[w.root].offset));
  }
  replace(edge, first, last, windows);
  join_at(edge, first + static_cast<std::uint32_t>(windows.size()), length);
  join_at(edge, first, length);
  if (edge.pending < edge.queued) {
    edge.queued = edge.pending;
    memory_.queue.push({edge.pending, e, Waiting::What::edge});
  }
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
