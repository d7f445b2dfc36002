// Shares of something that all clients together may hold only so much of. A client that holds
// some gets more only if it then holds no more than would be left without it: a client alone gets
// half, a second one half of the rest, and so on. So a client that comes for the first time finds
// something. Thread-safe.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>
#include <unordered_map>
#include <utility>

#include "core/base/error.h"
#include "server/base/service_codes.h"

namespace geodesic::server {

class ClientShares {
 public:
  // `most` 0: no bound. A refusal says "too many" and `what`, such as "replies wait".
  ClientShares(std::uint64_t most, std::string what) : most_(most), what_(std::move(what)) {}

  // `already`: held by what this is for, too, which gets as much as if it asked for both at once.
  // Errors: `too_many_requests` if the client has its share, `overloaded` if too little is left;
  // each with the bound and what would be held. Where nobody else holds any, any amount is given.
  [[nodiscard]] Result<void> take(const std::string& client, std::uint64_t amount,
                                  std::uint64_t already = 0) {
    const std::lock_guard lock(mutex_);
    const auto found = held_.find(client);
    const std::uint64_t own = (found == held_.end() ? 0 : found->second) - already;
    const std::uint64_t others = total_ - already;
    const std::uint64_t most = most_;
    if (most != 0 && others != 0) {
      const std::uint64_t left = others < most ? most - others : 0;
      if (already + amount > left) {
        return fail_limit(ServiceCode::overloaded, "too many " + what_, most, total_ + amount);
      }
      if (own != 0 && own + already + amount > left) {
        return fail_limit(ServiceCode::too_many_requests,
                          "too many " + what_ + ", and this client has its share of them", most,
                          total_ + amount);
      }
    }
    // What may throw comes first.
    std::uint64_t& held = found == held_.end() ? held_[client] : found->second;
    held += amount;
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

  // For what is taken from now on.
  void set_most(std::uint64_t most) { most_ = most; }
  [[nodiscard]] std::uint64_t most() const { return most_; }
  // Held by all clients now.
  [[nodiscard]] std::uint64_t total() const {
    const std::lock_guard lock(mutex_);
    return total_;
  }

 private:
  std::atomic<std::uint64_t> most_;
  const std::string what_;
  mutable std::mutex mutex_;
  std::unordered_map<std::string, std::uint64_t> held_;  // by client; none is 0
  std::uint64_t total_ = 0;
};

}  // namespace geodesic::server
