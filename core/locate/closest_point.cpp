#include "core/locate/closest_point.h"

#include <utility>

#include "core/locate/face_boxes.h"
#include "core/locate/face_hierarchy.h"
#include "core/locate/far_search.h"
#include "core/locate/near_search.h"
#include "core/locate/ray_search.h"

namespace geodesic {

struct ClosestPointIndex::Scene {
  Scene(const Mesh& mesh, Poll& poll)
      : unit(mesh.box()), boxes(mesh, unit, poll), far(mesh, unit, boxes) {}
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  UnitBox unit;
  FaceBoxes boxes;
  FarSearch far;
  std::unique_ptr<FaceHierarchy> hierarchy;  // null when cancelled halfway
};

ClosestPointIndex::ClosestPointIndex(std::shared_ptr<const Adjacency> adjacency)
    : ClosestPointIndex(std::move(adjacency), Cancel(), Hierarchy::quickest) {}

Result<std::shared_ptr<const ClosestPointIndex>> ClosestPointIndex::build(
    std::shared_ptr<const Adjacency> adjacency, const Cancel& cancel, Hierarchy hierarchy) {
  std::shared_ptr<const ClosestPointIndex> index(
      new ClosestPointIndex(std::move(adjacency), cancel, hierarchy));
  if (!index->scene_->hierarchy) return fail_stopped(cancel);
  return index;
}

ClosestPointIndex::ClosestPointIndex(std::shared_ptr<const Adjacency> adjacency,
                                     const Cancel& cancel, Hierarchy hierarchy)
    : adjacency_(std::move(adjacency)) {
  Poll poll(cancel);
  scene_ = std::make_unique<Scene>(adjacency_->mesh(), poll);
  if (poll.stopped()) return;
  scene_->hierarchy =
      hierarchy == Hierarchy::boxes
          ? box_hierarchy(scene_->boxes)
          : quickest_hierarchy(adjacency_->mesh(), scene_->unit, scene_->boxes, cancel);
}

ClosestPointIndex::~ClosestPointIndex() = default;

ClosestPoint ClosestPointIndex::closest(Vec3 from) const { return *closest(from, Cancel()); }

Result<ClosestPoint> ClosestPointIndex::closest(Vec3 from, const Cancel& cancel) const {
  // From farther away, single precision no longer tells from each other faces that differ by a
  // millionth of the mesh's size.
  constexpr double kFar = 4;
  FarSearch::Found found;
  NearSearch near(adjacency_->mesh(), scene_->unit, from, cancel);
  if (largest_component(near.q()) > kFar) {
    found = scene_->far.closest(near.q(), cancel);
  } else {
    scene_->hierarchy->find_closest(near);
    if (!near.was_cancelled()) found = {near.face(), near.bary()};
  }
  if (found.face == kNone) return fail_stopped(cancel);
  const SurfacePoint point = snapped_point(*adjacency_, found.face, found.bary);
  return ClosestPoint{point, distance(from, position_of(adjacency_->mesh(), point))};
}

std::optional<RayHit> ClosestPointIndex::first_hit(Vec3 origin, Vec3 direction) const {
  return *first_hit(origin, direction, Cancel());
}

Result<std::optional<RayHit>> ClosestPointIndex::first_hit(Vec3 origin, Vec3 direction,
                                                           const Cancel& cancel) const {
  auto search = RaySearch::begin(*adjacency_, scene_->unit, origin, direction);
  if (!search) return std::nullopt;
  Poll poll(cancel);
  scene_->hierarchy->find_first_hit(*search, poll);
  if (poll.stopped()) return fail_stopped(cancel);
  const auto point = search->hit();
  if (!point) return std::nullopt;
  return RayHit{*point, distance(origin, position_of(adjacency_->mesh(), *point))};
}

std::size_t ClosestPointIndex::bytes() const {
  return sizeof(*this) + sizeof(Scene) + scene_->boxes.bytes() + scene_->hierarchy->bytes();
}

}  // namespace geodesic
