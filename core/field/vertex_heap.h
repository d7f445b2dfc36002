// A min-heap of vertices (base/quaternary_heap.h) with positions, so that a vertex's key can be
// lowered in place. `tests/bench` measures it against the pairing heap of the paper.
//
// The heap keeps the state of every vertex in the same array as its position:
// far (never pushed), considered (in the heap) or accepted (popped).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/quaternary_heap.h"

namespace geodesic {

class VertexHeap {
 public:
  struct Entry {
    double key;
    std::uint32_t vertex;
  };

  // Forgets everything; all of `vertex_count` vertices are far. Keeps memory.
  void reset(std::size_t vertex_count) {
    position_.assign(vertex_count, kFar);
    entries_.clear();
  }

  [[nodiscard]] bool empty() const { return entries_.empty(); }
  [[nodiscard]] bool accepted(std::uint32_t vertex) const { return position_[vertex] == kAccepted; }
  // The entry that `pop` would remove. Not when empty.
  [[nodiscard]] const Entry& least() const { return entries_.front(); }
  // The entries left, in no useful order.
  [[nodiscard]] std::span<const Entry> entries() const { return entries_; }

  // Drops the entries left; their vertices are far again.
  void clear() {
    for (const Entry& entry : entries_) position_[entry.vertex] = kFar;
    entries_.clear();
  }
  // Takes an accepted vertex back, so that the next wave finds it far.
  void make_far(std::uint32_t vertex) { position_[vertex] = kFar; }

  // Inserts a far vertex, or lowers the key of a considered one. The vertex must
  // not be accepted, and `key` not above its present key.
  void push_or_lower(std::uint32_t vertex, double key) {
    std::size_t i = position_[vertex];
    if (i == kFar) {
      i = entries_.size();
      entries_.push_back({key, vertex});
    }
    sift_up(entries_, i, Entry{key, vertex}, KeepPosition{position_});
  }

  // Removes the vertex of the least key and marks it accepted. Not when empty.
  Entry pop() {
    const Entry top = entries_.front();
    position_[top.vertex] = kAccepted;
    const Entry last = entries_.back();
    entries_.pop_back();
    if (!entries_.empty()) sift_down(entries_, last, KeepPosition{position_});
    return top;
  }

 private:
  static constexpr std::uint32_t kFar = 0xffffffffU;
  static constexpr std::uint32_t kAccepted = 0xfffffffeU;

  // Is told of its entries' places by the heap.
  struct KeepPosition {
    std::vector<std::uint32_t>& position;
    void operator()(const Entry& entry, std::size_t i) const {
      position[entry.vertex] = static_cast<std::uint32_t>(i);
    }
  };

  std::vector<Entry> entries_;
  std::vector<std::uint32_t> position_;  // of each vertex in entries_, kFar or kAccepted
};

}  // namespace geodesic
