// How much memory the computations may take, by the configuration and the machine's memory.
#pragma once

#include <cstdint>
#include <filesystem>

#include "server/compute/memory.h"
#include "server/config/config.h"

namespace geodesic::server {

// What this process may use, in bytes: the machine's memory, or less if its control group, or one
// that this is in, has less (Linux: memory.max, or memory.limit_in_bytes of version 1). `groups`
// is where control groups are mounted, `own` the file that names those of this process. 0 if
// nobody tells.
[[nodiscard]] std::uint64_t memory_there_is(const std::filesystem::path& groups = "/sys/fs/cgroup",
                                            const std::filesystem::path& own = "/proc/self/cgroup");

// Of the computations. Where the configuration leaves it open, all together may have what
// there is less the caches, the replies, one decoder and 1 GiB for the rest; at the least a
// quarter of what there is.
[[nodiscard]] ComputeMemory::Limits memory_limits(const Config& config,
                                                  std::uint64_t there_is = memory_there_is());

}  // namespace geodesic::server
