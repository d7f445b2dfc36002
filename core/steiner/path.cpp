#include "core/steiner/path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/paths/trace_path.h"
#include "core/steiner/cheapest_way.h"
#include "core/steiner/steiner.h"
#include "core/steiner/strip_graph.h"

namespace geodesic {
namespace {

// The search takes about so much of the time, refining the rest.
constexpr double kSearch = 0.9;
// Bounds for paths that would creep on for ever. Twenty halvings leave a millionth
// of the first spacing.
constexpr int kMostRounds = 20;
constexpr int kMostPasses = 40;
// A cheap way up what is steep zigzags, the finer the more points there are. So many times as many
// crossings as at first, and some, are enough.
constexpr std::size_t kMostGrowth = 2;
constexpr std::size_t kMostMore = 32;
// The finest spacing is one part in this of an edge.
constexpr std::uint32_t kFinest = 1U << 30U;

bool are_one(const Adjacency& adjacency, const SurfacePoint& a, const SurfacePoint& b) {
  if (a.at_vertex() || b.at_vertex()) return a.vertex == b.vertex;
  const std::vector<SurfacePoint> places = in_all_faces(adjacency, a);
  return std::any_of(places.begin(), places.end(), [&](const SurfacePoint& place) {
    return place.face == b.face && place.bary == b.bary;
  });
}

// The points of a path traced in the unrefined graph, without its ends. Where a face has no area,
// the path may begin or end at another point of it that lies in the same place: from there it goes
// on into faces that the end itself is not in.
std::vector<Crossing> crossings_of(const Adjacency& adjacency, const Path& path,
                                   const SurfacePoint& from, const SurfacePoint& to,
                                   std::uint32_t steps) {
  std::vector<Crossing> crossings;
  for (const PathPoint& passed : path.points) {
    const SurfacePoint& point = passed.point;
    const bool is_first = &passed == &path.points.front();
    const bool is_last = &passed == &path.points.back();
    if (is_first && are_one(adjacency, from, point)) continue;
    if (is_last && are_one(adjacency, to, point)) continue;
    if (point.at_vertex()) {
      crossings.push_back({point.vertex, kNone, 0});
      continue;
    }
    const Halfedge under = edge_under(point);
    if (under == kNone) continue;
    const bool is_low = adjacency.tail(under) < adjacency.head(under);
    const double part = point.bary[is_low ? next_corner(corner_of(under)) : corner_of(under)];
    const auto step = static_cast<std::uint32_t>(std::lround(part * steps));
    crossings.push_back({kNone, least_in_ring(adjacency, under), std::clamp(step, 1U, steps - 1)});
  }
  return crossings;
}

// The places of one point of the path in all the faces it lies in.
std::vector<SurfacePoint> places_of(const Adjacency& adjacency, const Crossing& crossing,
                                    std::uint32_t steps) {
  if (crossing.vertex != kNone) {
    return in_all_faces(adjacency, point_at_vertex(adjacency, crossing.vertex));
  }
  const FaceRecord& face = adjacency.face(face_of(crossing.edge));
  const std::uint32_t c = corner_of(crossing.edge);
  const std::uint32_t n = next_corner(c);
  const bool is_low = face.vertex[c] < face.vertex[n];
  SurfacePoint point{face_of(crossing.edge), {0, 0, 0}, kNone};
  point.bary[is_low ? n : c] = double(crossing.step) / steps;
  point.bary[is_low ? c : n] = double(steps - crossing.step) / steps;
  return in_all_faces(adjacency, point);
}

// The polyline: each of its segments lies in a face that both its ends lie in, the cheapest. Of no
// bounded length where two points one after the other have no face in common.
Path assemble(const Adjacency& adjacency, const SurfacePoint& from, const SurfacePoint& to,
              const std::vector<Crossing>& crossings, std::uint32_t steps, const TravelCost* cost,
              Poll& poll) {
  const Mesh& mesh = adjacency.mesh();
  Path path;
  std::vector<SurfacePoint> here = in_all_faces(adjacency, from);
  path.points.push_back({from, position_of(mesh, from)});
  for (std::size_t i = 0; i <= crossings.size(); ++i) {
    std::vector<SurfacePoint> there = i < crossings.size()
                                          ? places_of(adjacency, crossings[i], steps)
                                          : in_all_faces(adjacency, to);
    std::sort(there.begin(), there.end(),
              [](const SurfacePoint& a, const SurfacePoint& b) { return a.face < b.face; });
    const SurfacePoint* leaves = nullptr;
    SurfacePoint comes;
    for (const SurfacePoint& place : here) {
      if (poll.cancelled()) return path;
      const auto arrives = std::lower_bound(
          there.begin(), there.end(), place,
          [](const SurfacePoint& a, const SurfacePoint& b) { return a.face < b.face; });
      if (arrives == there.end() || arrives->face != place.face) continue;
      if (leaves != nullptr && !(cost->weight(place.face) < cost->weight(leaves->face))) continue;
      leaves = &place;
      comes = *arrives;
      if (cost == nullptr) break;
    }
    if (leaves == nullptr) {
      path.length = kUnreached;
    } else {
      path.points.back().point = *leaves;
      const Vec3 position = position_of(mesh, comes);
      const double leg = distance(path.points.back().position, position);
      path.length += leg;
      // Where source or target lies on one of the points, the leg has no length.
      if (leg > 0) {
        path.points.push_back({comes, position});
      } else {
        path.points.back().point = comes;
      }
    }
    here = std::move(there);
  }
  return path;
}

// Whether a crossing is on an edge or at one of its ends.
bool is_on(const Adjacency& adjacency, const Crossing& crossing, Halfedge edge) {
  if (crossing.vertex == kNone) return crossing.edge == edge;
  return crossing.vertex == adjacency.tail(edge) || crossing.vertex == adjacency.head(edge);
}

// A cheap way often follows an edge. Of the points that it passes there the first and the last are
// enough; with all of them, and the points about them, each round would have several times as many.
void keep_ends_along_edges(const Adjacency& adjacency, std::vector<Crossing>& crossings) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < crossings.size(); ++i) {
    const Crossing crossing = crossings[i];
    const bool is_between = crossing.vertex == kNone && kept > 0 && i + 1 < crossings.size() &&
                            is_on(adjacency, crossings[kept - 1], crossing.edge) &&
                            is_on(adjacency, crossings[i + 1], crossing.edge);
    if (!is_between) crossings[kept++] = crossing;
  }
  crossings.resize(kept);
}

// The rounds of refinement: the same way among points that lie closer and closer, of which there
// are `steps` less one on an edge. `length`: of the way that is given, or its cost. Cut short if
// the poll says to stop.
void refine(const Adjacency& adjacency, const SurfacePoint& from, const SurfacePoint& to,
            double length, double tolerance, const TravelCost* cost,
            std::vector<Crossing>& crossings, std::uint32_t& steps, WavefrontScratch& scratch,
            Poll& poll) {
  std::vector<Crossing> shorter;
  if (cost != nullptr) keep_ends_along_edges(adjacency, crossings);
  const std::size_t most = kMostGrowth * crossings.size() + kMostMore;
  for (int round = 0; round < kMostRounds && steps <= kFinest / 2; ++round) {
    steps *= 2;
    for (Crossing& crossing : crossings) crossing.step *= 2;
    const double before = length;
    for (int pass = 0; pass < kMostPasses; ++pass) {
      if (poll.ask()) return;
      StripGraph graph(adjacency, from, to, crossings, steps, cost, poll);
      const double found =
          poll.stopped() ? kUnreached : graph.shortest(shorter, scratch.heap, poll);
      if (poll.stopped()) return;
      if (!(found < length)) break;
      const double gain = length - found;
      std::swap(crossings, shorter);
      if (cost != nullptr) keep_ends_along_edges(adjacency, crossings);
      length = found;
      if (cost != nullptr && crossings.size() > most) return;
      if (gain < tolerance * length) break;
    }
    if (before - length < tolerance * before) break;
  }
}

Result<std::optional<Path>> cheapest_path(const Adjacency& adjacency, const Field& field,
                                          const Source& from, const SurfacePoint& to,
                                          const MethodOptions& options, const TravelCost& cost,
                                          WavefrontScratch& scratch, const Cancel& cancel) {
  Path path;
  if (are_one(adjacency, from.point, to)) {
    path.points.push_back({from.point, position_of(adjacency.mesh(), from.point)});
    return path;
  }
  Poll poll(cancel);
  const CheapestWays ways(adjacency, field, poll);
  const CheapestWays::LastStep last = ways.last_step_to(to);
  if (poll.stopped()) return fail_stopped(poll);
  if (last.source == kNone) return std::nullopt;
  std::vector<Crossing> crossings = ways.way_of(last);
  std::uint32_t steps = options.points_per_edge + 1;
  refine(adjacency, from.point, to, last.cost, options.tolerance, &cost, crossings, steps, scratch,
         poll);
  if (!poll.stopped()) {
    path = assemble(adjacency, from.point, to, crossings, steps, &cost, poll);
  }
  if (poll.stopped()) return fail_stopped(poll);
  return path;
}

}  // namespace

std::vector<double> segment_costs(const Path& path, const TravelCost& cost) {
  std::vector<double> costs;
  costs.reserve(path.points.size());
  for (std::size_t i = 1; i < path.points.size(); ++i) {
    const PathPoint& from = path.points[i - 1];
    costs.push_back(cost.of_walked(from.point.face, from.position, path.points[i].position));
  }
  return costs;
}

Result<std::optional<Path>> steiner_path(const Adjacency& adjacency, const Source& from,
                                         const SurfacePoint& to, const MethodOptions& options,
                                         WavefrontScratch& scratch, const Cancel& cancel,
                                         const std::shared_ptr<const TravelCost>& cost) {
  if (!(options.tolerance >= 0)) {
    return fail(ErrorCode::value_out_of_range, "a tolerance is a number from zero up", "tolerance");
  }
  // The offset only delays; without it no length is lost to rounding.
  const auto field = steiner_field_towards(adjacency, {from.point, 0}, to, options.points_per_edge,
                                           scratch, cancel.part(0, kSearch), cost);
  if (!field) return fail(field.error());
  if (cost) return cheapest_path(adjacency, *field, from, to, options, *cost, scratch, cancel);
  auto trace = trace_path(adjacency, *field, to, cancel);
  if (!trace) return fail(std::move(trace.error()));
  std::optional<Path>& traced = *trace;
  // What lies in one face is straight already.
  if (!traced || traced->points.size() <= 2) return traced;

  std::uint32_t steps = options.points_per_edge + 1;
  std::vector<Crossing> crossings = crossings_of(adjacency, *traced, from.point, to, steps);
  Poll poll(cancel);
  refine(adjacency, from.point, to, traced->length, options.tolerance, nullptr, crossings, steps,
         scratch, poll);
  if (poll.stopped()) return fail_stopped(poll);
  Path refined = assemble(adjacency, from.point, to, crossings, steps, nullptr, poll);
  if (poll.stopped()) return fail_stopped(poll);
  return refined.length < traced->length ? std::move(refined) : std::move(*traced);
}

}  // namespace geodesic
