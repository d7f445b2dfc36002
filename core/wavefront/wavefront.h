// The distance field of Tang, Wu, Zhang and Zhang 2007, section 3.1: a wavefront
// that accepts vertices in the order of their distance and computes each from
// the virtual source of a triangle whose other two vertices are accepted.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/field.h"
#include "core/field/vertex_buckets.h"
#include "core/field/vertex_heap.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// Memory that a query works in, kept for the next query on the same thread.
struct WavefrontScratch {
  VertexHeap heap;
  VertexBuckets buckets;
  std::vector<std::uint32_t> round;  // out of a bucket
  std::vector<std::uint8_t> is_target;
  std::vector<double> distance;  // of one of several waves; kUnreached between waves
  std::vector<Parents> parents;
};

// The distances from the nearest of the sources. The paper's wavefront has one
// source; with several, each has a wave of its own, which stops where an earlier
// one was nearer: circles of two sources mean nothing together. No distance is below the
// straight line in space: what the rule makes less, as across faces without area, is raised to it.
//
// O(n log n) for n vertices and one source. With k sources that lie apart about twice that, for
// each wave goes little farther than where its source is the nearest; k times that at worst, where
// all lie within a few edges. With no source everything is unreached. Errors: cancelled.
[[nodiscard]] Result<Field> wavefront_field(const Adjacency& adjacency,
                                            std::span<const Source> sources,
                                            const FieldLimits& limits, WavefrontScratch& scratch,
                                            const Cancel& cancel);

}  // namespace geodesic
