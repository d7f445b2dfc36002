// For every vertex the sites whose cells may come near: what cells inside faces are cut by.
//
// A field of all sites says how far the nearest one is. Where two cells meet, both distances are
// needed on both sides. So each site has a field of its own, a little farther than its cell.
//
// Sites that are lines may share an end, and sites that are faces a border: all that is nearest
// there is as far from both. So where sites are no points, the distances of a vertex that differ by
// no more than the method's error are taken as the same, and the lowest site is the nearest.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/field.h"
#include "core/field/line_waves.h"
#include "core/field/method.h"
#include "core/solve/solve_field.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// What has a cell.
struct VoronoiSite {
  std::vector<Source> sources;               // a point, or the ends of lines and faces …
  std::shared_ptr<const SourceLines> lines;  // … which are here, all of one item; null: a point
};

struct VoronoiSites {
  std::uint32_t count = 0;
  // Makes one of them, as often as it is asked. The error ends the computation.
  std::function<Result<VoronoiSite>(std::uint32_t site, SolveScratch&, const Cancel&)> at;
};

// The sources of a field from points, which must outlive this.
[[nodiscard]] VoronoiSites points_of(const Field& field);

// Distances are kept as their squares, in a unit in which the greatest is about 1: no product of
// three of them overflows.
struct NearSite {
  std::uint32_t site = kNone;
  double square = 0;
};

class NearSites {
 public:
  // Those of a vertex, ascending by their numbers; none where it is unreached.
  [[nodiscard]] std::span<const NearSite> of(std::uint32_t vertex) const {
    return {sites_.data() + begin_[vertex], begin_[vertex + 1] - begin_[vertex]};
  }
  [[nodiscard]] bool is_reached(std::uint32_t vertex) const {
    return begin_[vertex] < begin_[vertex + 1];
  }
  // The nearest of them, the lowest of several; kNone where there is none.
  [[nodiscard]] std::uint32_t nearest(std::uint32_t vertex) const;
  // The square of any site's distance; of one that is not near, what it surely is above.
  [[nodiscard]] double square(std::uint32_t vertex, std::uint32_t site) const;
  // Mesh units, of the root of a square.
  [[nodiscard]] double unit() const { return unit_; }
  // Whether it has lines: its distances are linear beside these.
  [[nodiscard]] bool is_line(std::uint32_t site) const {
    return !is_line_.empty() && is_line_[site];
  }
  // Whether sites have whole faces, and the site that this one belongs to, or kNone.
  [[nodiscard]] bool own_faces() const { return waves_ && !waves_->lines().item_of_face.empty(); }
  [[nodiscard]] std::uint32_t owner(std::uint32_t face) const {
    return own_faces() ? waves_->lines().item_of_face[face] : kNone;
  }

 private:
  friend class NearSitesBuilder;
  double unit_ = 1;  // a power of two
  std::vector<std::size_t> begin_;
  std::vector<NearSite> sites_;
  std::vector<double> beyond_;              // by vertex, the square of what others are surely above
  std::vector<bool> is_line_;               // by site; empty: all are points
  std::shared_ptr<const LineWaves> waves_;  // what says whose faces are
};

// `field` is that of all sites by `method`. A site is near a vertex if it is no
// farther from it than the nearest one and twice the longest side there. By the triangle inequality
// that are all sites that are nearest anywhere in a face there. Methods whose distances are no
// metric may miss one by their error.
//
// `sites` are those that the field is of: where it has lines (solve_from_lines.h), its items.
// As many fields as there are sites. Errors: those of solve_field, and those of `sites`.
[[nodiscard]] Result<NearSites> near_sites(Method method, const MethodOptions& options,
                                           const Adjacency& adjacency, const Field& field,
                                           const VoronoiSites& sites, SolveScratch& scratch,
                                           const Cancel& cancel);

}  // namespace geodesic
