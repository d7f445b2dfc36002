#include "core/field/line_waves.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/polled_fill.h"

namespace geodesic {

Halfedge LineSegment::along() const {
  for (std::uint32_t c = 0; c < 3; ++c) {
    if (from[previous_corner(c)] == 0 && to[previous_corner(c)] == 0) return halfedge(face, c);
  }
  return kNone;
}

FaceOnBase FaceOnBase::of(const Adjacency& adjacency, Halfedge h) {
  const FaceRecord& face = adjacency.face(face_of(h));
  const std::uint32_t c = corner_of(h);
  const std::uint32_t n = next_corner(c);
  const auto positions = adjacency.mesh().positions();
  const Vec3 begin = positions[face.vertex[c]];
  const Vec3 end = positions[face.vertex[n]];
  const Vec3 apex = positions[face.vertex[previous_corner(c)]];
  FaceOnBase over{};
  // All faces on an edge agree on its length.
  over.base = distance(begin, end);
  over.left = distance(begin, apex);
  over.right = distance(end, apex);
  over.apex_x = face.dot[c] / over.base;
  over.apex_y = face.area2 / over.base;
  over.apex_back = face.dot[n] / over.base;
  return over;
}

FlatPoint flat_point(const FaceOnBase& face, const std::array<double, 3>& bary) {
  return {bary[1] * face.base + bary[2] * face.apex_x, bary[2] * face.apex_y};
}

BesideSegment beside(const FaceOnBase& face, const LineSegment& segment,
                     const std::array<double, 3>& bary) {
  // From differences of weights, which keep the digits of what is close.
  const auto difference = [&](const std::array<double, 3>& a, const std::array<double, 3>& b) {
    return flat_point(face, {a[0] - b[0], a[1] - b[1], a[2] - b[2]});
  };
  const FlatPoint ahead = difference(segment.to, segment.from);
  const FlatPoint here = difference(bary, segment.from);
  const double length = std::sqrt(ahead.x * ahead.x + ahead.y * ahead.y);
  if (!(length > 0)) return {-1, 0, 0};
  return {(here.x * ahead.x + here.y * ahead.y) / length,
          (ahead.x * here.y - ahead.y * here.x) / length, length};
}

LineWaves::LineWaves(const Adjacency& adjacency, std::shared_ptr<const SourceLines> lines,
                     std::uint32_t given, std::vector<LineStrip> strips, bool has_strips,
                     Poll& poll)
    : lines_(std::move(lines)), given_(given), has_strips_(has_strips), strips_(std::move(strips)) {
  if (!has_strips_) return;
  polled_assign(begin_, 4 * adjacency.faces().size() + 1, std::uint32_t{0}, poll);
  polled_assign(order_, strips_.size(), std::uint32_t{0}, poll);
  if (poll.stopped()) return;
  for (const LineStrip& strip : strips_) {
    if (poll.cancelled()) return;
    if (strip.into != kNone) ++begin_[strip.into + 1];
  }
  for (std::size_t h = 1; h < begin_.size() && !poll.cancelled(); ++h) begin_[h] += begin_[h - 1];
  std::vector<std::uint32_t> next;
  polled_copy(next, std::span<const std::uint32_t>(begin_), poll);
  for (std::uint32_t i = 0; i < strips_.size() && !poll.cancelled(); ++i) {
    if (strips_[i].into != kNone) order_[next[strips_[i].into]++] = i;
  }
  for (std::uint32_t s = 0; s < lines_->segments.size() && !poll.cancelled(); ++s) {
    if (lines_->segments[s].along() == kNone) in_face_.push_back(s);
  }
  if (poll.stopped()) return;
  std::stable_sort(in_face_.begin(), in_face_.end(), [&](std::uint32_t a, std::uint32_t b) {
    return lines_->segments[a].face < lines_->segments[b].face;
  });
}

std::span<const std::uint32_t> LineWaves::segments_within(std::uint32_t f) const {
  const auto is_before = [&](std::uint32_t s, std::uint32_t face) {
    return lines_->segments[s].face < face;
  };
  const auto first = std::lower_bound(in_face_.begin(), in_face_.end(), f, is_before);
  const auto last = std::lower_bound(first, in_face_.end(), f + 1, is_before);
  return {first, last};
}

void LineWaves::arrive_in_face(const Adjacency& adjacency, const SurfacePoint& place,
                               LineArrival& best) const {
  const std::uint32_t f = place.face;
  if (lines_->has_face(f)) {
    best = {0, place, kNone, kNone};
    return;
  }
  const auto take = [&](double distance, std::uint32_t strip, std::uint32_t segment) {
    if (!(distance < best.distance)) return;
    best = {distance, place, strip, segment};
  };
  if (const auto within = segments_within(f); !within.empty()) {
    const FaceOnBase over = FaceOnBase::of(adjacency, halfedge(f, 0));
    for (const std::uint32_t s : within) {
      const BesideSegment there = beside(over, lines_->segments[s], place.bary);
      const double slack = kStripSlack * over.base;
      if (there.along < -slack || there.along > there.length + slack) continue;
      take(std::abs(there.aside), kNone, s);
    }
  }
  for (std::uint32_t c = 0; c < 3; ++c) {
    const Halfedge h = halfedge(f, c);
    const std::span<const std::uint32_t> strips = strips_into(h);
    if (strips.empty()) continue;
    const FaceOnBase over = FaceOnBase::of(adjacency, h);
    const double above = place.bary[previous_corner(c)];
    const double x = place.bary[next_corner(c)] * over.base + above * over.apex_x;
    const double y = above * over.apex_y;
    const double slack = kStripSlack * over.base;
    for (const std::uint32_t number : strips) {
      const LineStrip& strip = strips_[number];
      const double foot = x - y * (strip.b / strip.c);
      if (foot < strip.begin - slack || foot > strip.end + slack) continue;
      // On a line, rounding leaves it beside 0.
      const double distance = strip.value + strip.b * (x - strip.begin) + strip.c * y;
      take(std::max(distance, 0.0), number, kNone);
    }
  }
}

LineArrival LineWaves::arrive(const Adjacency& adjacency, const SurfacePoint& point,
                              Poll* poll) const {
  LineArrival best;
  if (!has_strips_) return best;
  for (const SurfacePoint& place : in_all_faces(adjacency, point)) {
    if (poll != nullptr && poll->cancelled()) return {};
    arrive_in_face(adjacency, place, best);
  }
  return best;
}

std::uint32_t LineWaves::item_of(const LineArrival& arrival) const {
  if (arrival.segment != kNone) return lines_->segments[arrival.segment].item;
  if (arrival.strip != kNone) return lines_->segments[strips_[arrival.strip].segment].item;
  return lines_->item_of_face[arrival.place.face];
}

std::size_t LineWaves::bytes() const {
  return sizeof(LineWaves) + lines_->bytes() + strips_.capacity() * sizeof(LineStrip) +
         (begin_.capacity() + order_.capacity() + in_face_.capacity() + later_items_.capacity()) *
             sizeof(std::uint32_t);
}

}  // namespace geodesic
