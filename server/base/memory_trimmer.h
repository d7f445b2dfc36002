// A thread that gives memory back to the system which the C library keeps for later.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace geodesic::server {

// The C library has a heap for each few threads, and keeps what has been freed there:
//   - at a heap's end up to 64 MB, for the bound on that grows with the largest block that was ever
//     freed. Here it is a few MB and stays so (mallopt);
//   - between what is still in use all of it. malloc_trim returns whole pages of that. It is worth
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
