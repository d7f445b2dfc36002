// Bodies of replies that are being sent to somebody. Whoever asks for the same body shares it,
// instead of getting another copy. Nothing is kept longer than it is used.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "server/http/reply_budget.h"

namespace geodesic::server {

// A body, and its reservation, which lasts as long as the body.
struct ChargedBody {
  std::string bytes;
  std::shared_ptr<ReplyBudget::Share> share;
};

// Any thread may call any method.
class BodiesInUse {
 public:
  // Null if nobody uses it.
  [[nodiscard]] std::shared_ptr<const ChargedBody> find(const std::string& key) const {
    const std::lock_guard lock(mutex_);
    const auto found = bodies_.find(key);
    return found == bodies_.end() ? nullptr : found->second.lock();
  }
  void add(const std::string& key, const std::shared_ptr<const ChargedBody>& body) {
    const std::lock_guard lock(mutex_);
    std::erase_if(bodies_, [](const auto& entry) { return entry.second.expired(); });
    bodies_[key] = body;
  }

 private:
  mutable std::mutex mutex_;
  std::map<std::string, std::weak_ptr<const ChargedBody>> bodies_;
};

}  // namespace geodesic::server
