// How near a field from lines comes to other lines: to all of them, not to points on them.
//
// In one face, what a field knows is ways that go on straight: from a corner, a source or a point
// on an edge, through a window (Mitchell, Mount, Papadimitriou 1987), in a strip, or from a line in
// the same face. How long each is, is convex along a straight segment. So its least is at an end of
// the segment, or at the foot of a perpendicular, and no search is needed.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/field/field.h"
#include "core/field/line_waves.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// The faces that the segments lie in or along, ascending and each once: a field keeps its windows
// there (FieldLimits::detail_faces). Of no use if the poll says to stop.
[[nodiscard]] std::vector<std::uint32_t> faces_of_lines(const Adjacency& adjacency,
                                                        std::span<const LineSegment> segments,
                                                        Poll& poll);

class FieldOnLines {
 public:
  // The field has lines, and details in the faces of what is asked about. All must outlive this.
  FieldOnLines(const Adjacency& adjacency, const Field& field, Poll& poll);

  // The least distance over the segments' interiors: their ends are to be asked for as points. As
  // right as the field is at points inside faces; never below the
  // length of a way, but for rounding. 0 where the segments meet the field's lines. kUnreached
  // where there is no way. Of no use if the poll says to stop.
  [[nodiscard]] double least(std::span<const LineSegment> segments) const;
  // Whether one of the faces is a source, or has a point of the field's lines: they may lie within
  // a set of faces, and far from its border.
  [[nodiscard]] bool meets(std::span<const std::uint32_t> faces) const;

 private:
  // A source that was given inside a face or on an edge, which has it once for all of its faces.
  struct PointSource {
    std::array<std::uint32_t, 2> place;  // the face and kNone, or the edge's vertices, ascending
    double offset;
    std::array<double, 3> weights;  // of the face's corners, or of these vertices
  };

  // A segment in one face, as the weights of its ends there.
  struct Piece {
    std::uint32_t face;
    std::array<double, 3> from;
    std::array<double, 3> to;
  };
  void lower_within(const Piece& piece, double& least) const;
  void lower_by_side(const Piece& piece, std::uint32_t c, double& least) const;
  // `corners`: those of the piece's face that the weights are of.
  void lower_by_sources(const Piece& piece, const std::array<std::uint32_t, 2>& place,
                        const std::array<std::uint32_t, 3>& corners, double& least) const;
  [[nodiscard]] bool crosses_a_line(const Piece& piece) const;

  const Adjacency& adjacency_;
  const Field& field_;
  Poll& poll_;
  std::vector<PointSource> sources_;   // ascending by place
  std::vector<std::uint32_t> around_;  // the faces that have points of the lines, ascending
};

}  // namespace geodesic
