// Rows of one computation, handed out in their order while others are computed: what is large as
// a whole then takes only the memory of a few rows.
//
// They are computed in blocks by ComputePool::run_each, ahead of whoever takes them, but never
// more than two blocks. Who takes them slowly, because a client reads slowly, so holds no compute
// slot. The first block queues as any request does. The others are patient: a computation that has
// begun is not sent away for the queue's length.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "core/base/error.h"
#include "server/base/caller.h"
#include "server/compute/pool.h"

namespace geodesic::server {

class RowsAhead {
 public:
  // Makes the bytes of a row, in a slot: a part of `run_each`.
  using Compute =
      std::function<Result<std::string>(Worker&, std::size_t row, const GiveWay&, const Caller&)>;

  // Begins the first of `count` rows, in blocks of `block`, both at least 1. The pool must outlive
  // it. Errors: overloaded where no thread can be started.
  [[nodiscard]] static Result<std::unique_ptr<RowsAhead>> begin(ComputePool& pool,
                                                                std::size_t count,
                                                                std::size_t block, Compute compute,
                                                                Caller caller);
  // Ends what is being computed, and returns once it has ended.
  ~RowsAhead();
  RowsAhead(const RowsAhead&) = delete;
  RowsAhead& operator=(const RowsAhead&) = delete;

  // The next row; none after the last one. Blocks. Errors: those of `run_each`, once the rows that
  // are ready come to an end; `deadline` and `cancelled`, at once.
  [[nodiscard]] Result<std::optional<std::string>> next();

 private:
  RowsAhead(ComputePool& pool, std::size_t count, std::size_t block, Compute compute,
            Caller caller);
  void run();
  [[nodiscard]] Result<void> run_block(std::size_t begin, std::size_t end);
  void keep(std::size_t row, std::string bytes);

  ComputePool& pool_;
  const std::size_t count_;
  const std::size_t block_;
  const Compute compute_;
  const Caller caller_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::optional<std::string>> rows_;  // begun and not taken; none: not done
  std::size_t taken_ = 0;
  std::optional<Error> error_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace geodesic::server
