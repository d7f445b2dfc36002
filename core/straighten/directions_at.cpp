#include "core/straighten/directions_at.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/straighten/flat_face.h"
#include "core/straighten/vertex_fan.h"

namespace geodesic {
namespace {

constexpr double kAllRound = 2 * std::numbers::pi;

Result<void> no_fan() {
  return fail(
      ErrorCode::value_out_of_range,
      "the faces at the point do not lie side by side round it, so directions have no angle",
      "from");
}

double in_turn(double angle, double total) {
  if (!(total > 0)) return 0;  // of faces that are lines
  angle = std::fmod(angle, total);
  if (angle < 0) angle += total;
  return angle < total ? angle : 0;
}

}  // namespace

Result<DirectionsAt> DirectionsAt::of(const Adjacency& adjacency, const SurfacePoint& from,
                                      const Cancel& cancel) {
  if (from.face == kNone) {
    return fail(ErrorCode::value_out_of_range, "the point is at a vertex of no face", "from");
  }
  DirectionsAt directions(adjacency, from);
  Result<void> made;
  if (from.at_vertex()) {
    Poll poll(cancel);
    made = directions.turn_round_vertex(poll);
    if (poll.stopped()) return fail_stopped(poll);
  } else {
    directions.total_ = kAllRound;
    const Halfedge under = edge_under(from);
    if (under != kNone) made = directions.look_across_edge(corner_of(under));
  }
  if (!made) return fail(std::move(made.error()));
  return directions;
}

Result<void> DirectionsAt::look_across_edge(std::uint32_t side) {
  across_ = side;
  const Halfedge out = halfedge(from_.face, side);
  const Halfedge in = adjacency_->ring(out);
  if (in == out) {
    all_round_ = false;
    total_ = std::numbers::pi;
  }
  return adjacency_->ring(in) == out ? Result<void>() : no_fan();
}

Result<void> DirectionsAt::turn_round_vertex(Poll& poll) {
  const auto corners = adjacency_->corners(from_.vertex);
  if (!poll.may_take(corners.size() * sizeof(Sector))) return {};
  sectors_.reserve(corners.size());
  if (auto turned = turn(corners.front(), false, poll); !turned) return turned;
  if (!all_round_) {
    const Halfedge across = adjacency_->ring(corners.front());
    if (adjacency_->ring(across) != corners.front()) return no_fan();
    if (across != corners.front()) {
      if (auto turned = turn(across, true, poll); !turned) return turned;
    }
  }
  if (poll.stopped()) return {};
  if (sectors_.size() != corners.size()) return no_fan();  // there is another fan
  for (const Sector& sector : sectors_) total_ += sector.size;
  std::sort(sectors_.begin(), sectors_.end(),
            [](const Sector& a, const Sector& b) { return a.face < b.face; });
  return {};
}

Result<void> DirectionsAt::turn(Halfedge side, bool is_backward, Poll& poll) {
  const std::uint32_t vertex = from_.vertex;
  const Halfedge first = side;
  double turned = 0;
  do {
    if (poll.cancelled()) return {};
    const std::uint32_t f = face_of(side);
    const std::uint32_t c = corner_at(*adjacency_, f, vertex);
    const double size = corner_angle(adjacency_->face(f), c);
    sectors_.push_back({f, c, turned, size, side == halfedge(f, c), is_backward});
    turned += size;
    const Halfedge other = other_side_at(*adjacency_, side, vertex);
    side = adjacency_->ring(other);
    if (adjacency_->ring(side) != other) return no_fan();
    if (side == other) {
      all_round_ = false;
      return {};
    }
  } while (side != first);
  return {};
}

double DirectionsAt::scale() const {
  constexpr double kHardlyAny = 1e-9;  // of faces that are lines
  const bool fills_a_turn = (all_round_ && total_ > kHardlyAny) || total_ > kAllRound;
  return fills_a_turn ? kAllRound / total_ : 1;
}

const DirectionsAt::Sector* DirectionsAt::sector_of(std::uint32_t face) const {
  const auto sector = std::lower_bound(sectors_.begin(), sectors_.end(), face,
                                       [](const Sector& s, std::uint32_t f) { return s.face < f; });
  return sector == sectors_.end() || sector->face != face ? nullptr : &*sector;
}

Halfedge DirectionsAt::beyond_edge(std::uint32_t face) const {
  if (across_ == kNone) return kNone;
  const Halfedge beyond = adjacency_->ring(halfedge(from_.face, across_));
  return face_of(beyond) == face ? beyond : kNone;
}

std::optional<int> DirectionsAt::sense_of(std::uint32_t face) const {
  if (from_.at_vertex()) {
    const Sector* const sector = sector_of(face);
    if (sector == nullptr) return std::nullopt;
    return sector->from_next == (all_round_ || !sector->is_backward) ? 1 : -1;
  }
  if (face == from_.face) return 1;
  const Halfedge beyond = beyond_edge(face);
  if (beyond == kNone) return std::nullopt;
  // Faces that are wound alike go along their edge in opposite ways.
  return adjacency_->tail(beyond) == adjacency_->head(halfedge(from_.face, across_)) ? 1 : -1;
}

std::optional<double> DirectionsAt::angle_of(std::uint32_t face, Vec3 direction) const {
  const Mesh& mesh = adjacency_->mesh();
  if (from_.at_vertex()) {
    const Sector* const sector = sector_of(face);
    if (sector == nullptr) return std::nullopt;
    const auto [along, inward] = FlatFace(mesh, halfedge(face, sector->corner)).axes(*adjacency_);
    double to_next = std::atan2(dot(direction, inward), dot(direction, along));
    if (!all_round_) to_next = std::clamp(to_next, 0.0, sector->size);  // as rounded
    const double angle = sector->begin + (sector->from_next ? to_next : sector->size - to_next);
    if (!all_round_) return sector->is_backward ? -angle : angle;
    return in_turn(angle, total_);
  }
  if (face == from_.face) {
    const auto [along, inward] = FlatFace(mesh, halfedge(face, 0)).axes(*adjacency_);
    const double angle = std::atan2(dot(direction, inward), dot(direction, along));
    return all_round_ ? in_turn(angle, total_) : angle;
  }
  const Halfedge beyond = beyond_edge(face);
  if (beyond == kNone) return std::nullopt;
  // In the face beyond the edge, laid into the plane of the point's own.
  const FlatFace flat(mesh, halfedge(from_.face, 0));
  const Vec3 edge = FlatFace(mesh, halfedge(from_.face, across_)).axes(*adjacency_).first;
  const Vec3 outward = FlatFace(mesh, beyond).axes(*adjacency_).second;
  const Vec2 side = flat.edges[across_];
  const double away = std::atan2(dot(direction, outward), dot(direction, edge));
  return in_turn(std::atan2(side.y, side.x) - away, kAllRound);
}

}  // namespace geodesic
