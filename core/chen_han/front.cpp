#include "core/chen_han/front.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/tolerances.h"

namespace geodesic::chen_han {
namespace {

constexpr std::uint32_t kMostCrossed = (1U << 30U) - 1;

}  // namespace

// What a source sees of a side of a face: an interval, and the source below the side by `depth`.
struct Front::IntervalOfSource {
  double begin;
  double end;
  double x;
  double depth;
  double offset;
};

// A side over which windows leave a face.
struct Front::Exit {
  Halfedge side;
  std::uint32_t origin;  // the vertex from which positions on it count
  std::uint32_t other;
  double length;
  // The length of the best way by the face's third vertex to the beginning of the interval.
  double by_third;
  bool from_flat_face;
};

// Takes a way of that length to a vertex. It must be a real one: windows are dropped
// by these distances.
void Front::lower(std::uint32_t vertex, double distance, std::uint32_t source) {
  if (!(distance < distance_[vertex])) return;
  if (distance_[vertex] == kUnreached) ++reached_;
  distance_[vertex] = distance;
  if (!field_.nearest_source.empty()) field_.nearest_source[vertex] = source;
  const bool wanted = !limits_.targets.empty() && scratch_.is_target[vertex] != 0;
  if (!bends(vertex) && !wanted) return;
  // What rounding alone can gain is not worth a new start from a pseudo-source.
  double& waiting = scratch_.waiting[vertex];
  if (waiting != kUnreached && !clearly_less(distance, waiting)) return;
  waiting = distance;
  scratch_.queue.push_vertex(distance, vertex);
}

void Front::start(std::uint32_t number) {
  const Source& source = field_.sources[number];
  key_ = source.offset;
  if (source.point.at_vertex()) {
    const std::uint32_t v = source.point.vertex;
    if (!(source.offset < distance_[v])) return;
    // Every source sends out windows, whether or not paths may bend there.
    scratch_.bends[v] = 2;
    lower(v, source.offset, number);
    return;
  }
  for (const SurfacePoint& place : in_all_faces(adjacency_, source.point)) {
    if (poll_.cancelled()) return;
    if (skipped(place.face)) continue;
    for (std::uint32_t c = 0; c < 3; ++c) {
      lower(adjacency_.face(place.face).vertex[c],
            source.offset + distance_to_corner(adjacency_.mesh(), place, c), number);
    }
    for (std::uint32_t c = 0; c < 3; ++c) {
      const double above = place.bary[previous_corner(c)];
      if (!(above > 0)) continue;
      const Halfedge side = halfedge(place.face, c);
      const UnfoldedFace face = UnfoldedFace::over(adjacency_, side);
      Window from{};
      from.offset = source.offset;
      from.pseudo_source = kNone;
      from.source = number;
      from.split_by = kNone;
      leave_root(side, face, place.bary[next_corner(c)] * face.base + above * face.apex_x,
                 above * face.apex_y, from);
    }
  }
}

void Front::spread_from(std::uint32_t vertex) {
  const double d = distance_[vertex];
  key_ = d;
  const std::uint32_t number = source_of(vertex);
  const Source& source = field_.sources[number];
  Window from{};
  from.offset = d;
  from.pseudo_source = source.point.vertex == vertex && source.offset == d ? kNone : vertex;
  from.source = number;
  from.split_by = kNone;
  for (const std::uint32_t corner : adjacency_.corners(vertex)) {
    if (poll_.cancelled()) return;
    const std::uint32_t f = face_of(corner);
    if (skipped(f)) continue;
    const Halfedge side = halfedge(f, next_corner(corner_of(corner)));
    const UnfoldedFace face = UnfoldedFace::over(adjacency_, side);
    lower(face.at_begin, d + face.left, number);
    lower(face.at_end, d + face.right, number);
    leave_root(side, face, face.apex_x, face.apex_y, from);
  }
}

// Xin and Wang 2009, theorem 3.2, (1) and (2): when the way by an end of the edge is
// shorter to the far end of the window, it is shorter to every point of it.
bool Front::useless_on(std::uint32_t at_begin, std::uint32_t at_end, double base,
                       const Window& window) const {
  const double d_begin = distance_[at_begin];
  const double d_end = distance_[at_end];
  return clearly_less(d_begin + window.end, window.at(window.end)) ||
         clearly_less(d_end + (base - window.begin), window.at(window.begin));
}

// When the way by the far corner of the face beyond is shorter everywhere, what the window
// sees in the face is nearer to the corner.
bool Front::useless_in(const UnfoldedFace& face, const Window& window) const {
  if (useless_on(face.at_begin, face.at_end, face.base, window)) return true;
  const double d_apex = distance_[face.opposite];
  return d_apex != kUnreached && nearer_along(face.apex_x, face.apex_y, d_apex, window);
}

// Through every other face on the side, what is not useless goes into the queue.
void Front::pass(const Exit& exit, const SideInterval& at, const Window& from) {
  if (is_gap(at, exit.length)) return;
  Window window = from;
  window.begin = at.begin;
  window.end = at.end;
  window.x = at.x;
  window.y = std::max(at.y, tolerance::kDepthOnLine * exit.length);
  const double along = window.x - std::clamp(window.x, window.begin, window.end);
  if (exit.length < tolerance::kPoint * length(along, window.y)) return;
  // No shortest path crosses a face twice.
  if (window.crossed >= std::min(taking_part_, kMostCrossed)) return;
  window.crossed = window.crossed + 1;
  // Theorem 3.2, (3): a way by the third vertex of the face, across all the rays.
  if (clearly_less(exit.by_third, window.at(window.begin))) return;
  if (useless_on(exit.origin, exit.other, exit.length, window)) return;
  const Halfedge first = next_around(exit.side);
  if (first == exit.side) return;
  const bool branches = next_around(first) != exit.side;
  window.branched = from.branched != 0 || exit.from_flat_face || branches ? 1 : 0;
  if (see_all_ && !enter_edge(exit, window)) return;
  const double key = std::max(key_, window.least());
  if (key > limits_.max) return;
  Window mirrored = window;
  mirrored.mirror(exit.length);
  for (Halfedge h = first; h != exit.side; h = next_around(h)) {
    if (poll_.cancelled()) return;
    const bool same_way = adjacency_.face(face_of(h)).vertex[corner_of(h)] == exit.origin;
    Window& into = same_way ? window : mirrored;
    if (!(into.begin < into.end)) continue;
    into.into = h;
    if (scratch_.queue.is_full() && !poll_.may_take(scratch_.queue.bytes_to_grow())) return;
    scratch_.queue.push_window(key, into);
  }
}

// SeenWindows::enter for a window that counts positions from the side's origin.
bool Front::enter_edge(const Exit& exit, Window& window) {
  if (scratch_.seen.is_full() && !poll_.may_take(scratch_.seen.bytes_to_grow())) return false;
  const bool same_way =
      adjacency_.face(face_of(exit.side)).vertex[corner_of(exit.side)] == exit.origin;
  window.into = exit.side;
  if (!same_way) window.mirror(exit.length);
  const bool entered = scratch_.seen.enter(window, exit.length, poll_);
  if (!same_way) window.mirror(exit.length);
  return entered;
}

void Front::spread(Window window) {
  const UnfoldedFace face = UnfoldedFace::over(adjacency_, window.into);
  // Distances are known better than when it was put into the queue.
  if (window.split_by != kNone) {
    const double crossing = scratch_.occupier[window.split_by].crossing;
    if (window.left != 0 ? crossing < window.split_limit : crossing > window.split_limit) return;
  }
  if (useless_in(face, window)) return;
  if (window.branched != 0 && !scratch_.seen.trim_again(window, face.base, poll_)) return;
  key_ = window.least();
  if (limits_.keep_details) keep(window);
  for_each_piece(window.into, {window.begin, window.end, window.x, window.y, window.offset},
                 [&](double begin, double end) {
                   Window piece = window;
                   piece.begin = begin;
                   piece.end = end;
                   propagate_piece(piece, face);
                 });
}

// "One angle, one split" is proved for strips of faces without a source inside: of
// two paths one may start within the strip of the other, instead of crossing it. So
// a window is cut in two along its ray to a source in the face, unless that source is
// nearer to something else. Calls visit(begin, end) for the pieces of [begin, end] on
// a side of the face; `depth` is that of the window's source below the side, with the
// face above it or (negative) below.
template <class Visit>
void Front::for_each_piece(Halfedge side, const IntervalOfSource& from, Visit visit) {
  const std::uint32_t f = face_of(side);
  const std::uint32_t c = corner_of(side);
  if (scratch_.source_in_face.empty() || scratch_.source_in_face[f] == 0) {
    visit(from.begin, from.end);
    return;
  }
  const UnfoldedFace face = UnfoldedFace::over(adjacency_, side);
  std::vector<double> cuts{from.begin, from.end};
  auto place =
      std::lower_bound(scratch_.places.begin(), scratch_.places.end(), f,
                       [](const auto& p, std::uint32_t wanted) { return p.face < wanted; });
  for (; place != scratch_.places.end() && place->face == f; ++place) {
    const double above = place->bary[previous_corner(c)];
    const double x = place->bary[next_corner(c)] * face.base + above * face.apex_x;
    const double y = above * face.apex_y;
    const double rise = y + from.depth;
    // A window whose source is within the face meets what lies between its source and the side.
    if (from.depth < 0 && !(rise < 0)) continue;
    const double cut = from.x + (x - from.x) * (from.depth / rise);
    if (!(cut > from.begin && cut < from.end)) continue;
    const double offset = field_.sources[place->source].offset;
    if (!clearly_less(from.offset + length(x - from.x, rise), offset)) cuts.push_back(cut);
  }
  std::sort(cuts.begin(), cuts.end());
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    if (cuts[i] < cuts[i + 1]) visit(cuts[i], cuts[i + 1]);
  }
}

// The windows of a source in a corner of the face or inside it, through one side. The source
// stands over (x, 0) of the side at the height y.
void Front::leave_root(Halfedge side, const UnfoldedFace& face, double x, double y,
                       const Window& from) {
  const Exit exit{side,      face.at_begin, face.at_end,
                  face.base, kUnreached,    has_no_area(adjacency_.face(face_of(side)))};
  for_each_piece(side, {0, face.base, x, -y, from.offset}, [&](double begin, double end) {
    pass(exit, {begin, end, x, y}, from);
  });
}

void Front::propagate_piece(const Window& w, const UnfoldedFace& face) {
  const double to_apex = (w.y * face.apex_x + w.x * face.apex_y) / (w.y + face.apex_y);
  const bool meets = w.begin <= to_apex && to_apex <= w.end;
  const double bend = std::clamp(to_apex, w.begin, w.end);
  const double d_apex = meets ? w.offset + length(face.apex_x - w.x, face.apex_y + w.y)
                              : w.at(bend) + length(face.apex_x - bend, face.apex_y);
  lower(face.opposite, d_apex, w.source);
  lower(face.opposite, distance_[face.at_begin] + face.left, source_of(face.at_begin));
  lower(face.opposite, distance_[face.at_end] + face.right, source_of(face.at_end));

  const double hair = tolerance::kSameLine * face.base;
  bool left = w.begin < to_apex;
  bool right = w.end > to_apex;
  if (meets) {
    // One angle, one split: a window that is not the nearest to the vertex keeps only
    // the side on which its rays do not cross the nearest one's ray to the vertex.
    auto& occupier = scratch_.occupier[w.into];
    if (d_apex < occupier.distance) {
      occupier = {d_apex, to_apex};
    } else if (w.branched == 0 && to_apex < occupier.crossing - hair) {
      right = false;
    } else if (w.branched == 0 && to_apex > occupier.crossing + hair) {
      left = false;
    }
  }
  const std::uint32_t f = face_of(w.into);
  const std::uint32_t c = corner_of(w.into);
  const bool flat = has_no_area(adjacency_.face(f));
  // Mirrored when on the right, the side runs from the base's beginning to the apex.
  const auto leave = [&](Halfedge side, bool mirrored) {
    const double begin = mirrored ? face.base - w.end : w.begin;
    const double end = mirrored ? face.base - w.begin : w.end;
    const double x = mirrored ? face.base - w.x : w.x;
    const double apex_x = mirrored ? face.apex_back : face.apex_x;
    const double cut = mirrored ? (w.y * apex_x + x * face.apex_y) / (w.y + face.apex_y) : to_apex;
    const double side_length = mirrored ? face.right : face.left;
    if (!(begin < cut)) return;
    const SideInterval at = over_side(begin, end, x, w.y, apex_x, face.apex_y, cut, side_length);
    const double along = at.begin / side_length;
    const double to_third = length(face.base - along * apex_x, along * face.apex_y);
    const std::uint32_t origin = mirrored ? face.at_end : face.at_begin;
    const std::uint32_t third = mirrored ? face.at_begin : face.at_end;
    Window from = w;
    from.left = mirrored ? 0 : 1;
    from.split_by = meets && w.branched == 0 ? w.into : kNone;
    from.split_limit = to_apex + (mirrored ? hair : -hair);
    pass({side, origin, face.opposite, side_length, distance_[third] + to_third, flat}, at, from);
  };
  if (left) leave(halfedge(f, previous_corner(c)), false);
  if (right) leave(halfedge(f, next_corner(c)), true);
}

}  // namespace geodesic::chen_han
