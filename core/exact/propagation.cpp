#include "core/exact/propagation.h"

#include <algorithm>
#include <cmath>

#include "core/base/tolerances.h"

namespace geodesic::exact {
namespace {

// So many windows cross faces together, or more where an edge has more.
constexpr std::size_t kTogether = 256;

// On an edge of many faces no more than these, or else those of one face.
constexpr std::size_t kMostTogether = std::size_t{1} << 15U;

// Of a list that comes to an edge, so many without a question.
constexpr std::size_t kPlainAtOnce = 1024;

// Behind so many windows on an edge a vertex may become a source. What starts
// little earlier than it was reached spares few of them, and its own meet the others at more
// places: the less the tolerance, the more there must be. Measured: 8 at 1e-2, 13 at 1e-3,
// 22 at 1e-4, beyond which it makes no difference.
std::size_t windows_for_early_source(double tolerance) {
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
      poll_(poll),
      surface_(surface),
      memory_(memory),
      frames_(memory.frames),
      field_(field),
      distance_(field.distance.doubles()),
      max_(max * (1 + tolerance) * (1 + tolerance)),
      tolerance_(tolerance),
      keep_windows_(keep_windows),
      windows_for_early_source_(windows_for_early_source(tolerance)) {
  memory.frames.build(adjacency, surface, poll);
  if (poll.stopped()) return;
  memory.pool.reset(poll);
  if (poll.stopped()) return;
  double least = kUnreached;
  for (const Source& source : field.sources) least = std::min(least, source.offset);
  memory.queue.reset(least, 0.25 * frames_.mean_shortest_side());
  edges_ = memory.frames.edges();
  memory.pseudo_sources.clear();
  memory.offsets.clear();
  const std::size_t vertex_count = adjacency.mesh().vertex_count();
  memory.arrivals.assign(vertex_count, {kNone, false, 0});
  memory.bends.assign(frames_.bends().begin(), frames_.bends().end());
  // Mostly, each vertex where paths bend sends out windows once.
  const auto bending = static_cast<std::size_t>(std::count_if(
      memory.bends.begin(), memory.bends.end(), [](Bends b) { return b != Bends::nowhere; }));
  memory.pseudo_sources.reserve(bending + field.sources.size());
  memory.offsets.reserve(bending + field.sources.size());
  memory.emitted.assign(vertex_count, kUnreached);
  memory.allowance.assign(tolerance > 0 ? vertex_count : 0, 0);
}

void Propagation::keep_windows_of(std::span<const std::uint32_t> faces) {
  keeps_some_ = true;
  keep_of_.assign(surface_.faces.size(), false);
  keep_on_edge_.assign(edges_.size(), false);
  for (const std::uint32_t f : faces) {
    keep_of_[f] = true;
    for (const std::uint32_t e : frames_.face(f).edge) keep_on_edge_[e] = true;
  }
}

std::uint32_t Propagation::add_pseudo_source(const PseudoSource& pseudo_source) {
  std::vector<PseudoSource>& all = memory_.pseudo_sources;
  // What is refused, the computation learns when it polls next.
  if (all.size() == all.capacity()) (void)poll_.may_take(2 * all.size() * sizeof(PseudoSource));
  all.push_back(pseudo_source);
  memory_.offsets.push_back(pseudo_source.offset);
  return static_cast<std::uint32_t>(all.size() - 1);
}

// What is in one bucket of the queue may be done in any order. So windows are gathered from some
// edges, and then cross their faces together, each part of the work for all of them: what one
// list waits for does not keep the others.
bool Propagation::step() {
  memory_.entering.size = 0;
  memory_.over_faces.clear();
  Waiting next{};
  if (!memory_.queue.pop(next)) return false;
  do {
    switch (next.what) {
      case Waiting::What::edge:
        edges_[next.number].queued = kUnreached;
        set_out(next.number);
        break;
      case Waiting::What::vertex:
        bend_at(next.number);
        break;
      case Waiting::What::bounded_edge:
        let_go(next.number);
        break;
    }
  } while (memory_.entering.size < kTogether && memory_.queue.pop_near(next));
  cross_faces();
  return true;
}

// Propagates the windows that wait on an edge over the faces they did not come from. In the same
// pass it finds the greatest distance on the edge. A window that arrives later and starts farther
// than that is nearer nowhere on the edge.
void Propagation::set_out(std::uint32_t e) {
  Edge& edge = edges_[e];
  if (edge.pending == kUnreached) return;
  edge.pending = kUnreached;
  const double at_tail = distance_[edge.tail];
  const double at_head = distance_[edge.head];
  double farthest = 0;
  double covered = 0;
  const auto gap = [&](double begin, double end) {
    farthest = std::max(farthest, std::min(at_tail + end, at_head + (edge.length - begin)));
  };
  std::span<Window> windows(edge.windows, edge.size);
  Halfedge from = kNone;  // of those that wait
  bool from_one = true;
  // Less than this is rounding, and no branch worth.
  const double least_gap = tolerance::kLeastGap * edge.length;
  for (const Window& w : windows) {
    if (covered + least_gap < w.begin) gap(covered, w.begin);
    farthest = std::max(farthest, std::max(w.at_begin, w.at_end));
    covered = w.end;
    if (w.propagated) continue;
    if (from == kNone) from = w.from;
    from_one &= w.from == from;
  }
  if (covered < edge.length) gap(covered, edge.length);
  Halfedge h = edge.first;
  do {
    // Over a face with the same edges as another one it is as far as over that one. And windows
    // that pass to and fro between such faces, if thin, would gain by rounding for ever.
    const bool is_worth_it = (!from_one || h != from) && !frames_.face(face_of(h)).is_copy();
    if (is_worth_it) load_entering(windows, h);
    h = h == edge.first ? edge.second : surface_.ring(h);
    if (h != edge.first && memory_.entering.size > kMostTogether) [[unlikely]] {
      if (windows.data() == edge.windows) windows = take_waiting(windows);
      cross_faces();
      memory_.entering.size = 0;
      memory_.over_faces.clear();
    }
  } while (h != edge.first && !cancelled_after(windows.size()));
  for (Window& w : windows) w.propagated = true;
  bound_edge(e, farthest + least_gap);
}

// Those that wait, apart: of an edge that is in a face twice, more may come while they cross.
std::span<Window> Propagation::take_waiting(std::span<Window> windows) {
  std::vector<Window>& waiting = memory_.waiting;
  waiting.clear();
  if (!may_hold(waiting, windows.size())) return {};
  waiting.reserve(windows.size());
  for (Window& w : windows) {
    if (w.propagated) continue;
    waiting.push_back(w);
    w.propagated = true;
  }
  return waiting;
}

// The windows on the edge of h that wait and did not come from its face, in its frame.
void Propagation::load_entering(std::span<const Window> windows, Halfedge h) {
  EnteringWindows& entering = memory_.entering;
  const std::size_t first = entering.size;
  if (!entering.make_room(first + windows.size(), poll_)) return;
  const double* const offsets = memory_.offsets.data();
  double* const begin = entering.begin.data();
  double* const end = entering.end.data();
  double* const x = entering.x.data();
  double* const y = entering.y.data();
  double* const offset = entering.offset.data();
  std::uint32_t* const pseudo_source = entering.pseudo_source.data();
  std::size_t size = first;
  if (!frames_.is_reversed(h)) {
    for (const Window& w : windows) {
      if (w.propagated || w.from == h) continue;
      begin[size] = w.begin;
      end[size] = w.end;
      x[size] = w.x;
      y[size] = w.y;
      offset[size] = offsets[w.pseudo_source];
      pseudo_source[size++] = w.pseudo_source;
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
      offset[size] = offsets[w.pseudo_source];
      pseudo_source[size++] = w.pseudo_source;
    }
  }
  entering.size = size;
  if (frames_.has_flat()) [[unlikely]]
    keep_sources_on_line(first, frames_.edge(frames_.edge_of(h)).length);
  if (size > first) memory_.over_faces.push_back({.base = h, .first = first, .last = size});
}

// What comes out of a vertex in the middle of the edge, which it came to over faces that are lines,
// fans out at that place. A window that ends there, for on one side of it another one is nearer,
// has the place in it, so that nothing of the fan is lost between the two.
void Propagation::keep_sources_on_line(std::size_t first, double length) {
  EnteringWindows& entering = memory_.entering;
  for (std::size_t i = first; i < entering.size; ++i) {
    if (!(entering.y[i] <= tolerance::kOnLine * length)) continue;
    const double half_width = tolerance::kAtEnd * length;
    const double x = entering.x[i];
    if (!(x >= entering.begin[i] - half_width && x <= entering.end[i] + half_width)) continue;
    entering.y[i] = 0;
    entering.begin[i] = std::max(std::min(entering.begin[i], x - half_width), 0.0);
    entering.end[i] = std::min(std::max(entering.end[i], x + half_width), length);
  }
}

// The lists cross their faces and arrive on the sides beyond.
void Propagation::cross_faces() {
  if (memory_.over_faces.empty()) return;
  if (poll_.stopped()) return;
  for (ListOverFace& list : memory_.over_faces) unfold(list);
  for (ListOverFace& list : memory_.over_faces) find_nearest(list);
  for (const ListOverFace& list : memory_.over_faces) reach_apex(list);
  memory_.over_sides.clear();
  const std::size_t count = memory_.entering.size;
  for (PropagatedWindows& beyond : memory_.beyond) {
    if (!beyond.make_room(count, poll_)) return;
  }
  for (EquidistantPoints& equidistant : memory_.equidistant) {
    if (!equidistant.make_room(count, poll_)) return;
    equidistant.size = 0;
  }
  for (const ListOverFace& list : memory_.over_faces) cross_to_sides(list);
  for (const ListOverSide& list : memory_.over_sides) {
    pair_overlaps(vectors_, list.first, list.last, list.upwards, list.side.length,
                  memory_.beyond[list.on_right], memory_.equidistant[list.on_right]);
  }
  for (std::size_t i = 0; i < 2; ++i) {
    if (memory_.equidistant[i].size > 0) {
      find_equidistant_points(vectors_, memory_.entering, memory_.beyond[i],
                              memory_.equidistant[i]);
    }
  }
  for (const ListOverSide& list : memory_.over_sides) {
    if (cancelled_after(list.last - list.first)) return;
    arrive(list);
  }
}

void Propagation::unfold(ListOverFace& list) const {
  const std::uint32_t f = face_of(list.base);
  const std::uint32_t c = corner_of(list.base);
  list.base_length = frames_.length(f, c);
  list.at_tail = frames_.angle(f, c);
  const double left_length = frames_.length(f, previous_corner(c));
  list.apex_x = left_length * list.at_tail.cosine;
  list.apex_y = left_length * list.at_tail.sine;
}

// Finds for every entering window where the line to the far corner crosses the base, and the one by
// which that corner is nearest. A window that the line misses leads there round its end; that
// matters only where no window is.
void Propagation::find_nearest(ListOverFace& list) {
  EnteringWindows& entering = memory_.entering;
  list.best = find_crossings(vectors_, entering, list.first, list.last, list.apex_x, list.apex_y,
                             list.base_length);
  const std::size_t best = list.best;
  list.crossing = std::clamp(entering.crossing[best], entering.begin[best], entering.end[best]);
  const double run = list.crossing - entering.x[best];
  const double rest = list.apex_x - list.crossing;
  list.distance = entering.offset[best] +
                  std::sqrt(run * run + entering.y[best] * entering.y[best]) +
                  std::sqrt(rest * rest + list.apex_y * list.apex_y);
}

void Propagation::reach_apex(const ListOverFace& list) {
  const std::uint32_t f = face_of(list.base);
  const std::uint32_t apex_corner = previous_corner(corner_of(list.base));
  const std::uint32_t pseudo_source = memory_.entering.pseudo_source[list.best];
  relax(surface_.faces[f].vertex[apex_corner], list.distance, memory_.pseudo_sources[pseudo_source],
        {halfedge(f, apex_corner), list.last - list.first >= windows_for_early_source_,
         list.crossing});
}

// Over the sides from the far corner to the base's tail and from the base's head to it. Where
// only the best window may come to one, mostly it does not. Over a face that is a line a ray goes
// on at the place where it came, so that none of them cross, and each goes to the side that has it.
void Propagation::cross_to_sides(const ListOverFace& list) {
  const EnteringWindows& entering = memory_.entering;
  propagated_ += list.last - list.first;
  const std::size_t best = list.best;
  if (frames_.face(face_of(list.base)).is_flat()) [[unlikely]] {
    cross_to_side(list, false, list.first, list.last);
    cross_to_side(list, true, list.first, list.last);
    return;
  }
  if (best > list.first || entering.begin[best] < entering.crossing[best]) {
    cross_to_side(list, false, list.first, best + 1);
  }
  if (best + 1 < list.last || entering.crossing[best] < entering.end[best]) {
    cross_to_side(list, true, best, list.last);
  }
}

void Propagation::cross_to_side(const ListOverFace& list, bool on_right, std::size_t first,
                                std::size_t last) {
  const std::uint32_t f = face_of(list.base);
  const std::uint32_t c = corner_of(list.base);
  const Side side =
      this->side(halfedge(f, on_right ? next_corner(c) : previous_corner(c)), on_right);
  if (side.on_boundary) return;
  const CornerAngle angle = on_right ? frames_.angle(f, next_corner(c)) : list.at_tail;
  const SideFrame frame{on_right,    side.flipped, list.base_length, angle.cosine,     angle.sine,
                        side.length, side.at_tail, side.at_head,     side.upper_bound, max_};
  exact::cross_to_side(vectors_, memory_.entering, first, last, frame, memory_.beyond[on_right]);
  // On the left side t grows with the place on the base.
  memory_.over_sides.push_back({side, first, last, on_right, on_right == side.flipped});
}

// The propagated windows of a list join what is on their edge.
void Propagation::arrive(const ListOverSide& list) {
  PropagatedOrder order{list.first, list.last, list.upwards};
  FreshList fresh{memory_.fresh, 0, kUnreached};
  for (;;) {
    const bool is_plain = add_plain(list, order, fresh);
    if (poll_.stopped()) return;
    if (order.left() == 0) break;
    if (is_plain) {
      if (cancelled_after(kPlainAtOnce)) return;
      continue;
    }
    add_with_care(list, order, fresh);
    // What it overlapped has been taken apart, and room is made anew for those to come.
    if (cancelled_after(memory_.scratch.size() + std::min(order.left(), kPlainAtOnce))) return;
  }
  commit(list.side.edge, {fresh.list.data(), fresh.size}, fresh.least);
}

// Adds windows in the order on the edge, as long as they can be trimmed to those before:
// nearly all of them can, and most come whole and meet none but the one before. False at one that
// cannot; true after some, or the last.
bool Propagation::add_plain(const ListOverSide& list, PropagatedOrder& order, FreshList& fresh) {
  const Side& side = list.side;
  const std::size_t count = std::min(order.left(), kPlainAtOnce);
  const std::size_t most = fresh.size + count;
  if (fresh.list.size() < most) {
    if (!may_hold(fresh.list, most)) return false;
    fresh.list.resize(most);
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
  const double touch = tolerance::kTouch * side.length;
  const double narrow = tolerance::kLeastWidth * side.length;
  const double nearly = tolerance::kNearlyTouch * side.length;
  const std::size_t step = order.upwards ? 1 : static_cast<std::size_t>(-1);
  // The one before a window on the edge is numbered before it, or it before that one.
  const std::size_t to_pair = order.upwards ? 0 : 1;
  std::size_t i = order.next();
  std::size_t left = count;
  double least = fresh.least;
  Window* const begin = fresh.list.data();
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
Trimming Propagation::trim_last(Window* first, Window*& last, double length) {
  Window* before = last;
  Trimming trimming = Trimming::old_gone;
  while (trimming == Trimming::old_gone && before != first && before[-1].end > last->begin) {
    trimming = trim(before[-1], *last, true, memory_.pseudo_sources, length);
    if (trimming == Trimming::old_gone) --before;
  }
  if (before != last) {
    *before = *last;
    last = before;
  }
  return trimming;
}

// Adds the next window, whatever is the matter with it.
void Propagation::add_with_care(const ListOverSide& list, PropagatedOrder& order,
                                FreshList& fresh) {
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
                false};
  if (beyond.passes[i] != kWhole && !is_of_use(window, side)) return;
  fresh.least = std::min(fresh.least, window.least(memory_.entering.offset[i]));
  fresh.list.resize(fresh.size);
  memory_.scratch.clear();
  append(fresh.list, window, memory_.pseudo_sources, side.length, memory_.scratch);
  fresh.size = fresh.list.size();
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
          distance_[edge.tail],
          distance_[edge.head],
          edge.upper_bound};
}

// Whether something of a window that comes over a side is nearer than other ways; clips it.
bool Propagation::is_of_use(Window& window, const Side& side) const {
  const double offset = memory_.pseudo_sources[window.pseudo_source].offset;
  if (!clip_at_ends(window, offset, side.length, side.at_tail, side.at_head)) return false;
  const double least = window.least(offset);
  return least < side.upper_bound && least <= max_;
}

}  // namespace geodesic::exact
