// The cells of the nearest of some sites.
#include <memory>
#include <utility>
#include <vector>

#include "core/voronoi/voronoi.h"
#include "proto/wire/query_limits.h"
#include "server/base/timed.h"
#include "server/places/resolve_point.h"
#include "server/query/field_queries.h"
#include "server/query/place.h"

namespace geodesic::server {
namespace {

// The part of the time that the field of all sites takes, before those of each.
constexpr double kFieldOfVoronoi = 0.2;

// `sites`: where those are that are points, by their numbers.
void tell_cells(Voronoi&& found, const Mesh& mesh, const Refinement* refinement,
                const std::vector<SurfacePoint>& sites, proto::VoronoiReply& reply) {
  reply.cells.clear();  // it may be run again
  reply.triangles.clear();
  for (std::size_t i = 0; i < found.cells.size(); ++i) {
    const VoronoiCell& cell = found.cells[i];
    auto& told = reply.cells.emplace_back();
    told.site = reply.from[i].lines ? reply.from[i] : reply_point(mesh, refinement, sites[i]);
    told.area = cell.area;
    told.perimeter = cell.perimeter;
    told.boundary = cell.boundary;
    told.vertices = cell.vertices;
    if (!cell.is_empty()) told.centroid = reply_point(mesh, refinement, cell.centroid);
  }
  for (const VoronoiVertex& vertex : found.bisectors.vertices) {
    reply.triangles.push_back(
        {vertex.sites, reply_point(mesh, refinement, vertex.point), vertex.distance});
  }
  reply.neighbours = std::move(found.neighbours);
  reply.bisectors = std::move(found.bisectors.lines);
}

// Each of the rows, which must outlive this.
VoronoiSites sites_of(const FieldRows& rows) {
  return {static_cast<std::uint32_t>(rows.size()),
          [&rows](std::uint32_t site, SolveScratch& scratch,
                  const Cancel& cancel) -> Result<VoronoiSite> {
            auto from = rows.of(site, scratch, cancel);
            if (!from) return fail(std::move(from.error()));
            return VoronoiSite{std::move(from->points), std::move(from->lines)};
          }};
}

// What a drawing of the cells has, and a picture.
Result<void> cut_cells(const Adjacency& adjacency, const NearSites& near,
                       std::uint64_t most_triangles, proto::VoronoiReply& reply,
                       const Cancel& cancel) {
  constexpr std::uint64_t kBytesOfTriangle = 3 * sizeof(Vec3) + sizeof(std::uint32_t);
  // Lists may have grown by doubling.
  if (!cancel.may_take(2 * kBytesOfTriangle * most_triangles)) return fail_stopped(cancel);
  reply.drawn_cells.assign(reply.cells.size(), {});
  return each_cell_triangle(
      adjacency, near,
      [&](const CellTriangle& triangle) {
        auto& cell = reply.drawn_cells[triangle.site];
        cell.corners.insert(cell.corners.end(), triangle.corners.begin(), triangle.corners.end());
        cell.faces.push_back(triangle.face);
      },
      cancel);
}

}  // namespace

Result<Answered<proto::VoronoiReply>> FieldQueries::answer(const AskedSurface& surface,
                                                           const proto::VoronoiRequest& request,
                                                           const Caller& caller) {
  const auto place = find(surface, request.method, caller);
  if (!place) return fail(place.error());
  Answered<proto::VoronoiReply> answer;
  const auto adjacency = place->adjacency();
  answer.adjacency = adjacency;
  proto::VoronoiReply& reply = answer.reply;
  reply.mesh = surface.mesh();
  reply.method = request.method.which;
  reply.relax = request.relax;
  reply.part = request.part.value_or(proto::VoronoiRequest::Part::cells);
  auto sites = place->sources(request.from, reply.from, reply.warnings);
  if (!sites) return fail(std::move(sites.error()));
  FieldRows rows;  // each site apart
  if (sites->lines) {
    std::vector<proto::ResolvedPoint> same;
    std::vector<std::string> warned;
    auto apart = place->rows(request.from, same, warned);
    if (!apart) return fail(std::move(apart.error()));
    rows = std::move(*apart);
  }
  // Each round takes as long as the cells at the end.
  const double relaxing =
      static_cast<double>(request.relax) / static_cast<double>(request.relax + 1);
  const Method method = request.method.which;
  const MethodOptions& options = request.method.options;
  if (request.relax > 0) {
    auto relaxed = fields_.compute(
        [&](SolveScratch& scratch, const Cancel& cancel) {
          const Timed solving(caller, Stage::solve);
          return relax_sites(method, options, *adjacency, sites->points, request.relax, scratch,
                             cancel);
        },
        caller.part(0, relaxing));
    if (!relaxed) return fail(std::move(relaxed.error()));
    sites->points = std::move(*relaxed);
  }
  if (!sites->lines) rows = FieldRows(sites->points);
  const double with_field = relaxing + (1 - relaxing) * kFieldOfVoronoi;
  const Caller rest = caller.part(relaxing, with_field);
  const auto field = fields_.whole({surface.key(), adjacency, request.method, *sites},
                                   Details::none, request.relax > 0 ? rest.finishing() : rest);
  if (!field) return fail(field.error());
  answer.cache_hit = field->hit;
  const Caller last = caller.part(with_field, 1);
  const bool begins_here = field->hit && request.relax == 0;
  struct Found {
    std::shared_ptr<const NearSites> near;
    std::uint64_t segments = 0;
  };
  auto found = fields_.compute(
      [&](SolveScratch& scratch, const Cancel& cancel) -> Result<Found> {
        const Timed solving(caller, Stage::solve);
        const VoronoiSites of = sites->lines ? sites_of(rows) : points_of(*field->value);
        auto cells = voronoi(method, options, *adjacency, *field->value, of,
                             proto::kMaxIsolineSegments, scratch, cancel);
        if (!cells) return fail(std::move(cells.error()));
        Found kept{cells->near, cells->bisectors.segments};
        tell_cells(std::move(*cells), adjacency->mesh(), place->refinement(), rows.points(), reply);
        return kept;
      },
      begins_here ? last : last.finishing());
  if (!found) {
    if (found.error().code == ErrorCode::too_large) found.error().parameter = "from";
    return fail(std::move(found.error()));
  }
  if (reply.part != proto::VoronoiRequest::Part::cells) return answer;
  // A bisector through a part of a face makes two triangles more.
  const std::uint64_t triangles = adjacency->mesh().face_count() + 2 * found->segments;
  constexpr std::uint64_t kNumbersOfTriangle = 3;
  answer.drawn_numbers = kNumbersOfTriangle * triangles;
  answer.complete_drawing = [adjacency, near = found->near, triangles](proto::VoronoiReply& to,
                                                                       const Cancel& cancel) {
    return cut_cells(*adjacency, *near, triangles, to, cancel);
  };
  return answer;
}

}  // namespace geodesic::server
