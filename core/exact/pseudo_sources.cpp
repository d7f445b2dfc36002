// Where windows begin: at sources, and at the vertices where shortest paths bend; and how
// vertices come by their last distances.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/rough_angle.h"
#include "core/base/tolerances.h"
#include "core/exact/propagation.h"
#include "core/surface/point.h"

namespace geodesic::exact {
namespace {

double angle_at(const FaceRecord& face, std::uint32_t c) {
  return rough_angle(face.dot[c], face.area2);
}

}  // namespace

void Propagation::start(const Source& source, std::uint32_t number) {
  if (source.offset > max_) return;
  if (source.point.at_vertex()) {
    const std::uint32_t v = source.point.vertex;
    if (!(source.offset < distance_[v])) return;
    const std::uint32_t pseudo_source = add_pseudo_source({source.offset, kNone, number});
    distance_[v] = source.offset;
    if (!field_.nearest_source.empty()) field_.nearest_source[v] = number;
    memory_.bends[v] = Bends::everywhere;
    memory_.emitted[v] = source.offset;
    send_everywhere(v, pseudo_source);
    return;
  }
  const std::uint32_t pseudo_source = add_pseudo_source({source.offset, kNone, number});
  for (const SurfacePoint& place : in_all_faces(adjacency_, source.point)) {
    if (poll_.cancelled()) return;
    start_inside(place, source, pseudo_source);
  }
}

// Straight to the corners of the face, and over those of its sides that the source
// does not lie on.
void Propagation::start_inside(const SurfacePoint& place, const Source& source,
                               std::uint32_t pseudo_source) {
  const std::uint32_t f = place.face;
  const PseudoSource from = memory_.pseudo_sources[pseudo_source];
  for (std::uint32_t c = 0; c < 3; ++c) {
    const double ahead = place.bary[next_corner(c)];
    const double behind = place.bary[previous_corner(c)];
    const std::uint32_t v = surface_.faces[f].vertex[c];
    relax(v, source.offset + distance_to_corner(adjacency_.mesh(), place, c), from,
          {halfedge(f, c), false, frames_.length(f, next_corner(c)) * (behind / (ahead + behind))});
  }
  for (std::uint32_t c = 0; c < 3; ++c) {
    const double above = place.bary[previous_corner(c)];
    if (above == 0) continue;
    const double length = frames_.length(f, c);
    const double to_far_corner = above * frames_.length(f, previous_corner(c));
    const CornerAngle angle = frames_.angle(f, c);
    send_over(halfedge(f, c), pseudo_source, 0, length,
              place.bary[next_corner(c)] * length + to_far_corner * angle.cosine,
              to_far_corner * angle.sine);
  }
}

// By how much earlier than it was reached a vertex may send out windows on its own; 0
// where that is not worth the windows: where there are few windows to spare, or soon after an
// older one. Let p be the part of its distance that it may be
// early by, all in all: p of a distance is at most p / (1 - p) of that less p of it,
// which is the tolerance.
double Propagation::early_by(std::uint32_t v) const {
  // The least that is worth it, of what it may be in all and of an edge. With less of the
  // former, most of an older source's windows would be in the way of the new one's.
  constexpr double kWorthOfAll = 0.05;
  constexpr double kWorthOfSide = 6e-4;
  if (!(tolerance_ > 0) || !memory_.arrivals[v].among_many) return 0;
  const double all = tolerance_ / (1 + tolerance_) * distance_[v];
  const double left = all - memory_.allowance[v];
  return left > kWorthOfAll * all && left > kWorthOfSide * frames_.mean_shortest_side() ? left : 0;
}

void Propagation::bend_at(std::uint32_t v) {
  double distance = distance_[v];
  if (!(distance < memory_.emitted[v])) return;
  const double early = early_by(v);
  if (early > 0) {
    distance -= early;
    distance_[v] = distance;
    memory_.allowance[v] += early;
  } else if (memory_.bends[v] == Bends::nowhere) {
    return;
  }
  memory_.emitted[v] = distance;
  const std::uint32_t pseudo_source = add_pseudo_source({distance, v, nearest(v), allowance(v)});
  if (early > 0 || memory_.bends[v] == Bends::everywhere || memory_.arrivals[v].corner == kNone) {
    send_everywhere(v, pseudo_source);
  } else {
    send_beyond(v, pseudo_source);
  }
}

void Propagation::send_everywhere(std::uint32_t v, std::uint32_t pseudo_source) {
  for (const std::uint32_t corner : surface_.corners(v)) {
    if (poll_.cancelled()) return;
    relax_along_sides(corner, pseudo_source);
  }
  for (const std::uint32_t corner : surface_.corners(v)) {
    if (poll_.cancelled()) return;
    send_from_corner(corner, pseudo_source, 0, std::numbers::pi);
  }
}

// A shortest path that bends leaves angles of pi or more on both of its sides:
// turning from the way back, between pi and the whole angle less pi.
void Propagation::send_beyond(std::uint32_t v, std::uint32_t pseudo_source) {
  constexpr double kPi = std::numbers::pi;
  for (const std::uint32_t corner : surface_.corners(v)) {
    if (poll_.cancelled()) return;
    relax_along_sides(corner, pseudo_source);
  }
  const ArrivalAtVertex arrival = memory_.arrivals[v];
  const std::uint32_t f = face_of(arrival.corner);
  const std::uint32_t c = corner_of(arrival.corner);
  const CornerAngle at_next = frames_.angle(f, next_corner(c));
  const double side = frames_.length(f, c);
  const double x = side * at_next.cosine;
  const double y = side * at_next.sine;
  const double whole = angle_at(surface_.faces[f], c);
  const double way_back =
      std::clamp(rough_angle(x * (x - arrival.crossing) + y * y, y * arrival.crossing), 0.0, whole);

  memory_.fan.clear();
  double last = kUnreached;
  if (turn(arrival.corner, true, way_back)) {
    const double round = memory_.fan.empty() ? 0 : memory_.fan.back().end;
    last = round + (whole - way_back) - kPi;
  } else {
    (void)turn(arrival.corner, false, whole - way_back);
  }
  const double slack =
      tolerance::kDirection + kRoughAngle * static_cast<double>(memory_.fan.size() + 2);
  last += slack;
  for (std::size_t i = 0; i < memory_.fan.size() && !poll_.cancelled(); ++i) {
    const FanFace face = memory_.fan[i];
    const double begin = std::max(kPi - slack, face.begin) - face.begin;
    const double end = std::min(last, face.end) - face.begin;
    if (!(begin < end)) continue;
    const double angle = face.end - face.begin;
    if (face.from_next) {
      send_from_corner(face.corner, pseudo_source, begin, end < angle ? end : kPi);
    } else {
      send_from_corner(face.corner, pseudo_source, end < angle ? angle - end : 0,
                       begin > 0 ? angle - begin : kPi);
    }
  }
}

// Turns round a vertex from one side of a corner, which is at `angle` from the way
// back, and adds the faces passed to the fan. True when it comes back to the corner,
// false at a boundary.
bool Propagation::turn(std::uint32_t corner, bool over_next, double angle) {
  const std::uint32_t v = surface_.faces[face_of(corner)].vertex[corner_of(corner)];
  Halfedge side =
      over_next ? corner : halfedge(face_of(corner), previous_corner(corner_of(corner)));
  for (;;) {
    const Halfedge across = surface_.ring(side);
    if (across == side || poll_.cancelled()) return false;
    const std::uint32_t f = face_of(across);
    if (f == face_of(corner)) return true;
    const std::uint32_t c = corner_of(across);
    const bool from_next = surface_.faces[f].vertex[c] == v;
    const std::uint32_t here = from_next ? c : next_corner(c);
    const double end = angle + angle_at(surface_.faces[f], here);
    memory_.fan.push_back({halfedge(f, here), from_next, angle, end});
    angle = end;
    side = from_next ? halfedge(f, previous_corner(here)) : halfedge(f, here);
  }
}

// The side opposite a corner, between two angles from the side towards the corner's
// next vertex.
void Propagation::send_from_corner(std::uint32_t corner, std::uint32_t pseudo_source, double first,
                                   double last) {
  const std::uint32_t f = face_of(corner);
  const std::uint32_t c = corner_of(corner);
  const std::uint32_t n = next_corner(c);
  const double side = frames_.length(f, c);
  const double length = frames_.length(f, n);
  const bool from_start = !(first > 0);
  const bool to_end = !(last < std::numbers::pi);
  if (from_start && to_end) {
    // Behind the front all of it is farther than along the edge from one of its ends.
    const FaceRecord& face = surface_.faces[f];
    const double offset = memory_.pseudo_sources[pseudo_source].offset;
    const double other_side = frames_.length(f, previous_corner(c));
    if (distance_[face.vertex[n]] + length <= offset + other_side ||
        distance_[face.vertex[previous_corner(c)]] + length <= offset + side) {
      return;
    }
  }
  const CornerAngle at_next = frames_.angle(f, n);
  const auto meets = [&](double angle) {
    const double along = side * std::sin(angle);
    const double below = std::sin(angle) * at_next.cosine + std::cos(angle) * at_next.sine;
    return below > 0 ? std::clamp(along / below, 0.0, length) : length;
  };
  send_over(halfedge(f, n), pseudo_source, from_start ? 0 : meets(first),
            to_end ? length : meets(last), side * at_next.cosine, side * at_next.sine);
}

// A first window over a side, counted from its halfedge's tail.
void Propagation::send_over(Halfedge from, std::uint32_t pseudo_source, double begin, double end,
                            double x, double y) {
  const Side over = side(from, true);
  if (over.on_boundary) return;
  if (!(begin < end)) return;
  const double offset = memory_.pseudo_sources[pseudo_source].offset;
  Window window{};
  window.begin = over.flipped ? over.length - end : begin;
  window.end = over.flipped ? over.length - begin : end;
  window.x = over.flipped ? over.length - x : x;
  window.y = y;
  window.at_begin = window.at(window.begin, offset);
  window.at_end = window.at(window.end, offset);
  window.pseudo_source = pseudo_source;
  window.from = from;
  if (!is_of_use(window, over)) return;
  commit(over.edge, {&window, 1}, window.least(offset));
}

// The ways along the two sides that meet in a corner.
void Propagation::relax_along_sides(std::uint32_t corner, std::uint32_t pseudo_source) {
  const std::uint32_t f = face_of(corner);
  const std::uint32_t c = corner_of(corner);
  const std::uint32_t n = next_corner(c);
  const std::uint32_t p = previous_corner(c);
  const FaceRecord& face = surface_.faces[f];
  const double distance = distance_[face.vertex[c]];
  const double to_next = distance + frames_.length(f, c);
  const double to_previous = distance + frames_.length(f, p);
  if (to_next < distance_[face.vertex[n]]) {
    relax(face.vertex[n], to_next, memory_.pseudo_sources[pseudo_source],
          {halfedge(f, n), false, frames_.length(f, p)});
  }
  if (to_previous < distance_[face.vertex[p]]) {
    relax(face.vertex[p], to_previous, memory_.pseudo_sources[pseudo_source],
          {halfedge(f, p), false, 0});
  }
}

void Propagation::raise_to_paths(Poll& poll) {
  for (std::uint32_t v = 0; v < memory_.allowance.size() && !poll.cancelled(); ++v) {
    distance_[v] += memory_.allowance[v];
  }
}

bool Propagation::relax_along_edges(Poll& poll) {
  bool any = false;
  for (std::uint32_t e = 0; e < frames_.edges().size() && !poll.cancelled(); ++e) {
    const Edge& frame = frames_.edge(e);
    for (const auto& [from, to] :
         {std::pair{frame.tail, frame.head}, std::pair{frame.head, frame.tail}}) {
      const double distance = distance_[from] + frame.length;
      if (!(distance < distance_[to] * (1 - tolerance::kLostWindow)) || distance > max_) continue;
      memory_.bends[to] = Bends::everywhere;
      relax(to, distance, {distance_[from], from, nearest(from), allowance(from)},
            {kNone, false, 0});
      any = true;
    }
  }
  return any;
}

}  // namespace geodesic::exact
