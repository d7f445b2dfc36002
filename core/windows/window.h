// What exact propagation moves about: windows, as in Surazhsky, Surazhsky,
// Kirsanov, Gortler, Hoppe, "Fast exact and approximate geodesics on meshes",
// 2005, section 3.1.
//
// An edge has a frame of its own: its tail lies at 0 on the x axis and its head at
// the edge's length. A window is an interval of an edge that is seen straight, in
// the plane of the faces unfolded one after another, from one unfolded source. The
// source's depth is kept without a sign: which side it is on follows from the
// face that the window came out of, so windows of both directions lie in one list.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/surface/adjacency.h"

namespace geodesic::exact {

// Where straight lines begin: a source, or a vertex at which shortest paths bend.
// Made once and never changed, so a window needs only its number.
struct PseudoSource {
  double offset;         // its own distance, mesh units
  std::uint32_t vertex;  // kNone: a source
  std::uint32_t source;  // the number of the source that the way began at
  // With a tolerance: the path there is longer than `offset` by this much.
  double allowance = 0;
};

struct Window {
  double begin;  // along the edge from its tail, mesh units
  double end;
  double x;         // the unfolded source
  double y;         // its depth, not negative
  double at_begin;  // distances at the interval's ends
  double at_end;
  std::uint32_t pseudo_source;  // number of the pseudo-source
  Halfedge from;                // the window came out of this halfedge's face
  std::uint32_t faces;          // how many it has crossed on the way from its pseudo-source
  bool propagated;              // already passed on to the other faces

  // Distance at a place on the edge, given the pseudo-source's own.
  [[nodiscard]] double at(double place, double offset) const {
    const double along = place - x;
    return offset + std::sqrt(along * along + y * y);
  }
  // The least distance in the interval.
  [[nodiscard]] double least(double offset) const {
    return x > begin && x < end ? offset + y : std::min(at_begin, at_end);
  }
};

}  // namespace geodesic::exact
