#include "server/base/memory_trimmer.h"

#include <malloc.h>

#include "server/base/process_usage.h"

namespace geodesic::server {
namespace {

// Seconds of a processor. So much work may have freed much; so little is as good as none.
constexpr double kWork = 0.1;
constexpr double kIdle = 0.01;
// Bytes. A block of this size has pages of its own, which go back to the system when it is freed;
// to get them anew costs less than what is usually done with so large a block. A heap whose end is
// free for as much is cut off there.
constexpr int kLarge = 4 << 20;

}  // namespace

void trim_heaps() {
  // glibc sets up its heaps at the first call that any thread makes, and does not guard that: it
  // counts on a program that allocates before it starts threads. AddressSanitizer allocates
  // elsewhere, so that this may be the first call. Two first calls at once end the process.
  static std::once_flag first;
  std::call_once(first, [] { ::malloc_trim(0); });
  ::malloc_trim(0);
}

MemoryTrimmer::MemoryTrimmer(std::chrono::milliseconds interval) {
  (void)::mallopt(M_MMAP_THRESHOLD, kLarge);
  (void)::mallopt(M_TRIM_THRESHOLD, kLarge);
  thread_ = std::thread([this, interval] {
    std::unique_lock lock(mutex_);
    while (!wake_.wait_for(lock, interval, [&] { return stopping_; })) trim_if_worked();
  });
}

MemoryTrimmer::~MemoryTrimmer() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void MemoryTrimmer::trim_if_worked() {
  const double now = process_usage().cpu_seconds;
  const bool rests = now - looked_ < kIdle;
  looked_ = now;
  const double worked = now - trimmed_;
  // What little was done after the last trim may have freed a mesh: it is seen to at rest.
  if (worked < kWork && !(rests && worked >= kIdle)) return;
  trim_heaps();
  looked_ = trimmed_ = process_usage().cpu_seconds;  // the trim is no work
}

}  // namespace geodesic::server
