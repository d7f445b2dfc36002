#include "core/locate/plane_section.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "core/base/polled_sort.h"
#include "core/base/tolerances.h"
#include "core/base/vec2.h"
#include "core/surface/copied_faces.h"

namespace geodesic {
namespace {

// Of length one; nothing for a vector that has no direction. Its squares may overflow, so the
// greatest part comes to one first.
std::optional<Vec3> direction_of(Vec3 v) {
  const double most = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  if (!(most > 0) || !std::isfinite(most) || std::isnan(v.x + v.y + v.z)) return std::nullopt;
  const Vec3 scaled{v.x / most, v.y / most, v.z / most};
  return (1 / norm(scaled)) * scaled;
}

// Walks from face to face along a section.
class Section {
 public:
  Section(const Adjacency& adjacency, Vec3 through, Vec3 normal, const Cancel& cancel)
      : adjacency_(adjacency), through_(through), normal_(normal), poll_(cancel) {}

  Result<std::vector<SurfacePoint>> follow(const SurfacePoint& at) {
    const auto start = first_side(at);
    if (poll_.stopped()) return fail_stopped(poll_);
    if (!start) return touches();
    // Of a face and the side by which it is entered there is one next, and one before it: the
    // walk comes back to where it began, after as many steps as there are sides at most.
    Halfedge entered = *start;
    do {
      if (poll_.cancelled()) return fail_stopped(poll_);
      if (!add(point_on(entered))) return fail_stopped(poll_);
      const Halfedge left_by = other_cut_side(entered);
      entered = beyond(left_by);
      if (poll_.stopped()) return fail_stopped(poll_);
      if (entered == left_by) {
        return fail(ErrorCode::no_loop,
                    "the section comes to the boundary of the surface there: it is no closed curve",
                    "normal");
      }
    } while (entered != *start);
    while (points_.size() > 1 && is_same(points_.back(), points_.front())) {
      points_.pop_back();  // it leads through faces in which the curve does not move on
    }
    if (points_.size() < 2) return touches();  // a peak in the plane
    return std::move(points_);
  }

 private:
  [[nodiscard]] static tl::unexpected<Error> touches() {
    return fail(ErrorCode::no_loop, "the plane only touches the surface there, and does not cut it",
                "normal");
  }

  [[nodiscard]] double height(std::uint32_t vertex) const {
    return dot(normal_, adjacency_.mesh().positions()[vertex] - through_);
  }
  [[nodiscard]] bool is_cut(Halfedge h) const {
    return (height(adjacency_.tail(h)) >= 0) != (height(adjacency_.head(h)) >= 0);
  }

  // Of faces with the same corners the section goes through the last one alone: else it would turn
  // round in them.
  [[nodiscard]] Halfedge beyond(Halfedge side) {
    Halfedge h = adjacency_.ring(side);
    while (h != side && has_later_copy(adjacency_, face_of(h)) && !poll_.cancelled()) {
      h = adjacency_.ring(h);
    }
    return h;
  }

  [[nodiscard]] std::optional<Halfedge> cut_side(std::uint32_t face) const {
    for (std::uint32_t c = 0; c < 3; ++c) {
      if (is_cut(halfedge(face, c))) return halfedge(face, c);
    }
    return std::nullopt;
  }

  // Some side that the plane cuts, of the first face at the point that has one.
  [[nodiscard]] std::optional<Halfedge> first_side(const SurfacePoint& at) {
    for (const SurfacePoint& place : in_all_faces(adjacency_, at)) {
      if (poll_.cancelled()) return std::nullopt;
      // Copies of a face are cut alike: the last is looked for where it is cut, and so only once.
      std::uint32_t face = place.face;
      if (!cut_side(face)) continue;
      while (has_later_copy(adjacency_, face) && !poll_.cancelled()) {
        face = later_copy(adjacency_, face);
      }
      return cut_side(face);
    }
    return std::nullopt;
  }

  // A face that is cut has two such sides.
  [[nodiscard]] Halfedge other_cut_side(Halfedge entered) const {
    const std::uint32_t c = next_corner(corner_of(entered));
    const Halfedge next = halfedge(face_of(entered), c);
    return is_cut(next) ? next : halfedge(face_of(entered), next_corner(c));
  }

  // Where the plane cuts a side: the same place from whichever face.
  [[nodiscard]] SurfacePoint point_on(Halfedge h) const {
    const double at_tail = std::abs(height(adjacency_.tail(h)));
    const double at_head = std::abs(height(adjacency_.head(h)));
    std::array<double, 3> bary{0, 0, 0};
    bary[corner_of(h)] = at_head;
    bary[next_corner(corner_of(h))] = at_tail;
    return point_on_face(adjacency_, face_of(h), bary);
  }

  [[nodiscard]] bool is_same(const SurfacePoint& a, const SurfacePoint& b) const {
    return position_of(adjacency_.mesh(), a) == position_of(adjacency_.mesh(), b);
  }

  // False if there is no memory for it.
  [[nodiscard]] bool add(const SurfacePoint& point) {
    // The face of the segment that leaves it is that of the last of the same place.
    if (!points_.empty() && is_same(points_.back(), point)) {
      points_.back() = point;
      return true;
    }
    if (points_.size() == points_.capacity()) {
      const std::size_t more = std::max<std::size_t>(64, 2 * points_.size());
      // As it grows, it is there twice; then each point is in a path, and in one that is shorter.
      if (!poll_.may_take(8 * more * sizeof(SurfacePoint))) return false;
      points_.reserve(more);
    }
    points_.push_back(point);
    return true;
  }

  const Adjacency& adjacency_;
  Vec3 through_;
  Vec3 normal_;
  Poll poll_;
  std::vector<SurfacePoint> points_;
};

double to_segment(Vec3 p, Vec3 a, Vec3 b) {
  const Vec3 along = b - a;
  const double square = dot(along, along);
  const double part = square > 0 ? std::clamp(dot(p - a, along) / square, 0.0, 1.0) : 0;
  return distance(p, a + part * along);
}

struct Flat {
  Vec2 at;
  std::uint32_t place;
};

// Adds `point` to one side of a hull, which turns left everywhere.
void turn_left_to(const Flat& point, std::size_t least, std::vector<Flat>& side) {
  while (side.size() > least) {
    const Vec2 along = side.back().at - side[side.size() - 2].at;
    if (cross(along, point.at - side.back().at) > 0) break;
    side.pop_back();
  }
  side.push_back(point);
}

struct GivenPoint {
  SurfacePoint point;
  Vec3 at;
  std::size_t number;  // in the order in which they were given
};

// Whether a face in which one of the points lies is in the plane, to rounding. Of no use if the
// poll says to stop.
bool lies_along_a_face(const Adjacency& adjacency, const std::array<GivenPoint, 3>& points,
                       Vec3 normal, Poll& poll) {
  const Mesh& mesh = adjacency.mesh();
  const Vec3 up = (1 / norm(normal)) * normal;
  const Vec3 through = points[0].at;
  const double rounding = tolerance::kSamePath * norm(mesh.box().max - mesh.box().min);
  for (const GivenPoint& given : points) {
    for (const SurfacePoint& place : in_all_faces(adjacency, given.point)) {
      if (poll.cancelled()) return false;
      const auto& corners = adjacency.face(place.face).vertex;
      if (std::all_of(corners.begin(), corners.end(), [&](std::uint32_t v) {
            return std::abs(dot(up, mesh.positions()[v] - through)) <= rounding;
          })) {
        return true;
      }
    }
  }
  return false;
}

// The curve through the first of the points, if it runs through the others.
Result<SectionOfPoints> section_by(const Adjacency& adjacency,
                                   const std::array<GivenPoint, 3>& points, Vec3 normal,
                                   const Cancel& cancel) {
  auto section = plane_section(adjacency, points[0].point, normal, cancel);
  if (!section) {
    Error error = std::move(section.error());
    if (!error.parameter.empty()) error.parameter = "around";
    return fail(std::move(error));
  }
  const Mesh& mesh = adjacency.mesh();
  Poll poll(cancel);
  const double extent = norm(mesh.box().max - mesh.box().min);
  for (const GivenPoint& given : std::span(points).subspan(1)) {
    double least = std::numeric_limits<double>::infinity();
    Vec3 before = position_of(mesh, section->back());
    for (const SurfacePoint& point : *section) {
      if (poll.cancelled()) return fail_stopped(poll);
      const Vec3 here = position_of(mesh, point);
      least = std::min(least, to_segment(given.at, before, here));
      before = here;
    }
    if (least <= tolerance::kSamePath * extent) continue;
    return fail(ErrorCode::no_loop,
                "the plane of the three points cuts the surface in several curves: the one through "
                "another of them does not run through this one",
                "around[" + std::to_string(given.number) + "]");
  }
  return SectionOfPoints{std::move(*section), normal};
}

}  // namespace

Result<std::vector<SurfacePoint>> plane_section(const Adjacency& adjacency, const SurfacePoint& at,
                                                Vec3 normal, const Cancel& cancel) {
  const auto direction = direction_of(normal);
  if (!direction) {
    return fail(ErrorCode::value_out_of_range, "a normal has a length, and it is finite", "normal");
  }
  return Section(adjacency, position_of(adjacency.mesh(), at), *direction, cancel).follow(at);
}

Result<SectionOfPoints> section_through(const Adjacency& adjacency,
                                        const std::array<SurfacePoint, 3>& points,
                                        const Cancel& cancel) {
  // The same plane, to the last bit, in whichever order the points are given.
  std::array<GivenPoint, 3> given;
  for (std::size_t i = 0; i < 3; ++i) {
    given[i] = {points[i], position_of(adjacency.mesh(), points[i]), i};
  }
  std::sort(given.begin(), given.end(), [](const GivenPoint& a, const GivenPoint& b) {
    return std::array{a.at.x, a.at.y, a.at.z} < std::array{b.at.x, b.at.y, b.at.z};
  });
  const Vec3 one_side = given[1].at - given[0].at;
  const Vec3 other_side = given[2].at - given[0].at;
  const Vec3 normal = cross(one_side, other_side);
  // Too flat a triangle says no plane.
  if (!(norm(normal) > tolerance::kSamePath * norm(one_side) * norm(other_side))) {
    return fail(ErrorCode::value_out_of_range,
                "three points in one line say no plane: take another one, or at and normal",
                "around");
  }
  // Vertices in the plane count as above it. Where that leaves no curve, as along the edges of a
  // flat side, they may count as below it.
  auto section = section_by(adjacency, given, normal, cancel);
  if (!section && section.error().code == ErrorCode::no_loop) {
    auto other = section_by(adjacency, given, -1 * normal, cancel);
    if (other || other.error().code != ErrorCode::no_loop) return other;
    Poll poll(cancel);
    const bool is_along = lies_along_a_face(adjacency, given, normal, poll);
    if (poll.stopped()) return fail_stopped(poll);
    if (is_along) {
      return fail(ErrorCode::no_loop,
                  "the plane of the three points lies along a face there: it cuts no closed curve",
                  "around");
    }
    // That the plane touches the surface says more than that it cuts it elsewhere, too.
    if (other.error().parameter == "around") return other;
  }
  return section;
}

Result<std::vector<std::uint32_t>> hull_in_plane(std::span<const Vec3> points, Vec3 normal,
                                                 const Cancel& cancel) {
  Poll poll(cancel);
  std::vector<std::uint32_t> corners;
  const auto up = direction_of(normal);
  if (points.empty() || !up) return corners;
  // Two directions in the plane; the first is across from the axis that is least along `up`.
  const std::array<double, 3> sizes{std::abs(up->x), std::abs(up->y), std::abs(up->z)};
  const Vec3 axis = sizes[0] <= sizes[1] && sizes[0] <= sizes[2] ? Vec3{1, 0, 0}
                    : sizes[1] <= sizes[2]                       ? Vec3{0, 1, 0}
                                                                 : Vec3{0, 0, 1};
  Vec3 x = cross(*up, axis);
  x = (1 / norm(x)) * x;
  const Vec3 y = cross(*up, x);

  if (!poll.may_take(4 * points.size() * sizeof(Flat))) return fail_stopped(poll);
  std::vector<Flat> flat;
  flat.reserve(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (poll.cancelled()) return fail_stopped(poll);
    const Vec3 from_first = points[i] - points[0];
    flat.push_back({{dot(x, from_first), dot(y, from_first)}, i});
  }
  std::vector<Flat> spare;
  polled_sort(
      flat, 0, flat.size(),
      [](const Flat& a, const Flat& b) {
        if (a.at.x != b.at.x) return a.at.x < b.at.x;
        return a.at.y != b.at.y ? a.at.y < b.at.y : a.place < b.place;
      },
      spare, poll);
  if (poll.stopped()) return fail_stopped(poll);
  std::vector<Flat> hull;
  for (const Flat& point : flat) {
    if (poll.cancelled()) return fail_stopped(poll);
    turn_left_to(point, 1, hull);
  }
  const std::size_t lower = hull.size();
  for (std::size_t i = flat.size() - 1; i-- > 0;) {
    if (poll.cancelled()) return fail_stopped(poll);
    turn_left_to(flat[i], lower, hull);
  }
  if (hull.size() > 1) hull.pop_back();  // the first again
  corners.reserve(hull.size());
  for (const Flat& corner : hull) corners.push_back(corner.place);
  return corners;
}

}  // namespace geodesic
