// The only file that includes Embree, version 3 or 4.
#include "core/closest_point.h"

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

namespace geodesic {
namespace {

using Weights = std::array<double, 3>;

struct OnTriangle {
  double distance2;
  Weights bary;
};

// Where the foot of the perpendicular falls on the segment a-b, 0 at a, 1 at b.
double foot_on_segment(Vec3 p, Vec3 a, Vec3 b) {
  const Vec3 ab = b - a;
  const double length2 = dot(ab, ab);
  return length2 > 0 ? std::clamp(dot(p - a, ab) / length2, 0.0, 1.0) : 0.0;
}

OnTriangle closest_on_triangle(Vec3 p, const std::array<Vec3, 3>& corner) {
  const Vec3 normal = cross(corner[1] - corner[0], corner[2] - corner[0]);
  const double normal2 = dot(normal, normal);
  if (normal2 > 0) {
    Weights bary;
    for (std::uint32_t c = 0; c < 3; ++c) {
      const Vec3 a = corner[next_corner(c)];
      const Vec3 b = corner[previous_corner(c)];
      bary[c] = dot(normal, cross(b - a, p - a)) / normal2;
    }
    if (bary[0] > 0 && bary[1] > 0 && bary[2] > 0) {
      const double height = dot(normal, p - corner[0]) / std::sqrt(normal2);
      return {height * height, bary};
    }
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
  if (!search.consider(arguments->primID)) return false;
  const auto radius =
      static_cast<float>(std::sqrt(search.best2) * search.scale * 1.00001 + search.margin);
  if (radius >= arguments->query->radius) return false;
  arguments->query->radius = radius;
  return true;  // the radius has shrunk
}

bool count_memory(void* user, ssize_t bytes, bool /*after*/) {
  static_cast<std::atomic<std::int64_t>*>(user)->fetch_add(bytes);
  return true;
}

}  // namespace

// The mesh moved and scaled into [-1, 1], where single precision is at its best.
struct ClosestPointIndex::Scene {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::atomic<std::int64_t> memory{0};
  Vec3 centre;
  double scale = 1;

  ~Scene() {
    if (scene != nullptr) rtcReleaseScene(scene);
    if (device != nullptr) rtcReleaseDevice(device);
  }
};

ClosestPointIndex::ClosestPointIndex(std::shared_ptr<const Adjacency> adjacency)
    : adjacency_(std::move(adjacency)), scene_(std::make_unique<Scene>()) {
  const Mesh& mesh = adjacency_->mesh();
  const Box& box = mesh.box();
  scene_->centre = 0.5 * box.min + 0.5 * box.max;
  const Vec3 half = 0.5 * box.max - 0.5 * box.min;
  scene_->scale = 1 / std::max({half.x, half.y, half.z});

  // One thread: core has no threads of its own.
  scene_->device = rtcNewDevice("threads=1,set_affinity=0");
  if (scene_->device == nullptr) throw std::bad_alloc();
  rtcSetDeviceMemoryMonitorFunction(scene_->device, count_memory, &scene_->memory);
  scene_->scene = rtcNewScene(scene_->device);
  RTCGeometry geometry = rtcNewGeometry(scene_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 3 * sizeof(float),
                                                               mesh.vertex_count()));
  auto* indices = static_cast<std::uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(std::uint32_t), mesh.face_count()));
  if (vertices == nullptr || indices == nullptr) {
    rtcReleaseGeometry(geometry);
    throw std::bad_alloc();
  }
  for (const Vec3 p : mesh.positions()) {
    const Vec3 q = scene_->scale * (p - scene_->centre);
    *vertices++ = static_cast<float>(q.x);
    *vertices++ = static_cast<float>(q.y);
    *vertices++ = static_cast<float>(q.z);
  }
  for (const Triangle& t : mesh.faces()) indices = std::copy(t.begin(), t.end(), indices);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene_->scene);
}

ClosestPointIndex::~ClosestPointIndex() = default;

ClosestPoint ClosestPointIndex::closest(Vec3 from) const {
  const Vec3 q = scene_->scale * (from - scene_->centre);
  const double away = std::max({std::abs(q.x), std::abs(q.y), std::abs(q.z)});
  Search search{&adjacency_->mesh(), from, scene_->scale, 1e-6 * (1 + away)};
  // So far away that single precision tells no face from another, look at all.
  constexpr double kTooFar = 1e5;
  if (away < kTooFar) {
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    RTCPointQuery query;
    query.x = static_cast<float>(q.x);
    query.y = static_cast<float>(q.y);
    query.z = static_cast<float>(q.z);
    query.time = 0;
    query.radius = std::numeric_limits<float>::infinity();
    rtcPointQuery(scene_->scene, &query, &context, consider_face, &search);
  }
  if (search.face == kNone) {
    for (std::uint32_t f = 0; f < search.mesh->face_count(); ++f) search.consider(f);
  }
  const SurfacePoint point = point_on_face(*adjacency_, search.face, search.bary);
  return {point, distance(from, position_of(*search.mesh, point))};
}

std::size_t ClosestPointIndex::bytes() const {
  return sizeof(*this) + sizeof(Scene) +
         static_cast<std::size_t>(std::max<std::int64_t>(scene_->memory.load(), 0));
}

}  // namespace geodesic
