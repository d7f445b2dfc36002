#include "core/exact/field.h"

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/exact/propagation.h"
#include "core/exact/surface.h"
#include "core/field/around_points.h"
#include "core/field/longest_edge.h"
#include "core/field/straight_floor.h"
#include "core/field/vertex_front.h"

namespace geodesic {

ExactScratch::ExactScratch() : memory(std::make_unique<exact::PropagationMemory>()) {}
ExactScratch::~ExactScratch() = default;
ExactScratch::ExactScratch(ExactScratch&&) noexcept = default;
ExactScratch& ExactScratch::operator=(ExactScratch&&) noexcept = default;
std::size_t ExactScratch::window_bytes() const { return memory->window_bytes(); }

namespace {

// What a whole field takes on a surface of one piece, besides edges and faces, which ask for
// themselves: of a vertex its distance and what is known of its ways; where windows are kept, at
// least one on each edge between faces, in the front's memory and in the table.
std::uint64_t expected_bytes(const Adjacency& adjacency, const Triangulation& surface,
                             bool keep_windows) {
  const std::uint64_t of_vertex =
      sizeof(double) + sizeof(exact::ArrivalAtVertex) + sizeof(exact::Bends) + sizeof(double);
  const std::uint64_t edges = exact::count_edges(adjacency, surface);
  const std::uint64_t of_windows =  // of the mesh's own faces
      (edges - adjacency.report().edges_boundary) *
          (sizeof(exact::Window) + sizeof(VisibleInterval)) +
      4 * surface.faces.size() * sizeof(WindowTable::Part);
  return (surface.corner_begin.size() - 1) * of_vertex + edges * sizeof(std::uint32_t) +
         (keep_windows ? of_windows : 0);
}

// Of which faces windows are kept, for the details of a field: of a machine part, of those that
// are best for it, unless points have no places on them; with directions, of the refined surface,
// where it is better and has all, or of the mesh.
enum class Keep : std::uint8_t { nothing, of_mesh, with_directions, of_part };

Keep keep_for(const FieldLimits& limits) {
  if (!limits.keep_details) return Keep::nothing;
  return limits.may_keep_refined ? Keep::with_directions : Keep::of_mesh;
}

// Vertices have the same distances on faces that are better for it.
Triangulation surface_for(const Adjacency& adjacency, std::span<const Source> sources, Keep keep,
                          Poll& poll) {
  if (keep == Keep::of_mesh) return adjacency.triangulation();
  if (keep == Keep::with_directions) {
    return exact::surface_with_directions(adjacency, sources, poll);
  }
  return keep == Keep::of_part && adjacency.has_large_faces()
             ? exact::surface_of_part(adjacency, sources, poll)
             : exact::surface_for_windows(adjacency, sources, poll);
}

bool keeps_windows(Keep keep, bool keep_details, const Adjacency& adjacency,
                   const Triangulation& surface) {
  if (keep != Keep::of_part || !keep_details) {
    return keep == Keep::of_mesh || keep == Keep::with_directions;
  }
  return exact::is_refined(adjacency, surface) ||
         (adjacency.has_large_faces() && surface.faces.data() == adjacency.faces().data());
}

std::vector<SurfaceWindows::SourcePlace> source_places(const Adjacency& adjacency,
                                                       const Triangulation& surface,
                                                       std::span<const Source> sources,
                                                       Poll& poll) {
  std::vector<SurfaceWindows::SourcePlace> places;
  for (std::uint32_t s = 0; s < sources.size() && !poll.cancelled(); ++s) {
    if (sources[s].point.at_vertex()) continue;
    for (const auto& place : exact::places_on(adjacency, surface, sources[s].point, poll)) {
      places.push_back({place.face, s, place.weights});
    }
  }
  std::stable_sort(places.begin(), places.end(),
                   [](const auto& a, const auto& b) { return a.face < b.face; });
  return places;
}

// Takes the distances of vertices that the mesh has not away.
void keep_vertices_of_mesh(const Adjacency& adjacency, Field& field) {
  const std::size_t vertex_count = adjacency.mesh().vertex_count();
  if (field.distance.size() == vertex_count) return;
  Field left = unreached_field(field.method, field.sources, vertex_count);
  const auto distances = std::span<const double>(field.distance.doubles()).first(vertex_count);
  std::copy(distances.begin(), distances.end(), left.distance.doubles().begin());
  field.distance = std::move(left.distance);
  if (!field.nearest_source.empty()) field.nearest_source.resize(vertex_count);
}

void forget_windows(ExactScratch& scratch, Poll& poll) {
  std::vector<exact::DomainMemory>& domains = scratch.memory->domains;
  for (exact::DomainMemory& domain : domains) domain.pool.reset(poll, domains.size());
}

Result<Field> field_by_windows(Method method, const Adjacency& adjacency,
                               std::span<const Source> sources, double tolerance, Keep keep,
                               const FieldLimits& limits, ExactScratch& scratch,
                               const Cancel& cancel, const Cancel& at_end) {
  const bool is_whole = limits.targets.empty() && limits.max == kUnreached;
  Poll poll(cancel);
  forget_windows(scratch, poll);  // before anybody asks for window_bytes()
  if (poll.stopped()) return fail_stopped(cancel);
  const Triangulation surface = surface_for(adjacency, sources, keep, poll);
  if (keep == Keep::with_directions) {
    if (!exact::is_refined(adjacency, surface)) keep = Keep::of_mesh;
    // Vertices that start early may be such as were added, of which a field knows nothing.
    if (keep == Keep::with_directions) tolerance = 0;
  }
  const bool keeps = keeps_windows(keep, limits.keep_details, adjacency, surface);
  const bool keeps_some = keep == Keep::of_mesh && !limits.detail_faces.empty();
  if (is_whole && !cancel.may_take(expected_bytes(adjacency, surface, keeps && !keeps_some))) {
    return fail_stopped(cancel);
  }
  const std::size_t vertex_count = surface.corner_begin.size() - 1;
  Field field = unreached_field(method, sources, vertex_count);
  exact::Propagation propagation(adjacency, surface, *scratch.memory, field, limits.max, tolerance,
                                 keeps, poll);
  if (poll.stopped()) return fail_stopped(cancel);
  if (keeps_some) propagation.keep_windows_of(limits.detail_faces);
  for (std::uint32_t s = 0; s < sources.size(); ++s) {
    // Each may be in all faces.
    if (s > 0 && poll.ask()) return fail_stopped(cancel);
    propagation.start(sources[s], s);
  }

  std::vector<std::uint32_t> targets(limits.targets.begin(), limits.targets.end());
  // True once every target's distance is final.
  const auto arrived = [&] {
    if (limits.targets.empty()) return false;
    while (!targets.empty() && propagation.path_length(targets.back()) + limits.beyond_targets <
                                   propagation.final_below()) {
      targets.pop_back();
    }
    return targets.empty();
  };
  // A step is some hundred windows over their faces.
  Poll steps(cancel, 16);
  do {
    while (!arrived() && propagation.step()) {
      if (poll.stopped() || steps.cancelled(propagation.reached(), vertex_count)) {
        return fail_stopped(cancel);
      }
    }
  } while (!arrived() && propagation.relax_along_edges(poll));

  propagation.raise_to_paths(poll);
  // What was not final when the last target was is farther than any of them.
  double farthest = limits.targets.empty() ? kUnreached : 0;
  for (const std::uint32_t v : limits.targets) farthest = std::max(farthest, field.distance[v]);
  // Ways to points inside faces lead over other vertices than the corners of theirs.
  if (keep == Keep::with_directions) farthest += limits.beyond_targets;
  keep_vertices_of_mesh(adjacency, field);
  field.forget_beyond(std::min(farthest, limits.max));
  if (poll.stopped()) return fail_stopped(cancel);
  Poll last(at_end);
  if (keep == Keep::of_mesh) {
    field.windows = std::make_shared<const WindowTable>(propagation.window_table(last));
  } else if (keeps) {
    field.kept_windows = std::make_shared<const SurfaceWindows>(SurfaceWindows{
        propagation.window_table(last), exact::is_refined(adjacency, surface),
        source_places(adjacency, surface, sources, last), keep == Keep::with_directions});
  }
  propagation.drop_windows(last);
  if (last.stopped()) return fail_stopped(at_end);
  field.count_reached();
  return field;
}

}  // namespace

Result<Field> exact_field(const Adjacency& adjacency, std::span<const Source> sources,
                          const FieldLimits& limits, ExactScratch& scratch, const Cancel& cancel) {
  auto field = field_by_windows(Method::exact, adjacency, sources, 0, keep_for(limits), limits,
                                scratch, cancel, cancel);
  return not_below_straight_lines(adjacency.mesh(), std::move(field), limits, cancel);
}

Result<void> make_ready_for_windows(const Adjacency& adjacency, std::span<const Source> sources,
                                    ExactScratch& scratch, const Cancel& cancel) {
  Poll poll(cancel);
  forget_windows(scratch, poll);
  const Triangulation surface = surface_for(adjacency, sources, Keep::of_part, poll);
  if (!poll.stopped()) scratch.memory->shared.frames.build(adjacency, surface, poll);
  if (poll.stopped()) return fail_stopped(cancel);
  return {};
}

Result<Field> field_within(double tolerance, const Adjacency& adjacency,
                           std::span<const Source> sources, const FieldLimits& limits,
                           ExactScratch& scratch, const Cancel& cancel) {
  const bool keeps = limits.keep_details && !limits.detail_faces.empty();
  return field_by_windows(Method::back_traced, adjacency, sources, tolerance,
                          keeps ? keep_for(limits) : Keep::nothing, limits, scratch, cancel,
                          cancel);
}

Result<Field> field_with_kept_windows(const Adjacency& adjacency, std::span<const Source> sources,
                                      bool keep_details, ExactScratch& scratch,
                                      const Cancel& counting, const Cancel& cancel) {
  FieldLimits limits;
  limits.keep_details = keep_details;
  return field_by_windows(Method::back_traced, adjacency, sources, 0, Keep::of_part, limits,
                          scratch, counting, cancel);
}

bool prefers_refined(const Adjacency& adjacency, std::span<const Source> sources, Poll& poll) {
  return exact::is_refined(adjacency, exact::surface_with_directions(adjacency, sources, poll));
}

Result<Field> exact_field_over_mesh(const Adjacency& adjacency, const Field& field,
                                    const SurfacePoint& point, const Cancel& cancel) {
  const auto faces = faces_around(adjacency, {&point, 1}, cancel);
  if (!faces) return fail(faces.error());
  const auto targets = vertices_around(adjacency, {&point, 1}, cancel);
  if (!targets) return fail(targets.error());
  FieldLimits limits;
  limits.targets = *targets;
  limits.beyond_targets = longest_edge_of(adjacency, *faces);
  ExactScratch scratch;
  return exact_field(adjacency, field.sources, limits, scratch, cancel);
}

}  // namespace geodesic
