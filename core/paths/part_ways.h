// Ways over a machine part whose field keeps windows, mostly of its refined surface
// (surface/refined_surface.h): how far a point of the mesh is, and which faces of the mesh the
// shortest path to it crosses. Between two places where it bends, a shortest path is straight
// whatever faces cut the surface up. So of each straight piece the windows tell how long it is,
// where it begins and in which direction; it is then walked over the mesh's own faces.
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

// One straight piece of a path within a face of the mesh, going back from the target: from the
// weights `start` to `end`.
struct WayLeg {
  std::uint32_t face;
  std::array<double, 3> start;
  std::array<double, 3> end;
};

class PartWays {
 public:
  // Of a field with `part_windows`. All must outlive this object. What is answered after the
  // poll says to stop is of no use.
  PartWays(const Adjacency& adjacency, const Field& field, Poll& poll);

  // Nothing where the refined surface does not know the point's place.
  [[nodiscard]] std::optional<double> distance_at(const SurfacePoint& point) const;

  struct Way {
    std::vector<WayLeg> legs;  // from the target to the source; none from a source to itself
    std::uint32_t source;
    double distance;  // of the target
  };
  // Nothing also where rounding, an edge of three faces, or a vertex round which faces are no fan
  // hides where a piece leads.
  [[nodiscard]] std::optional<Way> way_to(const SurfacePoint& target) const;

 private:
  // Straight back from a place: to a vertex of the mesh, or to a source.
  struct Piece {
    double distance = kUnreached;  // of the place
    Vec2 end;                      // in the plane that the place's face is laid into
    std::uint32_t vertex = kNone;
    std::uint32_t source = kNone;  // a source's number, unless it leads to a vertex
  };
  struct SourcePlace {
    std::uint32_t face;
    std::uint32_t source;
    std::array<double, 3> weights;
  };

  using Place = RefinedSurface::Place;
  [[nodiscard]] std::vector<Place> places_of(const SurfacePoint& point) const;
  // The shortest through one face of the windows' surface, to a place with those weights.
  [[nodiscard]] Piece piece_through(const UnfoldedTriangle& laid,
                                    const std::array<double, 3>& weights) const;
  // Where a piece ends: at a vertex, or at a source.
  struct Stop {
    std::uint32_t vertex = kNone;
    std::uint32_t source = kNone;
  };
  // A piece in the plane, and what is as good as on it.
  struct Line {
    Line(Vec2 start, const Piece& piece_of_way, double extent);
    [[nodiscard]] double left_of(Vec2 place) const;  // how far, in mesh units
    [[nodiscard]] int way_out_of(const UnfoldedTriangle& face) const;
    Vec2 from;
    Vec2 direction;  // of length one
    double length;
    double beside;
    const Piece& piece;
  };
  [[nodiscard]] std::optional<Stop> walk_from_point(const SurfacePoint& target, Way& way) const;
  [[nodiscard]] std::optional<Stop> walk_from_vertex(std::uint32_t v, Way& way) const;
  // Over the mesh's faces, from `from` in the first one.
  [[nodiscard]] std::optional<Stop> walk(UnfoldedTriangle face, Vec2 from,
                                         std::array<double, 3> start, const Piece& piece,
                                         std::vector<WayLeg>& legs) const;
  // The corner of the face.
  [[nodiscard]] std::optional<std::uint32_t> vertex_on(const Line& line,
                                                       const UnfoldedTriangle& face) const;
  // Its weights in the face.
  [[nodiscard]] std::optional<std::array<double, 3>> source_on(const Line& line,
                                                               const UnfoldedTriangle& face) const;
  [[nodiscard]] std::uint32_t source_at(std::uint32_t v) const;

  const Adjacency& adjacency_;
  const Field& field_;
  Poll& poll_;
  const WindowTable& windows_;
  const RefinedSurface* refined_;  // null where windows are those of the mesh's own faces
  Triangulation mesh_;
  Triangulation surface_;  // whose windows they are
  double extent_;
  std::vector<SourcePlace> source_places_;  // on the windows' surface
};

}  // namespace geodesic
