// A closed path that bends at its base alone, moved along the base's edge to where it is shortest.
#pragma once

#include <cstdint>
#include <optional>

#include "core/paths/path.h"
#include "core/straighten/path_chain.h"
#include "core/surface/adjacency.h"

namespace geodesic {

struct LoopSlide {
  Path path;                      // closed, with its base where it was moved to
  std::uint32_t touches = kNone;  // the vertex that ended the way; or it is straight at its base
};

// `loop` begins and ends at its base, a point inside an edge, and is straight everywhere else, with
// no vertex; `chain` is what read_chain makes of it. Nothing where it comes back to the base on the
// side by which it left: then the base is better moved off the edge. O(faces of the loop).
[[nodiscard]] std::optional<LoopSlide> slide_loop(const Adjacency& adjacency, const Path& loop,
                                                  const Chain& chain);

}  // namespace geodesic
