// `operator new` and `operator delete` that count what the computation on the thread takes, if one
// runs (compute/memory.h). They are linked into the program itself, not into its library, because a
// test may have operators of its own.
#include <malloc.h>

#include <algorithm>
#include <cstdlib>
#include <new>

#include "server/compute/memory.h"

namespace geodesic::server {

// Allocates as `operator new` does. `alignment` 0: malloc's.
static void* allocate(std::size_t bytes, std::size_t alignment) {
  JobMemory* const job = JobMemory::here();
  if (job != nullptr && !job->may_allocate(bytes)) throw std::bad_alloc();
  for (;;) {
    void* memory = nullptr;
    if (alignment == 0) {
      memory = std::malloc(std::max<std::size_t>(bytes, 1));
    } else if (::posix_memalign(&memory, std::max(alignment, sizeof(void*)), bytes) != 0) {
      memory = nullptr;
    }
    if (memory != nullptr) {
      if (job != nullptr) job->allocated(::malloc_usable_size(memory));
      return memory;
    }
    const std::new_handler handler = std::get_new_handler();
    if (handler == nullptr) {
      if (job != nullptr) job->allocated(0);
      throw std::bad_alloc();
    }
    handler();
  }
}

static void* allocate_or_null(std::size_t bytes, std::size_t alignment) noexcept {
  try {
    return allocate(bytes, alignment);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

static void give_back(void* memory) {
  JobMemory* const job = JobMemory::here();
  if (job != nullptr && memory != nullptr) job->freed(::malloc_usable_size(memory));
  std::free(memory);
}

}  // namespace geodesic::server

// All of the standard's forms are here, because what one of them takes another may give back. A
// sanitizer's own forms would not count it.
using geodesic::server::allocate;
using geodesic::server::allocate_or_null;
using geodesic::server::give_back;

void* operator new(std::size_t bytes) { return allocate(bytes, 0); }
void* operator new[](std::size_t bytes) { return allocate(bytes, 0); }
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return allocate(bytes, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t bytes, std::align_val_t alignment) {
  return allocate(bytes, static_cast<std::size_t>(alignment));
}
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
  return allocate_or_null(bytes, 0);
}
void* operator new[](std::size_t bytes, const std::nothrow_t&) noexcept {
  return allocate_or_null(bytes, 0);
}
void* operator new(std::size_t bytes, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  return allocate_or_null(bytes, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t bytes, std::align_val_t alignment,
                     const std::nothrow_t&) noexcept {
  return allocate_or_null(bytes, static_cast<std::size_t>(alignment));
}

void operator delete(void* memory) noexcept { give_back(memory); }
void operator delete[](void* memory) noexcept { give_back(memory); }
void operator delete(void* memory, std::size_t) noexcept { give_back(memory); }
void operator delete[](void* memory, std::size_t) noexcept { give_back(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { give_back(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { give_back(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { give_back(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { give_back(memory); }
void operator delete(void* memory, const std::nothrow_t&) noexcept { give_back(memory); }
void operator delete[](void* memory, const std::nothrow_t&) noexcept { give_back(memory); }
void operator delete(void* memory, std::align_val_t, const std::nothrow_t&) noexcept {
  give_back(memory);
}
void operator delete[](void* memory, std::align_val_t, const std::nothrow_t&) noexcept {
  give_back(memory);
}
