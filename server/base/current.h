// A value that many threads read while another replaces it as a whole: settings
// that a reload changes. Who has read one keeps it as it was.
//
// (A mutex, not std::atomic<std::shared_ptr>: libstdc++'s is a lock as well, and one
// that ThreadSanitizer does not understand.)
#pragma once

#include <memory>
#include <mutex>
#include <utility>

namespace geodesic::server {

template <class T>
class Current {
 public:
  explicit Current(T value) : value_(std::make_shared<const T>(std::move(value))) {}
  Current(const Current&) = delete;
  Current& operator=(const Current&) = delete;

  // The value of this moment; several of its members belong together only if they
  // are read through one pointer. Never null.
  [[nodiscard]] std::shared_ptr<const T> get() const {
    const std::lock_guard lock(mutex_);
    return value_;
  }
  [[nodiscard]] std::shared_ptr<const T> operator->() const { return get(); }

  void set(T value) {
    auto fresh = std::make_shared<const T>(std::move(value));
    const std::lock_guard lock(mutex_);
    value_.swap(fresh);
  }

 private:
  mutable std::mutex mutex_;
  std::shared_ptr<const T> value_;
};

}  // namespace geodesic::server
