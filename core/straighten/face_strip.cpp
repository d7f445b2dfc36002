#include "core/straighten/face_strip.h"

#include <algorithm>
#include <cassert>

#include "core/surface/face_over_edge.h"

namespace geodesic {
namespace {

bool goes_through(const Adjacency& adjacency, Halfedge edge, const SurfacePoint& point) {
  const std::uint32_t tail = adjacency.tail(edge);
  const std::uint32_t head = adjacency.head(edge);
  if (point.at_vertex()) return point.vertex == tail || point.vertex == head;
  const Halfedge under = edge_under(point);
  if (under == kNone) return false;
  const std::uint32_t a = adjacency.tail(under);
  const std::uint32_t b = adjacency.head(under);
  return (a == tail && b == head) || (a == head && b == tail);
}

// A unit vector from corner `from` to corner `to`, kept as that of the edge between.
void set_edge(std::array<Vec2, 3>& edges, std::uint32_t from, std::uint32_t to, Vec2 direction) {
  if (next_corner(from) == to) {
    edges[from] = direction;
  } else {
    edges[to] = -direction;
  }
}

Vec2 place_of(const SurfacePoint& point, const std::array<Vec2, 3>& corners) {
  return point.bary[0] * corners[0] + point.bary[1] * corners[1] + point.bary[2] * corners[2];
}

Vec2 place_in_face(const Adjacency& adjacency, const SurfacePoint& point, std::uint32_t face,
                   const std::array<Vec2, 3>& corners) {
  const auto seen = seen_from_face(adjacency, point, face);
  assert(seen);
  return place_of(seen ? *seen : point, corners);
}

}  // namespace

void FaceStrip::cross(Portal portal) {
  if (portals.empty() || portals.back().in != portal.out) {
    portals.push_back(portal);
  } else if (portals.back().out == portal.in) {
    portals.pop_back();
  } else {
    portals.back().in = portal.in;
  }
}

void trim_strip(const Adjacency& adjacency, const SurfacePoint& start, const SurfacePoint& end,
                FaceStrip& strip) {
  auto& portals = strip.portals;
  std::size_t unneeded = 0;
  while (unneeded < portals.size() && goes_through(adjacency, portals[unneeded].out, start)) {
    ++unneeded;
  }
  if (unneeded > 0) {
    strip.first_face = face_of(portals[unneeded - 1].in);
    portals.erase(portals.begin(), portals.begin() + static_cast<std::ptrdiff_t>(unneeded));
  }
  while (!portals.empty() && goes_through(adjacency, portals.back().in, end)) portals.pop_back();
}

void unfold_strip(const Adjacency& adjacency, const FaceStrip& strip, const SurfacePoint& start,
                  const SurfacePoint& end, UnfoldedStrip& result) {
  const Mesh& mesh = adjacency.mesh();
  result.unfolded_portals.clear();

  // The first face lies behind its portal, which runs from left to right along x.
  const bool one_face = strip.portals.empty();
  const Halfedge base = one_face ? halfedge(strip.first_face, 0) : strip.portals.front().out;
  const FaceOverEdge first = face_over_edge(mesh, base);
  const std::uint32_t c = corner_of(base);
  std::array<Vec2, 3> corners;
  corners[c] = {0, 0};
  corners[next_corner(c)] = {first.length, 0};
  corners[previous_corner(c)] = {first.apex_from_tail.x, -first.apex_from_tail.y};
  set_edge(result.first_edges, c, next_corner(c), {1, 0});
  set_edge(result.first_edges, c, previous_corner(c),
           unit({first.apex_from_tail.x, -first.apex_from_tail.y}));
  set_edge(result.first_edges, next_corner(c), previous_corner(c),
           unit({first.apex_from_head.x, -first.apex_from_head.y}));
  result.first_sense = -1;
  result.start = place_in_face(adjacency, start, strip.first_face, corners);
  if (one_face) {
    result.end = place_in_face(adjacency, end, strip.first_face, corners);
    result.last_edges = result.first_edges;
    result.last_sense = result.first_sense;
    return;
  }

  UnfoldedPortal unfolded_portal{corners[c], corners[next_corner(c)], adjacency.tail(base),
                                 adjacency.head(base)};
  // The direction of the portal is carried from face to face as a unit vector: that
  // of a short edge cannot be had from the difference of its ends.
  Vec2 along{1, 0};
  for (std::size_t i = 0; i < strip.portals.size(); ++i) {
    result.unfolded_portals.push_back(unfolded_portal);
    const Halfedge in = strip.portals[i].in;
    const FaceOverEdge face = face_over_edge(mesh, in);
    const Vec2 ahead{-along.y, along.x};
    const bool tail_is_left = adjacency.tail(in) == unfolded_portal.left_vertex;
    const Vec2 by_left =
        tail_is_left ? face.apex_from_tail : Vec2{-face.apex_from_head.x, face.apex_from_head.y};
    const Vec2 by_right =
        tail_is_left ? face.apex_from_head : Vec2{-face.apex_from_tail.x, face.apex_from_tail.y};
    const Vec2 from_left = by_left.x * along + by_left.y * ahead;
    const Vec2 from_right = by_right.x * along + by_right.y * ahead;
    const bool left_is_nearer = dot(by_left, by_left) <= dot(by_right, by_right);
    const Vec2 apex =
        left_is_nearer ? unfolded_portal.left + from_left : unfolded_portal.right + from_right;

    if (i + 1 < strip.portals.size()) {
      if (adjacency.apex(strip.portals[i + 1].out) == unfolded_portal.left_vertex) {
        unfolded_portal.left = apex;
        unfolded_portal.left_vertex = adjacency.apex(in);
        along = unit(-from_right);
      } else {
        unfolded_portal.right = apex;
        unfolded_portal.right_vertex = adjacency.apex(in);
        along = unit(from_left);
      }
      continue;
    }
    const std::uint32_t tail = corner_of(in);
    const std::uint32_t left = tail_is_left ? tail : next_corner(tail);
    const std::uint32_t right = tail_is_left ? next_corner(tail) : tail;
    const std::uint32_t top = previous_corner(tail);
    corners[left] = unfolded_portal.left;
    corners[right] = unfolded_portal.right;
    corners[top] = apex;
    result.last_sense = tail_is_left ? 1 : -1;
    set_edge(result.last_edges, left, right, along);
    set_edge(result.last_edges, left, top, unit(from_left));
    set_edge(result.last_edges, right, top, unit(from_right));
  }
  result.end = place_in_face(adjacency, end, strip.last_face(), corners);
}

}  // namespace geodesic
