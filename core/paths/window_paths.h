// Distances of surface points, and shortest paths to them, from the windows that a field has kept
// on a machine part (Mitchell, Mount and Papadimitriou 1987). The windows belong to the mesh's own
// faces or to its refined surface (surface/refined_surface.h). A shortest path bends only at
// pseudo-sources. Between two of them it unfolds to a straight line in every triangulation of the
// same surface. The windows give each piece's length and direction; it is then traced over the
// mesh's own faces.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/vec2.h"
#include "core/field/field.h"
#include "core/field/window_table.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"
#include "core/surface/refined_surface.h"
#include "core/surface/walk_over_faces.h"

namespace geodesic {

// A straight piece of a path within a face of the mesh, as barycentric weights; `start` is the end
// nearer to the target.
struct WayLeg {
  std::uint32_t face;
  std::array<double, 3> start;
  std::array<double, 3> end;
};

class WindowPaths {
 public:
  // `field.kept_windows` is not null. All must outlive this object, of which threads may not share
  // one. What is answered after the poll says to stop is of no use.
  WindowPaths(const Adjacency& adjacency, const Field& field, Poll& poll);

  // Mesh units, the source's offset included. Exact up to what rounding to a float takes of
  // vertices' distances, if they are floats; kUnreached if no path leads there. Nothing where the
  // point has no place in the windows' triangulation: on a refined surface, where no corner of its
  // face has directions.
  [[nodiscard]] std::optional<double> distance_at(const SurfacePoint& point) const;

  struct Way {
    std::vector<WayLeg> legs;  // from the target to the source
    std::uint32_t source;
    double distance;  // of the target, as above
  };
  // Nothing if the target has no place or is not reached, if a piece meets the boundary or a
  // non-manifold edge or, on a refined surface, starts at a vertex without directions, or if
  // rounding hides where it leads: no proof that there is no path.
  [[nodiscard]] std::optional<Way> way_to(const SurfacePoint& target) const;

 private:
  // The last straight piece of the shortest path to a place, followed from there: to a
  // pseudo-source, or to a source.
  struct Piece {
    double distance = kUnreached;  // of the place
    Vec2 end;                      // in the plane that the place's face is unfolded into
    std::uint32_t vertex = kNone;
    std::uint32_t source = kNone;  // a source's number, if `vertex` is kNone
  };
  using Place = RefinedSurface::Place;
  [[nodiscard]] std::vector<Place> places_of(const SurfacePoint& point) const;
  // The shortest piece that comes to a place through this face, which is of the windows'
  // triangulation.
  [[nodiscard]] Piece piece_through(const UnfoldedTriangle& laid,
                                    const std::array<double, 3>& weights) const;
  // Where a piece ends: at a vertex, or at a source.
  struct Stop {
    std::uint32_t vertex = kNone;
    std::uint32_t source = kNone;
  };
  // A piece in the plane, with a tolerance.
  struct Line {
    Line(Vec2 start, const Piece& piece_of_way, double extent);
    // Positive to the left; mesh units.
    [[nodiscard]] double signed_offset(Vec2 place) const { return cross(direction, place - from); }
    // The side by which it leaves the face that has its start; -1 if rounding hides it.
    [[nodiscard]] int exit_side(const UnfoldedTriangle& face) const;
    Vec2 from;
    Vec2 direction;  // of length one
    double length;
    double tolerance;  // mesh units, to either side
    const Piece& piece;
  };
  [[nodiscard]] std::optional<Stop> walk_from_point(const SurfacePoint& target, Way& way) const;
  [[nodiscard]] std::optional<Stop> walk_from_vertex(std::uint32_t v, Way& way) const;
  // Over the mesh's faces, from `from` in the first one.
  [[nodiscard]] std::optional<Stop> walk(UnfoldedTriangle face, Vec2 from,
                                         std::array<double, 3> start, const Piece& piece,
                                         std::vector<WayLeg>& legs) const;
  [[nodiscard]] std::optional<Stop> stop_beside(const Line& line, const UnfoldedTriangle& face,
                                                const std::array<double, 3>& start,
                                                std::vector<WayLeg>& legs) const;
  // The first vertex of the mesh on the line, as a corner of the face.
  [[nodiscard]] std::optional<std::uint32_t> vertex_on(const Line& line,
                                                       const UnfoldedTriangle& face) const;
  // The source at the end of the piece, as weights in the face, if it is there.
  [[nodiscard]] std::optional<std::array<double, 3>> source_on(const Line& line,
                                                               const UnfoldedTriangle& face) const;
  [[nodiscard]] std::uint32_t source_at(std::uint32_t v) const;

  const Adjacency& adjacency_;
  const Field& field_;
  Poll& poll_;
  const WindowTable& windows_;
  const RefinedSurface* refined_;  // null where windows are those of the mesh's own faces
  Triangulation mesh_;
  Triangulation surface_;  // that the windows belong to
  double extent_;          // the diagonal of the bounding box, mesh units
  double same_;            // what rounding may take of a vertex's distance: a part of it
};

}  // namespace geodesic
