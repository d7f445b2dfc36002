// A path as straight pieces between vertices, each within a strip of faces: the form
// in which it is shortened.
#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/cancel.h"
#include "core/paths/path.h"
#include "core/straighten/face_strip.h"
#include "core/straighten/vertex_fan.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"

namespace geodesic {

// A straight piece between two path vertices, within a strip of faces.
struct PathSegment {
  FaceStrip strip;
  std::vector<double> crossings;  // per portal, 0 at the tail of the halfedge `in`, 1 at its head
  double length = 0;
  DirectionAtVertex leaves;   // at the path vertex before, when that is a vertex
  DirectionAtVertex arrives;  // at the path vertex behind, looking back
};

// An end of the path, or a vertex that it goes through.
struct PathVertex {
  SurfacePoint place;
  bool is_changed = true;  // whether a segment next to it has changed since it was looked at
};

// Path vertices and the segments between them, path_vertices[i] before segments[i].
struct Chain {
  std::vector<PathVertex> path_vertices;
  std::vector<PathSegment> segments;

  // Moves a segment of another chain and the path vertex behind it to the end.
  void take(Chain& other, std::size_t segment) {
    segments.push_back(std::move(other.segments[segment]));
    path_vertices.push_back(other.path_vertices[segment + 1]);
  }
};

// The portal that a path takes at a point inside an edge, from the face `before` into that of the
// point. Nothing where the point is inside no edge, `before` is not at it, or the poll says to
// stop.
[[nodiscard]] std::optional<Portal> portal_at(const Adjacency& adjacency, std::uint32_t before,
                                              const SurfacePoint& point, Poll& poll);

// A path from `from` with the places in faces without width (line_gaps.h) that it has left out, as
// it does with points that are where the one before is: each point is in the face of the one
// before, unless no such faces lead there. Of no use if the poll says to stop.
[[nodiscard]] Path without_gaps(const Adjacency& adjacency, const SurfacePoint& from, Path path,
                                Poll& poll);

// Path segments from vertex to vertex of a path, as it goes: not straight, without
// crossings and length; with what it has left out in faces without width. Nothing when the path has
// no segment, or when two segments are in faces that do not meet in the point between them, or the
// poll says to stop.
[[nodiscard]] std::optional<Chain> read_chain(const Adjacency& adjacency, const Path& path,
                                              Poll& poll);

// The path along a chain that is straightened, with the source and the ends of `given`.
[[nodiscard]] Path write_path(const Adjacency& adjacency, const Chain& chain, const Path& given);

}  // namespace geodesic
