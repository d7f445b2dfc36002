// The priority queue of Xin and Wang 2009, section 3.3: windows by the least distance
// that they can give, and vertices at which paths may bend by their own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/quaternary_heap.h"
#include "core/chen_han/window.h"

namespace geodesic::chen_han {

class Queue {
 public:
  struct Next {
    double key;
    std::uint32_t vertex;  // kNone: a window
    Window window;         // of no meaning with a vertex
  };

  // Forgets everything; keeps memory.
  void clear() {
    entries_.clear();
    pool_.clear();
    free_.clear();
  }
  [[nodiscard]] bool empty() const { return entries_.empty(); }
  // Whether the next window makes it grow, and by how many bytes.
  [[nodiscard]] bool is_full() const { return free_.empty() && pool_.size() == pool_.capacity(); }
  [[nodiscard]] std::size_t bytes_to_grow() const {
    return 2 * pool_.capacity() * (sizeof(Window) + sizeof(Entry) + sizeof(std::uint64_t));
  }
  [[nodiscard]] double least_key() const { return entries_.front().key; }

  void push_window(double key, const Window& window) {
    std::uint64_t slot = pool_.size();
    if (free_.empty()) {
      pool_.push_back(window);
    } else {
      slot = free_.back();
      free_.pop_back();
      pool_[slot] = window;
    }
    push({key, slot});
  }
  void push_vertex(double key, std::uint32_t vertex) { push({key, kVertex | vertex}); }

  // Not when empty.
  Next pop() {
    const Entry top = entries_.front();
    const Entry last = entries_.back();
    entries_.pop_back();
    if (!entries_.empty()) sift_down(entries_, last, ignore_place);
    if ((top.what & kVertex) != 0) return {top.key, static_cast<std::uint32_t>(top.what), {}};
    free_.push_back(top.what);
    return {top.key, kNone, pool_[top.what]};
  }

 private:
  struct Entry {
    double key;
    std::uint64_t what;  // a slot of the pool, or kVertex and a vertex
  };
  static constexpr std::uint64_t kVertex = 1ULL << 63U;

  static void ignore_place(const Entry&, std::size_t) {}
  void push(const Entry& entry) {
    entries_.push_back(entry);
    sift_up(entries_, entries_.size() - 1, entry, ignore_place);
  }

  std::vector<Entry> entries_;  // a heap, base/quaternary_heap.h
  std::vector<Window> pool_;
  std::vector<std::uint64_t> free_;  // slots of the pool
};

}  // namespace geodesic::chen_han
