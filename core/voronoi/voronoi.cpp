#include "core/voronoi/voronoi.h"

#include <array>
#include <utility>

#include "core/voronoi/face_cells.h"

namespace geodesic {
namespace {

// How far the whole has come when the field of all sites, each site's own, and the measures are
// there.
constexpr double kFieldOfSites = 0.3;
constexpr double kFields = 0.8;
constexpr double kMeasures = 0.9;

}  // namespace

Result<Voronoi> voronoi(Method method, const MethodOptions& options, const Adjacency& adjacency,
                        const Field& field, std::uint64_t max_segments, SolveScratch& scratch,
                        const Cancel& cancel) {
  return voronoi(method, options, adjacency, field, points_of(field), max_segments, scratch,
                 cancel);
}

Result<Voronoi> voronoi(Method method, const MethodOptions& options, const Adjacency& adjacency,
                        const Field& field, const VoronoiSites& sites, std::uint64_t max_segments,
                        SolveScratch& scratch, const Cancel& cancel) {
  Voronoi found;
  auto near =
      near_sites(method, options, adjacency, field, sites, scratch, cancel.part(0, kFields));
  if (!near) return fail(std::move(near.error()));
  found.near = std::make_shared<const NearSites>(std::move(*near));
  auto cells = measure_cells(adjacency, *found.near, sites.count, cancel.part(kFields, kMeasures));
  if (!cells) return fail(std::move(cells.error()));
  found.cells = std::move(*cells);
  auto bisectors =
      trace_bisectors(adjacency, *found.near, max_segments, found.cells, cancel.part(kMeasures, 1));
  if (!bisectors) return fail(std::move(bisectors.error()));
  found.bisectors = std::move(*bisectors);
  for (const Bisector& line : found.bisectors.lines) {
    if (found.neighbours.empty() || found.neighbours.back().sites != line.sites) {
      found.neighbours.push_back({line.sites, 0});
    }
    found.neighbours.back().length += line.length;
  }
  return found;
}

Result<std::vector<Source>> relax_sites(Method method, const MethodOptions& options,
                                        const Adjacency& adjacency, std::vector<Source> sites,
                                        std::uint64_t rounds, SolveScratch& scratch,
                                        const Cancel& cancel) {
  FieldLimits limits;
  limits.keep_details = false;
  for (std::uint64_t round = 0; round < rounds; ++round) {
    const auto all = static_cast<double>(rounds);
    const Cancel part =
        cancel.part(static_cast<double>(round) / all, static_cast<double>(round + 1) / all);
    const auto field = solve_field(method, options, adjacency, sites, limits, scratch,
                                   part.part(0, kFieldOfSites));
    if (!field) return fail(field.error());
    const auto near = near_sites(method, options, adjacency, *field, points_of(*field), scratch,
                                 part.part(kFieldOfSites, kMeasures));
    if (!near) return fail(near.error());
    const auto cells = measure_cells(adjacency, *near, static_cast<std::uint32_t>(sites.size()),
                                     part.part(kMeasures, 1));
    if (!cells) return fail(cells.error());
    bool any = false;
    for (std::size_t i = 0; i < sites.size(); ++i) {
      const VoronoiCell& cell = (*cells)[i];
      if (cell.is_empty() || is_same_place(cell.centroid, sites[i].point)) continue;
      sites[i].point = cell.centroid;
      any = true;
    }
    if (!any) break;
  }
  return sites;
}

Result<void> each_cell_triangle(const Adjacency& adjacency, const NearSites& near,
                                const std::function<void(const CellTriangle&)>& take,
                                const Cancel& cancel) {
  Poll poll(cancel);
  FaceCells face_cells(adjacency, near);
  const std::uint32_t faces = adjacency.mesh().face_count();
  for (std::uint32_t f = 0; f < faces; ++f) {
    if (poll.cancelled_after(1, f, faces)) return fail_stopped(poll);
    for (const CellPart& part : face_cells.parts_of(f, poll)) {
      const auto at = [&](std::size_t i) {
        return position_in_face(adjacency, f, part.corners[i]);
      };
      for (std::size_t i = 2; i < part.corners.size(); ++i) {
        take({part.site, f, {at(0), at(i - 1), at(i)}});
      }
    }
    if (poll.stopped()) return fail_stopped(poll);
  }
  return {};
}

}  // namespace geodesic
