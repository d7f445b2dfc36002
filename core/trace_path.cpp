#include "core/trace_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/arrive_at_point.h"
#include "core/down_edges.h"

namespace geodesic {
namespace {

// Relative, in distances by different faces.
constexpr double kRounding = 1e-9;

// One straight piece of the path, going back: from `start` to `end` within a face.
struct Leg {
  std::uint32_t face;
  std::array<double, 3> start;
  std::array<double, 3> end;
};

class Tracer {
 public:
  Tracer(const Adjacency& adjacency, const Field& field)
      : adjacency_(adjacency),
        field_(field),
        arrivals_(adjacency, field),
        entered_(adjacency.faces().size(), false) {}

  std::optional<Path> trace(const SurfacePoint& target) {
    StepBack step = first_step(target);
    while (step.to != StepBack::To::nowhere) {
      walk(step);
      switch (step.to) {
        case StepBack::To::source:
          return assemble(step.source);
        case StepBack::To::vertex:
          step = from_vertex(step.vertex);
          break;
        case StepBack::To::edge:
          step = from_edge(step);
          break;
        case StepBack::To::nowhere:
          break;
      }
    }
    return std::nullopt;
  }

 private:
  void walk(const StepBack& step) {
    if (step.face == kNone) return;
    entered_[step.face] = true;
    legs_.push_back({step.face, step.start, step.bary});
  }

  // Step 1 of the paper: a vertex by its parents, an inner point of a face by the
  // shortest of the ways over the face's sides.
  StepBack first_step(const SurfacePoint& target) {
    if (target.at_vertex()) return from_vertex(target.vertex);
    StepBack best;
    for (const SurfacePoint& place : in_all_faces(adjacency_, target)) {
      const StepBack step = arrivals_.through_face(place);
      if (arrivals_.is_better(step, best)) best = step;
    }
    return best;
  }

  // Steps 2 to 4 from a vertex. A front of `fast_marching` may have come to it from
  // beyond the base of an obtuse face, before its neighbours; one of `back_traced` over
  // faces that are not the mesh's.
  StepBack from_vertex(std::uint32_t vertex) {
    const StepBack step = arrivals_.by_parents(vertex);
    const bool blocked = step.to == StepBack::To::edge && !may_enter(step.face);
    if (by_distance_alone() && (blocked || step.to == StepBack::To::nowhere)) {
      std::vector<StepBack> steps = arrivals_.to_lesser_vertex(vertex);
      if (steps.empty()) steps = down_edges(adjacency_, field_, vertex);
      if (steps.empty()) return {};
      for (std::size_t i = 0; i + 1 < steps.size(); ++i) walk(steps[i]);
      return steps.back();
    }
    if (!blocked) return step;
    // Through faces without area a shortest path may come back to a vertex, by no way at all:
    // on through another face, with the same distance.
    if (field_.windows) {
      const StepBack other = through_others(point_at_vertex(adjacency_, vertex));
      if (other.distance <= step.distance * (1 + kRounding)) return other;
    }
    return arrivals_.to_end_of_side(step.face, corner_of(step.base), step.start);
  }

  // Through whichever face not yet entered gives the point the least distance.
  [[nodiscard]] StepBack through_others(const SurfacePoint& here) const {
    StepBack best;
    for (const SurfacePoint& place : in_all_faces(adjacency_, here)) {
      if (!may_enter(place.face)) continue;
      const StepBack step = arrivals_.through_face(place);
      if (arrivals_.is_better(step, best)) best = step;
    }
    return best;
  }

  // Step 3: on across the edge, through whichever face beyond it gives the point
  // the least distance. Step 5, first rule: a source opposite the edge is one of
  // the ways that through_face considers.
  //
  // Approximate distances could send a path round in circles. A shortest path
  // enters no face twice; one that would, and one that ends at a boundary, goes
  // on along the edge to the end that is closer, which was accepted before
  // anything that was computed from it.
  StepBack from_edge(const StepBack& arrived) {
    const StepBack best = through_others({face_of(arrived.base), arrived.bary, kNone});
    if (best.to != StepBack::To::nowhere) return best;
    return arrivals_.to_end_of_side(arrived.face, corner_of(arrived.base), arrived.bary);
  }

  // Approximate distances without a word of where they came from.
  [[nodiscard]] bool by_distance_alone() const {
    return field_.method == Method::fast_marching || field_.method == Method::back_traced;
  }

  // In the graph of `steiner` every step leads to a lesser distance as it is.
  [[nodiscard]] bool may_enter(std::uint32_t face) const {
    return field_.method == Method::steiner || !entered_[face];
  }

  Path assemble(std::uint32_t source) const {
    Path path;
    path.source = source;
    const Mesh& mesh = adjacency_.mesh();
    const auto add = [&](std::uint32_t face, const std::array<double, 3>& bary) {
      const SurfacePoint point = point_on_face(adjacency_, face, bary);
      const Vec3 position = position_of(mesh, point);
      if (!path.points.empty()) {
        PathPoint& last = path.points.back();
        if (last.position == position) {
          // A leg without length: the next one leaves from here.
          last = {point, position};
          return;
        }
        path.length += distance(last.position, position);
      }
      path.points.push_back({point, position});
    };
    for (auto leg = legs_.rbegin(); leg != legs_.rend(); ++leg) {
      // The start of a leg going forward is in that leg's face …
      if (path.points.empty()) {
        add(leg->face, leg->end);
      } else {
        path.points.back().point = point_on_face(adjacency_, leg->face, leg->end);
      }
      // … and its end too, until the next leg says otherwise.
      add(leg->face, leg->start);
    }
    if (path.points.empty()) {
      const SurfacePoint& point = field_.sources[source].point;
      path.points.push_back({point, position_of(mesh, point)});
    }
    return path;
  }

  const Adjacency& adjacency_;
  const Field& field_;
  PointArrivals arrivals_;
  std::vector<Leg> legs_;
  std::vector<bool> entered_;  // by face
};

}  // namespace

std::optional<Path> trace_path(const Adjacency& adjacency, const Field& field,
                               const SurfacePoint& target) {
  if (target.at_vertex() && field.distance[target.vertex] == kUnreached) return std::nullopt;
  return Tracer(adjacency, field).trace(target);
}

}  // namespace geodesic
