// A distance field over the vertices of a mesh, and where each value came from.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "core/base/vec3.h"
#include "core/field/method.h"
#include "core/field/vertex_distances.h"
#include "core/mesh/mesh.h"
#include "core/surface/point.h"

namespace geodesic {

// A place where distances start, at `offset` instead of zero.
struct Source {
  SurfacePoint point;
  double offset = 0;  // mesh units, not negative
};

// What is too far out of the way to a target: no path to it that is no longer than
// `longest` leads through a point at which this is so, for no path is shorter than the
// straight line in space.
struct Detour {
  Vec3 target;
  double longest = std::numeric_limits<double>::infinity();  // mesh units, without offset

  [[nodiscard]] bool is_bounded() const { return longest < kUnreached; }

  [[nodiscard]] bool is_too_far(double distance, Vec3 place) const {
    return is_bounded() && distance + geodesic::distance(place, target) > longest;
  }
};

// How far a field goes, and what it keeps.
struct FieldLimits {
  // Distances above this are not computed: they read kUnreached.
  double max = std::numeric_limits<double>::infinity();
  // When not empty: stop once these vertices have their final distance. Vertices farther than all
  // of them read kUnreached, but up to `beyond_targets` by `steiner` and with `kept_windows`.
  std::span<const std::uint32_t> targets;
  // Windows, and points on edges, go on until they are final so much farther than the last of the
  // targets: a point inside a face may be farther than all of its corners, by up to the face's
  // longest side, and its shortest way may come after theirs. In units of the distance.
  double beyond_targets = 0;
  // Keep what paths and points inside faces need besides the vertices' distances:
  // the windows of an exact method, the points on edges of `steiner`.
  bool keep_details = true;
  // When not empty: `exact` keeps them of these faces alone, which takes little memory where
  // all of them would take much. Points in other faces, and paths there, then lack windows.
  // Within a tolerance they are kept of no others.
  std::span<const std::uint32_t> detail_faces;
  // Windows may be kept of the refined surface instead, as `kept_windows`, of all its faces: where
  // it has fewer, and where every direction over the mesh is one over it. For points and paths;
  // what asks Field::windows does without.
  bool may_keep_refined = false;
  // When bounded: fronts need not go on from vertices that are too far out of the way to
  // the targets. Others than these then read kUnreached, or more than their distance. For
  // `wavefront`, `novotni`, `dijkstra` and `back_traced`, from one source; others go
  // everywhere.
  Detour detour;
};

class WindowTable;      // window_table.h
struct SurfaceWindows;  // window_table.h
struct EdgePoints;      // edge_points.h
class LineWaves;        // line_waves.h

// The two vertices from which a vertex's distance was computed (Tang et al.
// 2007, section 3.3). Three special forms:
//   {kNone, kNone}    not reached;
//   {kNone, s}        straight from source number s, within one face;
//   {v, v}            along the edge from v.
struct Parents {
  std::uint32_t first = kNone;
  std::uint32_t second = kNone;

  [[nodiscard]] bool from_source() const { return first == kNone && second != kNone; }
  [[nodiscard]] bool along_edge() const { return first == second && first != kNone; }
};

// As in the paper, a vertex costs one number for its distance and two for its
// parents: 16 bytes. Without parents, and where floats will do for the distance: 4.
struct Field {
  Method method = Method::wavefront;
  Bound bound = Bound::none;  // of the distances, asked for by a bound or a tolerance
  std::vector<Source> sources;
  VertexDistances distance;  // mesh units; kUnreached where there is none
  // Per vertex, of the methods that compute one vertex from two others or from
  // one; empty for the rest.
  std::vector<Parents> parents;
  // Per vertex the number of the source that its distance is from, kNone where
  // there is none. Empty for a single source.
  std::vector<std::uint32_t> nearest_source;
  std::shared_ptr<const WindowTable> windows;  // of `exact` and `chen_han`, when kept
  // Of `back_traced` that goes by windows on a machine part, when kept; of `exact` and within a
  // tolerance, in place of `windows`, with FieldLimits::may_keep_refined.
  std::shared_ptr<const SurfaceWindows> kept_windows;
  std::shared_ptr<const EdgePoints> edge_points;  // of `steiner`, when kept
  // When lines or faces are sources, too: what leaves them straight. Each vertex that is nearest by
  // that is a source of its own then, with its distance as the offset.
  std::shared_ptr<const LineWaves> lines;
  std::uint64_t reached = 0;       // vertices with a distance
  double max = 0;                  // the greatest distance
  std::uint32_t farthest = kNone;  // the vertex that has it

  // Whether distances at two vertices that both have one are from the same source.
  [[nodiscard]] bool same_source(std::uint32_t a, std::uint32_t b) const {
    return nearest_source.empty() || nearest_source[a] == nearest_source[b];
  }

  // Which of the things that were asked for a source belongs to: itself, unless there are lines.
  [[nodiscard]] std::uint32_t item_of_source(std::uint32_t source) const;

  // What is farther than this is not reached.
  void forget_beyond(double farthest);

  // Fills `reached`, `max` and `farthest` from the distances.
  void count_reached();

  // Does forget_beyond(most) and count_reached(), looking at `among` alone: every vertex that has a
  // distance, each once.
  void keep_within(double most, std::span<const std::uint32_t> among);

  [[nodiscard]] std::size_t bytes() const;
};

}  // namespace geodesic
