// What pools, caches and stores hold at the moment that Prometheus asks.
#pragma once

#include <cstdint>

#include "server/base/lru_cache.h"
#include "server/compute/jobs.h"
#include "server/compute/pool.h"
#include "server/decoder/processes.h"
#include "server/http/reply_budget.h"
#include "server/prepared/prepared_files.h"
#include "server/store/budget.h"

namespace geodesic::server {

struct PresentState {
  ComputePool::Stats pool;
  ComputeMemory::Stats memory;
  CacheStats meshes, adjacency, fields, replies;
  ReplyBudget::Stats reply_memory;
  StoreStats store;
  PreparedFiles::Stats prepared;
  Jobs::Stats jobs;
  DecoderProcesses::Stats decoders;
  std::uint64_t connections = 0;      // open on the API's listener
  std::uint64_t accept_failures = 0;  // of the API's listener
  bool ready = true;
};

}  // namespace geodesic::server
