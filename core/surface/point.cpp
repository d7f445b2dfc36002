#include "core/surface/point.h"

#include <algorithm>

namespace geodesic {
namespace {

// Of the largest weight. Positions have no more digits.
constexpr double kNoWeight = 1e-13;

}  // namespace

SurfacePoint point_at_vertex(const Adjacency& adjacency, std::uint32_t vertex) {
  SurfacePoint point;
  point.vertex = vertex;
  const auto corners = adjacency.corners(vertex);
  if (!corners.empty()) {
    point.face = face_of(corners.front());
    point.bary = {0, 0, 0};
    point.bary[corner_of(corners.front())] = 1;
  }
  return point;
}

SurfacePoint point_on_face(const Adjacency& adjacency, std::uint32_t face,
                           std::array<double, 3> bary) {
  // Divided by the largest first, so that neither the sum nor a part overflows.
  const double largest = std::max({bary[0], bary[1], bary[2]});
  for (double& weight : bary) weight /= largest;
  const double sum = bary[0] + bary[1] + bary[2];
  for (double& weight : bary) weight /= sum;
  SurfacePoint point{face, bary, kNone};
  for (std::uint32_t c = 0; c < 3; ++c) {
    if (bary[next_corner(c)] == 0 && bary[previous_corner(c)] == 0) {
      point.vertex = adjacency.face(face).vertex[c];
      point.bary[c] = 1;
    }
  }
  return point;
}

SurfacePoint snapped_point(const Adjacency& adjacency, std::uint32_t face,
                           std::array<double, 3> bary) {
  const double largest = std::max({bary[0], bary[1], bary[2]});
  for (double& weight : bary) {
    if (weight < kNoWeight * largest) weight = 0;
  }
  return point_on_face(adjacency, face, bary);
}

Vec3 position_of(const Mesh& mesh, const SurfacePoint& point) {
  if (point.at_vertex()) return mesh.positions()[point.vertex];
  const Triangle& t = mesh.faces()[point.face];
  return point.bary[0] * mesh.positions()[t[0]] + point.bary[1] * mesh.positions()[t[1]] +
         point.bary[2] * mesh.positions()[t[2]];
}

double distance_to_corner(const Mesh& mesh, const SurfacePoint& point, std::uint32_t c) {
  const Triangle& t = mesh.faces()[point.face];
  const auto positions = mesh.positions();
  const std::uint32_t n = next_corner(c);
  const std::uint32_t p = previous_corner(c);
  return norm(point.bary[n] * (positions[t[n]] - positions[t[c]]) +
              point.bary[p] * (positions[t[p]] - positions[t[c]]));
}

std::vector<SurfacePoint> in_all_faces(const Adjacency& adjacency, const SurfacePoint& point) {
  std::vector<SurfacePoint> places;
  if (point.at_vertex()) {
    for (const std::uint32_t corner : adjacency.corners(point.vertex)) {
      SurfacePoint& place = places.emplace_back();
      place.face = face_of(corner);
      place.bary = {0, 0, 0};
      place.bary[corner_of(corner)] = 1;
      place.vertex = point.vertex;
    }
    return places;
  }
  places.reserve(2);  // faces on most edges
  places.push_back(point);
  const Halfedge under = edge_under(point);
  if (under == kNone) return places;
  const std::uint32_t c = corner_of(under);
  for (Halfedge h = adjacency.ring(under); h != under; h = adjacency.ring(h)) {
    const std::uint32_t hc = corner_of(h);
    const bool same_way = adjacency.tail(h) == adjacency.tail(under);
    SurfacePoint& place = places.emplace_back();
    place.face = face_of(h);
    place.bary[hc] = point.bary[same_way ? c : next_corner(c)];
    place.bary[next_corner(hc)] = point.bary[same_way ? next_corner(c) : c];
    place.bary[previous_corner(hc)] = 0;
  }
  return places;
}

std::optional<SurfacePoint> seen_from_face(const Adjacency& adjacency, const SurfacePoint& point,
                                           std::uint32_t face) {
  if (point.face == face && !point.at_vertex()) return point;
  const auto& corners = adjacency.face(face).vertex;
  SurfacePoint seen{face, {0, 0, 0}, point.vertex};
  const auto put = [&](std::uint32_t vertex, double weight) {
    for (std::uint32_t c = 0; c < 3; ++c) {
      if (corners[c] == vertex) return seen.bary[c] = weight, true;
    }
    return false;
  };
  if (point.at_vertex()) return put(point.vertex, 1) ? std::optional(seen) : std::nullopt;
  if (edge_under(point) == kNone) return std::nullopt;
  for (std::uint32_t c = 0; c < 3; ++c) {
    if (point.bary[c] == 0) continue;
    if (!put(adjacency.face(point.face).vertex[c], point.bary[c])) return std::nullopt;
  }
  return seen;
}

}  // namespace geodesic
