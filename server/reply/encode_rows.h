// Tables that go out row after row: what is before the rows, and each of them as bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "proto/replies/replies.h"
#include "proto/wire/reply_format.h"
#include "server/http/message.h"

namespace geodesic::server {

// How the rows of a table are written. The table has no distances; it is shared by all rows.
struct RowEncoding {
  std::shared_ptr<const proto::TableReply> table;
  std::uint64_t first_row = 0;  // of these rows in the whole table
  std::uint64_t all_rows = 0;   // of that
  bool sparse = false;
  proto::ReplyFormat format;
};

// Bytes of a row and of what is before the rows, at most.
[[nodiscard]] std::uint64_t bytes_of_row(const RowEncoding& encoding);
[[nodiscard]] std::uint64_t bytes_before_rows(const RowEncoding& encoding);
// Bytes of a row at least.
[[nodiscard]] std::uint64_t least_bytes_of_row(const RowEncoding& encoding);

// The reply without its rows: its head, and in `begin` what its body begins with.
[[nodiscard]] HttpResponse reply_before_rows(const RowEncoding& encoding, std::string& begin);

// One row. Errors: cancelled.
[[nodiscard]] Result<std::string> encode_row(const RowEncoding& encoding, std::size_t row,
                                             std::span<const double> distances,
                                             const Cancel& cancel);

// The row of a sparse table: the columns that are reached (uint32), then their distances (float64).
// Errors: cancelled.
[[nodiscard]] Result<std::string> encode_sparse_row(std::span<const double> distances,
                                                    const Cancel& cancel);
// Adds it to the others.
void append_sparse_row(proto::SparseEntries& entries, const std::string& row);

}  // namespace geodesic::server
