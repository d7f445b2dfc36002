// `operator new` and `operator delete` that tell the computation of the thread, if one runs, what
// it takes (compute_memory.h). Linked into the program itself, not into its library: a test may
// have operators of its own.
#include <malloc.h>

#include <algorithm>
#include <cstdlib>
#include <new>

#include "server/compute_memory.h"

namespace geodesic::server {
namespace {

// Memory as `operator new` gives it, `alignment` 0: as malloc's.
void* allocate(std::size_t bytes, std::size_t alignment) {
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
    if (handler == nullptr) throw std::bad_alloc();
    handler();
  }
}

void give_back(void* memory) {
  JobMemory* const job = JobMemory::here();
  if (job != nullptr && memory != nullptr) job->freed(::malloc_usable_size(memory));
  std::free(memory);
}

}  // namespace
}  // namespace geodesic::server

// The standard's other forms call these.
void* operator new(std::size_t bytes) { return geodesic::server::allocate(bytes, 0); }
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return geodesic::server::allocate(bytes, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept { geodesic::server::give_back(memory); }
void operator delete(void* memory, std::size_t) noexcept { geodesic::server::give_back(memory); }
void operator delete(void* memory, std::align_val_t) noexcept {
  geodesic::server::give_back(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  geodesic::server::give_back(memory);
}
