// Where a query is asked: one mesh, and what its points are there.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/adjacency.h"
#include "core/error.h"
#include "core/field.h"
#include "core/surface_point.h"
#include "proto/point_request.h"
#include "proto/query_replies.h"
#include "server/field_queries.h"
#include "server/mesh_catalog.h"
#include "server/resolve_point.h"

namespace geodesic::server {

// Refers to the catalogue, the id and `caller` of the query.
class FieldQueries::Place {
 public:
  Place(MeshCatalog& catalog, const std::string& mesh, std::shared_ptr<const Adjacency> adjacency,
        const Caller& caller)
      : adjacency_(std::move(adjacency)),
        closest_([&catalog, &mesh, &caller] { return catalog.closest_points(mesh, caller); }) {}

  [[nodiscard]] const std::shared_ptr<const Adjacency>& adjacency() const { return adjacency_; }
  [[nodiscard]] const Mesh& mesh() const { return adjacency_->mesh(); }

  // The place, and what the reply says of it in `echo`.
  [[nodiscard]] Result<SurfacePoint> point(const proto::PointRequest& request,
                                           proto::ResolvedPoint& echo) const {
    auto placed = resolve_point(*adjacency_, closest_, request);
    if (!placed) return fail(std::move(placed.error()));
    echo = std::move(placed->echo);
    return placed->point;
  }
  [[nodiscard]] Result<std::vector<SurfacePoint>> points(
      const std::vector<proto::PointRequest>& requests,
      std::vector<proto::ResolvedPoint>& echo) const {
    std::vector<SurfacePoint> points;
    points.reserve(requests.size());
    echo.reserve(requests.size());
    for (const proto::PointRequest& request : requests) {
      auto found = point(request, echo.emplace_back());
      if (!found) return fail(std::move(found.error()));
      points.push_back(*found);
    }
    return points;
  }
  // The points with their offsets.
  [[nodiscard]] Result<std::vector<Source>> sources(
      const std::vector<proto::PointRequest>& requests,
      std::vector<proto::ResolvedPoint>& echo) const {
    const auto found = points(requests, echo);
    if (!found) return fail(found.error());
    std::vector<Source> sources;
    sources.reserve(found->size());
    for (std::size_t i = 0; i < found->size(); ++i) {
      sources.push_back({(*found)[i], requests[i].offset});
    }
    return sources;
  }

 private:
  std::shared_ptr<const Adjacency> adjacency_;
  ClosestPoints closest_;
};

}  // namespace geodesic::server
