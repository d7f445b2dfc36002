// A process killed with SIGKILL in the middle of a put. tests/crash does the same to
// the whole server; here nearly all of the time is spent on writing, so that a kill
// often falls into the middle of a file.
#include <doctest/doctest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <map>
#include <random>
#include <string>
#include <thread>

#include "server/base/sha256.h"
#include "server/config/config.h"
#include "server/store/mesh_store.h"
#include "server/store/open_store.h"

using namespace geodesic;
using namespace geodesic::server;
namespace fs = std::filesystem;

namespace {

constexpr int kKills = 25;
constexpr int kMeshes = 4;

std::string bytes_of(int number) { return std::string(2 << 20, static_cast<char>('a' + number)); }

std::unique_ptr<MeshStore> store_at(const fs::path& path) {
  auto store = open_store(path.string(), {}, process_environment());
  return store ? std::move(*store) : nullptr;
}

// Puts and removes in turn until it is killed, and tells the pipe a mesh's number before
// each ('?') and after it ('+' it is there, '-' it is gone).
[[noreturn]] void put_and_remove_for_ever(const fs::path& path, int pipe) {
  const auto store = store_at(path);
  const auto tell = [&](char what, int number) {
    const char line[2] = {what, static_cast<char>('0' + number)};
    if (::write(pipe, line, sizeof line) != sizeof line) ::_exit(1);
  };
  std::string bytes[kMeshes];
  std::string ids[kMeshes];
  for (int i = 0; i < kMeshes; ++i) {
    bytes[i] = bytes_of(i);
    ids[i] = sha256_hex(bytes[i]);
  }
  tell('!', 0);  // ready
  for (int i = 0;; i = (i + 1) % kMeshes) {
    tell('?', i);
    if (!store->contains(ids[i])) {
      if (!store->put(ids[i], bytes[i], "{}")) ::_exit(1);
      tell('+', i);
    } else {
      if (!store->remove(ids[i])) ::_exit(1);
      tell('-', i);
    }
  }
}

}  // namespace

TEST_CASE("after a kill what was acknowledged is there, whole, and nothing is half there") {
  // In memory, where there is such a folder: there a sync costs nothing.
  const fs::path base = fs::is_directory("/dev/shm") && ::access("/dev/shm", W_OK) == 0
                            ? fs::path("/dev/shm")
                            : fs::temp_directory_path();
  std::string pattern = (base / "store_kill_XXXXXX").string();
  REQUIRE(::mkdtemp(pattern.data()) != nullptr);
  const fs::path folder = pattern;
  std::map<std::string, std::string> bytes;
  for (int i = 0; i < kMeshes; ++i) bytes.emplace(sha256_hex(bytes_of(i)), bytes_of(i));
  std::map<int, char> last;  // what was said of each mesh last
  std::minstd_rand random(17);
  int changes = 0;
  // On a machine that is busy, a child may have done little by then.
  for (int kill = 0; kill < kKills || (changes <= kKills && kill < 40 * kKills); ++kill) {
    int pipe[2];
    REQUIRE(::pipe(pipe) == 0);
    std::fflush(nullptr);  // or the child might print what is buffered once more
    const pid_t child = ::fork();
    REQUIRE(child >= 0);
    if (child == 0) put_and_remove_for_ever(folder, pipe[1]);
    ::close(pipe[1]);
    char line[2];
    REQUIRE(::read(pipe[0], line, sizeof line) == sizeof line);  // it is ready
    std::this_thread::sleep_for(
        std::chrono::microseconds(std::uniform_int_distribution(0, 40'000)(random)));
    REQUIRE(::kill(child, SIGKILL) == 0);
    int status = 0;
    REQUIRE(::waitpid(child, &status, 0) == child);
    REQUIRE(WIFSIGNALED(status));
    while (::read(pipe[0], line, sizeof line) == sizeof line) {
      last[line[1] - '0'] = line[0];
      changes += line[0] != '?';
    }
    ::close(pipe[0]);

    const auto store = store_at(folder);
    REQUIRE(store);
    CHECK(fs::is_empty(folder / "tmp"));
    for (const auto& [number, said] : last) {
      const bool is_there = store->contains(sha256_hex(bytes_of(number)));
      if (said == '+') CHECK(is_there);
      if (said == '-') CHECK_FALSE(is_there);
    }
    const auto listed = store->list("", 100);
    REQUIRE(listed);
    for (const std::string& id : *listed) {
      const auto got = store->get_source(id);
      REQUIRE(got);
      CHECK((*got == bytes.at(id)));
    }
  }
  CHECK(changes > kKills);
  fs::remove_all(folder);
}
