// From any path to a locally shortest one, after Martinez, Velho and Carvalho,
// "Computing geodesics on triangular meshes", Computers & Graphics 29, 2005: a path
// is shortest near each of its points when it is straight across faces and edges,
// and leaves an angle of at least pi on either side wherever it goes through a
// vertex (section 3). Where an angle is less, the path is moved over the vertex to
// that side.
//
// They correct one vertex at a time. Here the path is pulled straight within its
// whole strip of faces at once (funnel.h), which leaves vertices only where it bends
// round them; then it is moved over all of those that have a side below pi, by taking
// the fan of faces on that side instead (vertex_fan.h), and is pulled straight again.
#pragma once

#include <cstdint>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/paths/path.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// Faces unfolded, in sum over all changes; some twenty seconds. A path across the
// whole of a mesh of a million faces, from the shortest way along edges, takes some
// hundred thousand. Beyond this the path is handed back as far as it has got.
inline constexpr std::uint64_t kMostFacesUnfolded = 200'000'000;

// What a shortening took.
struct ShortenCounts {
  std::uint64_t rounds = 0;          // in which any vertex was crossed
  std::uint64_t crossings = 0;       // vertices passed over on the other side, tried ones included
  std::uint64_t faces_unfolded = 0;  // in sum
  bool locally_shortest = true;      // false when kMostFacesUnfolded was exceeded
};

// A locally shortest path between the ends of `path`, which may be any that
// path.h describes: along edges, through vertices, back and forth. It is the
// shortest of all that can be deformed into it near the given one, not the shortest
// of the surface.
//
// Both ends stay where they are, and so do points at which the path leaves a pinched
// vertex by faces that share no edge there with those it came by. The result is never
// longer than `path`; it is `path` itself when nothing is gained, or when two of its
// neighbouring segments are in faces that do not meet in the point between them.
// Errors: cancelled.
[[nodiscard]] Result<Path> shorten_path(const Adjacency& adjacency, const Path& path,
                                        const Cancel& cancel, ShortenCounts* counts = nullptr);

// The same without the second step: the path is pulled straight within the faces that it goes
// through, and by the lesser side round the vertices that it goes through, once.
[[nodiscard]] Result<Path> pull_straight(const Adjacency& adjacency, const Path& path,
                                         const Cancel& cancel);

}  // namespace geodesic
