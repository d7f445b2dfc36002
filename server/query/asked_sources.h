// Which sources were asked about lately: who asks for one path from somewhere and comes
// again will come once more, as the mouse moves, and gets a field that is kept; who asks
// once does not need it.
#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <mutex>
#include <string>
#include <unordered_map>

namespace geodesic::server {

// Thread-safe.
class AskedSources {
 public:
  // Remembers so many, the latest.
  explicit AskedSources(std::size_t most) : most_(most) {}

  // Whether the question is new, and from now on it is not. (Two questions may be taken
  // for one, as by any hash: then a field is computed a little early.)
  [[nodiscard]] bool is_first(const std::string& question) {
    const std::size_t hash = std::hash<std::string>{}(question);
    const std::lock_guard lock(mutex_);
    const auto known = places_.find(hash);
    if (known != places_.end()) {
      latest_.splice(latest_.begin(), latest_, known->second);
      return false;
    }
    latest_.push_front(hash);
    places_.emplace(hash, latest_.begin());
    if (latest_.size() > most_) {
      places_.erase(latest_.back());
      latest_.pop_back();
    }
    return true;
  }

 private:
  const std::size_t most_;
  std::mutex mutex_;
  std::list<std::size_t> latest_;  // the latest first
  std::unordered_map<std::size_t, std::list<std::size_t>::iterator> places_;
};

}  // namespace geodesic::server
