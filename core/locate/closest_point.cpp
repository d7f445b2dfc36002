// The only file that includes Embree, version 3 or 4.
#include "core/locate/closest_point.h"

#if GEODESIC_EMBREE == 3
#include <embree3/rtcore.h>
#else
#include <embree4/rtcore.h>
#endif

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <new>
#include <utility>

#include "core/locate/closest_on_triangle.h"
#include "core/locate/far_search.h"
#include "core/locate/ray_search.h"

namespace geodesic {
namespace {

using Weights = TriangleWeights;

struct OnTriangle {
  double distance2;
  Weights bary;
};

OnTriangle closest_on_triangle(Vec3 p, const std::array<Vec3, 3>& corner) {
  const Vec3 normal = cross(corner[1] - corner[0], corner[2] - corner[0]);
  if (const auto bary = foot_inside(p, corner, normal)) {
    const double height = dot(normal, p - corner[0]) / norm(normal);
    return {height * height, *bary};
  }
  OnTriangle best{std::numeric_limits<double>::infinity(), {1, 0, 0}};
  for (std::uint32_t c = 0; c < 3; ++c) {
    const Vec3 a = corner[c];
    const Vec3 b = corner[next_corner(c)];
    const double t = foot_on_segment(p, a, b);
    const Vec3 gap = p - ((1 - t) * a + t * b);
    const double distance2 = dot(gap, gap);
    if (distance2 < best.distance2) {
      best = {distance2, {0, 0, 0}};
      best.bary[c] = 1 - t;
      best.bary[next_corner(c)] = t;
    }
  }
  return best;
}

struct Search {
  const Mesh* mesh;
  Vec3 from;
  Poll poll;
  double scale;   // from mesh units to the hierarchy's
  double margin;  // what single precision may be off by, in the hierarchy's units
  double best2 = std::numeric_limits<double>::infinity();
  std::uint32_t face = kNone;
  Weights bary{};

  // True when the face is closer than all before it.
  bool consider(std::uint32_t f) {
    const Triangle& t = mesh->faces()[f];
    const auto positions = mesh->positions();
    const OnTriangle found =
        closest_on_triangle(from, {positions[t[0]], positions[t[1]], positions[t[2]]});
    if (found.distance2 > best2 || (found.distance2 == best2 && f > face)) return false;
    best2 = found.distance2;
    face = f;
    bary = found.bary;
    return true;
  }
};

bool consider_face(RTCPointQueryFunctionArguments* arguments) {
  auto& search = *static_cast<Search*>(arguments->userPtr);
  if (search.poll.cancelled()) {  // there is no other way to end it
    arguments->query->radius = 0;
    return true;
  }
  if (!search.consider(arguments->primID)) return false;
  const auto radius =
      static_cast<float>(std::sqrt(search.best2) * search.scale * 1.00001 + search.margin);
  if (radius >= arguments->query->radius) return false;
  arguments->query->radius = radius;
  return true;  // the radius has shrunk
}

// Embree hands the context of a ray on to the faces: what it leads to comes after it.
#if GEODESIC_EMBREE == 3
using EmbreeContext = RTCIntersectContext;
#else
using EmbreeContext = RTCRayQueryContext;
#endif

struct RayContext : EmbreeContext {
  RaySearch* search = nullptr;
  Poll* poll = nullptr;
};

// What of a ray's way single precision may be off by, in the hierarchy's units.
constexpr double kRayMargin = 1e-5;

void meet_face(const RTCIntersectFunctionNArguments* arguments) {
  if (arguments->valid[0] == 0) return;
  RaySearch& search = *static_cast<RayContext*>(arguments->context)->search;
  float& end = RTCRayN_tfar(RTCRayHitN_RayN(arguments->rayhit, arguments->N), arguments->N, 0);
  if (static_cast<RayContext*>(arguments->context)->poll->cancelled()) {
    end = -std::numeric_limits<float>::infinity();  // ends the search
    return;
  }
  if (!search.consider(arguments->primID)) return;
  end = std::min(end, static_cast<float>(search.reach() + kRayMargin));
}

// Embree asks this while it builds the hierarchy, and leaves off at a false.
bool goes_on(void* user, double done) {
  const Cancel& cancel = *static_cast<const Cancel*>(user);
  cancel.report(std::clamp(done, 0.0, 1.0));
  return !cancel.requested();
}

bool count_memory(void* user, ssize_t bytes, bool /*after*/) {
  static_cast<std::atomic<std::int64_t>*>(user)->fetch_add(bytes);
  return true;
}

}  // namespace

// The mesh moved and scaled into [-1, 1], where single precision is at its best.
// Embree knows of the faces only their boxes.
struct ClosestPointIndex::Scene {
  Scene(const Mesh& of, Poll& poll) : mesh(of), unit(of.box()), far(of, unit, poll) {}
  ~Scene() {
    if (scene != nullptr) rtcReleaseScene(scene);
    if (device != nullptr) rtcReleaseDevice(device);
  }
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  static void bound_face(const RTCBoundsFunctionArguments* arguments) {
    // More than what the rounding of corners, origins and directions adds up to.
    constexpr double kMargin = 4e-6;
    const auto& self = *static_cast<const Scene*>(arguments->geometryUserPtr);
    const Triangle& t = self.mesh.faces()[arguments->primID];
    const Vec3 a = self.unit.inside(self.mesh.positions()[t[0]]);
    const Vec3 b = self.unit.inside(self.mesh.positions()[t[1]]);
    const Vec3 c = self.unit.inside(self.mesh.positions()[t[2]]);
    RTCBounds& bounds = *arguments->bounds_o;
    bounds.lower_x = static_cast<float>(std::min({a.x, b.x, c.x}) - kMargin);
    bounds.lower_y = static_cast<float>(std::min({a.y, b.y, c.y}) - kMargin);
    bounds.lower_z = static_cast<float>(std::min({a.z, b.z, c.z}) - kMargin);
    bounds.upper_x = static_cast<float>(std::max({a.x, b.x, c.x}) + kMargin);
    bounds.upper_y = static_cast<float>(std::max({a.y, b.y, c.y}) + kMargin);
    bounds.upper_z = static_cast<float>(std::max({a.z, b.z, c.z}) + kMargin);
  }

  const Mesh& mesh;
  UnitBox unit;
  FarSearch far;
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::atomic<std::int64_t> memory{0};
  bool is_whole = false;  // not cancelled halfway
};

ClosestPointIndex::ClosestPointIndex(std::shared_ptr<const Adjacency> adjacency)
    : ClosestPointIndex(std::move(adjacency), Cancel()) {}

Result<std::shared_ptr<const ClosestPointIndex>> ClosestPointIndex::build(
    std::shared_ptr<const Adjacency> adjacency, const Cancel& cancel) {
  std::shared_ptr<const ClosestPointIndex> index(
      new ClosestPointIndex(std::move(adjacency), cancel));
  if (!index->scene_->is_whole) {
    return fail_stopped(cancel);
  }
  return index;
}

ClosestPointIndex::ClosestPointIndex(std::shared_ptr<const Adjacency> adjacency,
                                     const Cancel& cancel)
    : adjacency_(std::move(adjacency)) {
  Poll poll(cancel);
  scene_ = std::make_unique<Scene>(adjacency_->mesh(), poll);
  if (poll.stopped()) return;
  // One thread: core has no threads of its own.
  scene_->device = rtcNewDevice("threads=1,set_affinity=0");
  if (scene_->device == nullptr) throw std::bad_alloc();
  rtcSetDeviceMemoryMonitorFunction(scene_->device, count_memory, &scene_->memory);
  scene_->scene = rtcNewScene(scene_->device);
  rtcSetSceneFlags(scene_->scene, RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(scene_->device, RTC_GEOMETRY_TYPE_USER);
  if (geometry == nullptr) throw std::bad_alloc();
  rtcSetGeometryUserPrimitiveCount(geometry, scene_->mesh.face_count());
  rtcSetGeometryUserData(geometry, scene_.get());
  rtcSetGeometryBoundsFunction(geometry, Scene::bound_face, nullptr);
  rtcSetGeometryIntersectFunction(geometry, meet_face);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcSetSceneProgressMonitorFunction(scene_->scene, goes_on, const_cast<Cancel*>(&cancel));
  rtcCommitScene(scene_->scene);
  rtcSetSceneProgressMonitorFunction(scene_->scene, nullptr, nullptr);
  const RTCError error = rtcGetDeviceError(scene_->device);
  scene_->is_whole = error == RTC_ERROR_NONE;
  if (!scene_->is_whole && error != RTC_ERROR_CANCELLED) throw std::bad_alloc();
}

ClosestPointIndex::~ClosestPointIndex() = default;

ClosestPoint ClosestPointIndex::closest(Vec3 from) const { return *closest(from, Cancel()); }

Result<ClosestPoint> ClosestPointIndex::closest(Vec3 from, const Cancel& cancel) const {
  const Vec3 q = scene_->unit.inside(from);
  const double away = std::max({std::abs(q.x), std::abs(q.y), std::abs(q.z)});
  // From farther away, single precision no longer tells from each other faces that differ by a
  // millionth of the mesh's size.
  constexpr double kFar = 4;
  FarSearch::Found found;
  if (away > kFar) {
    found = scene_->far.closest(q, cancel);
  } else {
    Search search{&adjacency_->mesh(), from, Poll(cancel), scene_->unit.scale, 1e-6 * (1 + away)};
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    RTCPointQuery query;
    query.x = static_cast<float>(q.x);
    query.y = static_cast<float>(q.y);
    query.z = static_cast<float>(q.z);
    query.time = 0;
    query.radius = std::numeric_limits<float>::infinity();
    rtcPointQuery(scene_->scene, &query, &context, consider_face, &search);
    if (!search.poll.stopped()) found = {search.face, search.bary};
  }
  if (found.face == kNone) return fail_stopped(cancel);
  const SurfacePoint point = point_on_face(*adjacency_, found.face, found.bary);
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
  RayContext context;
  context.search = &*search;
  context.poll = &poll;
  RTCRayHit ray{};
  const Vec3 from = search->origin();
  const Vec3 ahead = search->direction();
  ray.ray.org_x = static_cast<float>(from.x);
  ray.ray.org_y = static_cast<float>(from.y);
  ray.ray.org_z = static_cast<float>(from.z);
  ray.ray.dir_x = static_cast<float>(ahead.x);
  ray.ray.dir_y = static_cast<float>(ahead.y);
  ray.ray.dir_z = static_cast<float>(ahead.z);
  ray.ray.tfar = std::numeric_limits<float>::infinity();
  ray.ray.mask = ~0U;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
#if GEODESIC_EMBREE == 3
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene_->scene, &context, &ray);
#else
  rtcInitRayQueryContext(&context);
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = &context;
  rtcIntersect1(scene_->scene, &ray, &arguments);
#endif
  if (poll.stopped()) return fail_stopped(cancel);
  const auto point = search->hit();
  if (!point) return std::nullopt;
  return RayHit{*point, distance(origin, position_of(adjacency_->mesh(), *point))};
}

std::size_t ClosestPointIndex::bytes() const {
  return sizeof(*this) + sizeof(Scene) + scene_->far.bytes() +
         static_cast<std::size_t>(std::max<std::int64_t>(scene_->memory.load(), 0));
}

}  // namespace geodesic
