// The straight waves that leave source lines, on their way over the surface.
//
// Bommes and Kobbelt 2007, section 4, has linear windows beside the circular ones of Mitchell,
// Mount and Papadimitriou. Here they go first and alone: a distance is the least of two fields,
// that of the strips and that of points, which are the ends of the lines and the vertices where
// what a strip brings bends. So each method for points is one for lines.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/field.h"
#include "core/field/line_waves.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// A vertex that a strip has met: the length of the straight way there, and where that began.
struct MetVertex {
  std::uint32_t vertex;
  double distance;
  std::uint32_t item;
};

struct StripsOfLines {
  std::shared_ptr<LineWaves> waves;
  std::vector<MetVertex> met;  // ascending; none within a face that is a source
  bool is_complete = true;     // false: there were more strips than `most`
};

struct StripLimits {
  double max = kUnreached;  // as FieldLimits::max
  bool keep_strips = true;  // for points inside faces and for paths
  std::uint64_t most = std::numeric_limits<std::uint64_t>::max();  // strips that go over a face
  bool fail_beyond = false;  // too_large where there are more; else the strips so far
};

// Sends the strips of the lines over the surface, the nearest first. A strip is cut off
// where the way by an end vertex of the edge, and along the edge, is shorter, for no shortest path
// goes on there (Xin, Wang 2009, theorem 3.2). On a surface with edges of three faces and more,
// strips may meet that came from one: there a strip is also cut off where an earlier one is at
// least as near, or the way along the edge from an earlier one's end is shorter
// (strips_on_edges.h).
//
// `sources`: the points of the field, among them the ends of all segments. On a surface without
// such edges there are no more strips on an edge than vertices that the wave has passed. Errors:
// cancelled, too_much_memory, too_large (see StripLimits).
[[nodiscard]] Result<StripsOfLines> spread_strips(const Adjacency& adjacency,
                                                  std::span<const Source> sources,
                                                  std::shared_ptr<const SourceLines> lines,
                                                  const StripLimits& limits, const Cancel& cancel);

// Whether shortest paths may bend at a vertex: where its angles are more than 2 pi, on a boundary
// or an edge of three faces and more, and beside faces so thin that rounding decides.
[[nodiscard]] bool may_bend(const Adjacency& adjacency, std::uint32_t vertex, Poll& poll);

}  // namespace geodesic
