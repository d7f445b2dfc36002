// A wavefront as that of Tang et al. 2007, which looks back before it accepts: the
// default between the paper's own and an exact method.
//
// The paper's front (wavefront/wavefront.h) decides the order of the vertices and the edge that
// each one's shortest way comes over. Each distance is then computed again: by going
// back along that way over ten faces, and taking the paper's two circles round the
// ends of the edge there, or a straight line from a vertex in between (back_traced/trace.h).
// The front goes on from that distance. It runs on the intrinsic Delaunay triangulation of the
// surface. Only the first look around from a source inside a face goes over the faces of the mesh.
#pragma once

#include <span>

#include "core/back_traced/scratch.h"
#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/field.h"
#include "core/field/method.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// The distances from the nearest of the sources. All have one front, which keeps up to four
// distances of a vertex, each from another source (front_distances.h). Only where a mesh has an
// edge of very many faces (crowded_edges.h) each source has a wave of its own, as in
// wavefront/wavefront.h. With Bound::upper each value is the length of a path on the surface,
// and never below the true distance but for rounding (1e-9 of it); without, it may be,
// by as little as it is above elsewhere. Never below the straight line in space. Never above the
// shortest way along edges, but for rounding: the front goes by doubles, and in the end each is
// as_float. `parents` stays empty.
//
// `near`, or null: where it has distances, from the same sources, these are taken.
//
// O(n log n) for n vertices and one source. From several, at most four times as many distances are
// computed, and each source looks over some thousand faces. Errors: cancelled, too_much_memory.
[[nodiscard]] Result<Field> back_traced_field(const Adjacency& adjacency,
                                              std::span<const Source> sources,
                                              const FieldLimits& limits, Bound bound,
                                              const Field* near, BackTracedScratch& scratch,
                                              const Cancel& cancel);

}  // namespace geodesic
