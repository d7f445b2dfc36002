// A path as straight pieces between vertices, each within a strip of faces: the form
// in which it is shortened.
#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/cancel.h"
#include "core/paths/trace_path.h"
#include "core/straighten/face_strip.h"
#include "core/straighten/vertex_fan.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"

namespace geodesic {

// A straight piece between two knots, within a strip of faces.
struct Section {
  FaceStrip strip;
  std::vector<double> crossings;  // per gate, 0 at the tail of the halfedge `in`, 1 at its head
  double length = 0;
  DirectionAtVertex leaves;   // at the knot before, when that is a vertex
  DirectionAtVertex arrives;  // at the knot behind, looking back
};

// An end of the path, or a vertex that it goes through.
struct Knot {
  SurfacePoint place;
  bool unsettled = true;  // whether a section next to it has changed since it was looked at
};

// Knots and the sections between them, knots[i] before sections[i].
struct Chain {
  std::vector<Knot> knots;
  std::vector<Section> sections;

  // Moves a section of another chain and the knot behind it to the end.
  void take(Chain& other, std::size_t section) {
    sections.push_back(std::move(other.sections[section]));
    knots.push_back(other.knots[section + 1]);
  }
};

// Sections from vertex to vertex of a path, as it goes: not straight, without
// crossings and length. Nothing when the path has no segment, or when two segments
// are in faces that do not meet in the point between them, or the poll says to stop.
[[nodiscard]] std::optional<Chain> read_chain(const Adjacency& adjacency, const Path& path,
                                              Poll& poll);

// The path along a chain that is straightened, with the source and the ends of `given`.
[[nodiscard]] Path write_path(const Adjacency& adjacency, const Chain& chain, const Path& given);

}  // namespace geodesic
