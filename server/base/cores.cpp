#include "server/base/cores.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>

namespace geodesic::server {
namespace {

constexpr std::size_t kMostLevels = 64;  // of groups in groups

void lower(std::optional<std::size_t>& least, double quota, double period) {
  if (!(quota > 0 && period > 0)) return;
  const double cores = std::max(1.0, std::ceil(quota / period));
  if (cores < 1e6) least = std::min(least.value_or(SIZE_MAX), static_cast<std::size_t>(cores));
}

// Version 2: one line, of a quota or `max`, and a period.
void read_max(const std::filesystem::path& folder, std::optional<std::size_t>& least) {
  double quota = 0;
  double period = 0;
  if (std::ifstream(folder / "cpu.max") >> quota >> period) lower(least, quota, period);
}

// Version 1: a file each; -1 is no quota.
void read_quota(const std::filesystem::path& folder, std::optional<std::size_t>& least) {
  double quota = 0;
  double period = 0;
  if (std::ifstream(folder / "cpu.cfs_quota_us") >> quota &&
      std::ifstream(folder / "cpu.cfs_period_us") >> period) {
    lower(least, quota, period);
  }
}

// The group, those that it is in, and the root. Where a container sees its own group as the root,
// the path of the host is not there.
template <class Read>
void read_up(const std::filesystem::path& root, const std::string& group, Read read) {
  std::filesystem::path below = std::filesystem::path(group).relative_path();
  for (std::size_t level = 0; !below.empty() && level < kMostLevels; ++level) {
    read(root / below);
    below = below.parent_path();
  }
  read(root);
}

bool has_word(const std::string& list, std::string_view word) {
  std::istringstream words(list);
  for (std::string each; std::getline(words, each, ',');) {
    if (each == word) return true;
  }
  return false;
}

}  // namespace

std::optional<std::size_t> cores_of_groups(const std::filesystem::path& root,
                                           std::string_view groups) {
  std::optional<std::size_t> least;
  std::istringstream lines{std::string(groups)};
  // "0::/system.slice/geodesicd.service", or of version 1 "4:cpu,cpuacct:/group".
  for (std::string line; std::getline(lines, line);) {
    std::istringstream fields(line);
    std::string number;
    std::string controllers;
    std::string group;
    if (!std::getline(fields, number, ':') || !std::getline(fields, controllers, ':') ||
        !std::getline(fields, group)) {
      continue;
    }
    if (group.find("..") != std::string::npos) group = "/";
    if (controllers.empty()) {
      read_up(root, group, [&](const auto& folder) { read_max(folder, least); });
    } else if (has_word(controllers, "cpu")) {
      read_up(root / "cpu", group, [&](const auto& folder) { read_quota(folder, least); });
    }
  }
  return least;
}

std::size_t usable_cores() {
  const std::size_t cores = std::max(1U, std::thread::hardware_concurrency());
  std::ostringstream groups;
  if (const std::ifstream file("/proc/self/cgroup"); file) groups << file.rdbuf();
  return std::min(cores, cores_of_groups("/sys/fs/cgroup", groups.str()).value_or(cores));
}

}  // namespace geodesic::server
