// What fields start from: from points, curves, boundaries and faces as clients name them to points,
// lines and faces of the mesh.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/curves/source_lines.h"
#include "core/field/field.h"
#include "core/field/line_waves.h"
#include "core/refine/refine_along.h"
#include "core/refine/refinement.h"
#include "core/solve/solve_scratch.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"
#include "proto/region/file_faces.h"
#include "proto/region/region.h"
#include "proto/replies/replies.h"
#include "proto/wire/point_request.h"
#include "server/base/caller.h"

namespace geodesic::server {

// What a field starts from. Where that is lines and faces, too, `points` has the ends of these as
// well, and `key` is what caches know them by. `reserved` has their memory counted (reserve_lines)
// for as long as they are held; null: it is not.
struct FieldSources {
  std::vector<Source> points;
  std::shared_ptr<const SourceLines> lines;
  std::string key;
  std::shared_ptr<const void> reserved = nullptr;

  [[nodiscard]] std::size_t bytes() const {
    return points.capacity() * sizeof(Source) + (lines ? lines->bytes() : 0);
  }
};

// Where sources are looked for.
struct SourceSurface {
  std::shared_ptr<const Adjacency> adjacency;
  std::shared_ptr<const Refinement> refinement;  // null where no face is split
  // Set if faces are named: the mesh of the file, whose faces shapes are of, and what they name.
  std::shared_ptr<const Adjacency> whole;
  proto::FileFaces file;
};

// How many points a source names: one, those of a curve, or none.
[[nodiscard]] std::size_t count_points(const proto::PointRequest& request);
// The points that all of them name, in this order.
[[nodiscard]] std::vector<proto::PointRequest> points_in(
    const std::vector<proto::PointRequest>& requests);
// Whether nothing but points is among them.
[[nodiscard]] bool is_all_points(std::span<const proto::PointRequest> requests);
// That of a request of faces. Errors: those of parse_json_shape.
[[nodiscard]] Result<proto::Shape> shape_in(const proto::PointRequest& request);

// Has what lines take counted until what is returned is gone: a query holds them while it waits for
// its fields, when no slot counts them any more. Null where that is little, or nobody counts.
// Errors: those of Caller::reserve.
[[nodiscard]] Result<std::shared_ptr<const void>> reserve_lines(const Caller& caller,
                                                                std::uint64_t bytes);

// Adds one thing after the other to what a field starts from, in a compute slot. One builder makes
// the sources of one query, whose limits it counts.
class SourceBuilder {
 public:
  // All must outlive this.
  SourceBuilder(const SourceSurface& surface, SolveScratch& scratch, const Cancel& cancel)
      : surface_(surface),
        adjacency_(*surface.adjacency),
        scratch_(scratch),
        cancel_(cancel),
        poll_(cancel) {}

  void add_point(const SurfacePoint& point, double offset);
  // What is no point. `points`: those that it names, on the surface. Returns what a reply says of
  // it. `round`, if it is not null, becomes the line of a closed curve, back to its first point.
  // Errors: index_out_of_range (a loop, a part or a face that there is not), value_out_of_range (no
  // boundary at all, no face), no_loop (a curve between pieces of the surface), too_large,
  // cancelled, too_much_memory.
  [[nodiscard]] Result<proto::ResolvedPoint> add_lines(const proto::PointRequest& request,
                                                       std::span<const SurfacePoint> points,
                                                       SurfacePolyline* round = nullptr);
  // What was added since the last time. Errors: cancelled, too_much_memory.
  [[nodiscard]] Result<FieldSources> take();

 private:
  Result<void> add_curve_of(const proto::PointRequest& request,
                            std::span<const SurfacePoint> points, SurfacePolyline* round,
                            proto::ResolvedLines& made);
  Result<void> add_boundary(const proto::PointRequest& request, proto::ResolvedLines& made);
  Result<void> add_faces_of(const proto::PointRequest& request, proto::ResolvedLines& made);

  const SourceSurface& surface_;
  const Adjacency& adjacency_;
  SolveScratch& scratch_;
  const Cancel& cancel_;
  Poll poll_;
  std::vector<Source> sources_;
  SourceLines lines_;
  std::vector<BoundaryLoop> loops_;
  std::uint32_t item_ = 0;
  std::size_t curve_pieces_ = 0;
  std::uint64_t ranges_ = 0;
};

}  // namespace geodesic::server
