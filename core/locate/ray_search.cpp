#include "core/locate/ray_search.h"

#include <algorithm>
#include <cmath>

#include "core/base/tolerances.h"
#include "core/locate/ray_box.h"

namespace geodesic {
namespace {

// Rays that begin within this need no moving, in the frame's units.
constexpr double kNearEnough = 4;

bool is_flat(const FaceRecord& face) {
  return !(face.area2 > tolerance::kZeroArea * face.length2(face.longest_side()));
}

struct OnFace {
  std::uint32_t face = kNone;
  std::array<double, 3> bary{};
};

// A point of a face without area is one of its sides' too. The nearest place on a
// side that a face with an area has as well; without such a side, nothing.
// `side_with_area(side)`: as RaySearch has it.
template <class SideWithArea>
OnFace beside(const Adjacency& adjacency, std::uint32_t flat, const std::array<double, 3>& bary,
              const SideWithArea& side_with_area) {
  const Mesh& mesh = adjacency.mesh();
  const Vec3 point = position_of(mesh, {flat, bary, kNone});
  OnFace best;
  double best2 = kInfinity;
  for (std::uint32_t c = 0; c < 3; ++c) {
    const Halfedge h = side_with_area(halfedge(flat, c));
    if (h == kNone) continue;
    const FaceRecord& face = adjacency.face(face_of(h));
    const std::uint32_t from = corner_of(h);
    const std::uint32_t to = next_corner(from);
    const Vec3 a = mesh.positions()[face.vertex[from]];
    const Vec3 b = mesh.positions()[face.vertex[to]];
    const double t = std::clamp(dot(point - a, b - a) / face.length2(from), 0.0, 1.0);
    const Vec3 gap = point - ((1 - t) * a + t * b);
    if (dot(gap, gap) >= best2) continue;
    best2 = dot(gap, gap);
    best.face = face_of(h);
    best.bary = {0, 0, 0};
    best.bary[from] = 1 - t;
    best.bary[to] = t;
  }
  return best;
}

}  // namespace

std::optional<RaySearch> RaySearch::begin(const Adjacency& adjacency, const UnitBox& unit,
                                          Vec3 origin, Vec3 direction) {
  const double largest = largest_component(direction);
  direction = {direction.x / largest, direction.y / largest, direction.z / largest};
  // Each step stops short of the box by what it may be off, so the next one, from
  // much nearer, sees better; 1e120 units need nine.
  constexpr int kMostSteps = 32;
  for (int i = 0; i < kMostSteps; ++i) {
    const Vec3 from = unit.inside(origin);
    const double away = largest_component(from);
    const double slack = 16 * std::numeric_limits<double>::epsilon() * away;
    const double half = 1 + slack;
    const RaySpan span = span_in_box({{-half, -half, -half}, {half, half, half}}, from, direction);
    if (span.begin > span.end + slack || span.end < 0) return std::nullopt;
    const double step = span.begin - 1 - slack;
    if (away <= kNearEnough || step <= 0) break;
    origin = origin + (step / unit.scale) * direction;
  }
  return RaySearch(adjacency, unit, origin, direction);
}

Halfedge RaySearch::side_with_area(Halfedge side, Poll& poll) {
  const auto has_area = [&](Halfedge h) { return !is_flat(adjacency_->face(face_of(h))); };
  Halfedge h = adjacency_->ring(side);
  for (std::size_t i = 0; i < Triangulation::kCrowd; ++i) {
    if (h == side) return kNone;
    if (has_area(h)) return h;
    h = adjacency_->ring(h);
  }
  // As many faces without area may be met as there are here: the edge is gone round once for all.
  const auto [low, high] = std::minmax({adjacency_->tail(side), adjacency_->head(side)});
  for (const CrowdedEdge& known : crowded_) {
    if (known.low == low && known.high == high) return known.side;
  }
  CrowdedEdge& known = crowded_[next_crowded_++ % crowded_.size()];
  known = {low, high, kNone};
  h = side;
  do {
    if (poll.cancelled()) return kNone;
    if (has_area(h)) known.side = std::min(known.side, h);
    h = adjacency_->ring(h);
  } while (h != side);
  return known.side;
}

bool RaySearch::consider(std::uint32_t face, Poll& poll) {
  const FaceRecord& record = adjacency_->face(face);
  const auto corner = [&](std::uint32_t c) {
    return unit_->scale * (adjacency_->mesh().positions()[record.vertex[c]] - origin_);
  };
  const auto met = frame_.meet({corner(0), corner(1), corner(2)});
  if (!met || met->t > reach_ || (met->t == reach_ && face > met_)) return false;
  OnFace place{face, met->bary};
  if (is_flat(record)) {
    place = beside(*adjacency_, face, met->bary,
                   [&](Halfedge side) { return side_with_area(side, poll); });
  }
  if (place.face == kNone) return false;
  reach_ = met->t;
  met_ = face;
  face_ = place.face;
  bary_ = place.bary;
  return true;
}

std::optional<SurfacePoint> RaySearch::hit() const {
  if (face_ == kNone) return std::nullopt;
  return snapped_point(*adjacency_, face_, bary_);
}

}  // namespace geodesic
