// The JSON of tables: whole, sparse, and row after row.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "proto/replies/reply_json.h"

namespace geodesic::proto {
namespace {

template <class Number>
Number number_at(const std::string& bytes, std::uint64_t i) {
  Number number;
  std::memcpy(&number, bytes.data() + i * sizeof number, sizeof number);
  return number;
}

// The rest of a sparse table.
std::string with_sparse(std::string out, const TableReply& reply, int digits, Poll* poll) {
  const SparseEntries& sparse = *reply.sparse;
  out += ",\"indptr\":";
  append_wholes(out, sparse.begins, poll);
  out += ",\"indices\":[";
  for (std::uint64_t i = 0; i < sparse.count() && !is_stopped(poll); ++i) {
    if (i > 0) out += ',';
    out += std::to_string(number_at<std::uint32_t>(sparse.columns, i));
  }
  out += "],\"data\":[";
  // Without its distances, which then go another way, there are none.
  for (std::uint64_t i = 0; i * sizeof(double) < sparse.distances.size() && !is_stopped(poll);
       ++i) {
    if (i > 0) out += ',';
    append_distance(out, number_at<double>(sparse.distances, i), digits, reply.short_digits,
                    reply.bound);
  }
  out += ']';
  append_warnings(out, reply.warnings);
  out += '}';
  return out;
}

}  // namespace

std::string estimated_json(const Estimated& estimated) {
  constexpr int kDigits = 3;
  std::string out = "{\"landmarks\":" + std::to_string(estimated.landmarks);
  out += ",\"mean\":";
  append_number(out, estimated.mean, kDigits);
  out += ",\"percentile_99\":";
  append_number(out, estimated.percentile_99, kDigits);
  out += ",\"max\":";
  append_number(out, estimated.max, kDigits);
  out += ",\"entries\":" + std::to_string(estimated.entries) + "}";
  return out;
}

std::string first_line(const TableReply& reply, std::uint64_t first_row, int digits, Poll* poll) {
  std::string out = opening(reply.mesh);
  append_method(out, reply.method);
  out += ",\"first_row\":" + std::to_string(first_row);
  out += ",\"rows\":" + std::to_string(reply.rows.size());
  out += ",\"columns\":";
  append_points(out, reply.columns, digits, poll);
  if (reply.estimated) out += ",\"estimated\":" + estimated_json(*reply.estimated);
  append_warnings(out, reply.warnings);
  out += "}\n";
  return out;
}

std::string row_line(const TableReply& reply, std::size_t row, std::uint64_t number,
                     std::span<const double> distances, bool sparse, int digits, Poll* poll) {
  std::string out = "{\"row\":" + std::to_string(number) + ",\"from\":";
  append_point(out, reply.rows[row], digits);
  if (!sparse) {
    out += ",\"distances\":";
    append_distances(out, distances, digits, reply.short_digits, reply.bound, poll);
    out += "}\n";
    return out;
  }
  std::vector<double> reached;
  out += ",\"columns\":[";
  for (std::size_t i = 0; i < distances.size() && !is_stopped(poll); ++i) {
    if (distances[i] == kUnreached) continue;
    if (!reached.empty()) out += ',';
    out += std::to_string(i);
    reached.push_back(distances[i]);
  }
  out += "],\"distances\":";
  append_distances(out, reached, digits, reply.short_digits, reply.bound, poll);
  out += "}\n";
  return out;
}

std::string to_json(const TableReply& reply, int digits, Poll* poll) {
  std::string out = opening(reply.mesh);
  out.reserve(reply.distances.size() * 19 + 1024);
  append_method(out, reply.method);
  append_unit(out, reply.unit);
  out += ",\"rows\":";
  append_points(out, reply.rows, digits, poll);
  out += ",\"columns\":";
  append_points(out, reply.columns, digits, poll);
  if (reply.sparse) return with_sparse(std::move(out), reply, digits, poll);
  out += ",\"distances\":[";
  const std::span<const double> all(reply.distances);
  // Without its distances, which then go another way, there is no row.
  const std::size_t rows = all.empty() ? 0 : reply.rows.size();
  for (std::size_t row = 0; row < rows; ++row) {
    if (is_stopped(poll)) break;
    if (row > 0) out += ',';
    append_distances(out, all.subspan(row * reply.columns.size(), reply.columns.size()), digits,
                     reply.short_digits, reply.bound, poll);
  }
  out += ']';
  append_warnings(out, reply.warnings);
  out += '}';
  return out;
}

}  // namespace geodesic::proto
