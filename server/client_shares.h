// What clients hold of something there is only so much of, so that none holds it all: who
// holds some gets more only while he holds no more than is left. A client alone gets half, a
// second one half of the rest, and so on; who comes for the first time finds something.
// Thread-safe.
#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <unordered_map>
#include <utility>

#include "core/error.h"

namespace geodesic::server {

class ClientShares {
 public:
  // `most` 0: no bound. `what` opens the sentence of a refusal, such as "replies wait".
  ClientShares(std::uint64_t most, std::string what) : most_(most), what_(std::move(what)) {}

  // Errors: `too_many_requests` for who has his share, `overloaded` if nothing is left.
  // Whoever would hold all there is, however much, may have it.
  [[nodiscard]] Result<void> take(const std::string& client, std::uint64_t amount) {
    const std::lock_guard lock(mutex_);
    const auto found = held_.find(client);
    const std::uint64_t own = found == held_.end() ? 0 : found->second;
    if (most_ != 0 && total_ != 0) {
      const std::uint64_t left = total_ < most_ ? most_ - total_ : 0;
      if (amount > left) return fail(ErrorCode::overloaded, "too many " + what_);
      if (own != 0 && own + amount > left) {
        return fail(ErrorCode::too_many_requests, "too many " + what_ + " of this client");
      }
    }
    held_[client] += amount;
    total_ += amount;
    return {};
  }

  void give_back(const std::string& client, std::uint64_t amount) {
    const std::lock_guard lock(mutex_);
    const auto found = held_.find(client);
    if (found == held_.end()) return;
    total_ -= amount;
    if ((found->second -= amount) == 0) held_.erase(found);
  }

 private:
  const std::uint64_t most_;
  const std::string what_;
  std::mutex mutex_;
  std::unordered_map<std::string, std::uint64_t> held_;  // none holds nothing
  std::uint64_t total_ = 0;
};

}  // namespace geodesic::server
