#include "server/compute/rows_ahead.h"

#include <algorithm>
#include <chrono>
#include <new>
#include <system_error>
#include <utility>

#include "server/base/joint_caller.h"
#include "server/base/service_codes.h"

namespace geodesic::server {
namespace {

// How often whoever waits for a row asks whether it is still wanted.
constexpr std::chrono::milliseconds kAskForRowsEvery{20};

}  // namespace

Result<std::unique_ptr<RowsAhead>> RowsAhead::begin(ComputePool& pool, std::size_t count,
                                                    std::size_t block, Compute compute,
                                                    Caller caller) {
  // The times of a request are told with its head, before most rows.
  caller.times = nullptr;
  std::unique_ptr<RowsAhead> rows(
      new RowsAhead(pool, count, block, std::move(compute), std::move(caller)));
  try {
    rows->thread_ = std::thread([ahead = rows.get()] { ahead->run(); });
  } catch (const std::system_error&) {
    return fail(ServiceCode::overloaded, "no thread can be started for the rows");
  }
  return rows;
}

RowsAhead::RowsAhead(ComputePool& pool, std::size_t count, std::size_t block, Compute compute,
                     Caller caller)
    : pool_(pool),
      count_(count),
      block_(block),
      compute_(std::move(compute)),
      caller_(std::move(caller)) {}

RowsAhead::~RowsAhead() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

Result<std::optional<std::string>> RowsAhead::next() {
  std::unique_lock lock(mutex_);
  while (taken_ < count_) {
    if (caller_()) return fail(caller_.why_stopped());
    if (!rows_.empty() && rows_.front()) {
      std::optional<std::string> row = std::move(rows_.front());
      rows_.pop_front();
      ++taken_;
      changed_.notify_all();
      return row;
    }
    if (error_) return fail(*error_);
    changed_.wait_for(lock, kAskForRowsEvery);
  }
  return std::optional<std::string>();
}

void RowsAhead::keep(std::size_t row, std::string bytes) {
  const std::lock_guard lock(mutex_);
  rows_[row - taken_] = std::move(bytes);
  changed_.notify_all();
}

// Its own thread.
void RowsAhead::run() {
  for (std::size_t begin = 0; begin < count_; begin += block_) {
    const std::size_t end = std::min(begin + block_, count_);
    Result<void> done;
    try {
      {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return stopping_ || begin - taken_ <= block_; });
        if (stopping_) return;
        rows_.resize(end - taken_);
      }
      done = run_block(begin, end);
    } catch (const std::bad_alloc&) {
      done = fail(ServiceCode::overloaded, "out of memory");
    }
    if (done) continue;
    const std::lock_guard lock(mutex_);
    error_ = std::move(done.error());
    changed_.notify_all();
    return;
  }
}

Result<void> RowsAhead::run_block(std::size_t begin, std::size_t end) {
  const auto all = static_cast<double>(count_);
  Caller caller = caller_.part(static_cast<double>(begin) / all, static_cast<double>(end) / all);
  caller.gone = [this] { return stopping_ || (caller_.gone && caller_.gone()); };
  caller.is_patient = caller.is_patient || begin > 0;
  JointCaller joint(caller, end - begin);
  return pool_.run_each(
      end - begin,
      [&](Worker& worker, std::size_t i, const GiveWay& give_way) -> Result<void> {
        JointCaller::Part part(joint, i);
        auto row = compute_(worker, begin + i, give_way, part.caller());
        if (!row) return fail(std::move(row.error()));
        keep(begin + i, std::move(*row));
        part.done(false);
        return {};
      },
      caller);
}

}  // namespace geodesic::server
