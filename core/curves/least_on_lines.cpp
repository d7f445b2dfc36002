#include "core/curves/least_on_lines.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "core/base/polled_sort.h"
#include "core/base/tolerances.h"
#include "core/field/edge_points.h"
#include "core/field/window_table.h"

namespace geodesic {
namespace {

// A straight segment in the plane of a face.
struct FlatSegment {
  FlatPoint from;
  FlatPoint to;

  [[nodiscard]] FlatPoint at(double part) const {
    return {from.x + part * (to.x - from.x), from.y + part * (to.y - from.y)};
  }
  // Its point that is closest to a place.
  [[nodiscard]] FlatPoint foot_of(double x, double y) const {
    const double along = to.x - from.x;
    const double up = to.y - from.y;
    const double square = along * along + up * up;
    if (!(square > 0)) return from;
    return at(std::clamp(((x - from.x) * along + (y - from.y) * up) / square, 0.0, 1.0));
  }
  [[nodiscard]] double distance_to(double x, double y) const {
    const FlatPoint foot = foot_of(x, y);
    return std::hypot(foot.x - x, foot.y - y);
  }
};

// A place of a face, laid over the side that starts at corner c.
FlatPoint over_side(const FaceOnBase& over, std::uint32_t c, const std::array<double, 3>& bary) {
  const double above = bary[previous_corner(c)];
  return {bary[next_corner(c)] * over.base + above * over.apex_x, above * over.apex_y};
}

// The way from a window's source to a point above, which bends at the window's end if it has to.
double through(const VisibleInterval& window, const FlatPoint& to) {
  const double rise = window.y + to.y;
  const double straight = rise > 0 ? window.x + (to.x - window.x) * (window.y / rise) : to.x;
  const double at = std::clamp(straight, window.begin, window.end);
  return window.offset + std::hypot(at - window.x, window.y) + std::hypot(to.x - at, to.y);
}

// The least of these ways to a segment: each is convex along it, and straight from the source or
// from an end of the window wherever it leads.
double least_through(const VisibleInterval& window, const FlatSegment& segment) {
  return std::min({through(window, segment.from), through(window, segment.to),
                   through(window, segment.foot_of(window.x, -window.y)),
                   through(window, segment.foot_of(window.begin, 0)),
                   through(window, segment.foot_of(window.end, 0))});
}

// The least of a strip's distances on a segment, which are linear; kUnreached where it goes by.
double least_in(const LineStrip& strip, const FlatSegment& segment, double slack) {
  // Where the line of flow through a point crosses the base.
  const auto flows_from = [&](const FlatPoint& p) { return p.x - p.y * (strip.b / strip.c); };
  const double begin = strip.begin - slack;
  const double end = strip.end + slack;
  const double at_from = flows_from(segment.from);
  const double at_to = flows_from(segment.to);
  double first = 0;
  double last = 1;
  const auto keep_above = [&](double from, double to) {
    if (from < 0 && to < 0) {
      last = -1;
    } else if (from < 0) {
      first = std::max(first, from / (from - to));
    } else if (to < 0) {
      last = std::min(last, from / (from - to));
    }
  };
  keep_above(at_from - begin, at_to - begin);
  keep_above(end - at_from, end - at_to);
  if (!(first <= last)) return kUnreached;
  const auto distance_at = [&](double part) {
    const FlatPoint p = segment.at(part);
    return strip.value + strip.b * (p.x - strip.begin) + strip.c * p.y;
  };
  return std::max(0.0, std::min(distance_at(first), distance_at(last)));
}

// Calls `visit(face, from, to)` for each face that a segment lies in, with its ends there.
template <class Visit>
void in_each_face(const Adjacency& adjacency, const LineSegment& segment, Poll& poll,
                  const Visit& visit) {
  visit(segment.face, segment.from, segment.to);
  const Halfedge h = segment.along();
  if (h == kNone) return;
  const std::uint32_t tail = corner_of(h);
  const std::uint32_t head = next_corner(tail);
  for (Halfedge g = adjacency.ring(h); g != h; g = adjacency.ring(g)) {
    if (poll.cancelled()) return;
    std::uint32_t there = corner_of(g);
    std::uint32_t other = next_corner(there);
    if (adjacency.tail(g) != adjacency.tail(h)) std::swap(there, other);
    std::array<double, 3> from{};
    std::array<double, 3> to{};
    from[there] = segment.from[tail];
    from[other] = segment.from[head];
    to[there] = segment.to[tail];
    to[other] = segment.to[head];
    visit(face_of(g), from, to);
  }
}

// False, and nothing added, if there is no memory for it.
template <class Value>
bool add_within_budget(std::vector<Value>& values, const Value& value, Poll& poll) {
  if (values.size() == values.capacity()) {
    const std::size_t more = std::max<std::size_t>(64, values.size());
    // As it grows, it is there twice.
    if (!poll.may_take(2 * more * sizeof(Value))) return false;
    values.reserve(values.size() + more);
  }
  values.push_back(value);
  return true;
}

// A face, an edge or a vertex that lines lie in. An edge is known by its vertices: it is the same
// from all of its faces, however many they are.
struct LinePlace {
  // A face and kNone, an edge's vertices, ascending, or a vertex twice.
  std::array<std::uint32_t, 2> key;
  Halfedge along = kNone;  // of an edge, whichever of its halfedges
};

std::array<std::uint32_t, 2> key_of_edge(const Adjacency& adjacency, Halfedge h) {
  const std::uint32_t tail = adjacency.tail(h);
  const std::uint32_t head = adjacency.head(h);
  return {std::min(tail, head), std::max(tail, head)};
}

LinePlace place_in(const Adjacency& adjacency, std::uint32_t face, Halfedge along) {
  if (along == kNone) return {{face, kNone}, kNone};
  return {key_of_edge(adjacency, along), along};
}

LinePlace place_of(const Adjacency& adjacency, const SurfacePoint& point) {
  if (point.at_vertex()) return {{point.vertex, point.vertex}, kNone};
  return place_in(adjacency, point.face, edge_under(point));
}

// Adds the faces round a place. False if the poll says to stop.
bool add_faces_round(const Adjacency& adjacency, const LinePlace& place,
                     std::vector<std::uint32_t>& faces, Poll& poll) {
  const auto add = [&](std::uint32_t f) {
    return !poll.cancelled() && add_within_budget(faces, f, poll);
  };
  if (place.along != kNone) {
    Halfedge h = place.along;
    do {
      if (!add(face_of(h))) return false;
      h = adjacency.ring(h);
    } while (h != place.along);
    return true;
  }
  if (place.key[1] == kNone) return add(place.key[0]);
  const auto corners = adjacency.corners(place.key[0]);
  return std::all_of(corners.begin(), corners.end(),
                     [&](std::uint32_t corner) { return add(face_of(corner)); });
}

// The faces round all of the places, ascending and each once. A place that is there a thousand
// times is gone round once. Of no use if the poll says to stop.
std::vector<std::uint32_t> faces_round(const Adjacency& adjacency, std::vector<LinePlace>& places,
                                       Poll& poll) {
  std::vector<std::uint32_t> faces;
  std::vector<LinePlace> spare_places;
  polled_sort(
      places, 0, places.size(),
      [](const LinePlace& a, const LinePlace& b) { return a.key < b.key; }, spare_places, poll);
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (poll.stopped() || poll.cancelled()) return faces;
    if (i > 0 && places[i].key == places[i - 1].key) continue;
    if (!add_faces_round(adjacency, places[i], faces, poll)) return faces;
  }
  std::vector<std::uint32_t> spare_faces;
  polled_sort(faces, 0, faces.size(), std::less<>(), spare_faces, poll);
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  return faces;
}

// False if the poll says to stop.
bool add_places(const Adjacency& adjacency, std::span<const LineSegment> segments,
                std::vector<LinePlace>& places, Poll& poll) {
  for (const LineSegment& segment : segments) {
    const LinePlace place = place_in(adjacency, segment.face, segment.along());
    if (poll.cancelled() || !add_within_budget(places, place, poll)) return false;
  }
  return true;
}

}  // namespace

std::vector<std::uint32_t> faces_of_lines(const Adjacency& adjacency,
                                          std::span<const LineSegment> segments, Poll& poll) {
  std::vector<LinePlace> places;
  if (!add_places(adjacency, segments, places, poll)) return {};
  return faces_round(adjacency, places, poll);
}

FieldOnLines::FieldOnLines(const Adjacency& adjacency, const Field& field, Poll& poll)
    : adjacency_(adjacency), field_(field), poll_(poll) {
  std::vector<LinePlace> places;
  if (!add_places(adjacency, field.lines->lines().segments, places, poll)) return;
  for (std::uint32_t s = 0; s < field.lines->given(); ++s) {
    const Source& source = field.sources[s];
    const LinePlace place = place_of(adjacency, source.point);
    if (poll.cancelled() || !add_within_budget(places, place, poll)) return;
    // At a vertex it is a corner with a distance.
    if (source.point.at_vertex()) continue;
    PointSource kept{place.key, source.offset, source.point.bary};
    if (place.along != kNone) {
      // The lower vertex first, as the key has them.
      const std::uint32_t c = corner_of(place.along);
      kept.weights = {source.point.bary[c], source.point.bary[next_corner(c)], 0};
      if (adjacency.tail(place.along) != place.key[0]) std::swap(kept.weights[0], kept.weights[1]);
    }
    if (!add_within_budget(sources_, kept, poll)) return;
  }
  around_ = faces_round(adjacency, places, poll);
  std::vector<PointSource> spare;
  polled_sort(
      sources_, 0, sources_.size(),
      [](const PointSource& a, const PointSource& b) { return a.place < b.place; }, spare, poll);
}

bool FieldOnLines::meets(std::span<const std::uint32_t> faces) const {
  return std::any_of(faces.begin(), faces.end(), [&](std::uint32_t f) {
    return !poll_.cancelled() && (field_.lines->lines().has_face(f) ||
                                  std::binary_search(around_.begin(), around_.end(), f));
  });
}

double FieldOnLines::least(std::span<const LineSegment> segments) const {
  double least = kUnreached;
  for (const LineSegment& segment : segments) {
    if (poll_.cancelled() || least == 0) break;
    in_each_face(adjacency_, segment, poll_,
                 [&](std::uint32_t f, const auto& from, const auto& to) {
                   if (least > 0) lower_within({f, from, to}, least);
                 });
  }
  if (field_.bound != Bound::upper || least == 0 || least == kUnreached) return least;
  const Box& box = adjacency_.mesh().box();
  return least + tolerance::kWindows * (least + norm(box.max - box.min));
}

bool FieldOnLines::crosses_a_line(const Piece& piece) const {
  const std::span<const std::uint32_t> others = field_.lines->segments_within(piece.face);
  if (others.empty()) return false;
  const FaceOnBase over = FaceOnBase::of(adjacency_, halfedge(piece.face, 0));
  const double slack = kStripSlack * over.base;
  return std::any_of(others.begin(), others.end(), [&](std::uint32_t s) {
    if (poll_.cancelled()) return false;
    const LineSegment& other = field_.lines->lines().segments[s];
    const BesideSegment from = beside(over, other, piece.from);
    const BesideSegment to = beside(over, other, piece.to);
    // On both sides of it; what only touches it does so at an end.
    if (!(from.aside * to.aside < 0)) return false;
    const double part = from.aside / (from.aside - to.aside);
    const double along = from.along + part * (to.along - from.along);
    return along >= -slack && along <= from.length + slack;
  });
}

void FieldOnLines::lower_within(const Piece& piece, double& least) const {
  if (field_.lines->lines().has_face(piece.face) || crosses_a_line(piece)) {
    least = 0;
    return;
  }
  for (std::uint32_t c = 0; c < 3; ++c) lower_by_side(piece, c, least);
  if (sources_.empty()) return;
  lower_by_sources(piece, {piece.face, kNone}, {0, 1, 2}, least);
  for (std::uint32_t c = 0; c < 3; ++c) {
    const std::array<std::uint32_t, 2> edge = key_of_edge(adjacency_, halfedge(piece.face, c));
    std::array<std::uint32_t, 3> corners{c, next_corner(c), previous_corner(c)};
    if (adjacency_.tail(halfedge(piece.face, c)) != edge[0]) std::swap(corners[0], corners[1]);
    lower_by_sources(piece, edge, corners, least);
  }
}

void FieldOnLines::lower_by_sources(const Piece& piece, const std::array<std::uint32_t, 2>& place,
                                    const std::array<std::uint32_t, 3>& corners,
                                    double& least) const {
  using Key = std::array<std::uint32_t, 2>;
  auto source =
      std::lower_bound(sources_.begin(), sources_.end(), place,
                       [](const PointSource& one, const Key& key) { return one.place < key; });
  if (source == sources_.end() || source->place != place) return;
  const FaceOnBase over = FaceOnBase::of(adjacency_, halfedge(piece.face, 0));
  for (; source != sources_.end() && source->place == place; ++source) {
    if (poll_.cancelled()) return;
    std::array<double, 3> at{};
    for (std::size_t i = 0; i < 3; ++i) at[corners[i]] = source->weights[i];
    // Seen from the source, so that what is close keeps its digits.
    const auto seen = [&](const std::array<double, 3>& bary) {
      std::array<double, 3> difference{};
      for (std::size_t i = 0; i < 3; ++i) difference[i] = bary[i] - at[i];
      return flat_point(over, difference);
    };
    const FlatSegment segment{seen(piece.from), seen(piece.to)};
    least = std::min(least, source->offset + segment.distance_to(0, 0));
  }
}

void FieldOnLines::lower_by_side(const Piece& piece, std::uint32_t c, double& least) const {
  const Halfedge h = halfedge(piece.face, c);
  const FaceOnBase over = FaceOnBase::of(adjacency_, h);
  if (!(over.base > 0)) return;
  const FlatSegment segment{over_side(over, c, piece.from), over_side(over, c, piece.to)};
  const double at_tail = field_.distance[adjacency_.tail(h)];
  if (at_tail < least) least = std::min(least, at_tail + segment.distance_to(0, 0));
  if (field_.windows) {
    const std::span<const VisibleInterval> windows = field_.windows->into(h);
    if (poll_.cancelled_after(windows.size() / kWindowsAStep)) return;
    for (const VisibleInterval& window : windows) {
      if (window.offset < least) least = std::min(least, least_through(window, segment));
    }
  }
  const double slack = kStripSlack * over.base;
  const std::span<const std::uint32_t> strips = field_.lines->strips_into(h);
  if (poll_.cancelled_after(strips.size() / kWindowsAStep)) return;
  for (const std::uint32_t number : strips) {
    least = std::min(least, least_in(field_.lines->strip(number), segment, slack));
  }
  if (!field_.edge_points) return;
  const EdgePoints& points = *field_.edge_points;
  const bool is_forward = adjacency_.tail(h) < adjacency_.head(h);
  const std::size_t first = std::size_t{points.edge_of[h]} * points.per_edge;
  for (std::uint32_t i = 0; i < points.per_edge; ++i) {
    const double d = points.distance[first + i];
    if (!(d < least)) continue;
    const double part = (double(i) + 1) / (double(points.per_edge) + 1);
    const double x = over.base * (is_forward ? part : 1 - part);
    least = std::min(least, d + segment.distance_to(x, 0));
  }
}

}  // namespace geodesic
