// The files that a report is made from: tables as CSV, arrays as bare little-endian
// numbers. Writing one that fails ends the process.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/vec3.h"
#include "core/field/field.h"
#include "core/mesh/triangle_soup.h"
#include "core/paths/path.h"
#include "core/surface/adjacency.h"

namespace geodesic::report {

// A table with named columns, one line a row.
class Table {
 public:
  Table(const std::filesystem::path& file, const std::vector<std::string>& columns);
  ~Table();
  Table(const Table&) = delete;
  Table& operator=(const Table&) = delete;

  // Cells of a row, as many as columns. Numbers have nine digits, integers all.
  class Cell {
   public:
    Cell(std::string_view text);  // NOLINT(google-explicit-constructor): rows read as lists
    Cell(const char* text) : Cell(std::string_view(text)) {}         // NOLINT
    Cell(const std::string& text) : Cell(std::string_view(text)) {}  // NOLINT
    Cell(double number);                                             // NOLINT
    Cell(std::size_t number) : text_(std::to_string(number)) {}      // NOLINT
    Cell(std::uint32_t number) : text_(std::to_string(number)) {}    // NOLINT
    Cell(int number) : text_(std::to_string(number)) {}              // NOLINT
    [[nodiscard]] const std::string& text() const { return text_; }

   private:
    std::string text_;
  };
  void row(const std::vector<Cell>& cells);

 private:
  std::filesystem::path file_;
  std::size_t columns_;
  std::ofstream out_;
};

// FOLDER/NAME.positions.f64 (n x 3) and FOLDER/NAME.faces.u32 (m x 3).
void write_surface(const std::filesystem::path& folder, const std::string& name,
                   const TriangleSoup& soup);
// FOLDER/NAME.f64, one number a source vertex.
void write_values(const std::filesystem::path& folder, const std::string& name,
                  std::span<const double> values);
// FOLDER/NAME.isolines.f64 (n x 3): the points of 24 isolines between zero and the
// greatest distance, with a row of NaN after each.
void write_isolines(const std::filesystem::path& folder, const std::string& name,
                    const Adjacency& adjacency, const Field& field);
// FOLDER/NAME.csv with the columns x, y and z, source first.
void write_path(const std::filesystem::path& folder, const std::string& name, const Path& path);

}  // namespace geodesic::report
