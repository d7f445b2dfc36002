// Those columns of a table that are lines: which fields tell their entries, and the entries.
//
// A distance is the same from either end. So a column that is a line takes one field, which starts
// there, however many rows there are: it is read at the rows. Of two lines, the field is that of
// the one whose key is less. So an entry is the same to the last bit wherever the two stand in a
// table, and whatever else is asked.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/surface/point.h"
#include "server/places/field_rows.h"

namespace geodesic::server {

class LineColumns {
 public:
  // A line that is a row, a column, or several of both.
  struct Line {
    const FieldRows* in;
    std::size_t number;                  // there
    const FieldRows::Outline* outline;   // which has its key
    std::vector<std::uint32_t> rows;     // that are this line
    std::vector<std::uint32_t> columns;  // likewise, counted among those that are lines
  };

  // Both with outlines. They are referred to until `let_go`.
  LineColumns(const FieldRows& rows, const FieldRows& columns);

  // Each once, by ascending keys.
  [[nodiscard]] const std::vector<Line>& lines() const { return lines_; }
  // Whether the field of `first` tells an entry of the two: the table has one, and the key of
  // `first` is not the greater.
  [[nodiscard]] bool is_told_by(std::size_t first, std::size_t other) const;
  // The rows that are points; each has an entry with each column.
  [[nodiscard]] std::span<const std::uint32_t> point_rows() const { return point_rows_; }
  [[nodiscard]] const SurfacePoint& point(std::uint32_t row) const {
    return rows_->point(row).point;
  }

  // Entries of lines, or of a line and a row that is a point. May be called for different ones at
  // once.
  void put(const Line& one, const Line& other, double distance);
  void put(const Line& column, std::uint32_t row, double distance);
  // The entries are there, and the lines not needed any more: from then on there are none.
  void let_go();

  // The columns that are points, in their order.
  [[nodiscard]] const std::vector<SurfacePoint>& points() const { return points_; }
  // All of a row, of which `at_points` has the columns that are points.
  [[nodiscard]] std::vector<double> whole_row(std::size_t row,
                                              std::span<const double> at_points) const;

 private:
  const FieldRows* rows_;
  std::vector<Line> lines_;
  std::vector<std::uint32_t> point_rows_;
  std::vector<SurfacePoint> points_;
  std::vector<bool> is_line_;  // by column
  std::size_t line_columns_ = 0;
  std::vector<double> entries_;  // row after row
};

}  // namespace geodesic::server
