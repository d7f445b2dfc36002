// A solve allocates its result and little more, and nothing in its loop. By itself,
// because it counts all allocations of its process.
#include <doctest/doctest.h>

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

#include "core/mesh/shapes.h"
#include "tests/fixtures/surface.h"

namespace {

std::atomic<std::size_t> allocations{0};

}  // namespace

void* operator new(std::size_t size) {
  allocations.fetch_add(1, std::memory_order_relaxed);
  void* memory = std::malloc(size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

using namespace geodesic;

TEST_CASE("ASecondSolveAllocatesNoMoreOnALargerMesh") {
  for (const Method method :
       {Method::wavefront, Method::novotni, Method::fast_marching, Method::dijkstra,
        Method::steiner, Method::exact, Method::chen_han, Method::back_traced}) {
    CAPTURE(static_cast<int>(method));
    std::size_t on_smaller = 0;
    for (const std::uint32_t level : {3, 5}) {  // 642 and 10,242 vertices
      const fixtures::Surface surface(shapes::icosphere(level));
      const Source source{surface.at(7), 0};
      FieldLimits limits;
      limits.keep_details = false;
      SolveScratch scratch;
      std::size_t taken = 0;
      for (int round = 0; round < 2; ++round) {
        const std::size_t before = allocations;
        const auto field =
            solve_field(method, {}, surface.adjacency(), {&source, 1}, limits, scratch, Cancel());
        taken = allocations - before;
        REQUIRE(field);
      }
      if (level == 3) on_smaller = taken;
      CHECK(taken > 0);  // they are counted
      CHECK(taken <= on_smaller);
      CHECK(taken < 30);
    }
  }
}
