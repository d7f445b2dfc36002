// Exact geodesic distances by Chen and Han, "Shortest Paths on a Polyhedron", 1996,
// with the filter and the priority queue of Xin and Wang, "Improving Chen and Han's
// Algorithm on the Discrete Geodesic Problem", ACM Trans. Graph. 28(4), 2009.
//
// A window (an interval of an edge that one unfolded source sees straight) is passed from
// edge to edge. Where it meets the vertex opposite its edge it splits in two, but of
// all windows that meet the same corner through the same edge only the one nearest
// to the vertex may: "one angle, one split" (Chen and Han, section 3). Windows are
// not compared with each other along an edge, as they are in Mitchell, Mount and
// Papadimitriou's method; one that is not shorter than a way through a vertex is
// dropped (Xin and Wang, theorem 3.2). So the two methods check each other.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/chen_han/queue.h"
#include "core/chen_han/seen.h"
#include "core/chen_han/window.h"
#include "core/field/field.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// Memory that a query works in, kept for the next query on the same thread.
struct ChenHanScratch {
  // Of the window nearest to the vertex opposite a halfedge, among those that meet it
  // through that halfedge.
  struct Occupier {
    double distance;  // of the vertex
    double crossing;  // of the halfedge, from its first vertex
  };
  // A source that is not at a vertex, in one of its faces.
  struct Place {
    std::uint32_t face;
    std::uint32_t source;
    std::array<double, 3> bary;
  };
  chen_han::Queue queue;
  std::vector<Occupier> occupier;      // by halfedge
  std::vector<std::uint8_t> bends;     // by vertex: 0 not known yet, 1 no, 2 yes
  std::vector<double> waiting;         // by vertex: its latest key in the queue
  std::vector<std::uint8_t> accepted;  // by vertex: has come out of the queue
  std::vector<std::uint8_t> is_target;
  std::vector<std::uint8_t> source_in_face;  // by face; empty when all sources are vertices
  std::vector<Place> places;                 // ascending by face
  std::vector<std::uint32_t> same_as;        // by face: the first one with the same corners
  chen_han::SeenWindows seen;
};

// The distances from the nearest of the sources, exact up to rounding: each is the
// length of a path on the surface, and none is below the straight line in space. With keep_details,
// field.windows has every window that was passed on and is not known to be useless; the least over
// the windows into a face, its corners and the sources in it is exact at each of its points.
// With no source everything is unreached.
//
// O(n^2 log n) for n faces without non-manifold edges; far less on scanned meshes. Errors:
// cancelled, too_much_memory; too_large where windows become too many, as in a heap of faces
// (SeenWindows::is_overfull).
[[nodiscard]] Result<Field> chen_han_field(const Adjacency& adjacency,
                                           std::span<const Source> sources,
                                           const FieldLimits& limits, ChenHanScratch& scratch,
                                           const Cancel& cancel);

}  // namespace geodesic
