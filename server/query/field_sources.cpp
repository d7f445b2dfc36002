// What fields start from: the points that clients name are found, and lines and faces made of them.
#include "server/places/field_sources.h"

#include <memory>
#include <utility>
#include <variant>
#include <vector>

#include "server/places/field_rows.h"
#include "server/query/place.h"

namespace geodesic::server {

Result<SourceSurface> FieldQueries::Place::source_surface(
    const std::vector<proto::PointRequest>& requests) const {
  SourceSurface surface{adjacency(), prepared_.refinement, nullptr, {}};
  bool has_faces = false;
  proto::NamedOfFile named;
  for (const proto::PointRequest& request : requests) {
    if (!std::holds_alternative<proto::FacesRequest>(request.where)) continue;
    const auto shape = shape_in(request);
    if (!shape) return fail(shape.error());
    has_faces = true;
    named.add(*shape);
  }
  if (!has_faces) return surface;
  auto told = queries_.catalog_.file_faces(surface_.mesh(), named, caller_.part(0, 0));
  if (!told) return fail(std::move(told.error()));
  surface.file = std::move(*told);
  auto whole = queries_.catalog_.adjacency(surface_.mesh(), caller_.part(0, 0));
  if (!whole) return fail(std::move(whole.error()));
  surface.whole = std::move(*whole);
  return surface;
}

Result<FieldSources> FieldQueries::Place::sources(const std::vector<proto::PointRequest>& requests,
                                                  std::vector<proto::ResolvedPoint>& echo,
                                                  std::vector<std::string>& warnings,
                                                  SurfacePolyline* round) const {
  const bool is_points = is_all_points(requests);
  std::vector<proto::ResolvedPoint> echoes;
  const auto found =
      is_points ? points(requests, echo, warnings) : points(points_in(requests), echoes, warnings);
  if (!found) return fail(found.error());
  if (is_points) {
    FieldSources from;
    from.points.reserve(found->size());
    for (std::size_t i = 0; i < found->size(); ++i) {
      from.points.push_back({(*found)[i], requests[i].offset});
    }
    return from;
  }
  const auto surface = source_surface(requests);
  if (!surface) return fail(surface.error());
  return queries_.fields_.compute(
      [&](SolveScratch& scratch, const Cancel& cancel) -> Result<FieldSources> {
        echo.clear();  // it may be run again
        SourceBuilder builder(*surface, scratch, cancel);
        std::size_t next = 0;  // of the points
        for (const proto::PointRequest& request : requests) {
          const std::size_t count = count_points(request);
          if (request.is_point()) {
            builder.add_point((*found)[next], request.offset);
            echo.push_back(echoes[next]);
          } else {
            auto told = builder.add_lines(request, std::span(*found).subspan(next, count), round);
            if (!told) return fail(std::move(told.error()));
            echo.push_back(std::move(*told));
          }
          next += count;
        }
        auto made = builder.take();
        if (!made) return made;
        auto reserved = reserve_lines(caller_, made->bytes());
        if (!reserved) return fail(std::move(reserved.error()));
        made->reserved = std::move(*reserved);
        return made;
      },
      caller_.part(0, 0));
}

Result<FieldRows> FieldQueries::Place::rows(const std::vector<proto::PointRequest>& requests,
                                            std::vector<proto::ResolvedPoint>& echo,
                                            std::vector<std::string>& warnings,
                                            bool outlines) const {
  if (is_all_points(requests)) {
    auto from = sources(requests, echo, warnings);
    if (!from) return fail(std::move(from.error()));
    return FieldRows(std::move(from->points));
  }
  std::vector<proto::ResolvedPoint> echoes;
  const auto found = points(points_in(requests), echoes, warnings);
  if (!found) return fail(found.error());
  auto made = source_surface(requests);
  if (!made) return fail(std::move(made.error()));
  const auto surface = std::make_shared<const SourceSurface>(std::move(*made));
  std::vector<proto::ResolvedPoint> lines;
  auto rows = queries_.fields_.compute(
      [&](SolveScratch& scratch, const Cancel& cancel) -> Result<FieldRows> {
        lines.clear();  // it may be run again
        auto apart = FieldRows::make(surface, requests, *found, lines, outlines, scratch, cancel);
        if (!apart) return apart;
        if (auto reserved = apart->reserve(caller_); !reserved) {
          return fail(std::move(reserved.error()));
        }
        return apart;
      },
      caller_.part(0, 0));
  if (!rows) return fail(std::move(rows.error()));
  std::size_t next_point = 0;
  std::size_t next_line = 0;
  for (const proto::PointRequest& request : requests) {
    echo.push_back(request.is_point() ? echoes[next_point] : lines[next_line++]);
    next_point += count_points(request);
  }
  return rows;
}

}  // namespace geodesic::server
