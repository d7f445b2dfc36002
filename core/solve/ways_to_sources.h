// Ways from a point straight to sources, where distances at vertices do not say which is nearest.
#pragma once

#include <cstdint>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/field.h"
#include "core/paths/path.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"
#include "core/wavefront/wavefront.h"

namespace geodesic {

// A path's length, and what rounding may have taken off it: of a sum of n segments n epsilon;
// of each end of a segment some epsilon of its coordinates.
[[nodiscard]] double not_below_length(const Path& path);

// How far it is from a source in space: no way is shorter.
[[nodiscard]] double straight_from(const Adjacency& adjacency, const Field& field, std::uint32_t s,
                                   const SurfacePoint& point);

// Whether a source that none of the corners is nearest to may be the nearest one.
[[nodiscard]] bool may_be_of_another(const Adjacency& adjacency, const Field& field,
                                     const SurfacePoint& point, double told, Poll& poll);

// Where several sources meet, the distances of a face's corners do not lead to the nearest one of
// a point between them. Ways to the sources themselves do: to those of the corners, and to those
// that no vertex leads to; where the corners are nearest to several, to the others about, too. Each
// from the shortest along edges, so few are asked.
class WaysToSources {
 public:
  // All must outlive this.
  WaysToSources(const Adjacency& adjacency, const Field& field, const SurfacePoint& point,
                const Cancel& cancel)
      : adjacency_(adjacency), field_(field), point_(point), cancel_(cancel) {}

  // The shortest that is below `least`, or that; without the source that has been asked.
  [[nodiscard]] Result<double> below(double least, std::uint32_t asked);

  // The length of one to that source.
  [[nodiscard]] Result<double> from(std::uint32_t s);

 private:
  [[nodiscard]] bool is_near(std::uint32_t s, double least) const {
    return straight_from(adjacency_, field_, s, point_) < least;
  }

  const Adjacency& adjacency_;
  const Field& field_;
  const SurfacePoint& point_;
  const Cancel& cancel_;
  WavefrontScratch scratch_;
};

}  // namespace geodesic
