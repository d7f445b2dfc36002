#include "tests/paper/report/report_files.h"

#include <bit>
#include <cassert>
#include <cstdio>
#include <limits>

#include "core/paths/isolines.h"
#include "tests/bench/prepared.h"

namespace geodesic::report {
namespace {

static_assert(std::endian::native == std::endian::little, "arrays are little-endian");

[[noreturn]] void cannot_write(const std::filesystem::path& file) {
  bench::give_up("cannot write " + file.string());
}

template <class T>
void write_array(const std::filesystem::path& file, std::span<const T> values) {
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(values.data()),
            static_cast<std::streamsize>(values.size_bytes()));
  out.close();
  if (!out) cannot_write(file);
}

}  // namespace

Table::Cell::Cell(std::string_view text) : text_(text) {
  if (text_.find_first_of(",\"\n") == std::string::npos) return;
  std::string quoted = "\"";
  for (const char c : text_) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  text_ = quoted + '"';
}

Table::Cell::Cell(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", number);
  text_ = text;
}

Table::Table(const std::filesystem::path& file, const std::vector<std::string>& columns)
    : file_(file), columns_(columns.size()), out_(file) {
  row({columns.begin(), columns.end()});
}

Table::~Table() {
  out_.close();
  if (!out_) cannot_write(file_);
}

void Table::row(const std::vector<Cell>& cells) {
  assert(cells.size() == columns_);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    out_ << (i == 0 ? "" : ",") << cells[i].text();
  }
  out_ << '\n';
}

void write_surface(const std::filesystem::path& folder, const std::string& name,
                   const TriangleSoup& soup) {
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  write_array<Vec3>(folder / (name + ".positions.f64"), soup.positions);
  write_array<std::array<std::uint32_t, 3>>(folder / (name + ".faces.u32"), soup.faces);
}

void write_values(const std::filesystem::path& folder, const std::string& name,
                  std::span<const double> values) {
  write_array(folder / (name + ".f64"), values);
}

void write_isolines(const std::filesystem::path& folder, const std::string& name,
                    const Adjacency& adjacency, const Field& field) {
  constexpr int kLines = 24;
  constexpr std::uint64_t kMaxSegments = 10'000'000;
  std::vector<double> levels;
  for (int i = 1; i <= kLines; ++i) levels.push_back(field.max * i / (kLines + 1));
  const auto lines = isolines(adjacency, field, levels, kMaxSegments, Cancel());
  if (!lines) bench::give_up(name + ": " + lines.error().detail);
  constexpr double kBreak = std::numeric_limits<double>::quiet_NaN();
  std::vector<Vec3> points;
  for (const Isoline& line : *lines) {
    points.insert(points.end(), line.points.begin(), line.points.end());
    if (line.closed) points.push_back(line.points.front());
    points.push_back({kBreak, kBreak, kBreak});
  }
  write_array<Vec3>(folder / (name + ".isolines.f64"), points);
}

void write_path(const std::filesystem::path& folder, const std::string& name, const Path& path) {
  Table table(folder / (name + ".csv"), {"x", "y", "z"});
  for (const PathPoint& point : path.points) {
    table.row({point.position.x, point.position.y, point.position.z});
  }
}

}  // namespace geodesic::report
