// Memory that the C library keeps for later is given back to the system.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace geodesic::server {

// Returns to the system the whole pages that the C library keeps. Any thread may call it.
void trim_heaps();

// The C library has a heap for each few threads, and keeps what has been freed there:
//   - at a heap's end up to 64 MB, for the bound on that grows with the largest block that was ever
//     freed. Here it is a few MB and stays so (mallopt);
//   - between what is still in use all of it. trim_heaps returns whole pages of that. It is worth
//     its time only where the process has worked, and once more when it has come to rest.
// After minutes of requests by many threads, it was several hundred MB for 12 MB in use.
class MemoryTrimmer {
 public:
  explicit MemoryTrimmer(std::chrono::milliseconds interval);
  ~MemoryTrimmer();
  MemoryTrimmer(const MemoryTrimmer&) = delete;
  MemoryTrimmer& operator=(const MemoryTrimmer&) = delete;

 private:
  void trim_if_worked();

  // Seconds of a processor that the process had used by the last look, and by the last trim.
  double looked_ = 0;
  double trimmed_ = 0;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace geodesic::server
