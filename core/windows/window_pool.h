// Memory for the edges' lists of windows: blocks of 1, 2, 3, 4, 6, 8, 12, ... windows from
// large slabs. A released block waits for the next list of its size; nothing goes
// back to the system before the pool does, except blocks too large for a slab. The budget is
// asked for slabs a few ahead: what it refuses, the computation learns when it polls next.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "core/base/cancel.h"
#include "core/windows/window.h"

namespace geodesic::exact {

class WindowPool {
 public:
  // The number of windows that a block for `size` of them holds.
  [[nodiscard]] static std::uint32_t capacity_for(std::size_t size) {
    const auto power = static_cast<std::uint32_t>(std::bit_ceil(size));
    const std::uint32_t three_quarters = power / 4 * 3;
    return size <= three_quarters ? three_quarters : power;
  }

  // A block of `capacity` windows, a value of capacity_for; not initialised.
  [[nodiscard]] Window* take(std::uint32_t capacity, Poll& poll) {
    if (capacity > kSlab) {
      (void)poll.may_take(std::size_t{capacity} * sizeof(Window));
      auto block = std::make_unique_for_overwrite<Window[]>(capacity);
      large_bytes_ += std::size_t{capacity} * sizeof(Window);
      Window* windows = block.get();
      large_.emplace(windows, std::move(block));
      return windows;
    }
    std::vector<Window*>& waiting = waiting_[class_of(capacity)];
    if (!waiting.empty()) {
      Window* block = waiting.back();
      waiting.pop_back();
      return block;
    }
    if (left_ < capacity) new_slab(poll);
    Window* block = slabs_[slab_ - 1].get() + (kSlab - left_);
    left_ -= capacity;
    return block;
  }

  void give_back(Window* block, std::uint32_t capacity) {
    if (capacity > kSlab) {
      large_.erase(block);
      large_bytes_ -= std::size_t{capacity} * sizeof(Window);
    } else if (capacity > 0) {
      waiting_[class_of(capacity)].push_back(block);
    }
  }

  // Of what the blocks handed out since the last reset have needed at once.
  [[nodiscard]] std::size_t bytes() const { return slab_ * kSlab * sizeof(Window) + large_bytes_; }

  // Slabs for what may soon be asked for, so that the computing thread takes them and not one that
  // helps it, whose memory is asked for afterwards. Of one pool of so many.
  void make_ready(std::size_t pools, Poll& poll) {
    const std::size_t ahead = std::max<std::size_t>(2, kSlabsAhead / pools);
    if (slabs_.size() - slab_ >= ahead / 2) return;
    if (!poll.may_take(ahead * kSlab * sizeof(Window))) return;
    for (std::size_t i = 0; i < ahead; ++i) {
      slabs_.push_back(std::make_unique_for_overwrite<Window[]>(kSlab));
    }
  }

  // Every block is free again. Keeps the first slabs for the next query, of one pool of so many,
  // and gives the rest back to the system, unless the poll says to stop: hundreds of megabytes take
  // it longer than a cancelled query may.
  void reset(Poll& poll, std::size_t pools) {
    for (std::vector<Window*>& waiting : waiting_) waiting.clear();
    large_.clear();
    large_bytes_ = 0;
    slab_ = 0;
    left_ = 0;
    while (slabs_.size() * pools > kKeptSlabs && !poll.ask()) slabs_.pop_back();
  }

 private:
  static constexpr std::uint32_t kSlab = 4096;   // a quarter of a megabyte
  static constexpr std::size_t kKeptSlabs = 64;  // 16 MB
  static constexpr std::size_t kClasses = 26;    // up to a slab
  static constexpr std::size_t kSlabsAhead = 16;

  [[nodiscard]] static std::size_t class_of(std::uint32_t capacity) {
    const auto power = static_cast<std::size_t>(std::bit_width(capacity)) - 1;
    // Not std::has_single_bit: without the instruction for it, that is a call.
    const std::uint32_t is_between = (capacity & (capacity - 1)) == 0 ? 0 : 1;
    return (2 * power + is_between) % kClasses;
  }

  // What is left of the old slab is cut into blocks.
  void new_slab(Poll& poll) {
    while (left_ > 0) {
      const std::uint32_t capacity = std::bit_floor(left_);
      waiting_[class_of(capacity)].push_back(slabs_[slab_ - 1].get() + (kSlab - left_));
      left_ -= capacity;
    }
    if (slab_ == slabs_.size()) {
      (void)poll.may_take(kSlabsAhead * kSlab * sizeof(Window));
      slabs_.push_back(std::make_unique_for_overwrite<Window[]>(kSlab));
    }
    ++slab_;
    left_ = kSlab;
  }

  std::vector<std::unique_ptr<Window[]>> slabs_;
  std::size_t slab_ = 0;    // slabs in use
  std::uint32_t left_ = 0;  // windows never handed out in the last of them
  std::array<std::vector<Window*>, kClasses> waiting_;  // by the capacity
  std::unordered_map<const Window*, std::unique_ptr<Window[]>> large_;
  std::size_t large_bytes_ = 0;
};

}  // namespace geodesic::exact
