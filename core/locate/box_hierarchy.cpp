#include <algorithm>
#include <cmath>
#include <limits>

#include "core/locate/face_hierarchy.h"

namespace geodesic {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// What rounding adds up to in the frame, where the mesh and the point are not larger than some 10.
constexpr double kMargin = 1e-12;

struct ByDistance {
  NearSearch& search;

  [[nodiscard]] double least_in(const Box& box) const {
    const Vec3 q = search.q();
    const Vec3 nearest{std::clamp(q.x, box.min.x, box.max.x), std::clamp(q.y, box.min.y, box.max.y),
                       std::clamp(q.z, box.min.z, box.max.z)};
    return distance(q, nearest);
  }
  [[nodiscard]] bool is_beaten(double least, std::size_t /*first_face*/) const {
    return least > search.radius(kMargin);
  }
  void consider(std::uint32_t face) { search.consider(face); }
  [[nodiscard]] bool is_cancelled() { return search.is_cancelled(); }
};

// By how far along the ray a box begins.
struct AlongRay {
  RaySearch& search;
  Poll& poll;
  Vec3 origin = search.origin();
  Vec3 direction = search.direction();

  [[nodiscard]] double least_in(const Box& box) const {
    const double from[] = {origin.x, origin.y, origin.z};
    const double ahead[] = {direction.x, direction.y, direction.z};
    const double low[] = {box.min.x, box.min.y, box.min.z};
    const double high[] = {box.max.x, box.max.y, box.max.z};
    double begin = 0;
    double end = kInfinity;
    for (int axis = 0; axis < 3; ++axis) {
      const double a = low[axis] - kMargin - from[axis];
      const double b = high[axis] + kMargin - from[axis];
      if (ahead[axis] == 0) {
        if (a > 0 || b < 0) return kInfinity;
        continue;
      }
      begin = std::max(begin, std::min(a / ahead[axis], b / ahead[axis]));
      end = std::min(end, std::max(a / ahead[axis], b / ahead[axis]));
    }
    return begin <= end ? begin : kInfinity;
  }
  [[nodiscard]] bool is_beaten(double least, std::size_t /*first_face*/) const {
    return least == kInfinity || least > search.reach() + kMargin;
  }
  void consider(std::uint32_t face) { search.consider(face); }
  [[nodiscard]] bool is_cancelled() { return poll.cancelled(); }
};

class BoxHierarchy : public FaceHierarchy {
 public:
  explicit BoxHierarchy(const FaceBoxes& boxes) : boxes_(boxes) {}

  void find_closest(NearSearch& search) const override {
    ByDistance by_distance{search};
    boxes_.visit(by_distance);
  }
  void find_first_hit(RaySearch& search, Poll& poll) const override {
    AlongRay along_ray{search, poll};
    boxes_.visit(along_ray);
  }
  [[nodiscard]] std::size_t bytes() const override { return sizeof(*this); }

 private:
  const FaceBoxes& boxes_;
};

}  // namespace

std::unique_ptr<FaceHierarchy> box_hierarchy(const FaceBoxes& boxes) {
  return std::make_unique<BoxHierarchy>(boxes);
}

}  // namespace geodesic
