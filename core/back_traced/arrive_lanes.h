// Many arrivals at once, in the lanes of vector registers: what arrive() of
// virtual_source.h computes, to the last bit, whatever the processor has for vectors.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "core/back_traced/front_distances.h"
#include "core/base/vectors.h"
#include "core/surface/face_record.h"

namespace geodesic {

struct ArrivalLanes {
  static constexpr std::size_t kLanes = 8;

  std::array<double, kLanes> distance;  // of the apex
  // Where the line meets the base, 0 at its tail and 1 at its head; or one of these:
  std::array<float, kLanes> crossing;
  static constexpr float kBendsAtTail = -1;  // Fig4::b
  static constexpr float kBendsAtHead = 2;   // Fig4::c
};

// The arrivals at the vertices opposite these halfedges, from the distances at their ends, which
// must be finite. All eight are computed. `sources`: of each halfedge the number of the source that
// it is about; may be null where there is one.
void arrive_lanes(std::span<const FaceRecord> faces, const FrontDistances& distances,
                  std::span<const Halfedge, ArrivalLanes::kLanes> bases,
                  const std::uint32_t* sources, Vectors vectors, ArrivalLanes& to);

}  // namespace geodesic
