// What a process that reads hostile bytes may still do: compute, take memory, answer
// on what is open already, and end.
#pragma once

#include <cstdint>

namespace geodesic::server {

struct ProcessLimits {
  std::uint64_t memory_bytes;  // beyond what the process has mapped now
  std::uint64_t cpu_seconds;   // of its own; then it is killed
};

// Made once, for any number of copies of the process that makes it.
class Confinement {
 public:
  Confinement();
  ~Confinement();
  Confinement(const Confinement&) = delete;
  Confinement& operator=(const Confinement&) = delete;

  // For the calling process, which must have one thread, for ever: no file or socket can
  // be opened, no other process be seen, no memory become code. Another system call than
  // those that computing needs kills it. False if this system cannot do that.
  //
  // Does nothing in builds with AddressSanitizer or ThreadSanitizer, which need more.
  [[nodiscard]] bool enter(const ProcessLimits& limits) const;

  // Whether `enter` does anything.
  [[nodiscard]] static bool can_confine();

 private:
  void* filter_;  // libseccomp's; null if there can be none
};

}  // namespace geodesic::server
