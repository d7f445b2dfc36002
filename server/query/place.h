// Where a query is asked: one surface, and what its points are there.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/field/field.h"
#include "core/field/travel_cost.h"
#include "core/refine/refine_along.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"
#include "proto/replies/replies.h"
#include "proto/wire/point_request.h"
#include "server/places/field_rows.h"
#include "server/places/field_sources.h"
#include "server/query/far_points.h"
#include "server/query/field_queries.h"

namespace geodesic::server {

// Refers to the queries, the surface and `caller` of the query.
class FieldQueries::Place {
 public:
  Place(FieldQueries& queries, const AskedSurface& surface, PreparedSurface prepared,
        const Caller& caller)
      : queries_(queries), surface_(surface), prepared_(std::move(prepared)), caller_(caller) {}

  [[nodiscard]] const std::shared_ptr<const Adjacency>& adjacency() const {
    return prepared_.adjacency;
  }
  [[nodiscard]] const Mesh& mesh() const { return adjacency()->mesh(); }
  // Null where no face is split.
  [[nodiscard]] const Refinement* refinement() const { return prepared_.refinement.get(); }
  // What a reply says of a place.
  [[nodiscard]] proto::ResolvedPoint told(const SurfacePoint& point) const {
    return reply_point(mesh(), refinement(), point);
  }
  // What ways cost; null: their length.
  [[nodiscard]] const std::shared_ptr<const TravelCost>& cost() const { return cost_; }
  void set_cost(std::shared_ptr<const TravelCost> cost) { cost_ = std::move(cost); }
  // What part of the surface's area is steeper than so many points on edges are good for
  // (core/steiner/steep_ground.h).
  void set_steep_ground(double part, double slope, std::uint32_t points_per_edge) {
    steep_part_ = part;
    steep_slope_ = slope;
    points_per_edge_ = points_per_edge;
  }
  // Warns where much of the surface is steeper than that.
  void warn_of_steep_ground(std::vector<std::string>& warnings) const;

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
  // What fields start from (field_sources.cpp): points with their offsets, and the lines and faces
  // of what is no point, in a compute slot. In `echo` one for each of `requests`. Errors besides:
  // index_out_of_range (a loop, a part or a face that there is not), value_out_of_range (no
  // boundary at all), outside_region, no_loop (a curve between pieces of the surface), too_large,
  // and those of reserve_lines: what is made counts as long as it is held.
  // `round`, if it is not null, becomes the line of the last closed curve, back to its first point.
  [[nodiscard]] Result<FieldSources> sources(const std::vector<proto::PointRequest>& requests,
                                             std::vector<proto::ResolvedPoint>& echo,
                                             std::vector<std::string>& warnings,
                                             SurfacePolyline* round = nullptr) const;
  // The same of each of the requests apart. `outlines`: as FieldRows::make has it.
  [[nodiscard]] Result<FieldRows> rows(const std::vector<proto::PointRequest>& requests,
                                       std::vector<proto::ResolvedPoint>& echo,
                                       std::vector<std::string>& warnings,
                                       bool outlines = false) const;

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
  // What lines and faces among the requests are made of.
  [[nodiscard]] Result<SourceSurface> source_surface(
      const std::vector<proto::PointRequest>& requests) const;

  FieldQueries& queries_;
  const AskedSurface& surface_;
  PreparedSurface prepared_;
  std::shared_ptr<const TravelCost> cost_;
  double steep_part_ = 0;
  double steep_slope_ = 0;
  std::uint32_t points_per_edge_ = 0;
  const Caller& caller_;
};

}  // namespace geodesic::server
