// A min-heap with four children to a node, in a vector: half as deep as a binary heap, and the keys
// of the children share a cache line.
//
// An entry has a `key`, compared by <. `placed(entry, i)` is told of every entry that comes to lie
// at i, so that who needs to find entries again can keep their places.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace geodesic {

inline constexpr std::size_t kHeapArity = 4;

// Puts `entry` at i, or above where keys are greater. What lies at i is written over.
template <class Entry, class Placed>
void sift_up(std::vector<Entry>& heap, std::size_t i, Entry entry, Placed placed) {
  while (i > 0) {
    const std::size_t parent = (i - 1) / kHeapArity;
    if (heap[parent].key <= entry.key) break;
    heap[i] = heap[parent];
    placed(heap[i], i);
    i = parent;
  }
  heap[i] = entry;
  placed(entry, i);
}

// Puts `entry` at the root, or below where keys are less. The root is written over.
template <class Entry, class Placed>
void sift_down(std::vector<Entry>& heap, Entry entry, Placed placed) {
  const std::size_t size = heap.size();
  std::size_t i = 0;
  for (std::size_t first = 1; first < size; first = kHeapArity * i + 1) {
    std::size_t least = first;
    const std::size_t end = std::min(first + kHeapArity, size);
    for (std::size_t child = first + 1; child < end; ++child) {
      if (heap[child].key < heap[least].key) least = child;
    }
    if (heap[least].key >= entry.key) break;
    heap[i] = heap[least];
    placed(heap[i], i);
    i = least;
  }
  heap[i] = entry;
  placed(entry, i);
}

}  // namespace geodesic
