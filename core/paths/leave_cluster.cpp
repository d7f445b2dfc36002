#include "core/paths/leave_cluster.h"

#include <algorithm>
#include <unordered_map>

#include "core/base/tolerances.h"
#include "core/paths/step_in_face.h"

namespace geodesic {
namespace {

struct Came {
  std::uint32_t from = kNone;  // the vertex before
  StepBack step;               // from there
};
using Cluster = std::unordered_map<std::uint32_t, Came>;

StepBack along_side(const FaceRecord& face, std::uint32_t f, std::uint32_t start, std::uint32_t end,
                    double distance) {
  StepBack step;
  step.to = StepBack::To::vertex;
  step.distance = distance;
  step.face = f;
  step.start[start] = 1;
  step.bary[end] = 1;
  step.vertex = face.vertex[end];
  return step;
}

// All vertices of the cluster in breadth-first order, each once.
std::vector<std::uint32_t> gather(const Adjacency& adjacency, const Field& field,
                                  std::uint32_t vertex, Cluster& cluster, Poll& poll) {
  const double longest = tolerance::kPoint * field.distance[vertex];
  std::vector<std::uint32_t> found{vertex};
  cluster.emplace(vertex, Came{});
  for (std::size_t i = 0; i < found.size(); ++i) {
    for (const std::uint32_t corner : adjacency.corners(found[i])) {
      if (poll.cancelled()) return found;
      const FaceRecord& face = adjacency.face(face_of(corner));
      const std::uint32_t c = corner_of(corner);
      for (const std::uint32_t end : {next_corner(c), previous_corner(c)}) {
        const std::uint32_t side = end == next_corner(c) ? c : end;
        if (!(side_length2(adjacency, face_of(corner), side) <= longest * longest)) continue;
        const StepBack step = along_side(face, face_of(corner), c, end, field.distance[found[i]]);
        if (cluster.emplace(step.vertex, Came{found[i], step}).second) {
          found.push_back(step.vertex);
        }
      }
    }
  }
  return found;
}

// Whether a step ends at a vertex of the cluster or between two of them.
bool ends_within(const Adjacency& adjacency, const StepBack& step, const Cluster& cluster) {
  if (step.to == StepBack::To::vertex) return cluster.contains(step.vertex);
  if (step.to != StepBack::To::edge) return false;
  const FaceRecord& face = adjacency.face(face_of(step.base));
  const std::uint32_t c = corner_of(step.base);
  return cluster.contains(face.vertex[c]) && cluster.contains(face.vertex[next_corner(c)]);
}

}  // namespace

std::vector<StepBack> leave_cluster(const Adjacency& adjacency, const Field& field,
                                    const PointArrivals& arrivals, std::uint32_t vertex,
                                    const std::function<bool(std::uint32_t)>& entered,
                                    const std::function<bool(std::uint32_t)>& passed, Poll& poll) {
  Cluster cluster;
  Came best;      // of all ways out
  Came best_new;  // of those through faces not yet entered
  for (const std::uint32_t v : gather(adjacency, field, vertex, cluster, poll)) {
    for (const SurfacePoint& place : in_all_faces(adjacency, point_at_vertex(adjacency, v))) {
      if (poll.cancelled()) return {};
      const StepBack step = arrivals.through_face(place);
      if (step.to == StepBack::To::vertex && passed(step.vertex)) continue;
      if (ends_within(adjacency, step, cluster)) continue;
      if (arrivals.is_better(step, best.step)) best = {v, step};
      if (!entered(place.face) && arrivals.is_better(step, best_new.step)) best_new = {v, step};
    }
  }
  if (best_new.step.distance <= best.step.distance * (1 + tolerance::kSamePath)) best = best_new;
  if (best.step.to == StepBack::To::nowhere) return {};
  std::vector<StepBack> steps{best.step};
  for (std::uint32_t v = best.from; v != vertex; v = cluster.at(v).from) {
    steps.push_back(cluster.at(v).step);
  }
  std::reverse(steps.begin(), steps.end());
  return steps;
}

}  // namespace geodesic
