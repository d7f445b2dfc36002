// Large tables: their rows sent as they are done, or gathered where only what is near is kept.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "proto/wire/query_limits.h"
#include "server/compute/rows_ahead.h"
#include "server/reply/encode_rows.h"
#include "server/routes/routes.h"

namespace geodesic::server {
namespace {

// Rows in flight take about so much, unless single ones are larger.
constexpr std::uint64_t kBytesInFlight = std::uint64_t{8} << 20;

// Rows of a block, of which there are two at a time: some for each slot, so that few slots wait
// for the last row of a block.
std::size_t rows_at_once(std::uint64_t bytes_of_row, std::size_t slots) {
  constexpr std::size_t kRowsOfSlot = 16;
  const std::uint64_t fit = kBytesInFlight / 2 / std::max<std::uint64_t>(bytes_of_row, 1);
  return std::clamp<std::size_t>(fit, slots, kRowsOfSlot * slots);
}

// A table on its way.
struct RowsUnderWay {
  std::string begin;                     // of the body, with the first row
  std::shared_ptr<const void> reserved;  // for rows in flight
  std::shared_ptr<const void> held;      // for what is known of all rows before the first
  std::unique_ptr<RowsAhead> rows;       // all but the first
  std::optional<Error> error;            // what ended it before its end
};

}  // namespace

Result<std::shared_ptr<const void>> Routes::reserve_lines(const proto::TableRequest& request,
                                                          const Caller& caller) {
  const auto& columns = request.to.empty() ? request.from : request.to;
  const auto lines = std::count_if(columns.begin(), columns.end(),
                                   [](const auto& column) { return !column.is_point(); });
  if (lines == 0) return nullptr;
  auto reserved = reply_budget_.reserve(
      request.from.size() * static_cast<std::uint64_t>(lines) * sizeof(double), caller.client);
  if (!reserved) return fail(std::move(reserved.error()));
  return std::move(*reserved);
}

Result<HttpResponse> Routes::stream_rows(Answered<proto::TableReply> answer,
                                         const proto::TableRequest& request,
                                         const proto::ReplyFormat& format,
                                         std::shared_ptr<const void> held, const Caller& caller) {
  if (answer.before_rows) {
    auto reserved = reply_budget_.reserve(answer.bytes_before_rows, caller.client);
    if (!reserved) return fail(std::move(reserved.error()));
    held = std::move(*reserved);
    if (auto ready = answer.before_rows(answer.reply); !ready) {
      return fail(std::move(ready.error()));
    }
  }
  std::string warnings;
  for (const std::string& warning : answer.reply.warnings) {
    warnings += (warnings.empty() ? "" : "; ") + warning;
  }
  const RowEncoding encoding{std::make_shared<const proto::TableReply>(std::move(answer.reply)),
                             request.first_row, request.all_rows, request.sparse, format};
  const std::uint64_t row_bytes = bytes_of_row(encoding);
  const std::size_t block = rows_at_once(row_bytes, pool_.slots());
  auto reserved = reply_budget_.reserve(
      bytes_before_rows(encoding) + row_bytes * std::min(2 * block + 1, request.from.size()),
      caller.client);
  if (!reserved) return fail(std::move(reserved.error()));
  auto rows = answer.rows(
      [encoding](std::size_t row, std::span<const double> distances, const Cancel& cancel) {
        return encode_row(encoding, row, distances, cancel);
      },
      block);
  if (!rows) return fail(std::move(rows.error()));
  const auto table = std::make_shared<RowsUnderWay>();
  table->rows = std::move(*rows);
  table->reserved = std::move(*reserved);
  table->held = std::move(held);
  HttpResponse response = reply_before_rows(encoding, table->begin);
  response.stream_bytes = table->begin.size() + least_bytes_of_row(encoding) * request.from.size();
  // What fails before the first row has a status of its own.
  auto first = table->rows->next();
  if (!first) return fail(std::move(first.error()));
  table->begin += **first;
  response.set_header("Cache-Control", "no-store");
  if (!warnings.empty()) response.set_header("Geo-Warnings", warnings);
  response.broken = std::shared_ptr<const std::optional<Error>>(table, &table->error);
  response.stream = [table](std::string& chunk) {
    if (!table->begin.empty()) {
      chunk = std::exchange(table->begin, {});
      return true;
    }
    auto row = table->rows->next();
    if (!row) table->error = std::move(row.error());
    if (!row || !*row) return false;
    chunk = std::move(**row);
    return true;
  };
  return response;
}

Result<std::shared_ptr<const void>> Routes::collect_rows(Answered<proto::TableReply>& answer,
                                                         const Caller& caller) {
  // Asked for in steps, as the entries come; strings grow to twice what they hold.
  constexpr std::uint64_t kEntriesOfStep = 1'000'000;
  constexpr std::uint64_t kBytesOfEntry = 2 * 12;
  const auto held = std::make_shared<std::vector<std::shared_ptr<ReplyBudget::Share>>>();
  const std::uint64_t row_bytes = answer.reply.columns.size() * 12;
  const std::size_t block = rows_at_once(row_bytes, pool_.slots());
  auto under_way = reply_budget_.reserve(
      row_bytes * std::min<std::uint64_t>(2 * block + 1, answer.reply.rows.size()), caller.client);
  if (!under_way) return fail(std::move(under_way.error()));
  auto rows = answer.rows([](std::size_t, std::span<const double> distances,
                             const Cancel& cancel) { return encode_sparse_row(distances, cancel); },
                          block);
  if (!rows) return fail(std::move(rows.error()));
  proto::SparseEntries& entries = answer.reply.sparse.emplace();
  while (true) {
    auto row = (*rows)->next();
    if (!row) return fail(std::move(row.error()));
    if (!*row) return std::shared_ptr<const void>(held);
    const std::uint64_t count = entries.count() + (*row)->size() / 12;
    if (count > proto::kMaxSparseEntries) {
      return fail_limit(ErrorCode::too_large,
                        "so many distances are within `max`: ask for fewer rows at once, or for a "
                        "stream",
                        proto::kMaxSparseEntries, count, "max");
    }
    while (held->size() * kEntriesOfStep < count) {
      auto more = reply_budget_.reserve(kEntriesOfStep * kBytesOfEntry, caller.client);
      if (!more) return fail(std::move(more.error()));
      held->push_back(std::move(*more));
    }
    append_sparse_row(entries, **row);
  }
}

}  // namespace geodesic::server
