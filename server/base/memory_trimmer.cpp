#include "server/base/memory_trimmer.h"

#include <malloc.h>

#include "server/base/process_usage.h"

namespace geodesic::server {
namespace {

constexpr double kWork = 0.1;  // seconds of a processor, which may have freed much
// Bytes: of blocks that have pages of their own, which go back at once, and at a heap's end. To get
// pages anew costs less than what is usually done with so large a block.
constexpr int kLarge = 4 << 20;

}  // namespace

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
  if (now - cpu_seconds_ < kWork) return;
  ::malloc_trim(0);
  cpu_seconds_ = process_usage().cpu_seconds;  // the trim is no work
}

}  // namespace geodesic::server
