#include "server/base/cores.h"

#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/server/routes/service_fixture.h"

using namespace geodesic::server;
using geodesic::server::test::TemporaryFolder;

namespace {

void write_group(const std::filesystem::path& file, const std::string& text) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file) << text;
}

}  // namespace

TEST_CASE("ACoreIsUsableAtLeastAndNoMoreThanThereAre") { CHECK(usable_cores() >= 1); }

TEST_CASE("AQuotaOfAControlGroupBoundsTheCores") {
  const TemporaryFolder folder;
  const std::filesystem::path root = folder.path();
  CHECK(!cores_of_groups(root, ""));
  CHECK(!cores_of_groups(root, "0::/\n"));
  write_group(root / "cpu.max", "max 100000\n");
  CHECK(!cores_of_groups(root, "0::/\n"));
  // Of a container, which sees its group as the root: the path may be the host's.
  write_group(root / "cpu.max", "250000 100000\n");
  CHECK(cores_of_groups(root, "0::/\n") == 3);
  CHECK(cores_of_groups(root, "0::/kubepods.slice/pod\n") == 3);
  CHECK(cores_of_groups(root, "0::/../../elsewhere\n") == 3);
  // The least of all groups that it is in.
  write_group(root / "a.slice" / "cpu.max", "800000 100000\n");
  write_group(root / "a.slice" / "b.service" / "cpu.max", "50000 100000\n");
  CHECK(cores_of_groups(root, "0::/a.slice/b.service\n") == 1);
  CHECK(cores_of_groups(root, "0::/a.slice\n") == 3);
}

TEST_CASE("AQuotaOfTheFirstVersionOfControlGroupsDoesToo") {
  const TemporaryFolder folder;
  const std::filesystem::path root = folder.path();
  const std::string groups = "12:memory:/x\n4:cpu,cpuacct:/docker/1\n1:name=systemd:/x\n";
  CHECK(!cores_of_groups(root, groups));
  write_group(root / "cpu" / "docker" / "1" / "cpu.cfs_quota_us", "-1\n");
  write_group(root / "cpu" / "docker" / "1" / "cpu.cfs_period_us", "100000\n");
  CHECK(!cores_of_groups(root, groups));
  write_group(root / "cpu" / "docker" / "1" / "cpu.cfs_quota_us", "150000\n");
  CHECK(cores_of_groups(root, groups) == 2);
}

TEST_CASE("WhatIsNoQuotaIsNone") {
  const TemporaryFolder folder;
  const std::filesystem::path root = folder.path();
  for (const char* text : {"", "max", "0 0", "-5 100000", "100000", "nan 1", "1e300 1", "x y"}) {
    CAPTURE(text);
    write_group(root / "cpu.max", text);
    CHECK(!cores_of_groups(root, "0::/\n"));
  }
  for (const char* groups : {":", "::", "0:", "0::", "\n\n", "no groups at all"}) {
    CAPTURE(groups);
    CHECK(!cores_of_groups(root, groups));
  }
}
