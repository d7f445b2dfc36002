#include "tests/bench/peak_memory.h"

#include <malloc.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <new>

// Plain variables: the programs that count have one thread of their own. Counting
// is off while times are taken, which then costs one test of a flag.
namespace {

bool counting = false;
std::int64_t held = 0;
std::int64_t most_held = 0;

// Nothing where there is no memory.
void* counted(void* memory) {
  if (memory != nullptr && counting) {
    held += static_cast<std::int64_t>(malloc_usable_size(memory));
    most_held = std::max(most_held, held);
  }
  return memory;
}

void* taken(std::size_t size) { return counted(std::malloc(std::max(size, std::size_t{1}))); }

void* taken(std::size_t size, std::align_val_t alignment) {
  const auto unit = static_cast<std::size_t>(alignment);
  return counted(std::aligned_alloc(unit, (std::max(size, unit) + unit - 1) / unit * unit));
}

void* or_throw(void* memory) {
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

void give_back(void* memory) {
  if (counting) held -= static_cast<std::int64_t>(malloc_usable_size(memory));
  std::free(memory);
}

}  // namespace

// The library's array forms call these. Its nothrow forms would, too, but not
// AddressSanitizer's.
void* operator new(std::size_t size) { return or_throw(taken(size)); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return or_throw(taken(size, alignment));
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept { return taken(size); }
void* operator new(std::size_t size, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  return taken(size, alignment);
}
void operator delete(void* memory) noexcept { give_back(memory); }
void operator delete(void* memory, std::size_t) noexcept { give_back(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { give_back(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { give_back(memory); }

namespace geodesic::bench {

std::size_t peak_bytes_of(const std::function<void()>& work) {
  held = 0;
  most_held = 0;
  counting = true;
  work();
  counting = false;
  return static_cast<std::size_t>(most_held);
}

}  // namespace geodesic::bench
