#include "core/solve/pair_search.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/base/tolerances.h"
#include "core/field/around_points.h"
#include "core/field/longest_edge.h"
#include "core/paths/arrive_at_point.h"
#include "core/paths/edge_path.h"
#include "core/solve/distance_at_point.h"
#include "core/solve/exact_pair.h"
#include "core/solve/scratch_parts.h"
#include "core/solve/surface_patch.h"
#include "core/straighten/refine_path.h"
#include "core/straighten/shorten_path.h"

namespace geodesic {
namespace {

// A margin of so many mean edges and such a part of the path, beyond which hardly anything
// has a say. Traces of `auto` need less of it: with 10 edges none of 3,000 pairs on scans
// differs from the whole field; of `wavefront`, with 13 edges 1 in 200 does, in the last bits.
constexpr double margin_edges(Method method) { return method == Method::back_traced ? 11 : 16; }
constexpr double kMarginPart = 0.01;

// A path along edges is usually longer than the shortest by about as much. What is
// found within a length so much smaller, and half the margin, is the shortest, too; else it
// was too little.
constexpr double kAlongEdges = 1.13;

// The part of the time that the path along edges takes.
constexpr double kPathAlongEdges = 0.1;

bool is_exact(Method method) { return method == Method::exact || method == Method::chen_han; }

// The vertices that decide the distance of a point, and the first step of the path to it.
std::vector<std::uint32_t> vertices_about(const Adjacency& adjacency, const SurfacePoint& point) {
  std::vector<std::uint32_t> vertices;
  if (point.at_vertex()) vertices.push_back(point.vertex);
  for (const SurfacePoint& place : in_all_faces(adjacency, point)) {
    for (const std::uint32_t v : adjacency.face(place.face).vertex) vertices.push_back(v);
  }
  return vertices;
}

// Beyond this part of the vertices, a search costs as much as the whole surface. (Fronts see
// less than the straight lines say: at half of them the search is still well worth it.)
constexpr double kMostOfTheSurface = 0.9;

// About how many vertices a way of that length may lead by, from a sample of them: their
// order follows a curve through space, so one in so many is anywhere.
double vertices_within(const Mesh& mesh, Vec3 from, Vec3 to, double longest) {
  constexpr std::uint32_t kSample = 1000;
  const std::uint32_t step = mesh.vertex_count() / kSample + 1;
  std::uint32_t within = 0;
  for (std::uint32_t v = 0; v < mesh.vertex_count(); v += step) {
    const Vec3 place = mesh.positions()[v];
    if (distance(from, place) + distance(place, to) <= longest) ++within;
  }
  return static_cast<double>(within) * step;
}

// Whether that is most of the surface.
bool is_most_within(const Mesh& mesh, Vec3 from, Vec3 to, double longest) {
  return vertices_within(mesh, from, to, longest) > kMostOfTheSurface * mesh.vertex_count();
}

class PairSearch {
 public:
  PairSearch(Method method, const MethodOptions& options, SolveScratch& scratch,
             const Cancel& cancel, PairPath path)
      : method_(method), options_(options), scratch_(scratch), cancel_(cancel), path_(path) {}

  // By a field that stops at the target, and goes on only where the way to it is no
  // longer than `longest`.
  Result<Pair> by_field(const Adjacency& adjacency, const Source& from, const SurfacePoint& to,
                        double longest) {
    const std::vector<std::uint32_t> targets = vertices_about(adjacency, to);
    const auto faces = faces_around(adjacency, {&to, 1}, cancel_);
    if (!faces) return fail(faces.error());
    FieldLimits limits;
    limits.beyond_targets = longest_edge_of(adjacency, *faces);
    // A path needs windows all the way.
    if (!with_path()) limits.detail_faces = *faces;
    // A path that goes by approximate distances looks at what is farther than the target; and
    // inside a face the default's distance may be the length of such a path.
    const bool may_follow_path = with_path() || (method_ == Method::back_traced && !to.at_vertex());
    if (is_exact(method_) || !(may_follow_path || longest < kUnreached)) limits.targets = targets;
    limits.keep_details = with_path() || !to.at_vertex();
    limits.may_keep_refined = true;
    const std::span<const Vec3> positions = adjacency.mesh().positions();
    const Vec3 goal = position_of(adjacency.mesh(), to);
    double about = 0;  // those round the target are to be reached as well
    for (const std::uint32_t v : targets) about = std::max(about, distance(positions[v], goal));
    limits.detour = {goal, longest + 2 * about};
    const auto field =
        solve_field(method_, options_, adjacency, {&from, 1}, limits, scratch_, cancel_);
    if (!field) return fail(field.error());
    Pair pair;
    if (with_path()) {
      auto path = path_through(adjacency, *field, to,
                               refines() ? PathWork::refined : PathWork::traced, cancel_);
      if (!path) return fail(std::move(path.error()));
      pair.path = std::move(*path);
    }
    Poll poll(cancel_);
    const PointArrivals arrivals(adjacency, *field, &poll);
    const Result<double> at_target =
        refines() ? distance_at_point(adjacency, *field, arrivals, to, pair.path, cancel_)
                  : distance_at_point(adjacency, *field, arrivals, to, cancel_);
    if (!at_target) return fail(at_target.error());
    if (poll.stopped()) return fail_stopped(poll);
    pair.distance = *at_target;
    return pair;
  }

  // The pair with its path made shortest, if that is asked for.
  Result<Pair> straightened(const Adjacency& adjacency, Result<Pair> pair) {
    if (!pair || !pair->path || path_ != PairPath::refined) return pair;
    auto shorter = shorten_path(adjacency, *pair->path, cancel_);
    if (!shorter) return fail(shorter.error());
    pair->path = std::move(*shorter);
    return pair;
  }

  // In the part of the surface that the path must be in.
  Result<Pair> in_patch(const Adjacency& adjacency, const Source& from, const SurfacePoint& to,
                        const Path& guess) {
    // From a vertex to itself. It may be in no face, and then in no part of the surface.
    if (guess.points.size() == 1) {
      return Pair{from.offset, with_path() ? std::optional(guess) : std::nullopt};
    }
    const auto shorter = shorten_path(adjacency, guess, cancel_);
    if (!shorter) return fail(shorter.error());
    const double longest = (1 + tolerance::kSamePath) * shorter->length;
    const Vec3 start = guess.points.front().position;
    const Vec3 goal = guess.points.back().position;
    if (method_ == Method::exact &&
        vertices_within(adjacency.mesh(), start, goal, longest) > kManyForWindows) {
      return exact_pair(adjacency, from, to, with_path(), scratch_.parts().exact, cancel_);
    }
    if (is_most_within(adjacency.mesh(), start, goal, longest)) {
      return by_field(adjacency, from, to, kUnreached);
    }
    const auto patch = SurfacePatch::cut(adjacency, from.point, to, longest, cancel_);
    if (!patch) return fail(patch.error());
    if (patch->is_whole()) return by_field(adjacency, from, to, kUnreached);
    const std::optional<SurfacePoint> source = patch->inside(from.point);
    const std::optional<SurfacePoint> target = patch->inside(to);
    // Rounding may put a point so far out of its face that the face is not near enough.
    if (!source || !target) return by_field(adjacency, from, to, kUnreached);
    auto pair = by_field(patch->adjacency(), {*source, from.offset}, *target, kUnreached);
    if (pair && pair->path) patch->bring_back(*pair->path);
    return pair;
  }

  // Within wider and wider margins, until the result is well inside.
  Result<Pair> in_margins(const Adjacency& adjacency, const Source& from, const SurfacePoint& to,
                          double guess) {
    const Vec3 start = position_of(adjacency.mesh(), from.point);
    const Vec3 goal = position_of(adjacency.mesh(), to);
    double margin = kMarginPart * guess + margin_edges(method_) * adjacency.report().mean_edge;
    double longest = guess / kAlongEdges;
    bool is_way = false;  // whether `longest` is the length of a way
    // The margin doubles until what is within is most of the surface.
    while (!is_most_within(adjacency.mesh(), start, goal, longest + margin)) {
      // A field may be too small to ask on its own.
      if (cancel_.requested()) return fail_stopped(cancel_);
      auto pair = by_field(adjacency, from, to, longest + margin);
      if (!pair || pair->distance - from.offset <= longest + margin / 2) return pair;
      if (is_way) margin *= 2;
      is_way = true;
      longest = std::min(guess, pair->distance - from.offset);
    }
    return by_field(adjacency, from, to, kUnreached);
  }

 private:
  [[nodiscard]] bool with_path() const { return path_ != PairPath::none; }
  // By an exact method the traced path is on the right side of everything.
  [[nodiscard]] bool refines() const { return path_ == PairPath::refined && !is_exact(method_); }

  Method method_;
  const MethodOptions& options_;
  SolveScratch& scratch_;
  const Cancel& cancel_;
  PairPath path_;
};

}  // namespace

bool searches_pairs(Method method) {
  return method != Method::fast_marching && method != Method::steiner;
}

Result<Pair> pair_search(Method method, const MethodOptions& options, const Adjacency& adjacency,
                         const Source& from, const SurfacePoint& to, PairPath path,
                         SolveScratch& scratch, const Cancel& cancel) {
  PairSearch search(method, options, scratch, cancel, path);
  // Windows go no farther than the target by themselves, and take no notice of a detour.
  const bool by_windows =
      !is_exact(method) && goes_by_windows(method, options, adjacency, {&from, 1});
  if (!searches_pairs(method) || by_windows) {
    return search.by_field(adjacency, from, to, kUnreached);
  }
  // A part of the surface that is cut out has no refined surface.
  Poll poll(cancel);
  if (method == Method::exact && prefers_refined(adjacency, {&from, 1}, poll)) {
    return search.straightened(adjacency, search.by_field(adjacency, from, to, kUnreached));
  }
  WavefrontScratch& along_edges = scratch.parts().wavefront;
  // A search may be too small to ask or tell on its own.
  const auto begins = [&] {
    cancel.report(kPathAlongEdges);
    return !cancel.requested();
  };
  // Where the mesh's faces are long and thin, the Delaunay triangulation's edges say more of the
  // length. But fronts over the mesh's own faces then need more of a margin than they have.
  if (method == Method::back_traced) {
    const auto length = delaunay_edge_distance(adjacency, from.point, to, along_edges, cancel);
    if (!length) return fail(length.error());
    if (!*length) return Pair{};
    return begins() ? search.in_margins(adjacency, from, to, **length) : fail_stopped(cancel);
  }
  const auto guess = edge_path(adjacency, from.point, to, along_edges, cancel);
  if (!guess) return fail(guess.error());
  if (!*guess) return Pair{};
  if (!begins()) return fail_stopped(cancel);
  if (is_exact(method)) {
    return search.straightened(adjacency, search.in_patch(adjacency, from, to, **guess));
  }
  const double length = (*guess)->length;
  if (method == Method::dijkstra) {
    return search.by_field(adjacency, from, to, (1 + tolerance::kSamePath) * length);
  }
  return search.in_margins(adjacency, from, to, length);
}

}  // namespace geodesic
