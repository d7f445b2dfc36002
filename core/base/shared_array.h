// An array that never changes, with whatever holds its memory: a vector, or a file that is mapped.
// Copies share it.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace geodesic {

template <class T>
class SharedArray {
 public:
  SharedArray() = default;
  // No moves: the source would keep a span of memory that it no longer holds.
  SharedArray(const SharedArray&) = default;
  SharedArray& operator=(const SharedArray&) = default;
  ~SharedArray() = default;
  explicit SharedArray(std::vector<T> values) {
    auto held = std::make_shared<const std::vector<T>>(std::move(values));
    bytes_ = held->capacity() * sizeof(T);
    values_ = *held;
    holder_ = std::move(held);
  }
  // Values that are there as long as `holder` is.
  SharedArray(std::span<const T> values, std::shared_ptr<const void> holder)
      : values_(values), holder_(std::move(holder)), bytes_(values.size_bytes()) {}

  // NOLINTNEXTLINE(google-explicit-constructor): it is a span, with who holds the memory
  operator std::span<const T>() const { return values_; }
  [[nodiscard]] const T& operator[](std::size_t i) const { return values_[i]; }
  [[nodiscard]] const T* data() const { return values_.data(); }
  [[nodiscard]] std::size_t size() const { return values_.size(); }
  [[nodiscard]] bool empty() const { return values_.empty(); }
  [[nodiscard]] auto begin() const { return values_.begin(); }
  [[nodiscard]] auto end() const { return values_.end(); }

  // Memory taken, mapped or not.
  [[nodiscard]] std::size_t bytes() const { return bytes_; }

 private:
  std::span<const T> values_;
  std::shared_ptr<const void> holder_;
  std::size_t bytes_ = 0;
};

}  // namespace geodesic
