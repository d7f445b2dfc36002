#include "server/program/memory_limits.h"

#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>

namespace geodesic::server {
namespace {

// The number in a file; the largest number for "max", or if there is no such file.
std::uint64_t limit_in(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::uint64_t limit = 0;
  return in >> limit ? limit : std::numeric_limits<std::uint64_t>::max();
}

// The least limit of a group and of all groups that it is in, up to the root.
std::uint64_t limit_up_from(const std::filesystem::path& root, const std::filesystem::path& group,
                            const char* file) {
  std::uint64_t least = std::numeric_limits<std::uint64_t>::max();
  std::filesystem::path at = root;
  for (const std::filesystem::path& name : group) {
    if (name == "..") break;  // seen from within a namespace: nothing there is ours to see
    at /= name;
    least = std::min(least, limit_in(at / file));
  }
  return least;
}

}  // namespace

std::uint64_t memory_there_is(const std::filesystem::path& groups,
                              const std::filesystem::path& own) {
  const long pages = ::sysconf(_SC_PHYS_PAGES);
  const long page = ::sysconf(_SC_PAGESIZE);
  if (pages <= 0 || page <= 0) return 0;
  const auto machine = static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page);
  std::uint64_t least = std::min({machine, limit_in(groups / "memory.max"),
                                  limit_in(groups / "memory" / "memory.limit_in_bytes")});
  // Lines such as "0::/system.slice/geodesicd.service", or "4:cpu,memory:/docker/0123".
  std::ifstream lines(own);
  for (std::string line; std::getline(lines, line);) {
    const auto controllers = line.find(':');
    const auto path = line.find(":/", controllers + 1);
    if (controllers == std::string::npos || path == std::string::npos) continue;
    const std::string named = line.substr(controllers + 1, path - controllers - 1);
    const std::filesystem::path group = line.substr(path + 2);
    if (named.empty()) {
      least = std::min(least, limit_up_from(groups, group, "memory.max"));
    } else if (("," + named + ",").find(",memory,") != std::string::npos) {
      least = std::min(least, limit_up_from(groups / "memory", group, "memory.limit_in_bytes"));
    }
  }
  return least;
}

ComputeMemory::Limits memory_limits(const Config& config, std::uint64_t there_is) {
  constexpr std::uint64_t kOther = std::uint64_t{1} << 30;
  std::uint64_t all = config.compute_memory_bytes;
  if (all == 0) {
    std::uint64_t rest = there_is;
    for (const std::uint64_t part :
         {config.mesh_cache_bytes, config.adjacency_cache_bytes, config.field_cache_bytes,
          config.reply_cache_bytes, config.reply_memory_bytes, kOther,
          config.decoder == "process" ? config.decoder_memory_bytes : std::uint64_t{0}}) {
      rest -= std::min(rest, part);
    }
    all = std::max(rest, there_is / 4);
  }
  return {config.query_memory_bytes, all};
}

}  // namespace geodesic::server
