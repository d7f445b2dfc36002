// The paper's queue against ours: the same wavefront must come out.
#include "tests/bench/pairing_heap.h"

#include <doctest/doctest.h>

#include <random>
#include <vector>

#include "core/mesh/shapes.h"
#include "tests/bench/queue_wave.h"
#include "tests/fixtures/surface.h"

using namespace geodesic;
using bench::PairingHeap;

TEST_CASE("PairingHeapPopsInTheOrderOfTheLowestKeys") {
  constexpr std::uint32_t kVertices = 500;
  std::mt19937 random(7);
  PairingHeap heap;
  heap.reset(kVertices);
  CHECK(heap.empty());
  std::vector<double> key(kVertices, kUnreached);
  // Pushes, lowerings and pops in one muddle; a popped vertex stays out.
  std::uint32_t popped = 0;
  double most = 0;
  const auto pop = [&] {
    const auto entry = heap.pop();
    CHECK(entry.key == key[entry.vertex]);
    CHECK(entry.key >= most);
    CHECK(heap.accepted(entry.vertex));
    for (std::uint32_t v = 0; v < kVertices; ++v) {
      if (!heap.accepted(v)) CHECK(key[v] >= entry.key);
    }
    most = entry.key;
    ++popped;
  };
  for (int step = 0; step < 5000; ++step) {
    const std::uint32_t v = random() % kVertices;
    const double k = most + random() % 1000;
    if (!heap.accepted(v) && k < key[v]) heap.push_or_lower(v, key[v] = k);
    if (step % 20 == 0 && !heap.empty()) pop();
  }
  while (!heap.empty()) pop();
  CHECK(popped == kVertices);
}

TEST_CASE("PairingHeapGivesTheSameField") {
  for (const TriangleSoup& soup : {shapes::terrain(60, 5, 2), shapes::icosphere(4)}) {
    const fixtures::Surface surface(soup);
    const Field field = surface.field_from(0);
    bench::QueueWave<PairingHeap> wave(surface.adjacency());
    wave.run(Source{surface.at(0), 0});
    REQUIRE(wave.distance().size() == field.distance.size());
    // Only ties may come in another order.
    for (std::size_t v = 0; v < field.distance.size(); ++v) {
      CHECK(wave.distance()[v] == doctest::Approx(field.distance[v]).epsilon(1e-9));
    }
  }
}
