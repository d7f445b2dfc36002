// An array that is filled by several threads at once: its memory is as the system gave it until
// then, so that each touches its own part first, which for large arrays takes as long as filling
// it.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>

#include "core/base/cancel.h"
#include "core/base/shared_array.h"

namespace geodesic {

template <class T>
class LargeArray {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);

 public:
  LargeArray() = default;
  // Empty when the poll says to stop, or does because the budget has no room for it.
  LargeArray(std::size_t size, Poll& poll) {
    if (poll.stopped() || !poll.may_take(size * sizeof(T))) return;
    memory_ = {std::allocator<T>().allocate(size), Deallocate{size}};
    size_ = size;
  }

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] T& operator[](std::size_t i) { return memory_.get()[i]; }
  [[nodiscard]] const T& operator[](std::size_t i) const { return memory_.get()[i]; }
  [[nodiscard]] std::span<T> all() { return {memory_.get(), size_}; }
  [[nodiscard]] std::span<const T> all() const { return {memory_.get(), size_}; }

  // The same memory, never to be changed again.
  [[nodiscard]] SharedArray<T> share() && {
    const std::shared_ptr<T[]> held = std::move(memory_);
    return {std::span<const T>(held.get(), std::exchange(size_, 0)), held};
  }

 private:
  struct Deallocate {
    std::size_t size = 0;
    void operator()(T* memory) const { std::allocator<T>().deallocate(memory, size); }
  };
  std::unique_ptr<T[], Deallocate> memory_;
  std::size_t size_ = 0;
};

}  // namespace geodesic
