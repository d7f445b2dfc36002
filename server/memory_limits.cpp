#include "server/memory_limits.h"

#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>

namespace geodesic::server {
namespace {

// The number in a file; none for "max", or where there is no such file.
std::uint64_t limit_in(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::uint64_t limit = 0;
  return in >> limit ? limit : std::numeric_limits<std::uint64_t>::max();
}

}  // namespace

std::uint64_t memory_there_is(const std::filesystem::path& groups) {
  const long pages = ::sysconf(_SC_PHYS_PAGES);
  const long page = ::sysconf(_SC_PAGESIZE);
  if (pages <= 0 || page <= 0) return 0;
  const auto machine = static_cast<std::uint64_t>(pages) * static_cast<std::uint64_t>(page);
  return std::min({machine, limit_in(groups / "memory.max"),
                   limit_in(groups / "memory" / "memory.limit_in_bytes")});
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
