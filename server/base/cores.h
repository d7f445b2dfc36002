// How many processors this process may use.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string_view>

namespace geodesic::server {

// Those that it may run on, or fewer where its control group has less time than that: as many as
// have that much, rounded up. At least one. Linux: cgroups version 2 (cpu.max), of this group and
// those that it is in, and version 1 (cpu.cfs_quota_us).
[[nodiscard]] std::size_t usable_cores();

// The same bound alone, of groups below `root` (usually /sys/fs/cgroup) for a process whose
// /proc/self/cgroup is `groups`. Nothing where there is none.
[[nodiscard]] std::optional<std::size_t> cores_of_groups(const std::filesystem::path& root,
                                                         std::string_view groups);

}  // namespace geodesic::server
