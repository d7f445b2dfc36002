// What back_traced/wavefront.h works in.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "core/back_traced/crowded_edges.h"
#include "core/back_traced/front_distances.h"
#include "core/back_traced/visibility_cones.h"
#include "core/field/field.h"
#include "core/field/vertex_buckets.h"
#include "core/field/vertex_set.h"
#include "core/surface/face_record.h"

namespace geodesic {

// What a front knows of a vertex from one source, besides its distance. A quarter of a cache line.
struct FrontVertex {
  // By the paper's rule, of several sources with the offset; times -1 once it has its distance.
  double estimate = kUnreached;
  Halfedge base = kNone;  // opposite the vertex, what the estimate is over; or kNone:
                          // straight from the source
  float crossing = 0;     // where its way crosses that, as in arrive_lanes.h

  [[nodiscard]] bool is_accepted() const { return std::signbit(estimate); }
};

// An estimate for the vertex opposite its base.
struct FrontEstimate {
  double distance;
  Halfedge base;
  float crossing;
};

// What a part of a round's vertices is worked on in.
struct FrontRoom {
  struct Ask {
    std::uint32_t place;  // in the part
    double best;          // before it asked
  };

  std::vector<std::uint32_t> corners;
  std::vector<Halfedge> bases;
  // The source that each is about. Read only if there are several sources.
  std::vector<std::uint32_t> sources_of_corners;
  std::vector<std::uint32_t> sources_of_bases;
  std::vector<Ask> asks;  // which vertex of the part each of `bases` belongs to
};

// What a front knows of some of the vertices. On a cache line of its own.
struct alignas(64) FrontDomain {
  struct Late {
    Slot slot;
    std::uint32_t source;
    FrontEstimate estimate;
  };

  // What the front asks all domains between two steps. The first bucket that has any vertices, how
  // many, and the least of their estimates;
  std::uint64_t next = VertexBuckets::kNoBucket;
  std::size_t waiting_next = 0;
  double least = kUnreached;
  // how many are accepted together, and whether some of their bucket are not.
  std::size_t accepted = 0;
  bool has_left_early = false;

  alignas(64) VertexBuckets waiting;
  // The slots of those that are accepted together, and their distances.
  std::vector<Slot> round;
  std::vector<double> best;
  FrontRoom room;
  // By domain: estimates for its vertices, where there is one source.
  std::vector<std::vector<FrontEstimate>> handed_to;
  // For vertices that are visible from the source, which take a base from the least of a round.
  std::vector<Late> late;
};

// Memory that a query works in, kept for the next query on the same thread.
struct BackTracedScratch {
  std::vector<FrontVertex> vertices;  // by slot
  // Whether all of them are as constructed, as a finished query leaves them.
  bool is_clean = false;
  VertexSet visited;
  // Of several sources in one front, a distance a slot. Of a front for each source, those of the
  // one at hand, kUnreached between two. Of one source in several domains, the distances with those
  // of the round.
  std::vector<double> distance;
  SourceSlots slots;
  std::vector<std::uint8_t> is_target;
  std::vector<VisibilityCone> cones;
  CrowdedEdges crowds;
  std::vector<FrontDomain> domains;
};

}  // namespace geodesic
