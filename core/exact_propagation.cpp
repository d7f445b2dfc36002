#include "core/exact_propagation.h"

#include <algorithm>
#include <cmath>

namespace geodesic::exact {
namespace {

// Gaps between windows below this part of the edge need not be looked into: what is in
// them is no farther from their ends.
constexpr double kLeastGap = 1e-9;

// So many windows on an edge are a crowd, in which a vertex may become a source. What starts
// little earlier than it was reached spares few of them, and its own meet the others at more
// places: the less the tolerance, the more there must be. Measured: 8 at 1e-2, 13 at 1e-3,
// 22 at 1e-4, beyond which it makes no difference.
std::size_t crowd_for(double tolerance) {
  constexpr double kMost = 1e-2;
  constexpr double kLeast = 1e-4;
  const double part = kMost / std::clamp(tolerance, kLeast, kMost);
  return static_cast<std::size_t>(std::lround(8 * std::pow(part, 0.22)));
}

}  // namespace

Propagation::Propagation(const Adjacency& adjacency, const Triangulation& surface,
                         PropagationMemory& memory, Field& field, double max, double tolerance,
                         bool keep_windows, Poll& poll)
    : adjacency_(adjacency),
      surface_(surface),
      memory_(memory),
      frames_(memory.frames),
      field_(field),
      max_(max * (1 + tolerance) * (1 + tolerance)),
      tolerance_(tolerance),
      keep_windows_(keep_windows),
      crowd_(crowd_for(tolerance)) {
  memory.frames.build(adjacency, surface, poll);
  if (poll.stopped()) return;
  memory.pool.reset(poll);
  if (poll.stopped()) return;
  double least = kUnreached;
  for (const Source& source : field.sources) least = std::min(least, source.offset);
  memory.queue.reset(least, 0.25 * frames_.mean_shortest_side());
  edges_ = memory.frames.edges();
  memory.roots.clear();
  memory.offsets.clear();
  const std::size_t vertex_count = adjacency.mesh().vertex_count();
  memory.arrivals.assign(vertex_count, {kNone, false, 0});
  memory.bends.assign(frames_.bends().begin(), frames_.bends().end());
  memory.emitted.assign(vertex_count, kUnreached);
  memory.above.assign(tolerance > 0 ? vertex_count : 0, 0);
}

std::uint32_t Propagation::add_root(const PseudoSource& root) {
  memory_.roots.push_back(root);
  memory_.offsets.push_back(root.offset);
  return static_cast<std::uint32_t>(memory_.roots.size() - 1);
}

bool Propagation::step() {
  Waiting next{};
  if (!memory_.queue.pop(next)) return false;
  switch (next.what) {
    case Waiting::What::edge:
      edges_[next.number].queued = kUnreached;
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
  Edge& edge = edges_[e];
  if (edge.pending == kUnreached) return;
  edge.pending = kUnreached;
  const double at_tail = field_.distance[edge.tail];
  const double at_head = field_.distance[edge.head];
  double farthest = 0;
  double covered = 0;
  const auto gap = [&](double begin, double end) {
    farthest = std::max(farthest, std::min(at_tail + end, at_head + (edge.length - begin)));
  };
  const std::span<Window> windows(edge.windows, edge.size);
  Halfedge from = kNone;  // of those that wait
  bool from_one = true;
  // Less than this is rounding, and no branch worth.
  const double least_gap = kLeastGap * edge.length;
  for (const Window& w : windows) {
    if (covered + least_gap < w.begin) gap(covered, w.begin);
    farthest = std::max(farthest, std::max(w.at_begin, w.at_end));
    covered = w.end;
    if (w.propagated) continue;
    if (from == kNone) from = w.from;
    from_one &= w.from == from;
  }
  if (covered < edge.length) gap(covered, edge.length);
  // No face has two sides on one edge, so the list stays as it is.
  Halfedge h = edge.first;
  do {
    if (!from_one || h != from) {
      load_beams(windows, h);
      if (memory_.beams.size != 0) cross_face(h);
    }
    h = h == edge.first ? edge.second : surface_.ring(h);
  } while (h != edge.first);
  for (Window& w : windows) w.propagated = true;
  settle(e, farthest + least_gap);
}

// The windows on the edge of h that wait and did not come from its face, in its frame.
void Propagation::load_beams(std::span<const Window> windows, Halfedge h) {
  Beams& beams = memory_.beams;
  beams.make_room(windows.size());
  const double* const offsets = memory_.offsets.data();
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
      offset[size] = offsets[w.root];
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
      offset[size] = offsets[w.root];
      root[size++] = w.root;
    }
  }
  beams.size = size;
}

// The beams cross the face of h from its base a -> b; the sides are those from the far
// corner to a and from b to it.
void Propagation::cross_face(Halfedge h) {
  const Beams& beams = memory_.beams;
  const std::size_t count = beams.size;
  propagated_ += count;
  const std::uint32_t f = face_of(h);
  const std::uint32_t c = corner_of(h);
  const CornerAngle at_tail = frames_.angle(f, c);
  const std::size_t best = reach_apex(h, at_tail);
  const FaceFrame& face = frames_.face(f);
  const double base = frames_.edge(face.edge[c]).length;
  // Where only the best beam may come to a side, mostly it does not.
  if (best > 0 || beams.begin[0] < beams.crossing[0]) {
    const Side left = side(halfedge(f, previous_corner(c)), false);
    if (!left.on_boundary) {
      cross_to(left,
               {false, left.flipped, base, at_tail.cosine, at_tail.sine, left.length, left.at_tail,
                left.at_head, left.settled, max_},
               0, best + 1);
    }
  }
  if (best + 1 < count || beams.crossing[best] < beams.end[best]) {
    const Side right = side(halfedge(f, next_corner(c)), true);
    if (!right.on_boundary) {
      const CornerAngle at_head = frames_.angle(f, next_corner(c));
      cross_to(right,
               {true, right.flipped, base, at_head.cosine, at_head.sine, right.length,
                right.at_tail, right.at_head, right.settled, max_},
               best, count);
    }
  }
}

// The beams from `first` to before `last` over one side of their face.
void Propagation::cross_to(const Side& side, const SideFrame& frame, std::size_t first,
                           std::size_t last) {
  Children& children = memory_.children;
  Ties& ties = memory_.ties;
  children.make_room(last);
  ties.make_room(last - first);
  cross_to_side(vectors_, memory_.beams, first, last, frame, children);
  // On the left side t grows with the place on the base.
  const bool upwards = frame.on_right == frame.flipped;
  pair_overlaps(vectors_, first, last, upwards, side.length, children, ties);
  if (ties.size > 0) find_ties(vectors_, memory_.beams, children, ties);
  ChildOrder order{first, last, upwards};
  FreshList fresh{memory_.fresh, 0, kUnreached};
  for (;;) {
    add_plain(side, order, fresh);
    if (order.left() == 0) break;
    add_with_care(side, order, fresh);
  }
  commit(side.edge, {fresh.list.data(), fresh.size}, fresh.least);
}

// Adds children in the order on the edge, as long as they can be sewn to those before:
// nearly all of them can, and most come whole and meet none but the one before.
void Propagation::add_plain(const Side& side, ChildOrder& order, FreshList& fresh) {
  const std::size_t most = fresh.size + order.left();
  if (fresh.list.size() < most) fresh.list.resize(most);
  const Children& children = memory_.children;
  const Ties& ties = memory_.ties;
  const double* const begins = children.begin.data();
  const double* const ends = children.end.data();
  const double* const xs = children.x.data();
  const double* const ys = children.y.data();
  const double* const at_begins = children.at_begin.data();
  const double* const at_ends = children.at_end.data();
  const double* const leasts = children.least.data();
  const std::int64_t* const passes = children.passes.data();
  const std::int64_t* const overlaps = children.overlaps.data();
  const std::uint32_t* const roots = memory_.beams.root.data();
  const double touch = kTouch * side.length;
  const double narrow = kLeastWidth * side.length;
  const double nearly = kNearlyTouch * side.length;
  const std::size_t step = order.upwards ? 1 : static_cast<std::size_t>(-1);
  // The one before a child on the edge is numbered before it, or it before that one.
  const std::size_t to_pair = order.upwards ? 0 : 1;
  std::size_t i = order.next();
  std::size_t left = order.left();
  double least = fresh.least;
  Window* const begin = fresh.list.data();
  Window* out = begin + fresh.size;
  double reached = out == begin ? -kUnreached : out[-1].end;
  double last_x = out == begin ? 0 : out[-1].x;
  std::uint32_t last_root = out == begin ? kNone : out[-1].root;
  for (; left > 0; --left, i += step) {
    if (passes[i] == kMisses) continue;
    const bool whole = passes[i] == kWhole;
    double from = begins[i];
    double at_from = at_begins[i];
    const bool maybe_same = (static_cast<int>(last_root == roots[i]) &
                             static_cast<int>(std::abs(xs[i] - last_x) <= kNearSource * at_from) &
                             static_cast<int>(std::abs(from - reached) <= nearly)) != 0;
    if (whole && maybe_same && reached == ends[i - step] &&
        is_as_good(out[-1], from, ends[i], at_from, at_ends[i], memory_.beams.offset[i])) {
      reached = out[-1].end = ends[i];
      out[-1].at_end = at_ends[i];
      least = std::min(least, leasts[i]);
      continue;
    }
    if (out != begin && overlaps[i + to_pair] != 0) {
      const std::size_t tie = children.tie[i + to_pair];
      const double place = ties.place[tie];
      const bool clear = ties.found[tie] != 0 && reached == ends[i - step] &&
                         place - out[-1].begin > narrow && ends[i] - place > narrow;
      if (clear) {
        out[-1].end = reached = place;
        out[-1].at_end = ties.at_left[tie];
        from = place;
        at_from = ties.at_right[tie];
      }
    }
    out->begin = from;
    out->end = ends[i];
    out->x = xs[i];
    out->y = ys[i];
    out->at_begin = at_from;
    out->at_end = at_ends[i];
    out->root = roots[i];
    out->from = side.from;
    out->propagated = false;
    double least_here = leasts[i];
    if (!whole) {
      if (!is_of_use(*out, side)) continue;
      least_here = out->least(memory_.beams.offset[i]);
    }
    if (!(reached <= out->begin + touch)) {
      const Seam seam = sew_last(begin, out, side.length);
      if (seam == Seam::not_plain) break;
      if (seam == Seam::fresh_gone) {
        reached = out[-1].end;
        continue;
      }
    }
    ++out;
    last_root = roots[i];
    last_x = xs[i];
    reached = out[-1].end;
    least = std::min(least, least_here);
  }
  order.skip(order.left() - left);
  fresh.size = static_cast<std::size_t>(out - begin);
  fresh.least = least;
}

// Sews the last of the windows from `first` on, which is not counted in yet, to those before
// it that it overlaps.
Seam Propagation::sew_last(Window* first, Window*& last, double length) {
  Window* before = last;
  Seam seam = Seam::old_gone;
  while (seam == Seam::old_gone && before != first && before[-1].end > last->begin) {
    seam = sew(before[-1], *last, true, memory_.roots, length);
    if (seam == Seam::old_gone) --before;
  }
  if (before != last) {
    *before = *last;
    last = before;
  }
  return seam;
}

// Adds the next child, whatever is the matter with it.
void Propagation::add_with_care(const Side& side, ChildOrder& order, FreshList& fresh) {
  const Children& children = memory_.children;
  const std::size_t i = order.next();
  order.skip(1);
  Window window{
      children.begin[i],  children.end[i],       children.x[i], children.y[i], children.at_begin[i],
      children.at_end[i], memory_.beams.root[i], side.from,     false};
  if (children.passes[i] != kWhole && !is_of_use(window, side)) return;
  fresh.least = std::min(fresh.least, window.least(memory_.beams.offset[i]));
  fresh.list.resize(fresh.size);
  append(fresh.list, window, memory_.roots, side.length, memory_.scratch);
  fresh.size = fresh.list.size();
}

// Finds for every beam where the line to the far corner crosses the base, and lowers
// that corner. Returns the beam by which it is nearest. A beam that the line misses
// leads there round its end; that matters only where there is a gap.
std::size_t Propagation::reach_apex(Halfedge h, const CornerAngle& at_tail) {
  const std::uint32_t f = face_of(h);
  const std::uint32_t c = corner_of(h);
  const std::uint32_t apex_corner = previous_corner(c);
  const FaceFrame& frame = frames_.face(f);
  const double left_length = frames_.edge(frame.edge[apex_corner]).length;
  const double apex_x = left_length * at_tail.cosine;
  const double apex_y = left_length * at_tail.sine;
  Beams& beams = memory_.beams;
  const std::size_t best =
      find_crossings(vectors_, beams, apex_x, apex_y, frames_.edge(frame.edge[c]).length);
  const double crossing = std::clamp(beams.crossing[best], beams.begin[best], beams.end[best]);
  const double run = crossing - beams.x[best];
  const double rest = apex_x - crossing;
  const double distance = beams.offset[best] +
                          std::sqrt(run * run + beams.y[best] * beams.y[best]) +
                          std::sqrt(rest * rest + apex_y * apex_y);
  lower(surface_.faces[f].vertex[apex_corner], distance, memory_.roots[beams.root[best]],
        {halfedge(f, apex_corner), beams.size >= crowd_, crossing});
  return best;
}

// A side of a face, for windows counted from the halfedge's tail or from its head.
Side Propagation::side(Halfedge h, bool from_tail) const {
  const std::uint32_t e = frames_.edge_of(h);
  const Edge& edge = edges_[e];
  return {h,
          e,
          frames_.is_reversed(h) == from_tail,
          edge.on_boundary(),
          edge.length,
          field_.distance[edge.tail],
          field_.distance[edge.head],
          edge.settled};
}

// Whether something of a window that comes over a side is nearer than other ways; clips it.
bool Propagation::is_of_use(Window& window, const Side& side) const {
  const double offset = memory_.roots[window.root].offset;
  if (!clip_at_ends(window, offset, side.length, side.at_tail, side.at_head)) return false;
  const double least = window.least(offset);
  return least < side.settled && least <= max_;
}

}  // namespace geodesic::exact
