#include "core/straighten/loop_slide.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/base/tolerances.h"
#include "core/straighten/face_strip.h"

namespace geodesic {
namespace {

constexpr double kNever = 2;  // of a move from 0 to 1

// When q0 + q1 t + q2 t^2, not negative at 0, becomes negative; kNever if not for t from 0 to 1.
double first_below_zero(double q0, double q1, double q2) {
  q0 = std::max(q0, 0.0);
  if (q0 == 0) {
    if (q1 < 0 || (q1 == 0 && q2 < 0)) return 0;
    return q2 < 0 ? -q1 / q2 : kNever;
  }
  const double inside = q1 * q1 - 4 * q0 * q2;
  if (inside < 0) return kNever;
  const double r = -0.5 * (q1 + std::copysign(std::sqrt(inside), q1));
  double first = kNever;
  if (r != 0 && q0 / r >= 0) first = q0 / r;
  if (q2 != 0 && r / q2 >= 0) first = std::min(first, r / q2);
  return first;
}

// A line from a place on the base's edge to the place's image once round the loop, both of which
// move along with t from 0 to 1. (In the plane into which the strip of faces unfolds.)
struct MovingLine {
  Vec2 start;
  Vec2 along;  // from start to image
  Vec2 start_moves;
  Vec2 along_changes;

  [[nodiscard]] Vec2 start_at(double t) const { return start + t * start_moves; }
  [[nodiscard]] Vec2 along_at(double t) const { return along + t * along_changes; }

  // When a point comes to be on the other side of it: `is_left` says on which it is.
  [[nodiscard]] double meets(Vec2 point, bool is_left) const {
    const Vec2 to = point - start;
    const double sign = is_left ? 1 : -1;
    return first_below_zero(sign * cross(along, to),
                            sign * (cross(along_changes, to) - cross(along, start_moves)),
                            -sign * cross(along_changes, start_moves));
  }
};

// The vertex that a move ends at, by the portals next to each other that end in it.
struct Touched {
  std::uint32_t vertex = kNone;
  std::size_t portal = 0;  // the first of them; of no use for an end of the base's edge
  bool is_end_of_base = false;
};

// Which portals cross at the vertex that is touched.
std::vector<bool> crossed_at(const Touched& touched, const UnfoldedStrip& plane) {
  const auto& portals = plane.unfolded_portals;
  const auto ends_there = [&](const UnfoldedPortal& portal) {
    return portal.left_vertex == touched.vertex || portal.right_vertex == touched.vertex;
  };
  std::vector<bool> crossed(portals.size(), false);
  if (touched.vertex == kNone) return crossed;
  const std::size_t first = touched.is_end_of_base ? 0 : touched.portal;
  for (std::size_t i = first; i < portals.size() && ends_there(portals[i]); ++i) crossed[i] = true;
  for (std::size_t i = portals.size();
       touched.is_end_of_base && i-- > 0 && ends_there(portals[i]);) {
    crossed[i] = true;
  }
  return crossed;
}

// Where a line crosses the portals, as PathSegment has it. Other vertices that it runs through all
// but exactly are run through, too, by all portals that end in them.
std::vector<double> crossings_of(const Adjacency& adjacency, const FaceStrip& strip,
                                 const UnfoldedStrip& plane, Vec2 start, Vec2 to_end,
                                 const Touched& touched) {
  const Vec2 along = unit(to_end);
  const double near = tolerance::kThroughVertex * norm(to_end);
  const std::vector<bool> at_touched = crossed_at(touched, plane);
  std::vector<double> crossings;
  crossings.reserve(strip.portals.size());
  for (std::size_t i = 0; i < strip.portals.size(); ++i) {
    const UnfoldedPortal& portal = plane.unfolded_portals[i];
    const double left = cross(along, portal.left - start);
    const double right = -cross(along, portal.right - start);
    const bool left_is_nearer = left <= right;
    double from_left = left_is_nearer ? 0 : 1;
    if (at_touched[i]) {
      from_left = portal.left_vertex == touched.vertex ? 0 : 1;
    } else if (std::min(left, right) > near) {
      from_left = left / (left + right);
    }
    const Halfedge in = strip.portals[i].in;
    const bool tail_is_left = adjacency.tail(in) == portal.left_vertex;
    crossings.push_back(tail_is_left ? from_left : 1 - from_left);
  }
  return crossings;
}

bool is_between(const Adjacency& adjacency, Halfedge edge, std::uint32_t last_face) {
  for (Halfedge h = adjacency.ring(edge); h != edge; h = adjacency.ring(h)) {
    if (face_of(h) == last_face) return true;
  }
  return false;
}

}  // namespace

std::optional<LoopSlide> slide_loop(const Adjacency& adjacency, const Path& loop,
                                    const Chain& chain) {
  if (chain.segments.size() != 1) return std::nullopt;
  const FaceStrip& strip = chain.segments.front().strip;
  const SurfacePoint& base = loop.points.front().point;
  const Halfedge edge = edge_under(base);
  const std::uint32_t c = corner_of(edge);
  if (strip.first_face != base.face || strip.portals.empty() ||
      !is_between(adjacency, edge, strip.last_face())) {
    return std::nullopt;
  }
  // The ends of the base's edge, and their images.
  const std::array<std::uint32_t, 2> ends{adjacency.tail(edge), adjacency.head(edge)};
  std::array<Vec2, 2> here;
  std::array<Vec2, 2> image;
  UnfoldedStrip plane;
  for (std::size_t i = 0; i < 2; ++i) {
    const SurfacePoint end = point_at_vertex(adjacency, ends[i]);
    unfold_strip(adjacency, strip, end, end, plane);
    here[i] = plane.start;
    image[i] = plane.end;
  }
  const Vec2 side = here[1] - here[0];
  const Vec2 change = (image[1] - image[0]) - side;
  const double from = base.bary[next_corner(c)];
  const Vec2 along = image[0] - here[0] + from * change;
  const double change2 = dot(change, change);
  const double best = change2 > 0 ? from - dot(along, change) / change2 : from;
  const double to = std::clamp(best, 0.0, 1.0);
  const double move = to - from;
  const MovingLine line{here[0] + from * side, along, move * side, move * change};

  Touched touched;
  double end = 1;
  if (to != best) touched = {ends[to == 0 ? 0 : 1], 0, true};
  for (std::size_t i = 0; i < strip.portals.size(); ++i) {
    const UnfoldedPortal& portal = plane.unfolded_portals[i];
    for (const bool is_left : {true, false}) {
      const double t = line.meets(is_left ? portal.left : portal.right, is_left);
      if (!(t < end)) continue;
      end = t;
      touched = {is_left ? portal.left_vertex : portal.right_vertex, i, false};
    }
  }

  double at = end == 1 ? to : from + end * move;
  // The faces round the ends of the base's edge touch the line there, too, all at once.
  for (std::size_t i = 0; i < 2; ++i) {
    const double place = static_cast<double>(i);
    if (touched.vertex != ends[i] || std::abs(at - place) > tolerance::kAtEnd) continue;
    at = place;
    touched.is_end_of_base = true;
  }
  std::array<double, 3> bary{0, 0, 0};
  bary[c] = 1 - at;
  bary[next_corner(c)] = at;
  const SurfacePoint moved = point_on_face(adjacency, base.face, bary);
  Chain straight;
  straight.path_vertices = {{moved}, {moved}};
  straight.segments.push_back(
      {strip,
       crossings_of(adjacency, strip, plane, line.start_at(end), line.along_at(end), touched),
       0,
       {},
       {}});
  const Vec3 position = position_of(adjacency.mesh(), moved);
  Path given;
  given.source = loop.source;
  given.points = {{moved, position}, {moved, position}};
  return LoopSlide{write_path(adjacency, straight, given), touched.vertex};
}

}  // namespace geodesic
