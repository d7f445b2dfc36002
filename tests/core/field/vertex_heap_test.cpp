#include "core/field/vertex_heap.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <vector>

using geodesic::VertexHeap;

TEST_CASE("PopsInOrderWhateverWasLowered") {
  std::mt19937 random(1);
  VertexHeap heap;
  for (int round = 0; round < 50; ++round) {
    const std::uint32_t size = 1 + random() % 300;
    heap.reset(size);
    std::vector<double> key(size);
    for (std::uint32_t v = 0; v < size; ++v) {
      key[v] = random() % 1000;
      heap.push_or_lower(v, key[v]);
    }
    for (int i = 0; i < 500; ++i) {
      const std::uint32_t v = random() % size;
      key[v] -= random() % 100;
      heap.push_or_lower(v, key[v]);
    }
    std::vector<double> popped;
    while (!heap.empty()) {
      const VertexHeap::Entry entry = heap.pop();
      CHECK(entry.key == key[entry.vertex]);
      CHECK(heap.accepted(entry.vertex));
      popped.push_back(entry.key);
    }
    std::sort(key.begin(), key.end());
    CHECK(popped == key);
  }
}
