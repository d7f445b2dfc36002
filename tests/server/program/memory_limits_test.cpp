// How much memory there is: the least that the machine and the control groups allow.
#include "server/program/memory_limits.h"

#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/server/routes/service_fixture.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20U;

void put_file(const std::filesystem::path& file, const std::string& text) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file) << text << "\n";
}

}  // namespace

TEST_CASE("the limit of a service's own control group counts, and those above it") {
  const TemporaryFolder folder;
  const std::filesystem::path& groups = folder.path();
  const auto own = groups / "own";
  const auto is = [&] { return memory_there_is(groups, own); };
  const std::uint64_t machine = is();
  CHECK(machine > 256 * kMiB);
  // As systemd sets MemoryMax=.
  put_file(own, "0::/system.slice/geodesicd.service");
  CHECK(is() == machine);
  put_file(groups / "system.slice" / "geodesicd.service" / "memory.max",
           std::to_string(200 * kMiB));
  CHECK(is() == 200 * kMiB);
  put_file(groups / "system.slice" / "memory.max", std::to_string(100 * kMiB));
  CHECK(is() == 100 * kMiB);
  put_file(groups / "system.slice" / "memory.max", "max");
  CHECK(is() == 200 * kMiB);
  // Another's does not.
  put_file(own, "0::/system.slice/other.service");
  CHECK(is() == machine);
  // A group outside of the namespace cannot be seen.
  put_file(own, "0::/../system.slice/geodesicd.service");
  CHECK(is() == machine);
}

TEST_CASE("the limits of control groups of version 1 count") {
  const TemporaryFolder folder;
  const std::filesystem::path& groups = folder.path();
  const auto own = groups / "own";
  put_file(own, "9:name=systemd:/\n4:cpu,memory:/docker/0123\n0::/");
  const auto is = [&] { return memory_there_is(groups, own); };
  const std::uint64_t machine = is();
  put_file(groups / "memory" / "docker" / "0123" / "memory.limit_in_bytes",
           std::to_string(150 * kMiB));
  CHECK(is() == 150 * kMiB);
  // A limit of a container is at the root of what it sees.
  put_file(groups / "memory" / "memory.limit_in_bytes", std::to_string(120 * kMiB));
  CHECK(is() == 120 * kMiB);
  // No limit is a number near 2^63.
  put_file(groups / "memory" / "docker" / "0123" / "memory.limit_in_bytes", "9223372036854771712");
  put_file(groups / "memory" / "memory.limit_in_bytes", "9223372036854771712");
  CHECK(is() == machine);
}
