// Windows begin: out of sources, and out of vertices where shortest paths bend.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/base/rough_angle.h"
#include "core/base/tolerances.h"
#include "core/exact/domain.h"

namespace geodesic::exact {
namespace {

double angle_at(const FaceRecord& face, std::uint32_t c) {
  return rough_angle(face.dot[c], face.area2);
}

}  // namespace

// Straight to the corners of the face, and over those of its sides that the source
// does not lie on.
void Domain::send_inside(const PlaceInFace& place, std::uint32_t pseudo_source) {
  const double offset = pseudo_sources()[pseudo_source].offset;
  const std::uint32_t f = place.face;
  std::array<double, 3> at_corner{};
  for (std::uint32_t c = 0; c < 3; ++c) {
    const double ahead = place.weights[next_corner(c)];
    const double behind = place.weights[previous_corner(c)];
    at_corner[c] = offset + place.to_corner[c];
    hand_way(state_.surface.faces[f].vertex[c], at_corner[c],
             {halfedge(f, c), pseudo_source, 0,
              frames().length(f, next_corner(c)) * (behind / (ahead + behind))});
  }
  for (std::uint32_t c = 0; c < 3; ++c) {
    const double above = place.weights[previous_corner(c)];
    if (above == 0) continue;
    const double length = frames().length(f, c);
    const double to_far_corner = above * frames().length(f, previous_corner(c));
    const CornerAngle angle = frames().angle(f, c);
    send_over(halfedge(f, c), pseudo_source, 0, length,
              place.weights[next_corner(c)] * length + to_far_corner * angle.cosine,
              to_far_corner * angle.sine, {at_corner[c], at_corner[next_corner(c)]});
  }
}

// Makes a pseudo-source of the vertex, if it is nearer than when it last sent out windows.
void Domain::bend_at(std::uint32_t v) {
  SharedMemory& shared = state_.memory;
  const double early = state_.early_by(v);
  const double distance = state_.distance[v] - early;
  if (!(state_.distance[v] < shared.emitted[v])) return;
  if (!(early > 0) && shared.bends[v] == Bends::nowhere) return;
  if (early > 0) memory_.early.push_back({v, early});
  shared.emitted[v] = distance;
  const std::uint32_t pseudo_source = memory_.next_pseudo_source++;
  shared.pseudo_sources[pseudo_source] = {distance, v, state_.nearest(v),
                                          state_.allowance(v) + early};
  shared.offsets[pseudo_source] = distance;
  if (early > 0 || shared.bends[v] == Bends::everywhere || shared.arrivals[v].corner == kNone) {
    send_everywhere(v, pseudo_source);
  } else {
    send_beyond(v, pseudo_source);
  }
}

void Domain::send_everywhere(std::uint32_t v, std::uint32_t pseudo_source) {
  for (const std::uint32_t corner : state_.surface.corners(v)) {
    if (poll_->cancelled()) return;
    hand_along_sides(corner, pseudo_source);
    send_from_corner(corner, pseudo_source, 0, std::numbers::pi);
  }
}

// A shortest path that bends leaves angles of pi or more on both of its sides:
// turning from the way back, between pi and the whole angle less pi.
void Domain::send_beyond(std::uint32_t v, std::uint32_t pseudo_source) {
  constexpr double kPi = std::numbers::pi;
  for (const std::uint32_t corner : state_.surface.corners(v)) {
    if (poll_->cancelled()) return;
    hand_along_sides(corner, pseudo_source);
  }
  const ArrivalAtVertex arrival = state_.memory.arrivals[v];
  const std::uint32_t f = face_of(arrival.corner);
  const std::uint32_t c = corner_of(arrival.corner);
  const CornerAngle at_next = frames().angle(f, next_corner(c));
  const double side = frames().length(f, c);
  const double x = side * at_next.cosine;
  const double y = side * at_next.sine;
  const double whole = angle_at(state_.surface.faces[f], c);
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
  for (std::size_t i = 0; i < memory_.fan.size() && !poll_->cancelled(); ++i) {
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
bool Domain::turn(std::uint32_t corner, bool over_next, double angle) {
  const std::uint32_t v = state_.surface.faces[face_of(corner)].vertex[corner_of(corner)];
  Halfedge side =
      over_next ? corner : halfedge(face_of(corner), previous_corner(corner_of(corner)));
  for (;;) {
    const Halfedge across = state_.surface.ring(side);
    if (across == side || poll_->cancelled()) return false;
    const std::uint32_t f = face_of(across);
    if (f == face_of(corner)) return true;
    const std::uint32_t c = corner_of(across);
    const bool from_next = state_.surface.faces[f].vertex[c] == v;
    const std::uint32_t here = from_next ? c : next_corner(c);
    const double end = angle + angle_at(state_.surface.faces[f], here);
    memory_.fan.push_back({halfedge(f, here), from_next, angle, end});
    angle = end;
    side = from_next ? halfedge(f, previous_corner(here)) : halfedge(f, here);
  }
}

// The side opposite a corner, between two angles from the side towards the corner's
// next vertex.
void Domain::send_from_corner(std::uint32_t corner, std::uint32_t pseudo_source, double first,
                              double last) {
  const std::uint32_t f = face_of(corner);
  const std::uint32_t c = corner_of(corner);
  const std::uint32_t n = next_corner(c);
  const double side = frames().length(f, c);
  const double other_side = frames().length(f, previous_corner(c));
  const double length = frames().length(f, n);
  const double offset = pseudo_sources()[pseudo_source].offset;
  const bool from_start = !(first > 0);
  const bool to_end = !(last < std::numbers::pi);
  if (from_start && to_end) {
    // Behind the front all of it is farther than along the edge from one of its ends.
    const FaceRecord& face = state_.surface.faces[f];
    if (state_.distance[face.vertex[n]] + length <= offset + other_side ||
        state_.distance[face.vertex[previous_corner(c)]] + length <= offset + side) {
      return;
    }
  }
  const CornerAngle at_next = frames().angle(f, n);
  const auto meets = [&](double angle) {
    const double along = side * std::sin(angle);
    const double below = std::sin(angle) * at_next.cosine + std::cos(angle) * at_next.sine;
    return below > 0 ? std::clamp(along / below, 0.0, length) : length;
  };
  send_over(halfedge(f, n), pseudo_source, from_start ? 0 : meets(first),
            to_end ? length : meets(last), side * at_next.cosine, side * at_next.sine,
            {offset + side, offset + other_side});
}

// A first window over a side, counted from its halfedge's tail; how far the halfedge's tail and
// head are, straight from where it begins.
void Domain::send_over(Halfedge from, std::uint32_t pseudo_source, double begin, double end,
                       double x, double y, const std::array<double, 2>& straight) {
  Side over = side(from, true);
  if (over.on_boundary) return;
  if (!(begin < end)) return;
  over.at_tail = std::min(over.at_tail, straight[over.flipped ? 1 : 0]);
  over.at_head = std::min(over.at_head, straight[over.flipped ? 0 : 1]);
  const double offset = pseudo_sources()[pseudo_source].offset;
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
  memory_.fresh.assign(1, window);
  hand_list(over.edge, 4 * std::uint64_t{from} + 2, {&memory_.fresh, 0, 1, window.least(offset)});
}

// The ways along the two sides that meet in a corner.
void Domain::hand_along_sides(std::uint32_t corner, std::uint32_t pseudo_source) {
  const std::uint32_t f = face_of(corner);
  const std::uint32_t c = corner_of(corner);
  const std::uint32_t n = next_corner(c);
  const std::uint32_t p = previous_corner(c);
  const FaceRecord& face = state_.surface.faces[f];
  const double offset = pseudo_sources()[pseudo_source].offset;
  hand_way(face.vertex[n], offset + frames().length(f, c),
           {halfedge(f, n), pseudo_source, 0, frames().length(f, p)});
  hand_way(face.vertex[p], offset + frames().length(f, p), {halfedge(f, p), pseudo_source, 0, 0});
}

}  // namespace geodesic::exact
