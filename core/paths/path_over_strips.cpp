#include "core/paths/path_over_strips.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace geodesic {
namespace {

using Weights3 = std::array<double, 3>;

// A piece of the way within a face, going back.
struct StripPiece {
  std::uint32_t face;
  Weights3 start;
  Weights3 end;
};

// Weights of a point of the side that starts at corner c, so far from that corner of its length.
Weights3 on_side(std::uint32_t c, double part) {
  part = std::clamp(part, 0.0, 1.0);
  Weights3 bary{};
  bary[c] = 1 - part;
  bary[next_corner(c)] = part;
  return bary;
}

// The foot of the perpendicular from a point of the same face.
Weights3 foot_on(const Adjacency& adjacency, const LineSegment& segment, const Weights3& from) {
  const FaceOnBase over = FaceOnBase::of(adjacency, halfedge(segment.face, 0));
  const BesideSegment there = beside(over, segment, from);
  const double part = there.length > 0 ? std::clamp(there.along / there.length, 0.0, 1.0) : 0;
  Weights3 foot{};
  for (std::uint32_t c = 0; c < 3; ++c) {
    foot[c] = segment.from[c] + part * (segment.to[c] - segment.from[c]);
  }
  return foot;
}

}  // namespace

Result<std::optional<Path>> path_over_strips(const Adjacency& adjacency, const LineWaves& waves,
                                             const LineArrival& arrival, Poll& poll) {
  const SourceLines& lines = waves.lines();
  const SurfacePoint& place = arrival.place;
  std::vector<StripPiece> pieces;
  std::uint32_t face = place.face;
  Weights3 here = place.bary;
  std::uint32_t segment = arrival.segment;
  for (std::uint32_t number = arrival.strip; number != kNone;) {
    if (poll.cancelled()) return fail_stopped(poll);
    const LineStrip& strip = waves.strip(number);
    const std::uint32_t c = corner_of(strip.into);
    const std::uint32_t n = next_corner(c);
    const FaceOnBase over = FaceOnBase::of(adjacency, strip.into);
    const double above = here[previous_corner(c)];
    const double x = here[n] * over.base + above * over.apex_x;
    const double foot =
        std::clamp(x - above * over.apex_y * (strip.b / strip.c), strip.begin, strip.end);
    const Weights3 end = on_side(c, foot / over.base);
    pieces.push_back({face, here, end});
    // On in the face before, of the strip's parent or of the segment.
    number = strip.parent;
    segment = strip.segment;
    const std::uint32_t before =
        number != kNone ? face_of(waves.strip(number).into) : lines.segments[segment].face;
    if (number == kNone && lines.segments[segment].along() != kNone) {
      segment = kNone;  // it begins on the edge
      break;
    }
    const std::uint32_t tail = adjacency.tail(strip.into);
    const std::uint32_t head = adjacency.head(strip.into);
    const FaceRecord& record = adjacency.face(before);
    here = {};
    for (std::uint32_t k = 0; k < 3; ++k) {
      if (record.vertex[k] == tail) here[k] = end[c];
      if (record.vertex[k] == head) here[k] = end[n];
    }
    face = before;
  }
  if (segment != kNone) {
    pieces.push_back({face, here, foot_on(adjacency, lines.segments[segment], here)});
  }
  Path path;
  const Mesh& mesh = adjacency.mesh();
  const auto add = [&](std::uint32_t f, const Weights3& bary) {
    const SurfacePoint point = point_on_face(adjacency, f, bary);
    const Vec3 position = position_of(mesh, point);
    if (!path.points.empty()) {
      PathPoint& last = path.points.back();
      if (last.position == position) {
        last = {point, position};
        return;
      }
      path.length += distance(last.position, position);
    }
    path.points.push_back({point, position});
  };
  for (auto piece = pieces.rbegin(); piece != pieces.rend(); ++piece) {
    if (path.points.empty()) {
      add(piece->face, piece->end);
    } else {
      path.points.back().point = point_on_face(adjacency, piece->face, piece->end);
    }
    add(piece->face, piece->start);
  }
  if (path.points.empty()) path.points.push_back({place, position_of(mesh, place)});
  return std::optional(std::move(path));
}

}  // namespace geodesic
