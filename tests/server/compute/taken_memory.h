// Jobs of a compute pool that take memory, and do nothing with it.
#pragma once

#include <cstddef>
#include <cstdint>

#include "server/compute/pool.h"

namespace geodesic::server::test {

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;

// Memory that is taken, and not touched. A compiler may leave out what is only taken and given
// back, but for the volatile.
class Taken {
 public:
  explicit Taken(std::uint64_t bytes) : memory_(new char[bytes]) {}
  Taken(const Taken&) = delete;
  Taken& operator=(const Taken&) = delete;
  ~Taken() { delete[] memory_; }

 private:
  char* volatile memory_;
};

inline auto taking(std::uint64_t bytes) {
  return [bytes](Worker&) -> Result<std::size_t> {
    const Taken memory(bytes);
    return bytes;
  };
}
inline auto query_taking(std::uint64_t bytes) {
  return [bytes](Worker& worker) -> Result<std::size_t> {
    worker.memory->limit_to_query();
    return taking(bytes)(worker);
  };
}

}  // namespace geodesic::server::test
