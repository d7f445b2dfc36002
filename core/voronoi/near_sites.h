// For every vertex the sites whose cells may come near: what cells inside faces are cut by.
//
// A field of all sites says how far the nearest one is. Where two cells meet, both distances are
// needed on both sides. So each site has a field of its own, a little farther than its cell.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/field.h"
#include "core/field/method.h"
#include "core/solve/solve_field.h"
#include "core/surface/adjacency.h"

namespace geodesic {

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

 private:
  friend class NearSitesBuilder;
  double unit_ = 1;  // a power of two
  std::vector<std::size_t> begin_;
  std::vector<NearSite> sites_;
  std::vector<double> beyond_;  // by vertex, the square of what others are surely above
};

// `field` is that of all sites, its sources, by `method`. A site is near a vertex if it is no
// farther from it than the nearest one and twice the longest side there. By the triangle inequality
// that are all sites that are nearest anywhere in a face there. Methods whose distances are no
// metric may miss one by their error.
//
// As many fields as there are sites. Errors: those of solve_field.
[[nodiscard]] Result<NearSites> near_sites(Method method, const MethodOptions& options,
                                           const Adjacency& adjacency, const Field& field,
                                           SolveScratch& scratch, const Cancel& cancel);

}  // namespace geodesic
