// What several fields start from, one source each: the rows of a table, the sites of cells; and
// what a table's columns are.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/solve/solve_scratch.h"
#include "core/surface/point.h"
#include "proto/replies/replies.h"
#include "proto/wire/point_request.h"
#include "server/base/caller.h"
#include "server/places/field_sources.h"

namespace geodesic::server {

// Of rows that are lines, curves and boundaries are kept: a query has a limit of the former, and
// the mesh one of the latter. What is whole faces is made anew for each field, for it takes as much
// memory as the mesh has faces.
class FieldRows {
 public:
  // A line as a place, to which distances are asked.
  struct Outline {
    // Its ends and segments, and its key; of whole faces, those of their border, without the faces.
    std::shared_ptr<const FieldSources> lines;
    std::vector<std::uint32_t> faces;  // ascending

    [[nodiscard]] std::size_t bytes() const {
      return lines->bytes() + faces.capacity() * sizeof(std::uint32_t);
    }
  };

  FieldRows() = default;
  // Points alone.
  explicit FieldRows(std::vector<Source> points) : points_(std::move(points)) {}

  // In a compute slot. `points`: of all requests, one after the other. In `echo`: what a reply says
  // of each row that is no point, in their order. With `outlines` those of lines are kept, too.
  // Errors: those of SourceBuilder::add_lines.
  [[nodiscard]] static Result<FieldRows> make(std::shared_ptr<const SourceSurface> surface,
                                              std::span<const proto::PointRequest> requests,
                                              std::span<const SurfacePoint> points,
                                              std::vector<proto::ResolvedPoint>& echo,
                                              bool outlines, SolveScratch& scratch,
                                              const Cancel& cancel);

  [[nodiscard]] std::size_t size() const { return points_.size(); }
  [[nodiscard]] bool has_lines() const { return !lines_.empty(); }
  // Where the rows are that are points; others are anywhere.
  [[nodiscard]] std::vector<SurfacePoint> points() const;

  // Null for a point.
  [[nodiscard]] const Outline* outline(std::size_t row) const {
    const auto line = lines_.find(row);
    return line == lines_.end() ? nullptr : line->second.outline.get();
  }
  [[nodiscard]] const Source& point(std::size_t row) const { return points_[row]; }

  // In a compute slot. Errors: cancelled, too_much_memory.
  [[nodiscard]] Result<FieldSources> of(std::size_t row, SolveScratch& scratch,
                                        const Cancel& cancel) const;

  [[nodiscard]] std::size_t bytes() const;

  // Has its memory counted for as long as it is held: to be called in the slot that has made it.
  // Errors: those of reserve_lines.
  [[nodiscard]] Result<void> reserve(const Caller& caller);
  // Once nobody asks for distances to them any more. From then on there are none.
  void drop_outlines();

 private:
  // Without the lines of those that are kept in any case.
  [[nodiscard]] std::size_t bytes_of_outlines() const;

  struct Line {
    std::shared_ptr<const FieldSources> kept;
    proto::PointRequest faces;  // if it is not kept
    std::shared_ptr<const Outline> outline;
  };

  std::shared_ptr<const SourceSurface> surface_;
  std::vector<Source> points_;                   // by row; of no use where that is no point
  std::unordered_map<std::size_t, Line> lines_;  // by row
  std::shared_ptr<const void> reserved_;         // for all but the outlines
  std::shared_ptr<const void> outlines_reserved_;
};

}  // namespace geodesic::server
