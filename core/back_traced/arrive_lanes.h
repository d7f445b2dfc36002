// Many arrivals at once, in the lanes of vector registers: what arrive() of
// virtual_source.h computes, to the last bit, whatever the processor has for vectors.
#pragma once

#include <array>
#include <cstddef>
#include <span>

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

// The arrivals at the vertices opposite these halfedges, from the distances at their
// ends, which must be finite. All eight are computed; `distance` has an entry per vertex.
void arrive_lanes(std::span<const FaceRecord> faces, std::span<const double> distance,
                  std::span<const Halfedge, ArrivalLanes::kLanes> bases, Vectors vectors,
                  ArrivalLanes& to);

}  // namespace geodesic
