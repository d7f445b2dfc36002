// The only file that includes Embree, version 3 or 4.
//
// Embree holds and searches a hierarchy in single precision, with a margin.
#if GEODESIC_EMBREE == 3
#include <embree3/rtcore.h>
#else
#include <embree4/rtcore.h>
#endif

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <new>

#include "core/base/tolerances.h"
#include "core/locate/face_hierarchy.h"

namespace geodesic {
namespace {

// What single precision may misplace a face by, seen from so far away, in the frame.
double margin_from(Vec3 q) { return 1e-6 * (1 + largest_component(q)); }

bool consider_face(RTCPointQueryFunctionArguments* arguments) {
  auto& search = *static_cast<NearSearch*>(arguments->userPtr);
  if (search.is_cancelled()) {  // there is no other way to end it
    arguments->query->radius = 0;
    return true;
  }
  if (!search.consider(arguments->primID)) return false;
  const auto radius = static_cast<float>(search.radius(margin_from(search.q())));
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

void meet_face(const RTCIntersectFunctionNArguments* arguments) {
  if (arguments->valid[0] == 0) return;
  RaySearch& search = *static_cast<RayContext*>(arguments->context)->search;
  Poll& poll = *static_cast<RayContext*>(arguments->context)->poll;
  float& end = RTCRayN_tfar(RTCRayHitN_RayN(arguments->rayhit, arguments->N), arguments->N, 0);
  if (poll.cancelled()) {
    end = -std::numeric_limits<float>::infinity();  // ends the search
    return;
  }
  if (!search.consider(arguments->primID, poll)) return;
  end = std::min(end, static_cast<float>(search.reach() + tolerance::kEmbreeRay));
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

// Embree knows of the faces only their boxes in the frame, where single precision is at its best.
class EmbreeHierarchy : public FaceHierarchy {
 public:
  EmbreeHierarchy(const Mesh& mesh, const UnitBox& unit) : mesh_(mesh), unit_(unit) {}
  ~EmbreeHierarchy() override {
    if (scene_ != nullptr) rtcReleaseScene(scene_);
    if (device_ != nullptr) rtcReleaseDevice(device_);
  }
  EmbreeHierarchy(const EmbreeHierarchy&) = delete;
  EmbreeHierarchy& operator=(const EmbreeHierarchy&) = delete;

  // False when cancelled. Errors: std::bad_alloc.
  bool build(const Cancel& cancel) {
    // One thread: core has no threads of its own.
    device_ = rtcNewDevice("threads=1,set_affinity=0");
    if (device_ == nullptr) throw std::bad_alloc();
    rtcSetDeviceMemoryMonitorFunction(device_, count_memory, &memory_);
    scene_ = rtcNewScene(device_);
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_USER);
    if (geometry == nullptr) throw std::bad_alloc();
    rtcSetGeometryUserPrimitiveCount(geometry, mesh_.face_count());
    rtcSetGeometryUserData(geometry, this);
    rtcSetGeometryBoundsFunction(geometry, bound_face, nullptr);
    rtcSetGeometryIntersectFunction(geometry, meet_face);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcSetSceneProgressMonitorFunction(scene_, goes_on, const_cast<Cancel*>(&cancel));
    rtcCommitScene(scene_);
    rtcSetSceneProgressMonitorFunction(scene_, nullptr, nullptr);
    const RTCError error = rtcGetDeviceError(device_);
    if (error != RTC_ERROR_NONE && error != RTC_ERROR_CANCELLED) throw std::bad_alloc();
    return error == RTC_ERROR_NONE;
  }

  void find_closest(NearSearch& search) const override {
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    const Vec3 q = search.q();
    RTCPointQuery query;
    query.x = static_cast<float>(q.x);
    query.y = static_cast<float>(q.y);
    query.z = static_cast<float>(q.z);
    query.time = 0;
    query.radius = std::numeric_limits<float>::infinity();
    rtcPointQuery(scene_, &query, &context, consider_face, &search);
  }

  void find_first_hit(RaySearch& search, Poll& poll) const override {
    RayContext context;
    context.search = &search;
    context.poll = &poll;
    RTCRayHit ray{};
    const Vec3 from = search.origin();
    const Vec3 ahead = search.direction();
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
    rtcIntersect1(scene_, &context, &ray);
#else
    rtcInitRayQueryContext(&context);
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.context = &context;
    rtcIntersect1(scene_, &ray, &arguments);
#endif
  }

  [[nodiscard]] std::size_t bytes() const override {
    return sizeof(*this) + static_cast<std::size_t>(std::max<std::int64_t>(memory_.load(), 0));
  }

 private:
  static void bound_face(const RTCBoundsFunctionArguments* arguments) {
    const auto& self = *static_cast<const EmbreeHierarchy*>(arguments->geometryUserPtr);
    const Triangle& t = self.mesh_.faces()[arguments->primID];
    const Vec3 a = self.unit_.inside(self.mesh_.positions()[t[0]]);
    const Vec3 b = self.unit_.inside(self.mesh_.positions()[t[1]]);
    const Vec3 c = self.unit_.inside(self.mesh_.positions()[t[2]]);
    RTCBounds& bounds = *arguments->bounds_o;
    bounds.lower_x = static_cast<float>(std::min({a.x, b.x, c.x}) - tolerance::kEmbreeBox);
    bounds.lower_y = static_cast<float>(std::min({a.y, b.y, c.y}) - tolerance::kEmbreeBox);
    bounds.lower_z = static_cast<float>(std::min({a.z, b.z, c.z}) - tolerance::kEmbreeBox);
    bounds.upper_x = static_cast<float>(std::max({a.x, b.x, c.x}) + tolerance::kEmbreeBox);
    bounds.upper_y = static_cast<float>(std::max({a.y, b.y, c.y}) + tolerance::kEmbreeBox);
    bounds.upper_z = static_cast<float>(std::max({a.z, b.z, c.z}) + tolerance::kEmbreeBox);
  }

  const Mesh& mesh_;
  const UnitBox& unit_;
  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
  std::atomic<std::int64_t> memory_{0};
};

}  // namespace

std::unique_ptr<FaceHierarchy> quickest_hierarchy(const Mesh& mesh, const UnitBox& unit,
                                                  const FaceBoxes& /*boxes*/,
                                                  const Cancel& cancel) {
  auto hierarchy = std::make_unique<EmbreeHierarchy>(mesh, unit);
  if (!hierarchy->build(cancel)) return nullptr;
  return hierarchy;
}

}  // namespace geodesic
