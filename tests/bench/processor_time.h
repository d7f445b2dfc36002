// The processor's time of this thread: on a machine that others use too, it says more
// of what a computation costs than the clock on the wall.
#pragma once

#include <ctime>

namespace geodesic::bench {

[[nodiscard]] inline double processor_ms() {
  std::timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
}

template <class Work>
[[nodiscard]] double processor_ms_of(Work work) {
  const double begin = processor_ms();
  work();
  return processor_ms() - begin;
}

}  // namespace geodesic::bench
