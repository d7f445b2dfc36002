// Lines that a mesh has by itself: its boundary, and the borders of sets of faces.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/field/field.h"
#include "core/field/line_waves.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// Boundary edges in a row, each followed by the one at the other end of the fan of faces about
// their common vertex.
struct BoundaryLoop {
  std::vector<Halfedge> edges;
  double length = 0;      // mesh units
  bool is_closed = true;  // false where it ends at an edge of three faces or more
};

// The longest first, and of those as long the one with the lesser source vertex. As many as
// TopologyReport::boundary_loops. Of no use if the poll says to stop.
[[nodiscard]] std::vector<BoundaryLoop> boundary_loops(const Adjacency& adjacency, Poll& poll);

// What is told of one of them.
struct BoundarySize {
  double length = 0;  // mesh units
  std::uint64_t edges = 0;
  std::uint64_t vertex = 0;  // the least source vertex on it
  bool is_closed = true;
};

// The first `most` of boundary_loops, in memory for so many and one of the others at a time. Of no
// use if the poll says to stop.
[[nodiscard]] std::vector<BoundarySize> longest_boundaries(const Adjacency& adjacency,
                                                           std::size_t most, Poll& poll);

// Adds whole edges as lines of an item, and their ends as sources.
void add_edges(const Adjacency& adjacency, std::span<const Halfedge> edges, std::uint32_t item,
               SourceLines& lines, std::vector<Source>& sources, Poll& poll);

// Adds faces of an item: at no distance, with the edges between them and other faces as lines.
// `faces`: ascending. Of a face that two items have, the first has it.
void add_faces(const Adjacency& adjacency, std::span<const std::uint32_t> faces, std::uint32_t item,
               SourceLines& lines, std::vector<Source>& sources, Poll& poll);

// Removes repeated lines and sources; the first of each stays. Otherwise equal waves would cross
// the surface once each. A line is the same backwards, and in any face on its edge.
void merge_repeated(const Adjacency& adjacency, SourceLines& lines, std::vector<Source>& sources,
                    Poll& poll);

}  // namespace geodesic
