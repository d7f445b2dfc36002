// The first part of sending out: windows set out from the edges that they are on.
#include <algorithm>
#include <cmath>

#include "core/base/tolerances.h"
#include "core/exact/domain.h"

namespace geodesic::exact {
namespace {

// Of fewer windows on an edge, dropping or joining some spares little.
constexpr std::uint32_t kManyOnEdge = 64;

// On an edge of many faces no more than these, or else those of one face.
constexpr std::size_t kMostTogether = std::size_t{1} << 15U;

}  // namespace

// Propagates the windows that wait on an edge over the faces they did not come from. In the same
// pass it finds the greatest distance on the edge. A window that arrives later and starts farther
// than that is nearer nowhere on the edge.
void Domain::set_out(std::uint32_t e) {
  Edge& edge = state_.edges[e];
  if (edge.pending == kUnreached) return;
  edge.pending = kUnreached;
  const double at_tail = state_.distance[edge.tail];
  const double at_head = state_.distance[edge.head];
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
    const bool is_worth_it = (!from_one || h != from) && !frames().face(face_of(h)).is_copy();
    if (is_worth_it) load_entering(windows, h);
    h = h == edge.first ? edge.second : state_.surface.ring(h);
    if (h != edge.first && memory_.entering.size > kMostTogether) [[unlikely]]
      cross_faces();
  } while (h != edge.first && !cancelled_after(windows.size()));
  for (Window& w : windows) w.propagated = true;
  join_propagated(edge);
  memory_.bounds.emplace_back(e, farthest + least_gap);
}

// In a heap of faces on one line or about one vertex, windows come to an edge by ever more ways,
// each seen where none of the others is. Most of them are farther than the way along the edge from
// the end of another window: the shorter way bends there, and its own windows have not come yet. If
// all were passed on, there would be as many as there are ways. A window whose rays run along the
// edge is dropped even where that way is only as long.
void Domain::drop_overtaken(Edge& edge) {
  if (edge.size < kManyOnEdge) return;
  const std::span<Window> windows(edge.windows, edge.size);
  const auto is_overtaken = [](const Window& w, double along, double straight) {
    const double near = std::max(w.begin - w.x, w.x - w.end);  // negative above the interval
    const double rounding = tolerance::kSameDistance * straight;
    return along < straight + (w.y <= tolerance::kAlongEdge * near ? rounding : -rounding);
  };
  std::uint32_t left = 0;
  double along = state_.distance[edge.tail];  // less the place
  for (const Window& w : windows) {
    const bool goes = is_overtaken(w, along + w.end, w.at_end);
    along = std::min(along, w.at_end - w.end);
    if (!goes) edge.windows[left++] = w;
  }
  std::uint32_t first = left;
  along = state_.distance[edge.head] + edge.length;
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
void Domain::join_propagated(Edge& edge) {
  if (edge.size < kManyOnEdge) return;
  const double gap = tolerance::kLeastGap * edge.length;
  std::uint32_t last = 0;
  for (std::uint32_t i = 1; i < edge.size; ++i) {
    Window& left = edge.windows[last];
    const Window& right = edge.windows[i];
    const bool is_one = left.pseudo_source == right.pseudo_source && left.from == right.from &&
                        right.begin - left.end <= gap &&
                        is_as_good(left, right.begin, right.end, right.at_begin, right.at_end,
                                   pseudo_sources()[left.pseudo_source].offset);
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

// The windows on the edge of h that wait and did not come from its face, in its frame. No shortest
// path crosses a face twice: what has crossed more of them than there are goes round and round,
// where rounding makes it seem nearer each time, as in rings of needles it may.
void Domain::load_entering(std::span<const Window> windows, Halfedge h) {
  EnteringWindows& entering = memory_.entering;
  const std::size_t first = entering.size;
  if (!entering.make_room(first + windows.size(), *poll_)) return;
  const double* const offsets = state_.memory.offsets.data();
  double* const begin = entering.begin.data();
  double* const end = entering.end.data();
  double* const x = entering.x.data();
  double* const y = entering.y.data();
  double* const offset = entering.offset.data();
  std::uint32_t* const pseudo_source = entering.pseudo_source.data();
  std::uint32_t* const faces = entering.faces.data();
  const std::size_t most_faces = state_.surface.faces.size();
  std::size_t size = first;
  if (!frames().is_reversed(h)) {
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
    const double length = frames().edge(frames().edge_of(h)).length;
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
  if (frames().has_flat()) [[unlikely]]
    keep_sources_on_line(first, frames().edge(frames().edge_of(h)).length);
  if (size > first) memory_.over_faces.push_back({.base = h, .first = first, .last = size});
}

// What comes out of a vertex in the middle of the edge, which it came to over faces that are lines,
// fans out at that place. A window that ends there, for on one side of it another one is nearer,
// has the place in it, so that nothing of the fan is lost between the two.
void Domain::keep_sources_on_line(std::size_t first, double length) {
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

// Its windows are of no use any more.
void Domain::let_go(std::uint32_t e) {
  Edge& edge = state_.edges[e];
  if (edge.pending != kUnreached || edge.size == 0) return;
  memory_.pool.give_back(edge.windows, edge.capacity);
  edge.windows = nullptr;
  edge.size = edge.capacity = 0;
  edge.let_go = true;
}

}  // namespace geodesic::exact
