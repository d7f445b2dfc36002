#include "core/curves/least_on_lines.h"

#include <algorithm>
#include <cmath>
#include <utility>

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

}  // namespace

std::vector<std::uint32_t> faces_of_lines(const Adjacency& adjacency,
                                          std::span<const LineSegment> segments, Poll& poll) {
  std::vector<std::uint32_t> faces;
  for (const LineSegment& segment : segments) {
    if (poll.cancelled()) return faces;
    in_each_face(adjacency, segment, poll,
                 [&](std::uint32_t f, const auto&, const auto&) { faces.push_back(f); });
  }
  std::sort(faces.begin(), faces.end());
  faces.erase(std::unique(faces.begin(), faces.end()), faces.end());
  return faces;
}

FieldOnLines::FieldOnLines(const Adjacency& adjacency, const Field& field, Poll& poll)
    : adjacency_(adjacency), field_(field), poll_(poll) {
  around_ = faces_of_lines(adjacency, field.lines->lines().segments, poll);
  for (std::uint32_t s = 0; s < field.lines->given(); ++s) {
    const Source& source = field.sources[s];
    for (const SurfacePoint& place : in_all_faces(adjacency, source.point)) {
      if (poll.cancelled()) return;
      around_.push_back(place.face);
      // At a vertex it is a corner with a distance.
      if (source.point.at_vertex()) continue;
      sources_.push_back({place.face, source.offset, place.bary});
    }
  }
  std::sort(around_.begin(), around_.end());
  std::stable_sort(sources_.begin(), sources_.end(),
                   [](const PointSource& a, const PointSource& b) { return a.face < b.face; });
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
  auto source =
      std::lower_bound(sources_.begin(), sources_.end(), piece.face,
                       [](const PointSource& one, std::uint32_t f) { return one.face < f; });
  if (source == sources_.end() || source->face != piece.face) return;
  const FaceOnBase over = FaceOnBase::of(adjacency_, halfedge(piece.face, 0));
  for (; source != sources_.end() && source->face == piece.face; ++source) {
    if (poll_.cancelled()) return;
    // Seen from the source, so that what is close keeps its digits.
    const auto seen = [&](const std::array<double, 3>& bary) {
      std::array<double, 3> difference{};
      for (std::size_t i = 0; i < 3; ++i) difference[i] = bary[i] - source->bary[i];
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
