#include "core/surface/refined_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <queue>
#include <utility>

#include "core/base/polled_fill.h"
#include "core/base/tolerances.h"
#include "core/base/vec2.h"
#include "core/mesh/mesh.h"
#include "core/surface/corner_lists.h"
#include "core/surface/intrinsic_delaunay.h"
#include "core/surface/intrinsic_faces.h"
#include "core/surface/unfold_rounding.h"
#include "core/surface/walk_over_faces.h"

namespace geodesic {
namespace {

// The radius of a face's circle over its shortest side, squared: least angles of six degrees. With
// 12 degrees there are a half more vertices, with three, windows take as long.
constexpr double kMostRadius2 = 25;
// Of the edges that straight lines cross: worth the time where so many are of needles, if so many
// are left.
constexpr double kManyOfNeedles = 0.25;
constexpr double kFewerCrossings = 0.75;
// Of the faces, one in so many more may have no width, which nothing refines, than without vertices
// added: windows that pass between such faces come to more and more places.
constexpr std::size_t kFewWithoutWidth = 50;
// Of the longest side, squared: products of four sides are numbers, and those of sides 1e-16 as
// long keep their digits.
constexpr double kLeastLongest2 = 1e-100;
constexpr double kMostLongest2 = 1e100;
// Found at once, for each face there is room for.
constexpr std::size_t kMostNeedles = 4;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// As of a point that is given (point.h): rounding leaves so much of nothing.
constexpr double kRoundedWeight = 1e-13;
// Of a face's longest side, how far rounding puts a place beside where it is, at the most.
constexpr double kBesidePlace = 1e-9;
// Of a face's longest side, its height, if it has no width.
constexpr double kFlat = 1e-9;
// Of the sides of faces that a flip has made of two that are wound differently.
constexpr std::array<double, 3> kNoDirections{kNaN, kNaN, kNaN};

// Of the circumscribed circle.
double squared_radius(const FaceRecord& face) {
  return face.length2(0) / face.area2 * (face.length2(1) / face.area2) * face.length2(2) / 4;
}

// Its circle is anywhere.
bool has_no_width(const FaceRecord& face) {
  return !(face.area2 > tolerance::kWindowZeroArea * face.longest2());
}

bool is_needle(const FaceRecord& face) {
  return !has_no_width(face) && squared_radius(face) > kMostRadius2 * face.shortest2();
}

std::size_t count_without_width(std::span<const FaceRecord> faces) {
  return static_cast<std::size_t>(std::count_if(faces.begin(), faces.end(), has_no_width));
}

// Straight lines cross edges in proportion to their length.
struct SumOfSides {
  double of_all = 0;
  double of_needles = 0;
};

SumOfSides sum_of_sides(std::span<const FaceRecord> faces) {
  SumOfSides sum;
  for (const FaceRecord& face : faces) {
    double sides = 0;
    for (std::uint32_t c = 0; c < 3; ++c) sides += std::sqrt(std::max(face.length2(c), 0.0));
    sum.of_all += sides;
    if (is_needle(face)) sum.of_needles += sides;
  }
  return sum;
}

class Refining {
 public:
  Refining(const Triangulation& mesh, std::span<const Vec3> positions, Poll& poll);

  // Whether none waits any more; not if there was no more room. One whose circle's centre cannot be
  // walked to stays.
  [[nodiscard]] bool refine();
  [[nodiscard]] std::span<const FaceRecord> faces() const {
    return std::span(faces_).first(face_count_);
  }
  [[nodiscard]] std::uint32_t vertex_count() const { return vertex_count_; }
  [[nodiscard]] std::uint64_t flips() const { return flips_; }
  [[nodiscard]] double direction(std::uint32_t corner) const {
    return direction_[face_of(corner)][corner_of(corner)];
  }

 private:
  struct Needle {
    double radius2;
    std::uint32_t face;
    std::array<std::uint32_t, 3> vertex;  // of the face when it was found
    bool operator<(const Needle& other) const { return radius2 < other.radius2; }
  };

  [[nodiscard]] Triangulation view() const {
    return {faces(), {}, {}, mesh_.is_oriented, false, mesh_.has_flat_faces};
  }
  [[nodiscard]] bool has_room(std::size_t more) const {
    return face_count_ + more <= faces_.size();
  }
  void measure_directions();
  void flip_waiting();
  void note(std::uint32_t face);
  void put_vertex_at_centre(std::uint32_t face);
  void put_vertex_into(std::uint32_t face, const std::array<double, 3>& weights);
  void put_vertex_on(Halfedge h);

  const Triangulation& mesh_;
  Poll& poll_;
  std::size_t face_count_;
  std::uint32_t vertex_count_;
  std::size_t steps_;  // that are left
  std::uint64_t flips_ = 0;
  bool is_noting_ = false;
  std::vector<FaceRecord> faces_;
  std::vector<std::array<double, 3>> direction_;  // of the side that a corner begins
  std::vector<Halfedge> waiting_;
  std::priority_queue<Needle> needles_;
  SideLengths lengths_;
};

// A vertex put into a face makes two more: so at most twice as many vertices, and a few for the
// smallest meshes. One on the boundary makes one.
std::size_t most_faces(const Triangulation& mesh) {
  return mesh.faces.size() + 2 * mesh.corner_begin.size() + 64;
}

Refining::Refining(const Triangulation& mesh, std::span<const Vec3> positions, Poll& poll)
    : mesh_(mesh),
      poll_(poll),
      face_count_(mesh.faces.size()),
      vertex_count_(static_cast<std::uint32_t>(mesh.corner_begin.size() - 1)),
      steps_(most_flips(mesh.faces.size())),
      lengths_(positions, most_faces(mesh), poll) {
  constexpr std::size_t kOfFace = sizeof(FaceRecord) + sizeof(SquaredSides) +
                                  sizeof(direction_[0]) + 2 * kMostNeedles * sizeof(Needle) +
                                  8 * sizeof(Halfedge);
  if (!poll.may_take(most_faces(mesh) * kOfFace)) return;
  faces_.reserve(most_faces(mesh));
  faces_.assign(mesh.faces.begin(), mesh.faces.end());
  faces_.resize(most_faces(mesh));
  direction_.assign(most_faces(mesh), {});
  measure_directions();
}

void Refining::measure_directions() {
  for (std::uint32_t v = 0; v + 1 < mesh_.corner_begin.size() && !poll_.cancelled(); ++v) {
    if (mesh_.corners(v).empty()) continue;
    const std::uint32_t first = corner_of_directions(mesh_, v, poll_);
    double sum = 0;
    for (std::uint32_t corner = first; !poll_.cancelled();) {
      direction_[face_of(corner)][corner_of(corner)] = sum;
      sum += corner_angle(faces_[face_of(corner)], corner_of(corner));
      const std::uint32_t next = next_around(mesh_.faces, corner);
      if (next == corner || next == first) break;
      corner = next;
    }
  }
}

bool Refining::refine() {
  for (std::uint32_t f = 0; f < face_count_; ++f) {
    for (std::uint32_t c = 0; c < 3; ++c) waiting_.push_back(halfedge(f, c));
  }
  flip_waiting();
  is_noting_ = true;
  for (std::uint32_t f = 0; f < face_count_; ++f) note(f);
  // The largest first: they have the most others in their circles.
  while (!needles_.empty() && steps_ > 0 && has_room(Triangulation::kCrowd) && !poll_.cancelled()) {
    const Needle needle = needles_.top();
    needles_.pop();
    if (faces_[needle.face].vertex == needle.vertex) put_vertex_at_centre(needle.face);
  }
  return needles_.empty() && steps_ > 0;
}

void Refining::note(std::uint32_t f) {
  const FaceRecord& face = faces_[f];
  if (!is_noting_ || !is_needle(face)) return;
  if (needles_.size() < kMostNeedles * faces_.size()) {
    needles_.push({squared_radius(face), f, face.vertex});
  } else {
    steps_ = 0;
  }
}

void Refining::flip_waiting() {
  const std::span<FaceRecord> faces = std::span(faces_).first(face_count_);
  while (!waiting_.empty() && steps_ > 0 && !poll_.cancelled()) {
    const Halfedge h = waiting_.back();
    waiting_.pop_back();
    const Triangulation now = view();
    if (now.ring(h) == h || !IntrinsicDelaunay::can_flip(now, h)) continue;
    if (!(IntrinsicDelaunay::excess(now, h) < -IntrinsicDelaunay::excess_rounding(now, h))) {
      continue;
    }
    // As flip_edge has them: a - b with the apexes c and d.
    const Halfedge over = now.ring(h);
    const bool is_wound_alike = opposite_halfedge(now.faces, h) == over;
    const std::uint32_t f = face_of(h);
    const std::uint32_t g = face_of(over);
    const double to_c = direction_[f][next_corner(corner_of(h))];
    const double from_c = direction_[f][previous_corner(corner_of(h))];
    const double at_a = direction_[g][next_corner(corner_of(over))];
    const double from_d = direction_[g][previous_corner(corner_of(over))];
    if (!flip_edge(faces, h, lengths_)) continue;
    --steps_;
    ++flips_;
    direction_[f] = {at_a, from_d + corner_angle(faces[g], 2), from_c};
    direction_[g] = {to_c, from_c + corner_angle(faces[f], 2), from_d};
    if (!is_wound_alike) direction_[f] = direction_[g] = kNoDirections;
    for (const std::uint32_t face : {f, g}) {
      waiting_.push_back(halfedge(face, 0));
      waiting_.push_back(halfedge(face, 2));
      note(face);
    }
  }
  waiting_.clear();
}

void Refining::put_vertex_at_centre(std::uint32_t f) {
  const FaceRecord& face = faces_[f];
  const UnfoldedTriangle start = UnfoldedTriangle::from_corner(faces(), f, 0);
  Vec2 centre{0, 0};
  double sum = 0;
  for (std::uint32_t c = 0; c < 3; ++c) {
    const double weight = face.length2(next_corner(c)) * face.dot[c];
    centre = centre + weight * start.at[c];
    sum += weight;
  }
  centre = (1 / sum) * centre;
  const Vec2 from = (1.0 / 3) * (start.at[0] + start.at[1] + start.at[2]);
  const auto end = walk_straight(faces(), start, from, centre, steps_, poll_);
  if (!end) return;
  if (end->blocked != kNone) return put_vertex_on(end->blocked);
  const auto weights = end->face.weights_at(centre);
  if (weights) put_vertex_into(end->face.face, *weights);
}

void Refining::put_vertex_into(std::uint32_t f, const std::array<double, 3>& weights) {
  // Not on a side: flips take those away that are too near.
  constexpr double kLeast = 1e-3;
  double sum = 0;
  for (const double weight : weights) sum += std::max(weight, kLeast);
  const auto g = static_cast<std::uint32_t>(face_count_);
  const auto at = direction_[f];
  if (!put_into_face(faces_, f, std::max(weights[1], kLeast) / sum,
                     std::max(weights[2], kLeast) / sum, vertex_count_, g, lengths_)) {
    return;
  }
  ++vertex_count_;
  face_count_ += 2;
  const std::uint32_t h = g + 1;
  direction_[f] = {at[0], at[1] + corner_angle(faces_[g], 0), 0};
  direction_[g] = {at[1], at[2] + corner_angle(faces_[h], 0), 0};
  direction_[h] = {at[2], at[0] + corner_angle(faces_[f], 0), 0};
  for (const std::uint32_t face : {f, g, h}) {
    waiting_.push_back(halfedge(face, 0));
    note(face);
  }
  flip_waiting();
}

void Refining::put_vertex_on(Halfedge h) {
  std::array<Halfedge, Triangulation::kCrowd> ring{h};
  std::size_t count = 1;
  for (Halfedge p = view().ring(h); p != h; p = view().ring(p)) {
    if (count == ring.size()) return;
    ring[count++] = p;
  }
  const auto g = static_cast<std::uint32_t>(face_count_);
  if (!put_on_edge(faces_, std::span(ring).first(count), vertex_count_, g, lengths_)) return;
  ++vertex_count_;
  face_count_ += count;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint32_t f = face_of(ring[i]);
    const std::uint32_t x = corner_of(ring[i]);
    const std::uint32_t y = next_corner(x);
    const std::uint32_t z = previous_corner(x);
    direction_[g + i][y] = direction_[f][y];
    direction_[g + i][z] = direction_[f][z] + corner_angle(faces_[f], z);
    for (const std::uint32_t face : {f, g + i}) {
      for (std::uint32_t c = 0; c < 3; ++c) waiting_.push_back(halfedge(face, c));
      note(face);
    }
  }
  flip_waiting();
}

}  // namespace

Result<std::shared_ptr<const RefinedSurface>> RefinedSurface::build(const Triangulation& mesh,
                                                                    const Triangulation& delaunay,
                                                                    std::span<const Vec3> positions,
                                                                    const Cancel& cancel) {
  const std::size_t mesh_vertices = positions.size();
  if (mesh_vertices > kMostVertices || mesh.faces.size() > 3 * kMostVertices) return nullptr;
  if (!(mesh.longest2 > kLeastLongest2 && mesh.longest2 < kMostLongest2)) return nullptr;
  const SumOfSides before = sum_of_sides(delaunay.faces);
  if (!(before.of_needles > kManyOfNeedles * before.of_all)) return nullptr;
  Poll poll(cancel);
  Refining refining(mesh, positions, poll);
  const bool is_done = !poll.stopped() && refining.refine();
  if (poll.stopped()) return fail_stopped(cancel);
  // Holes in needles want more vertices without end, and windows become more by them.
  if (!is_done) return nullptr;
  if (!(sum_of_sides(refining.faces()).of_all < kFewerCrossings * before.of_all)) return nullptr;

  const std::size_t more_without_width =
      std::max(count_without_width(refining.faces()), count_without_width(delaunay.faces)) -
      count_without_width(delaunay.faces);
  if (kFewWithoutWidth * more_without_width > refining.faces().size()) return nullptr;

  if (!poll.may_take(refining.faces().size_bytes() +
                     mesh_vertices * (sizeof(std::uint32_t) + sizeof(double)))) {
    return fail_stopped(cancel);
  }
  std::vector<FaceRecord> faces(refining.faces().begin(), refining.faces().end());
  std::vector<std::uint32_t> corner_begin;
  std::vector<std::uint32_t> corners;
  list_corners(faces, refining.vertex_count(), corner_begin, corners, poll);
  std::vector<std::uint32_t> first_corner;
  std::vector<double> first_direction;
  const Triangulation refined{faces, corner_begin, corners};
  for (std::uint32_t v = 0; v < mesh_vertices && !poll.stopped(); ++v) {
    const bool are_fans = is_one_fan(mesh, v, poll) && is_one_fan(refined, v, poll);
    const std::uint32_t corner = are_fans ? corner_of_directions(refined, v, poll) : kNone;
    const double direction = are_fans ? refining.direction(corner) : 0;
    first_corner.push_back(std::isfinite(direction) ? corner : kNone);
    first_direction.push_back(std::isfinite(direction) ? direction : 0);
  }
  const SideExtent sides = extent_of_sides(faces, poll);
  if (poll.stopped()) return fail_stopped(cancel);
  return std::make_shared<const RefinedSurface>(
      Parts{.delaunay = IntrinsicDelaunay({.faces = SharedArray(std::move(faces)),
                                           .corner_begin = SharedArray(std::move(corner_begin)),
                                           .corners = SharedArray(std::move(corners)),
                                           .is_oriented = mesh.is_oriented,
                                           .is_crowded = mesh.is_crowded,
                                           .is_even = sides.is_even(),
                                           .has_flat_faces = mesh.has_flat_faces,
                                           .longest2 = sides.longest2,
                                           .flips = refining.flips()}),
            .first_corner = SharedArray(std::move(first_corner)),
            .first_direction = SharedArray(std::move(first_direction))});
}

namespace {

// A place at a vertex that was added, in all faces there.
std::vector<RefinedSurface::Place> in_faces_round(const Triangulation& refined,
                                                  const RefinedSurface::Place& at_vertex,
                                                  Poll& poll) {
  const auto& corners = at_vertex.laid.corner;
  const auto corner = std::find_if(corners.begin(), corners.end(),
                                   [&](std::uint32_t c) { return at_vertex.weights[c] != 0; });
  std::vector<RefinedSurface::Place> places;
  for (const auto& [face, c] : unfolded_round(refined.faces, at_vertex.laid,
                                              static_cast<int>(corner - corners.begin()), poll)) {
    places.push_back({face.face, {}, face, at_vertex.corner});
    places.back().weights[c] = 1;
  }
  return places;
}

}  // namespace

// From a corner of the point's face, in its direction and as far.
std::optional<RefinedSurface::Place> RefinedSurface::place_from(
    const Triangulation& mesh, std::uint32_t corner, const std::array<double, 3>& weights,
    Poll& poll) const {
  const std::uint32_t v = mesh.faces[face_of(corner)].vertex[corner_of(corner)];
  const std::uint32_t first = parts_.first_corner[v];
  const auto side = first == kNone ? std::nullopt : direction_of(mesh, corner, poll);
  if (!side) return std::nullopt;
  const Triangulation refined = triangulation();
  const UnfoldedTriangle face =
      UnfoldedTriangle::from_corner(mesh.faces, face_of(corner), corner_of(corner));
  const Vec2 point = weights[face.corner[1]] * face.at[1] + weights[face.corner[2]] * face.at[2];
  const double from_side = std::atan2(point.y, point.x);
  const Heading heading =
      turned_from(refined, first, *side + from_side - parts_.first_direction[v], poll);
  const UnfoldedTriangle start =
      UnfoldedTriangle::from_corner(refined.faces, face_of(heading.corner),
                                    corner_of(heading.corner))
          .turned_by(from_side - heading.angle);
  const UnfoldedTriangle end = walk_on_flat_faces(refined.faces, start, point, poll);
  const auto weights_there = end.weights_at(point);
  if (!weights_there) return std::nullopt;
  Vec2 found{0, 0};
  for (std::size_t i = 0; i < 3; ++i) found = found + (*weights_there)[end.corner[i]] * end.at[i];
  if (!(norm(found - point) <= kBesidePlace * std::sqrt(mesh.faces[face_of(corner)].longest2()))) {
    return std::nullopt;
  }
  Place place{end.face, *weights_there, end, corner_of(corner)};
  double sum = 0;
  for (double& weight : place.weights) {
    if (weight < kRoundedWeight) weight = 0;
    sum += weight;
  }
  for (double& weight : place.weights) weight /= sum;
  return place;
}

std::vector<RefinedSurface::Place> RefinedSurface::places_of(const Triangulation& mesh,
                                                             std::uint32_t face,
                                                             const std::array<double, 3>& weights,
                                                             Poll& poll) const {
  const Triangulation refined = triangulation();
  // From the nearest corner; in a face without width, from the one between the others, for the way
  // from these leads through it, and on as rounding has it.
  const FaceRecord& record = mesh.faces[face];
  const bool is_flat = record.area2 < kFlat * record.longest2();
  std::array<std::uint32_t, 3> corners{0, 1, 2};
  std::sort(corners.begin(), corners.end(), [&](std::uint32_t a, std::uint32_t b) {
    if (is_flat) return record.dot[a] < record.dot[b];
    return std::pair(weights[a], b) > std::pair(weights[b], a);
  });
  for (const std::uint32_t c : corners) {
    const auto place = place_from(mesh, halfedge(face, c), weights, poll);
    if (!place) continue;
    if (std::count(place->weights.begin(), place->weights.end(), 0.0) > 1) {
      return in_faces_round(refined, *place, poll);
    }
    std::vector<Place> places{*place};
    for (int i = 0; i < 3; ++i) {
      const Halfedge h = place->laid.side(i);
      if (place->weights[previous_corner(corner_of(h))] != 0) continue;
      const auto corner = [&](int k) {
        return place->laid.corner[static_cast<std::size_t>(k % 3)];
      };
      for (Halfedge over = refined.ring(h); over != h && !poll.cancelled();
           over = refined.ring(over)) {
        Place other{face_of(over), {}, place->laid.across(refined.faces, over, i), place->corner};
        other.weights[other.laid.corner[0]] = place->weights[corner(i + 1)];
        other.weights[other.laid.corner[1]] = place->weights[corner(i)];
        places.push_back(other);
      }
    }
    return places;
  }
  return {};
}

bool RefinedSurface::has_all_directions(const Triangulation& mesh) const {
  for (std::uint32_t v = 0; v < parts_.first_corner.size(); ++v) {
    if (parts_.first_corner[v] == kNone && !mesh.corners(v).empty()) return false;
  }
  return true;
}

std::optional<Heading> RefinedSurface::heading_on_mesh(const Triangulation& mesh,
                                                       const Heading& heading, Poll& poll) const {
  const Triangulation refined = triangulation();
  const std::uint32_t v = refined.faces[face_of(heading.corner)].vertex[corner_of(heading.corner)];
  const std::uint32_t first = v < parts_.first_corner.size() ? parts_.first_corner[v] : kNone;
  if (first == kNone) return std::nullopt;
  double direction = parts_.first_direction[v] + heading.angle;
  for (std::uint32_t at = first; at != heading.corner && !poll.cancelled();) {
    direction += corner_angle(refined.faces[face_of(at)], corner_of(at));
    const std::uint32_t next = next_around(refined.faces, at);
    if (next == at || next == first) return std::nullopt;
    at = next;
  }
  return turned_from(mesh, corner_of_directions(mesh, v, poll), direction, poll);
}

std::size_t RefinedSurface::bytes() const {
  return sizeof(RefinedSurface) + parts_.delaunay.bytes() + parts_.first_corner.bytes() +
         parts_.first_direction.bytes();
}

}  // namespace geodesic
