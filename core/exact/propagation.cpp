#include "core/exact/propagation.h"

#include <algorithm>
#include <cmath>

#include "core/base/tolerances.h"

namespace geodesic::exact {
namespace {

// So many windows cross faces together, or more where an edge has more.
constexpr std::size_t kTogether = 256;

// Of fewer windows on an edge, dropping or joining some spares little.
constexpr std::uint32_t kManyOnEdge = 64;

// On an edge of many faces no more than these, or else those of one face.
constexpr std::size_t kMostTogether = std::size_t{1} << 15U;

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
  drop_overtaken(edge);
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
  if (windows.data() == edge.windows) join_propagated(edge);
  bound_edge(e, farthest + least_gap);
}

// In a heap of faces on one line or about one vertex, windows come to an edge by ever more ways,
// each seen where none of the others is. Most of them are farther than the way along the edge from
// the end of another window: the shorter way bends there, and its own windows have not come yet. If
// all were passed on, there would be as many as there are ways. A window whose rays run along the
// edge is dropped even where that way is only as long.
void Propagation::drop_overtaken(Edge& edge) {
  if (edge.size < kManyOnEdge) return;
  const std::span<Window> windows(edge.windows, edge.size);
  const auto is_overtaken = [](const Window& w, double along, double straight) {
    const double near = std::max(w.begin - w.x, w.x - w.end);  // negative above the interval
    const double rounding = tolerance::kSameDistance * straight;
    return along < straight + (w.y <= tolerance::kAlongEdge * near ? rounding : -rounding);
  };
  std::uint32_t left = 0;
  double along = distance_[edge.tail];  // less the place
  for (const Window& w : windows) {
    const bool goes = is_overtaken(w, along + w.end, w.at_end);
    along = std::min(along, w.at_end - w.end);
    if (!goes) edge.windows[left++] = w;
  }
  std::uint32_t first = left;
  along = distance_[edge.head] + edge.length;
  for (std::uint32_t i = left; i-- > 0;) {
    const Window& w = edge.windows[i];
    const bool goes = is_overtaken(w, along - w.begin, w.at_begin);
    along = std::min(along, w.at_begin + w.begin);
    if (!goes) edge.windows[--first] = w;
  }
  std::copy(edge.windows + first, edge.windows + left, edge.windows);
  edge.size = left - first;
}

// Over a flat part cut up into long triangles one window comes in hundreds of pieces, one between
// every two vertices that it passed, at as many different times. Once they have all been passed on
// they are one again, or each that comes would be compared with all of them.
void Propagation::join_propagated(Edge& edge) {
  if (edge.size < kManyOnEdge) return;
  const double gap = tolerance::kLeastGap * edge.length;
  std::uint32_t last = 0;
  for (std::uint32_t i = 1; i < edge.size; ++i) {
    Window& left = edge.windows[last];
    const Window& right = edge.windows[i];
    const bool is_one = left.pseudo_source == right.pseudo_source && left.from == right.from &&
                        right.begin - left.end <= gap &&
                        is_as_good(left, right.begin, right.end, right.at_begin, right.at_end,
                                   memory_.pseudo_sources[left.pseudo_source].offset);
    if (is_one) {
      left.end = right.end;
      left.at_end = right.at_end;
      left.faces = std::max(left.faces, right.faces);
    } else {
      edge.windows[++last] = right;
    }
  }
  edge.size = last + 1;
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

// The windows on the edge of h that wait and did not come from its face, in its frame. No shortest
// path crosses a face twice: what has crossed more of them than there are goes round and round,
// where rounding makes it seem nearer each time, as in rings of needles it may.
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
  std::uint32_t* const faces = entering.faces.data();
  const std::size_t most_faces = surface_.faces.size();
  std::size_t size = first;
  if (!frames_.is_reversed(h)) {
    for (const Window& w : windows) {
      if (w.propagated || w.from == h || w.faces >= most_faces) continue;
      begin[size] = w.begin;
      end[size] = w.end;
      x[size] = w.x;
      y[size] = w.y;
      offset[size] = offsets[w.pseudo_source];
      faces[size] = w.faces;
      pseudo_source[size++] = w.pseudo_source;
    }
  } else {
    const double length = frames_.edge(frames_.edge_of(h)).length;
    for (std::size_t i = windows.size(); i-- > 0;) {
      const Window& w = windows[i];
      if (w.propagated || w.from == h || w.faces >= most_faces) continue;
      begin[size] = length - w.end;
      end[size] = length - w.begin;
      x[size] = length - w.x;
      y[size] = w.y;
      offset[size] = offsets[w.pseudo_source];
      faces[size] = w.faces;
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

}  // namespace geodesic::exact
