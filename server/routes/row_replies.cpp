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
  std::string begin;                           // of the body, with the first row
  std::shared_ptr<ReplyBudget::Share> memory;  // for rows in flight, and what is known of all
  std::unique_ptr<RowsAhead> rows;             // all but the first
  std::optional<Error> error;                  // what ended it before its end
};

}  // namespace

Result<HttpResponse> Routes::stream_rows(Answered<proto::TableReply> answer,
                                         const proto::TableRequest& request,
                                         const proto::ReplyFormat& format,
                                         std::shared_ptr<ReplyBudget::Share> memory) {
  const auto reply = std::make_shared<proto::TableReply>(std::move(answer.reply));
  const RowEncoding encoding{reply, request.first_row, request.all_rows, request.sparse, format};
  const std::uint64_t row_bytes = bytes_of_row(encoding);
  const std::size_t block = rows_at_once(row_bytes, pool_.slots());
  auto reserved = memory->grow(answer.bytes_of_estimates + bytes_before_rows(encoding) +
                               row_bytes * std::min(2 * block + 1, request.from.size()));
  if (!reserved) return fail(std::move(reserved.error()));
  if (answer.before_rows) {
    if (auto ready = answer.before_rows(*reply); !ready) return fail(std::move(ready.error()));
  }
  std::string warnings;
  for (const std::string& warning : reply->warnings) {
    warnings += (warnings.empty() ? "" : "; ") + warning;
  }
  auto rows = answer.rows(
      [encoding](std::size_t row, std::span<const double> distances, const Cancel& cancel) {
        return encode_row(encoding, row, distances, cancel);
      },
      block);
  if (!rows) return fail(std::move(rows.error()));
  const auto table = std::make_shared<RowsUnderWay>();
  table->rows = std::move(*rows);
  table->memory = std::move(memory);
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

Result<void> Routes::collect_rows(Answered<proto::TableReply>& answer, ReplyBudget::Share& memory) {
  // Asked for in steps, as the entries come; strings grow to twice what they hold.
  constexpr std::uint64_t kEntriesOfStep = 1'000'000;
  constexpr std::uint64_t kBytesOfEntry = 2 * 12;
  const std::uint64_t row_bytes = answer.reply.columns.size() * 12;
  const std::size_t block = rows_at_once(row_bytes, pool_.slots());
  const std::uint64_t under_way =
      row_bytes * std::min<std::uint64_t>(2 * block + 1, answer.reply.rows.size());
  if (auto more = memory.grow(under_way); !more) return more;
  auto rows = answer.rows([](std::size_t, std::span<const double> distances,
                             const Cancel& cancel) { return encode_sparse_row(distances, cancel); },
                          block);
  if (!rows) return fail(std::move(rows.error()));
  proto::SparseEntries& entries = answer.reply.sparse.emplace();
  std::uint64_t room = 0;  // for so many
  while (true) {
    auto row = (*rows)->next();
    if (!row) return fail(std::move(row.error()));
    if (!*row) {
      memory.shrink(memory.bytes() - under_way);
      return {};
    }
    const std::uint64_t count = entries.count() + (*row)->size() / 12;
    if (count > proto::kMaxSparseEntries) {
      return fail_limit(ErrorCode::too_large,
                        "so many distances are within `max`: ask for fewer rows at once, or for a "
                        "stream",
                        proto::kMaxSparseEntries, count, "max");
    }
    for (; room < count; room += kEntriesOfStep) {
      if (auto more = memory.grow(kEntriesOfStep * kBytesOfEntry); !more) return more;
    }
    append_sparse_row(entries, **row);
  }
}

}  // namespace geodesic::server
