#include "server/reply/encode_rows.h"

#include <array>
#include <cstring>
#include <string_view>
#include <vector>

#include "proto/wire/array_formats.h"

namespace geodesic::server {
namespace {

using proto::Format;
using proto::NumberType;

// Of an entry in JSON: a distance, and in a sparse row its column.
constexpr std::uint64_t kTextOfEntry = 25 + 10;
// A point as a reply echoes it.
constexpr std::uint64_t kTextOfPoint = 300;
constexpr std::size_t kBytesOfSparseEntry = sizeof(std::uint32_t) + sizeof(double);

NumberType type_of_rows(Format format) {
  return format == Format::f32 ? NumberType::f32 : NumberType::f64;
}

}  // namespace

std::uint64_t bytes_of_row(const RowEncoding& encoding) {
  const std::uint64_t columns = encoding.table->columns.size();
  if (encoding.format.format == Format::lines) return columns * kTextOfEntry + kTextOfPoint;
  return columns * (type_of_rows(encoding.format.format) == NumberType::f32 ? 4 : 8);
}

std::uint64_t least_bytes_of_row(const RowEncoding& encoding) {
  if (encoding.format.format != Format::lines) return bytes_of_row(encoding);
  // A digit and a comma.
  return encoding.sparse ? 0 : 2 * encoding.table->columns.size();
}

std::uint64_t bytes_before_rows(const RowEncoding& encoding) {
  constexpr std::uint64_t kRest = 4096;
  const bool is_text = encoding.format.format == Format::lines;
  return is_text ? encoding.table->columns.size() * kTextOfPoint + kRest : kRest;
}

HttpResponse reply_before_rows(const RowEncoding& encoding, std::string& begin) {
  const proto::TableReply& table = *encoding.table;
  const Format format = encoding.format.format;
  const std::array<std::uint64_t, 2> shape{table.rows.size(), table.columns.size()};
  HttpResponse response;
  response.content_type = proto::media_type_of(format);
  const std::uint64_t last = encoding.first_row + shape[0] - 1;
  response.set_header("Geo-Rows", std::to_string(encoding.first_row) + "-" + std::to_string(last) +
                                      "/" + std::to_string(encoding.all_rows));
  if (table.estimated) {
    response.set_header("Geo-Estimated", proto::estimated_json(*table.estimated));
  }
  if (format == Format::lines) {
    begin = proto::first_line(table, encoding.first_row, encoding.format.precision);
    return response;
  }
  const std::string_view dtype = proto::dtype_of(type_of_rows(format));
  response.set_header("Geo-Dtype", std::string(dtype));
  response.set_header("Geo-Shape", std::to_string(shape[0]) + "," + std::to_string(shape[1]));
  if (format == Format::npy) begin = proto::npy_header(dtype, shape);
  return response;
}

Result<std::string> encode_row(const RowEncoding& encoding, std::size_t row,
                               std::span<const double> distances, const Cancel& cancel) {
  Poll poll(cancel);
  const Format format = encoding.format.format;
  std::string bytes =
      format == Format::lines
          ? proto::row_line(*encoding.table, row, encoding.first_row + row, distances,
                            encoding.sparse, encoding.format.precision, &poll)
      : format == Format::f32 ? proto::f32_bytes(distances, encoding.table->bound, &poll)
                              : proto::f64_bytes(distances, &poll);
  if (poll.stopped()) return fail_stopped(poll);
  return bytes;
}

Result<std::string> encode_sparse_row(std::span<const double> distances, const Cancel& cancel) {
  Poll poll(cancel);
  std::vector<std::uint32_t> columns;
  std::vector<double> reached;
  for (std::size_t i = 0; i < distances.size(); ++i) {
    if (poll.cancelled()) return fail_stopped(poll);
    if (distances[i] == kUnreached) continue;
    columns.push_back(static_cast<std::uint32_t>(i));
    reached.push_back(distances[i]);
  }
  std::string bytes = proto::u32_bytes(columns, &poll) + proto::f64_bytes(reached, &poll);
  if (poll.stopped()) return fail_stopped(poll);
  return bytes;
}

void append_sparse_row(proto::SparseEntries& entries, const std::string& row) {
  const std::size_t count = row.size() / kBytesOfSparseEntry;
  const std::size_t columns = count * sizeof(std::uint32_t);
  entries.columns.append(row, 0, columns);
  entries.distances.append(row, columns);
  entries.begins.push_back(static_cast<std::uint32_t>(entries.begins.back() + count));
}

}  // namespace geodesic::server
