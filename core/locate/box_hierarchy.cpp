#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/tolerances.h"
#include "core/locate/face_hierarchy.h"
#include "core/locate/ray_box.h"

namespace geodesic {
namespace {

struct ByDistance {
  NearSearch& search;

  [[nodiscard]] double least_in(const Box& box) const {
    const Vec3 q = search.q();
    const Vec3 nearest{std::clamp(q.x, box.min.x, box.max.x), std::clamp(q.y, box.min.y, box.max.y),
                       std::clamp(q.z, box.min.z, box.max.z)};
    return distance(q, nearest);
  }
  [[nodiscard]] bool is_beaten(double least, std::size_t /*first_face*/) const {
    return least > search.radius(tolerance::kBox);
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
    const Vec3 margin{tolerance::kBox, tolerance::kBox, tolerance::kBox};
    const RaySpan span = span_in_box({box.min - margin, box.max + margin}, origin, direction);
    const double begin = std::max(0.0, span.begin);
    return begin <= span.end ? begin : kInfinity;
  }
  [[nodiscard]] bool is_beaten(double least, std::size_t /*first_face*/) const {
    return least == kInfinity || least > search.reach() + tolerance::kBox;
  }
  void consider(std::uint32_t face) { search.consider(face, poll); }
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
