#include "core/surface/line_gaps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "core/base/tolerances.h"
#include "core/surface/unfold_rounding.h"

namespace geodesic {
namespace {

// Of a face, a place and a step, with their places in the lists.
constexpr std::uint64_t kBytesOfStep = 200;

// Of the faces that a path's point is in. A place of a surface has few; in a heap of faces without
// width no more are looked for.
constexpr std::uint32_t kMostFaces = 4096;

// Of the largest coordinate: what a place computed from weights may be off the line that it is on.
constexpr double kPlace = 16 * std::numeric_limits<double>::epsilon();

double farthest_coordinate(const Box& box) {
  double farthest = 0;
  for (const Vec3 corner : {box.min, box.max}) {
    farthest = std::max({farthest, std::abs(corner.x), std::abs(corner.y), std::abs(corner.z)});
  }
  return farthest;
}

bool is_without_width(const Adjacency& adjacency, std::uint32_t face) {
  return is_lower_than(tolerance::kAtEnd, adjacency.face(face));
}

// The faces that have a point, then those that have a place of these where the point is, and so on.
class FacesAt {
 public:
  FacesAt(const Adjacency& adjacency, const SurfacePoint& point, Gaps gaps, std::uint32_t most,
          Poll& poll)
      : adjacency_(adjacency),
        position_(position_of(adjacency.mesh(), point)),
        gaps_(gaps),
        most_(most),
        rounding_(kPlace * farthest_coordinate(adjacency.mesh().box())),
        poll_(poll) {
    reach(point, kNone);
  }

  // Finds the next faces; false if there are none.
  bool go_on() {
    if (next_ == steps_.size() || steps_.size() >= most_ || poll_.stopped()) return false;
    const std::uint32_t step = next_++;
    // A path may go round a vertex by either side, so rounding must not lead it to the other one.
    if (gaps_ != Gaps::at_vertices && !is_without_width(adjacency_, steps_[step].face)) return true;
    for (std::uint32_t side = 0; side < 3; ++side) {
      const SurfacePoint closest = closest_on_side(steps_[step].face, side);
      if (distance(position_of(adjacency_.mesh(), closest), position_) <= width_of(step)) {
        reach(closest, step);
      }
    }
    return true;
  }

  // How many faces are found. They have numbers in the order in which they were.
  [[nodiscard]] std::uint32_t count() const { return static_cast<std::uint32_t>(steps_.size()); }
  [[nodiscard]] std::uint32_t face(std::uint32_t step) const { return steps_[step].face; }
  [[nodiscard]] const SurfacePoint& there(std::uint32_t step) const { return steps_[step].place; }
  // The face's number, or kNone.
  [[nodiscard]] std::uint32_t step_of(std::uint32_t face) const {
    const auto found = step_of_face_.find(face);
    return found == step_of_face_.end() ? kNone : found->second;
  }

  // The places from the face of a step back to the point, without the point.
  [[nodiscard]] std::vector<SurfacePoint> back_from(std::uint32_t step) const {
    std::vector<SurfacePoint> places;
    for (; steps_[step].before != kNone; step = steps_[step].before) {
      places.push_back(steps_[step].place);
    }
    return places;
  }

 private:
  struct Step {
    std::uint32_t face;
    SurfacePoint place;    // in this face, and in that of the step before
    std::uint32_t before;  // kNone at the point itself
  };

  // Each vertex and each edge is gone over once, however many faces it has.
  void reach(const SurfacePoint& place, std::uint32_t before) {
    if (!gone_over_.insert(key_of(place)).second) return;
    for (const SurfacePoint& there : in_all_faces(adjacency_, place)) {
      if (poll_.cancelled() || !poll_.may_take(kBytesOfStep)) return;
      const auto number = static_cast<std::uint32_t>(steps_.size());
      if (step_of_face_.emplace(there.face, number).second) {
        steps_.push_back({there.face, there, before});
      }
    }
  }

  [[nodiscard]] std::pair<std::uint32_t, std::uint32_t> key_of(const SurfacePoint& place) const {
    if (place.at_vertex()) return {place.vertex, place.vertex};
    const Halfedge under = edge_under(place);
    if (under == kNone) return {kNone, place.face};
    const auto& corners = adjacency_.face(place.face).vertex;
    const std::uint32_t c = corner_of(under);
    return std::minmax({corners[c], corners[next_corner(c)]});
  }

  [[nodiscard]] SurfacePoint closest_on_side(std::uint32_t face, std::uint32_t side) const {
    const auto& corners = adjacency_.face(face).vertex;
    const auto positions = adjacency_.mesh().positions();
    double t =
        foot_on_segment(position_, positions[corners[side]], positions[corners[next_corner(side)]]);
    if (gaps_ == Gaps::beside_vertices) {
      t = std::clamp(t, tolerance::kAtEnd, 1 - tolerance::kAtEnd);
    } else if (gaps_ == Gaps::at_vertices && t < tolerance::kAtEnd) {
      t = 0;
    } else if (gaps_ == Gaps::at_vertices && t > 1 - tolerance::kAtEnd) {
      t = 1;
    }
    std::array<double, 3> bary{0, 0, 0};
    bary[side] = 1 - t;
    bary[next_corner(side)] = t;
    return point_on_face(adjacency_, face, bary);
  }

  // What is no distance in the face of a step.
  [[nodiscard]] double width_of(std::uint32_t step) const {
    if (gaps_ == Gaps::anywhere) return rounding_;
    const double beside = gaps_ == Gaps::beside_vertices ? tolerance::kAtEnd : 0;
    return (tolerance::kAtEnd + beside) * std::sqrt(adjacency_.face(steps_[step].face).longest2());
  }

  const Adjacency& adjacency_;
  Vec3 position_;
  Gaps gaps_;
  std::uint32_t most_;
  double rounding_;
  Poll& poll_;
  std::vector<Step> steps_;
  std::uint32_t next_ = 0;
  std::map<std::uint32_t, std::uint32_t> step_of_face_;
  std::set<std::pair<std::uint32_t, std::uint32_t>> gone_over_;
};

// The points that a line has left out between two of it; none if there are none.
std::vector<SurfacePoint> places_left_out(const Adjacency& adjacency, const SurfacePoint& a,
                                          const SurfacePoint& b, Gaps gaps, Poll& poll) {
  const std::uint32_t most = gaps == Gaps::beside_vertices ? kMostFaces : kNone;
  FacesAt from(adjacency, a, gaps, most, poll);
  while (from.go_on()) {
  }
  FacesAt to(adjacency, b, gaps, most, poll);
  std::uint32_t step = 0;
  do {
    for (; step < to.count(); ++step) {
      const std::uint32_t met = from.step_of(to.face(step));
      if (met == kNone) continue;
      std::vector<SurfacePoint> places = from.back_from(met);
      std::reverse(places.begin(), places.end());
      const std::vector<SurfacePoint> rest = to.back_from(step);
      places.insert(places.end(), rest.begin(), rest.end());
      return places;
    }
  } while (to.go_on());
  return {};
}

}  // namespace

std::vector<SurfacePoint> in_all_faces_at(const Adjacency& adjacency, const SurfacePoint& point,
                                          Poll& poll) {
  std::vector<SurfacePoint> places = in_all_faces(adjacency, point);
  if (point.at_vertex() || !adjacency.triangulation().has_flat_faces ||
      std::none_of(places.begin(), places.end(), [&](const SurfacePoint& place) {
        return is_without_width(adjacency, place.face);
      })) {
    return places;
  }
  FacesAt at(adjacency, point, Gaps::anywhere, kMostFaces, poll);
  while (at.go_on()) {
  }
  for (auto step = static_cast<std::uint32_t>(places.size()); step < at.count(); ++step) {
    places.push_back(at.there(step));
  }
  return places;
}

std::uint32_t face_in_common(const Adjacency& adjacency, const SurfacePoint& a,
                             const SurfacePoint& b, Poll& poll) {
  for (const std::uint32_t face : {a.face, b.face}) {
    if (face != kNone && seen_from_face(adjacency, a, face) && seen_from_face(adjacency, b, face)) {
      return face;
    }
  }
  for (const SurfacePoint& there : in_all_faces(adjacency, a)) {
    if (poll.cancelled()) return kNone;
    if (seen_from_face(adjacency, b, there.face)) return there.face;
  }
  return kNone;
}

std::vector<SurfacePoint> close_gaps(const Adjacency& adjacency,
                                     const std::vector<SurfacePoint>& line, Gaps gaps, Poll& poll) {
  std::vector<SurfacePoint> whole;
  if (!poll.may_take(line.size() * sizeof(SurfacePoint))) return whole;
  whole.reserve(line.size());
  for (const SurfacePoint& point : line) {
    if (poll.cancelled()) break;
    if (!whole.empty() && face_in_common(adjacency, whole.back(), point, poll) == kNone) {
      const std::vector<SurfacePoint> left_out =
          places_left_out(adjacency, whole.back(), point, gaps, poll);
      if (!poll.may_take(2 * left_out.size() * sizeof(SurfacePoint))) break;
      whole.insert(whole.end(), left_out.begin(), left_out.end());
    }
    whole.push_back(point);
  }
  return whole;
}

}  // namespace geodesic
