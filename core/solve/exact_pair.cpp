#include "core/solve/exact_pair.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/base/tolerances.h"
#include "core/field/longest_edge.h"
#include "core/paths/arrive_at_point.h"
#include "core/paths/trace_path.h"

namespace geodesic {
namespace {

// How many rings of faces round the traced path have their windows kept: at the first attempt, and
// at the last.
constexpr std::uint32_t kRings = 2;
constexpr std::uint32_t kMostRings = 12;

// No list of faces means all.
constexpr std::span<const std::uint32_t> kEverywhere{};

// The part of the time that the first field takes: the second takes about as long.
constexpr double kFirstField = 0.5;

// Faces, each once.
class FaceSet {
 public:
  explicit FaceSet(const Adjacency& adjacency)
      : adjacency_(adjacency),
        has_(adjacency.faces().size(), false),
        has_all_at_(adjacency.mesh().vertex_count(), false) {}

  void add(std::uint32_t f) {
    if (has_[f]) return;
    has_[f] = true;
    faces_.push_back(f);
  }
  // Those on which a point is.
  void add_about(const SurfacePoint& point, Poll& poll) {
    for (const SurfacePoint& place : in_all_faces(adjacency_, point)) {
      if (poll.cancelled()) return;
      add(place.face);
    }
  }
  // All that share a vertex with one of these. However often it grows, the faces at a vertex
  // are gone through once: there may be as many as the mesh has.
  void grow(Poll& poll) {
    for (const std::size_t count = faces_.size(); grown_ < count; ++grown_) {
      for (const std::uint32_t v : adjacency_.face(faces_[grown_]).vertex) {
        if (has_all_at_[v]) continue;
        has_all_at_[v] = true;
        for (const std::uint32_t corner : adjacency_.corners(v)) {
          if (poll.cancelled()) return;
          add(face_of(corner));
        }
      }
    }
  }
  [[nodiscard]] const std::vector<std::uint32_t>& faces() const { return faces_; }

 private:
  const Adjacency& adjacency_;
  std::vector<bool> has_;
  std::vector<bool> has_all_at_;  // by vertex
  std::vector<std::uint32_t> faces_;
  std::size_t grown_ = 0;  // the first so many have all their neighbours
};

class ExactPair {
 public:
  // `about`: the faces on which `to` is.
  ExactPair(const Adjacency& adjacency, const Source& from, const SurfacePoint& to,
            const FaceSet& about, ExactScratch& scratch)
      : adjacency_(adjacency), from_(from), to_(to), scratch_(scratch) {
    // Their vertices are reached by the path at the latest.
    for (const std::uint32_t f : about.faces()) {
      const auto vertices = adjacency.face(f).vertex;
      targets_.insert(targets_.end(), vertices.begin(), vertices.end());
    }
    if (to.at_vertex()) {
      targets_.push_back(to.vertex);
    } else {
      beyond_targets_ = longest_edge_of(adjacency, about.faces());
    }
  }

  // With the windows of these faces, or of all.
  Result<Field> field(std::span<const std::uint32_t> details, const Cancel& cancel) {
    FieldLimits limits;
    limits.targets = targets_;
    limits.beyond_targets = beyond_targets_;
    limits.keep_details = true;
    limits.detail_faces = details;
    return exact_field(adjacency_, {&from_, 1}, limits, scratch_, cancel);
  }

  Result<std::optional<Path>> path_by_windows(std::span<const std::uint32_t> details,
                                              const Cancel& cancel) {
    const auto near = field(details, cancel);
    if (!near) return fail(near.error());
    return trace_path(adjacency_, *near, to_, cancel);
  }

  // A path that mostly runs close to the shortest one.
  Result<std::optional<Path>> rough_path(Field field, const Cancel& cancel) {
    field.windows.reset();
    field.method = Method::back_traced;  // by distances alone
    return trace_path(adjacency_, field, to_, cancel);
  }

 private:
  const Adjacency& adjacency_;
  const Source& from_;
  const SurfacePoint& to_;
  ExactScratch& scratch_;
  std::vector<std::uint32_t> targets_;
  double beyond_targets_ = 0;
};

}  // namespace

Result<Pair> exact_pair(const Adjacency& adjacency, const Source& from, const SurfacePoint& to,
                        bool with_path, ExactScratch& scratch, const Cancel& cancel) {
  Poll poll(cancel);
  FaceSet at_target(adjacency);
  at_target.add_about(to, poll);
  if (poll.stopped()) return fail_stopped(poll);
  // The offset only delays; beside it rounding would hide how long ways are.
  const Source undelayed{from.point, 0};
  ExactPair search(adjacency, undelayed, to, at_target, scratch);
  auto field = search.field(at_target.faces(), with_path ? cancel.part(0, kFirstField) : cancel);
  if (!field) return fail(std::move(field.error()));
  const double over_surface = PointArrivals(adjacency, *field, &poll).distance_at(to);
  if (poll.stopped()) return fail_stopped(poll);
  Pair pair;
  pair.distance = from.offset + over_surface;
  if (!with_path || pair.distance == kUnreached) return pair;
  const auto rough = search.rough_path(std::move(*field), cancel);
  if (!rough) return fail(rough.error());
  if (!*rough) return pair;
  FaceSet faces(adjacency);
  for (const PathPoint& at : (*rough)->points) faces.add_about(at.point, poll);
  std::uint32_t rings = 0;
  for (const std::uint32_t wanted : {kRings, kMostRings}) {
    for (; rings < wanted; ++rings) faces.grow(poll);
    if (poll.stopped()) return fail_stopped(poll);
    auto path = search.path_by_windows(faces.faces(), cancel.part(kFirstField, 1));
    if (!path) return fail(std::move(path.error()));
    if (*path && (*path)->length <= over_surface * (1 + tolerance::kSamePath)) {
      pair.path = std::move(*path);
      return pair;
    }
  }
  // The shortest path is elsewhere. What takes too much memory is refused.
  auto path = search.path_by_windows(kEverywhere, cancel.part(kFirstField, 1));
  if (!path) return fail(std::move(path.error()));
  pair.path = std::move(*path);
  return pair;
}

}  // namespace geodesic
