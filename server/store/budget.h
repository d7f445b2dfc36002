// How much a store may hold, and what it holds: plain values.
#pragma once

#include <cstdint>

namespace geodesic::server {

enum class WhenFull : std::uint8_t {
  refuse,  // an upload that does not fit is answered `store_full`
  evict,   // the meshes used longest ago make room
};

struct StoreBudget {
  std::uint64_t max_bytes = 0;  // of sources and metadata together; 0: no limit
  WhenFull when_full = WhenFull::refuse;
};

struct StoreStats {
  std::uint64_t meshes = 0;     // of a bucket: those that this process knows
  std::uint64_t bytes = 0;      // that their objects take
  std::uint64_t max_bytes = 0;  // 0: no limit
  std::uint64_t evictions = 0;  // since the start, as all below
  std::uint64_t refusals = 0;   // uploads that did not fit
  std::uint64_t corrupt = 0;    // meshes found damaged and put into quarantine
  std::uint64_t failures = 0;   // operations that the disk or the object store failed
};

}  // namespace geodesic::server
