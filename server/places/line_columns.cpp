#include "server/places/line_columns.h"

#include <map>
#include <string_view>

#include "core/field/field.h"

namespace geodesic::server {

LineColumns::LineColumns(const FieldRows& rows, const FieldRows& columns) : rows_(&rows) {
  std::map<std::string_view, Line> by_key;
  const auto line_of = [&](const FieldRows& in, std::size_t number) -> Line& {
    const FieldRows::Outline* outline = in.outline(number);
    return by_key.try_emplace(outline->lines->key, Line{&in, number, outline, {}, {}})
        .first->second;
  };
  for (std::uint32_t row = 0; row < rows.size(); ++row) {
    if (rows.outline(row) == nullptr) {
      point_rows_.push_back(row);
    } else {
      line_of(rows, row).rows.push_back(row);
    }
  }
  for (std::uint32_t column = 0; column < columns.size(); ++column) {
    is_line_.push_back(columns.outline(column) != nullptr);
    if (is_line_.back()) {
      line_of(columns, column).columns.push_back(static_cast<std::uint32_t>(line_columns_++));
    } else {
      points_.push_back(columns.point(column).point);
    }
  }
  for (auto& [key, line] : by_key) lines_.push_back(std::move(line));
  entries_.assign(rows.size() * line_columns_, kUnreached);
}

bool LineColumns::is_told_by(std::size_t first, std::size_t other) const {
  const Line& a = lines_[first];
  const Line& b = lines_[other];
  return first <= other &&
         ((!a.rows.empty() && !b.columns.empty()) || (!b.rows.empty() && !a.columns.empty()));
}

void LineColumns::put(const Line& one, const Line& other, double distance) {
  for (const std::uint32_t row : one.rows) put(other, row, distance);
  for (const std::uint32_t row : other.rows) put(one, row, distance);
}

void LineColumns::put(const Line& column, std::uint32_t row, double distance) {
  for (const std::uint32_t place : column.columns) {
    entries_[std::size_t{row} * line_columns_ + place] = distance;
  }
}

void LineColumns::let_go() {
  lines_ = {};
  point_rows_ = {};
  rows_ = nullptr;
}

std::vector<double> LineColumns::whole_row(std::size_t row,
                                           std::span<const double> at_points) const {
  std::vector<double> whole;
  whole.reserve(is_line_.size());
  std::size_t next_line = row * line_columns_;
  std::size_t next_point = 0;
  for (const bool is_line : is_line_) {
    whole.push_back(is_line ? entries_[next_line++] : at_points[next_point++]);
  }
  return whole;
}

}  // namespace geodesic::server
