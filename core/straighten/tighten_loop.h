// From any closed path to a closed geodesic near it, as a rubber band would slip: straight across
// faces and edges, with an angle of at least pi on either side at each vertex, and that all round,
// for no point of it is held.
//
// Sharp and Crane, "You can find geodesic paths in triangle meshes by just flipping edges", 2020,
// section 3.4, shorten closed curves by the same rule as paths. Here the loop is cut at one point,
// its base, and shortened as a path from there to there (shorten_path.h); then the base moves:
//
// - to a vertex that the loop bends round. Where both of its sides have pi, all is straight.
// - Where there is no vertex, the loop runs in a band of faces which unfolds into the plane. Going
//   once round it is a motion of the plane, which takes the base's edge to its image, and of all
//   lines from a point of the edge to the image of that point, the shortest is known in closed
//   form. The loop slides toward that one, up to the first vertex in the way.
// - Otherwise, to about halfway round.
#pragma once

#include <cstdint>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/paths/path.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// Times that the base moves. With kMostFacesUnfolded, over all of them, it ends what makes ever
// smaller gains; the loop is handed back as far as it has got.
inline constexpr std::uint64_t kMostBases = 100'000;

struct TightLoop {
  Path path;                // closed: its last point is the first one
  std::uint64_t bases = 0;  // at which it was cut
  // False when one of the limits was exceeded, or it passes faces without area where it has no
  // sides.
  bool is_finished = true;
};

// `loop` ends where it begins. The result is the shortest of all loops that it can be deformed into
// near it, not the shortest of its kind, and is never longer than `loop`. It is `loop` itself where
// two of its neighbouring segments are in faces that do not meet in the point between them.
// Errors: no_loop (the loop contracts to a point); cancelled.
[[nodiscard]] Result<TightLoop> tighten_loop(const Adjacency& adjacency, const Path& loop,
                                             const Cancel& cancel);

}  // namespace geodesic
