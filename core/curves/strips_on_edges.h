// The strips that have come to each edge of a surface with edges of three faces and more.
//
// Sheets may meet along several lines in a row, as coincident faces do. At each line a wave enters
// all sheets, so the number of strips doubles from line to line. To stop that, an edge remembers
// its strips. Of strips that are as long as each other the first goes on; a longer one is cut off
// where it is longer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/cancel.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// A part of an edge over which a wave comes, and how far it is at both ends, in mesh units: between
// them it is linear.
struct StripOnEdge {
  double begin;
  double end;
  double at_begin;
  double at_end;
  [[nodiscard]] double at(double p) const {
    const double width = end - begin;
    return width > 0 ? at_begin + (at_end - at_begin) * ((p - begin) / width) : at_begin;
  }
  // The same, counted from the other end of an edge of that length.
  [[nodiscard]] StripOnEdge mirrored(double length) const {
    return {length - end, length - begin, at_end, at_begin};
  }
};

class StripsOnEdges {
 public:
  // Of no use if the poll says to stop.
  StripsOnEdges(const Adjacency& adjacency, Poll& poll);

  // Cuts the strip at both ends to the part that is nearer than earlier strips, and not farther
  // than the ways along the edge from their ends. Only the nearest earlier strips on either side
  // are compared. Remembers what is left. `into`: any halfedge of the edge; the strip is counted
  // from its tail. A part narrower than `least` counts as nothing. False if nothing is left, or if
  // the poll says to stop.
  [[nodiscard]] bool keep_nearer(Halfedge into, double length, double least, StripOnEdge& strip,
                                 Poll& poll);

 private:
  struct Part {
    double begin;
    double end;
  };

  // Adds where a way that is linear in that part of the edge is no farther than the strip.
  template <class Way>
  void cover(const StripOnEdge& strip, Part part, const Way& way);

  const Adjacency& adjacency_;
  std::vector<std::uint32_t> list_of_;  // by an edge's first halfedge: which of the lists, or kNone
  // From the tail of the edge's first halfedge, by their beginnings.
  std::vector<std::vector<StripOnEdge>> lists_;
  std::vector<Part> covered_;  // of the strip in hand
};

}  // namespace geodesic
