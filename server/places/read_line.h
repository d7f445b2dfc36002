// What the field of one line is read at, and what it says there: the entries of a table's columns
// that are lines.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/field/field.h"
#include "core/surface/adjacency.h"
#include "server/places/line_columns.h"

namespace geodesic::server {

// A distance as it is told.
[[nodiscard]] inline double within(double max, double distance) {
  return distance <= max ? distance : kUnreached;
}

// Of one of the lines.
struct AskedOfLine {
  std::vector<std::uint32_t> at_vertices;  // rows that are points there
  std::vector<std::uint32_t> in_faces;     // and those that are elsewhere
  std::vector<const LineColumns::Line*> others;
  std::vector<std::uint32_t> faces;  // where details are needed: of all but the first

  [[nodiscard]] bool is_nothing() const { return at_vertices.empty() && faces.empty(); }
};

// Puts the line's distance from itself, too, if the table has it. Errors: cancelled,
// too_much_memory.
[[nodiscard]] Result<AskedOfLine> asked_of(const Adjacency& adjacency, LineColumns& lines,
                                           std::size_t number, const Cancel& cancel);

// Puts what the line's field says of all but vertices, as far as `max`. It has details in the faces
// that are asked for. Errors: cancelled, too_much_memory.
[[nodiscard]] Result<void> put_within(const Adjacency& adjacency, const Field& field, double max,
                                      const AskedOfLine& asked, const LineColumns::Line& line,
                                      LineColumns& lines, const Cancel& cancel);

}  // namespace geodesic::server
