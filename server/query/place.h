// Where a query is asked: one surface, and what its points are there.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/field/field.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"
#include "proto/wire/point_request.h"
#include "proto/wire/replies.h"
#include "server/query/far_points.h"
#include "server/query/field_queries.h"

namespace geodesic::server {

// Refers to the queries, the surface and `caller` of the query.
class FieldQueries::Place {
 public:
  Place(FieldQueries& queries, const AskedSurface& surface,
        std::shared_ptr<const Adjacency> adjacency, const Caller& caller)
      : queries_(queries), surface_(surface), adjacency_(std::move(adjacency)), caller_(caller) {}

  [[nodiscard]] const std::shared_ptr<const Adjacency>& adjacency() const { return adjacency_; }
  [[nodiscard]] const Mesh& mesh() const { return adjacency_->mesh(); }

  // The places, and what the reply says of each in `echo`. In a compute slot where any of
  // them takes longer than to look it up.
  [[nodiscard]] Result<std::vector<SurfacePoint>> points(
      const std::vector<proto::PointRequest>& requests,
      std::vector<proto::ResolvedPoint>& echo) const;
  // The same, with a warning of those that are far from the surface.
  [[nodiscard]] Result<std::vector<SurfacePoint>> points(
      const std::vector<proto::PointRequest>& requests, std::vector<proto::ResolvedPoint>& echo,
      std::vector<std::string>& warnings) const {
    auto found = points(requests, echo);
    if (found) warn_of_far_points(mesh(), requests, echo, warnings);
    return found;
  }
  // The points with their offsets.
  [[nodiscard]] Result<std::vector<Source>> sources(
      const std::vector<proto::PointRequest>& requests, std::vector<proto::ResolvedPoint>& echo,
      std::vector<std::string>& warnings) const {
    const auto found = points(requests, echo, warnings);
    if (!found) return fail(found.error());
    std::vector<Source> sources;
    sources.reserve(found->size());
    for (std::size_t i = 0; i < found->size(); ++i) {
      sources.push_back({(*found)[i], requests[i].offset});
    }
    return sources;
  }

  // One place.
  [[nodiscard]] Result<SurfacePoint> point(const proto::PointRequest& request,
                                           proto::ResolvedPoint& echo,
                                           std::vector<std::string>& warnings) const {
    std::vector<proto::ResolvedPoint> echoes;
    const auto found = points({request}, echoes, warnings);
    if (!found) return fail(found.error());
    echo = std::move(echoes.front());
    return found->front();
  }

 private:
  FieldQueries& queries_;
  const AskedSurface& surface_;
  std::shared_ptr<const Adjacency> adjacency_;
  const Caller& caller_;
};

}  // namespace geodesic::server
