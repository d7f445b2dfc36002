#include "core/paths/trace_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "core/base/tolerances.h"
#include "core/exact/field.h"
#include "core/field/edge_points.h"
#include "core/field/line_waves.h"
#include "core/paths/arrive_at_point.h"
#include "core/paths/down_edges.h"
#include "core/paths/edge_path.h"
#include "core/paths/leave_cluster.h"

namespace geodesic {
namespace {

// A path is astray when it is longer than the target's distance by more than this part of it: even
// the way along edges, which is some tenths of a path's length too long on coarse meshes, may be
// shorter.
constexpr double kAstray = 0.05;

// A step costs from a tenth of a microsecond to some; a question, as much.
constexpr std::uint32_t kStepsBetweenQuestions = 256;

// Of a path that may enter faces again, besides four times those of one that may not.
constexpr std::uint64_t kMostStepsAgain = 64;

// Whether a path is longer than its target's distance by more than this part of it. Without the
// source's offset, beside which no detour would be seen; but it has taken digits from the distance.
bool is_longer_than_said(const Field& field, const Path& path, double distance, double part) {
  const double offset = field.sources[path.source].offset;
  const double rounding =
      field.distance.are_floats() ? tolerance::kSinglePrecision : tolerance::kSameWay;
  return path.length > (1 + part) * (distance - offset) + rounding * offset;
}

// Of two paths, which may have other sources.
bool arrives_sooner(const Field& field, const Path& path, const Path& than) {
  const double head_start = field.sources[than.source].offset - field.sources[path.source].offset;
  return path.length - than.length < head_start;
}

// One straight piece of the path, going back: from `start` to `end` within a face.
struct Leg {
  std::uint32_t face;
  std::array<double, 3> start;
  std::array<double, 3> end;
  std::uint32_t to_vertex;  // kNone when it does not end at one
};

// Why a trace ends, whatever the distances are. It goes from vertex to vertex, over edges in
// between. Each step over an edge enters a face that it has not been in (or, by `steiner`, leads
// to a point of its graph that is closer to the sources than any before). A vertex is come to by
// a usual step once; the second time by way of its cluster, which is looked at once for each
// vertex; and from then on by going down along edges to what is closer than every vertex come to
// so far, which there are no more of than vertices. What is still not at a source after that
// many steps has no distances that lead to one.
class Tracer {
 public:
  // `most_steps`, if not 0: so many, and then it may enter faces again. Over faces that are lines a
  // shortest path does.
  Tracer(const Adjacency& adjacency, const Field& field, const Cancel& cancel,
         std::uint64_t most_steps = 0)
      : adjacency_(adjacency),
        field_(field),
        cancel_(cancel),
        poll_(cancel, kStepsBetweenQuestions),
        enters_again_(most_steps > 0),
        most_steps_(most_steps),
        arrivals_(adjacency, field, &poll_),
        entered_(adjacency.faces().size(), false),
        come_to_(adjacency.mesh().vertex_count(), false) {}

  // As the windows on a machine part say; nothing where they do not.
  Result<std::optional<Path>> along_window_paths(const SurfacePoint& target) {
    const auto way = arrivals_.window_paths()->way_to(target);
    if (poll_.stopped()) return fail_stopped(poll_);
    if (!way) return std::nullopt;
    for (const WayLeg& leg : way->legs) legs_.push_back({leg.face, leg.start, leg.end, kNone});
    Path path = assemble(way->source);
    const double same =
        field_.distance.are_floats() ? 2 * tolerance::kSinglePrecision : tolerance::kSamePath;
    if (is_longer_than_said(field_, path, way->distance, same)) return std::nullopt;
    return path;
  }

  Result<std::optional<Path>> trace(const SurfacePoint& target) {
    StepBack step = first_step(target);
    // Near the source, where hardly any of the distance is left, places on the mesh are rounded
    // more coarsely than that.
    const Box& box = adjacency_.mesh().box();
    same_way_ = tolerance::kSameWay * step.distance + tolerance::kSide * norm(box.max - box.min);
    if (step.to == StepBack::To::nowhere && !target.at_vertex() && !poll_.stopped()) {
      return std::nullopt;
    }
    for (std::uint64_t left = most_steps(); step.to != StepBack::To::nowhere && left > 0; --left) {
      if (poll_.cancelled()) break;
      walk(step);
      if (poll_.stopped()) break;
      if (step.to == StepBack::To::source) return unless_astray(assemble(step.source), target);
      step = step.to == StepBack::To::vertex ? from_vertex(step.vertex) : from_edge(step);
    }
    if (poll_.stopped()) return fail_stopped(poll_);
    return along_edges(target);
  }

 private:
  void walk(const StepBack& step) {
    if (step.face == kNone) return;
    entered_[step.face] = true;
    const bool is_over_border =
        std::find(step.start.begin(), step.start.end(), 0.0) != step.start.end();
    if (enters_again_) {
      ++times_entered_[step.face];
    } else if (is_over_border) {
      enter_copies_of(step.face);
    }
    const bool to_vertex = step.to == StepBack::To::vertex;
    legs_.push_back({step.face, step.start, step.bary, to_vertex ? step.vertex : kNone});
  }

  // A shortest path that comes to a face over its border goes through none of those that have the
  // same corners: there it could as well have gone on. By rounding a trace would go through all.
  void enter_copies_of(std::uint32_t face) {
    const auto apex_across = [this](Halfedge h) {
      return adjacency_.face(face_of(h)).vertex[previous_corner(corner_of(h))];
    };
    const Halfedge side = halfedge(face, 0);
    for (Halfedge h = adjacency_.ring(side); h != side; h = adjacency_.ring(h)) {
      if (poll_.cancelled()) return;
      if (apex_across(h) == apex_across(side)) entered_[face_of(h)] = true;
    }
  }

  // All but the last of several steps one after the other.
  StepBack walk_to_last(const std::vector<StepBack>& steps) {
    if (steps.empty()) return {};
    for (std::size_t i = 0; i + 1 < steps.size(); ++i) walk(steps[i]);
    return steps.back();
  }

  // Several times what the reasons above allow.
  [[nodiscard]] std::uint64_t most_steps() const {
    if (enters_again_) return most_steps_;
    const std::uint64_t points = field_.edge_points ? field_.edge_points->distance.size() : 0;
    return 8 * (entered_.size() + come_to_.size() + points + 1);
  }

  // Step 1 of the paper: a vertex by its parents, an inner point of a face by the
  // shortest of the ways over the face's sides.
  StepBack first_step(const SurfacePoint& target) {
    target_ = target.vertex;
    if (target.at_vertex()) return from_vertex(target.vertex);
    StepBack best;
    for (const SurfacePoint& place : arrivals_.all_faces_at(target)) {
      if (poll_.cancelled()) return {};
      const StepBack step = arrivals_.through_face(place);
      if (arrivals_.is_better(step, best)) best = step;
    }
    return best;
  }

  // The end, at a vertex that is nearest by the straight wave of a source line.
  [[nodiscard]] StepBack at_source_of_lines(std::uint32_t vertex) const {
    if (!field_.lines || field_.nearest_source.empty()) return {};
    const std::uint32_t s = field_.nearest_source[vertex];
    if (s == kNone || s < field_.lines->given() || field_.sources[s].point.vertex != vertex) {
      return {};
    }
    StepBack step;
    step.to = StepBack::To::source;
    step.distance = field_.distance[vertex];
    step.source = s;
    return step;
  }

  StepBack from_vertex(std::uint32_t vertex) {
    const StepBack end = at_source_of_lines(vertex);
    if (end.to == StepBack::To::source) return end;
    if (enters_again_) return through_others(point_at_vertex(adjacency_, vertex));
    lowest_ = std::min(lowest_, field_.distance[vertex]);
    if (!come_to_[vertex]) {
      come_to_[vertex] = true;
      const StepBack step = on_from_vertex(vertex);
      const bool is_found = step.to != StepBack::To::nowhere;
      // A vertex next to one as close to the sources, up to rounding, may have its distance from
      // there, which no face tells.
      if (is_found && !(field_.windows && is_longer_than_stated(step, vertex))) return step;
      const StepBack other = out_of_cluster(vertex);
      if (is_found && !arrivals_.is_better(other, step)) return step;
      if (other.to != StepBack::To::nowhere) return walk_to_last(steps_out_);
    } else {
      cut_loop(vertex);
      if (out_of_cluster(vertex).to != StepBack::To::nowhere) return walk_to_last(steps_out_);
    }
    return walk_to_last(down_edges(adjacency_, field_, vertex, lowest_, poll_));
  }

  [[nodiscard]] bool is_longer_than_stated(const StepBack& step, std::uint32_t vertex) const {
    return step.distance > field_.distance[vertex] * (1 + tolerance::kSamePath);
  }

  // The last of the steps out of the vertex's cluster, which are left in steps_out_; once for
  // each vertex, and then nowhere.
  StepBack out_of_cluster(std::uint32_t vertex) {
    if (!looked_about_.insert(vertex).second) return {};
    const auto entered = [this](std::uint32_t face) { return bool(entered_[face]); };
    const auto passed = [this](std::uint32_t v) { return bool(come_to_[v]); };
    steps_out_ = leave_cluster(adjacency_, field_, arrivals_, vertex, entered, passed, poll_);
    return steps_out_.empty() ? StepBack{} : steps_out_.back();
  }

  // A path that is at a vertex again need not have gone round; unless what led there before
  // has been cut off with a longer way round.
  void cut_loop(std::uint32_t vertex) {
    if (legs_.empty()) return;
    if (target_ != vertex) {
      const auto before =
          std::find_if(std::next(legs_.rbegin()), legs_.rend(),
                       [vertex](const Leg& leg) { return leg.to_vertex == vertex; });
      if (before != legs_.rend()) legs_.erase(before.base(), legs_.end());
    } else {
      legs_.clear();
    }
  }

  // Steps 2 to 4 from a vertex. A front of `fast_marching` may have come to it from
  // beyond the base of an obtuse face, before its neighbours; one of `back_traced` over
  // faces that are not the mesh's.
  StepBack on_from_vertex(std::uint32_t vertex) {
    const StepBack step = arrivals_.by_parents(vertex);
    const bool blocked = step.to == StepBack::To::edge && !may_enter(step.face);
    if (traits_of(field_.method).may_lead_astray && (blocked || step.to == StepBack::To::nowhere)) {
      std::vector<StepBack> steps = arrivals_.to_lesser_vertex(vertex);
      if (steps.empty()) {
        steps = down_edges(adjacency_, field_, vertex, field_.distance[vertex], poll_);
      }
      return walk_to_last(steps);
    }
    if (!blocked) return step;
    // Through faces without area a shortest path may come back to a vertex, by no way at all:
    // on through another face, with the same distance.
    if (field_.windows) {
      const StepBack other = through_others(point_at_vertex(adjacency_, vertex));
      if (other.distance <= step.distance * (1 + tolerance::kSamePath)) return other;
    }
    return arrivals_.to_end_of_side(step.face, corner_of(step.base), step.start);
  }

  // Through whichever face not yet entered gives the point the least distance.
  [[nodiscard]] StepBack through_others(const SurfacePoint& here) {
    StepBack best;
    for (const SurfacePoint& place : arrivals_.all_faces_at(here)) {
      if (poll_.cancelled()) return {};
      if (!may_enter(place.face)) continue;
      const StepBack step = arrivals_.through_face(place);
      if (enters_again_ ? is_newer(step, best) : arrivals_.is_better(step, best)) best = step;
    }
    return best;
  }

  // Shorter, or as short through a face that was entered less often: so it does not go round in
  // circles where steps have no length.
  [[nodiscard]] bool is_newer(const StepBack& step, const StepBack& than) const {
    if (than.to == StepBack::To::nowhere || step.to == StepBack::To::nowhere) {
      return step.to != StepBack::To::nowhere;
    }
    if (step.distance < than.distance - same_way_) return true;
    if (step.distance > than.distance + same_way_) return false;
    if (step.to == StepBack::To::source || than.to == StepBack::To::source) {
      return step.to == StepBack::To::source && than.to != StepBack::To::source;
    }
    return times_entered(step.face) < times_entered(than.face);
  }
  [[nodiscard]] std::uint32_t times_entered(std::uint32_t face) const {
    const auto found = times_entered_.find(face);
    return found == times_entered_.end() ? 0 : found->second;
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

  // In the graph of `steiner` every step leads to a lesser distance as it is.
  [[nodiscard]] bool may_enter(std::uint32_t face) const {
    if (enters_again_) return true;
    return traits_of(field_.method).has_edge_points || !entered_[face];
  }

  // Approximate distances may send a trace round and round, as on the wall of a hole that is hardly
  // wider than it is high. The way along edges is better then.
  Result<std::optional<Path>> unless_astray(Path traced, const SurfacePoint& target) {
    if (!traits_of(field_.method).may_lead_astray) return traced;
    const double expected = arrivals_.distance_at(target);
    if (poll_.stopped()) return fail_stopped(poll_);
    if (!is_longer_than_said(field_, traced, expected, kAstray)) return traced;
    auto other = along_edges(target);
    if (!other || (*other && arrives_sooner(field_, **other, traced))) return other;
    return traced;
  }

  // Where the distances do not lead to a source: some path, to that of the sources that the
  // target's distance says that it is from.
  Result<std::optional<Path>> along_edges(const SurfacePoint& target) {
    std::uint32_t nearest = target.vertex;
    if (!target.at_vertex()) {
      const auto& corners = adjacency_.face(target.face).vertex;
      nearest = *std::min_element(corners.begin(), corners.end(), [&](auto a, auto b) {
        return field_.distance[a] < field_.distance[b];
      });
    }
    std::uint32_t source = field_.nearest_source.empty() ? 0 : field_.nearest_source[nearest];
    if (source == kNone) return std::nullopt;
    WavefrontScratch scratch;
    auto path = edge_path(adjacency_, field_.sources[source].point, target, scratch, cancel_);
    if (path && *path) (*path)->source = source;
    return path;
  }

  // Whether a path that has but a vertex where it begins goes on where faces without width join
  // that to another place, as near as rounding can tell.
  [[nodiscard]] bool leaves_elsewhere(const Path& path, const Leg& leg) const {
    const SurfacePoint& start = path.points.front().point;
    return path.points.size() == 1 && start.at_vertex() &&
           point_on_face(adjacency_, leg.face, leg.end).vertex != start.vertex;
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
        const bool is_end = path.points.size() == 1 && last.point.at_vertex();
        if (last.position == position && (!is_end || point.vertex == last.point.vertex)) {
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
      if (path.points.empty() || leaves_elsewhere(path, *leg)) {
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
  const Cancel& cancel_;
  Poll poll_;
  bool enters_again_;
  std::unordered_map<std::uint32_t, std::uint32_t> times_entered_;  // … and how often which
  std::uint64_t most_steps_;
  double same_way_ = 0;  // in mesh units: what rounding may make of two ways as long as each other
  PointArrivals arrivals_;
  std::uint32_t target_ = kNone;  // when it is a vertex
  std::vector<Leg> legs_;
  std::vector<StepBack> steps_out_;
  std::vector<bool> entered_;                       // by face
  std::vector<bool> come_to_;                       // by vertex
  std::unordered_set<std::uint32_t> looked_about_;  // vertices whose clusters were left
  double lowest_ = kUnreached;                      // of the distances of vertices come to
};

// What has windows of the mesh's own faces is as good as a field by `exact`.
Field as_exact(const Field& field) {
  Field exact = field;
  exact.method = Method::exact;
  exact.windows = {field.kept_windows, &field.kept_windows->table};
  exact.kept_windows.reset();
  return exact;
}

}  // namespace

Result<std::optional<Path>> trace_path(const Adjacency& adjacency, const Field& field,
                                       const SurfacePoint& target, const Cancel& cancel) {
  if (target.at_vertex() && field.distance[target.vertex] == kUnreached) return std::nullopt;
  if (field.kept_windows) {
    auto path = Tracer(adjacency, field, cancel).along_window_paths(target);
    if (!path || *path) return path;
    if (!field.kept_windows->is_refined)
      return trace_path(adjacency, as_exact(field), target, cancel);
    if (field.kept_windows->are_the_answer) {
      const auto over_mesh = exact_field_over_mesh(adjacency, field, target, cancel);
      if (!over_mesh) return fail(over_mesh.error());
      return trace_path(adjacency, *over_mesh, target, cancel);
    }
  }
  auto path = Tracer(adjacency, field, cancel).trace(target);
  if (!path || !*path || !field.windows) return path;
  Poll poll(cancel);
  const double stated = PointArrivals(adjacency, field, &poll).distance_at(target);
  if (poll.stopped()) return fail_stopped(poll);
  if (!is_longer_than_said(field, **path, stated, tolerance::kSamePath)) return path;
  const std::uint64_t most_steps = kMostStepsAgain + 4 * (*path)->points.size();
  auto again = Tracer(adjacency, field, cancel, most_steps).trace(target);
  if (!again) return again;
  if (*again && arrives_sooner(field, **again, **path)) return again;
  return path;
}

}  // namespace geodesic
