#include "server/reply_budget.h"

#include <algorithm>

namespace geodesic::server {

struct ReplyBudget::Account {
  std::mutex mutex;
  Stats stats;

  void give_back(std::uint64_t bytes) {
    const std::lock_guard lock(mutex);
    stats.bytes -= bytes;
  }
};

ReplyBudget::Share::~Share() { account_->give_back(bytes_); }

void ReplyBudget::Share::shrink(std::uint64_t bytes) {
  if (bytes >= bytes_) return;
  account_->give_back(bytes_ - bytes);
  bytes_ = bytes;
}

ReplyBudget::ReplyBudget(std::uint64_t bytes) : account_(std::make_shared<Account>()) {
  account_->stats.budget = bytes;
}

Result<std::shared_ptr<ReplyBudget::Share>> ReplyBudget::reserve(std::uint64_t bytes) {
  const std::lock_guard lock(account_->mutex);
  Stats& stats = account_->stats;
  if (bytes > stats.budget) {
    ++stats.refused;
    return fail_limit(ErrorCode::too_much_memory,
                      "this reply takes more memory than the server has for replies; ask for less, "
                      "or in a binary format",
                      stats.budget, bytes);
  }
  if (bytes > stats.budget - std::min(stats.budget, stats.bytes)) {
    ++stats.refused;
    return fail_limit(ErrorCode::overloaded, "other replies take the memory for replies now",
                      stats.budget, stats.bytes + bytes);
  }
  stats.bytes += bytes;
  return std::make_shared<Share>(account_, bytes);
}

void ReplyBudget::set_budget(std::uint64_t bytes) {
  const std::lock_guard lock(account_->mutex);
  account_->stats.budget = bytes;
}

ReplyBudget::Stats ReplyBudget::stats() const {
  const std::lock_guard lock(account_->mutex);
  return account_->stats;
}

}  // namespace geodesic::server
