// Budgets of a store in a directory, and a disk that fails it.
#include <doctest/doctest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <future>
#include <string>
#include <thread>
#include <vector>

#include "server/base/service_codes.h"
#include "server/base/sha256.h"
#include "server/config/config.h"
#include "server/store/mesh_store.h"
#include "server/store/monitor.h"
#include "server/store/open_store.h"
#include "tests/fixtures/wait_until.h"
#include "tests/server/routes/service_fixture.h"
#include "tests/server/store/stored_files.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using geodesic::fixtures::wait_until;
namespace fs = std::filesystem;

namespace {

std::string bytes_of(char letter, std::size_t size = 1000) { return std::string(size, letter); }
std::string id_of(char letter, std::size_t size = 1000) {
  return sha256_hex(bytes_of(letter, size));
}

std::uint64_t file_bytes_below(const fs::path& path) {
  std::uint64_t bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(path)) {
    if (entry.is_regular_file()) bytes += entry.file_size();
  }
  return bytes;
}

// As if a mesh had last been used so many seconds ago.
void make_older(const fs::path& path, int seconds) {
  fs::last_write_time(path, fs::last_write_time(path) - std::chrono::seconds(seconds));
}

// While it lives, no file may grow beyond so many bytes: a full disk for any user.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    REQUIRE(::getrlimit(RLIMIT_FSIZE, &before_) == 0);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    REQUIRE(::setrlimit(RLIMIT_FSIZE, &limit) == 0);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int);
};

}  // namespace

TEST_CASE("a full store refuses uploads and keeps what it has") {
  const TemporaryFolder folder;
  const auto store = opened(folder.path(), {2500, WhenFull::refuse});
  REQUIRE(store->put(id_of('a'), bytes_of('a'), "{}"));
  REQUIRE(store->put(id_of('b'), bytes_of('b'), "{}"));
  const auto third = store->put(id_of('c'), bytes_of('c'), "{}");
  REQUIRE_FALSE(third);
  CHECK(third.error().code == ServiceCode::store_full);
  CHECK(third.error().limit == 2500u);
  CHECK(files_below(folder.path() / "objects") == 2);
  CHECK(store->stats().refusals == 1);
  // What is there already needs no room.
  CHECK(store->put(id_of('a'), bytes_of('a'), "{}"));
  CHECK(store->remove(id_of('a')) == true);
  CHECK(store->put(id_of('c'), bytes_of('c'), "{}"));
  CHECK(store->stats().bytes == 2004);
  CHECK(store->stats().bytes ==
        file_bytes_below(folder.path() / "objects") + file_bytes_below(folder.path() / "meta"));
}

TEST_CASE("a store that evicts drops what was used longest ago") {
  const TemporaryFolder folder;
  const auto store = opened(folder.path(), {3500, WhenFull::evict});
  for (const char letter : {'a', 'b', 'c'}) {
    REQUIRE(store->put(id_of(letter), bytes_of(letter), "{}"));
  }
  CHECK(store->use(id_of('a')) == true);
  CHECK(store->get_source(id_of('b')));
  REQUIRE(store->put(id_of('d'), bytes_of('d'), "{}"));
  CHECK_FALSE(store->contains(id_of('c')));
  CHECK_FALSE(fs::exists(object_of(folder.path(), id_of('c'))));
  CHECK(store->get_source(id_of('c')).error().code == ServiceCode::mesh_unknown);
  for (const char letter : {'a', 'b', 'd'}) CHECK(store->get_source(id_of(letter)));
  CHECK(store->stats().evictions == 1);
  // One larger than the budget evicts nobody.
  CHECK(store->put(id_of('e', 4000), bytes_of('e', 4000), "{}").error().code ==
        ServiceCode::store_full);
  CHECK(store->size() == 3);
  CHECK(files_below(folder.path() / "objects") == 3);
  CHECK(files_below(folder.path() / "meta") == 3);
}

TEST_CASE("the order of use survives a restart") {
  const TemporaryFolder folder;
  {
    const auto store = opened(folder.path());
    for (const char letter : {'a', 'b', 'c'}) {
      REQUIRE(store->put(id_of(letter), bytes_of(letter), "{}"));
    }
  }
  make_older(object_of(folder.path(), id_of('a')), 300);
  make_older(object_of(folder.path(), id_of('b')), 200);
  make_older(object_of(folder.path(), id_of('c')), 100);
  {
    // Used anew after more than a minute, which the file's time remembers.
    const auto store = opened(folder.path());
    CHECK(store->get_source(id_of('a')));
  }
  const auto store = opened(folder.path(), {3500, WhenFull::evict});
  REQUIRE(store->put(id_of('d'), bytes_of('d'), "{}"));
  CHECK_FALSE(store->contains(id_of('b')));
  REQUIRE(store->put(id_of('e'), bytes_of('e'), "{}"));
  CHECK_FALSE(store->contains(id_of('c')));
  CHECK(store->contains(id_of('a')));
}

TEST_CASE("a budget made smaller holds from the next upload on") {
  const TemporaryFolder folder;
  {
    const auto store = opened(folder.path());
    for (const char letter : {'a', 'b', 'c', 'd'}) {
      REQUIRE(store->put(id_of(letter), bytes_of(letter), "{}"));
    }
  }
  const auto store = opened(folder.path(), {2500, WhenFull::evict});
  CHECK(store->size() == 4);
  REQUIRE(store->put(id_of('e'), bytes_of('e'), "{}"));
  CHECK(store->size() == 2);
  CHECK(store->stats().evictions == 3);
}

TEST_CASE("uploads at once never exceed the budget") {
  const TemporaryFolder folder;
  const auto store = opened(folder.path(), {10'000, WhenFull::evict});
  std::atomic<bool> over{false};
  std::vector<std::future<int>> workers;
  for (int t = 0; t < 4; ++t) {
    workers.push_back(std::async(std::launch::async, [&, t] {
      int failed = 0;
      for (int i = 0; i < 30; ++i) {
        const std::string bytes = std::to_string(1000 * t + i) + bytes_of('x', 1500);
        failed += !store->put(sha256_hex(bytes), bytes, "{}");
        if (store->stats().bytes > 10'000) over = true;
      }
      return failed;
    }));
  }
  for (auto& worker : workers) CHECK(worker.get() == 0);
  CHECK_FALSE(over);
  CHECK(store->stats().evictions == 120 - store->size());
  CHECK(files_below(folder.path() / "objects") == store->size());
  CHECK(files_below(folder.path() / "meta") == store->size());
  CHECK(file_bytes_below(folder.path() / "objects") <= 10'000);
}

TEST_CASE("when the disk is full an upload fails whole, and the rest goes on") {
  const TemporaryFolder folder;
  const auto store = opened(folder.path());
  REQUIRE(store->put(id_of('a'), bytes_of('a'), "{}"));
  REQUIRE(store->check());
  const std::string large = bytes_of('b', 100'000);
  const std::string id = sha256_hex(large);
  Result<void> source_stored;
  Result<void> metadata_stored;
  Result<void> health;
  {
    const FileSizeLimit limit(50'000);
    source_stored = store->put(id, large, "{}");
    metadata_stored = store->put(id_of('c'), bytes_of('c'), large);
  }
  {
    const FileSizeLimit limit(2'000);
    health = store->check();
  }
  for (const Result<void>& stored : {source_stored, metadata_stored}) {
    REQUIRE_FALSE(stored);
    CHECK(stored.error().code == ServiceCode::store_full);
    CHECK(stored.error().detail.find(folder.path().string()) == std::string::npos);
  }
  REQUIRE_FALSE(health);
  CHECK(health.error().code == ServiceCode::store_unavailable);
  CHECK(store->health().error().detail == health.error().detail);
  CHECK(store->list("", 10) == std::vector<std::string>{id_of('a')});
  CHECK(files_below(folder.path() / "objects") == 1);
  CHECK(files_below(folder.path() / "meta") == 1);
  CHECK(files_below(folder.path() / "tmp") == 0);
  CHECK(store->get_source(id_of('a')) == bytes_of('a'));
  CHECK(store->stats().bytes == 1002);
  // There is room again.
  CHECK(store->check());
  CHECK(store->health());
  CHECK(store->put(id, large, "{}"));
}

TEST_CASE("a store that cannot be written to reads on and says that it is not well") {
  const TemporaryFolder folder;
  const auto store = opened(folder.path());
  REQUIRE(store->put(id_of('a'), bytes_of('a'), "{}"));
  // A file in the place of the folder refuses every user, root included.
  fs::remove_all(folder.path() / "tmp");
  std::ofstream(folder.path() / "tmp") << "in the way";
  CHECK(store->put(id_of('b'), bytes_of('b'), "{}").error().code == ServiceCode::store_failed);
  CHECK_FALSE(store->contains(id_of('b')));
  CHECK_FALSE(fs::exists(object_of(folder.path(), id_of('b'))));
  CHECK(store->get_source(id_of('a')) == bytes_of('a'));
  {
    const StoreMonitor monitor(*store, std::chrono::milliseconds(1));
    wait_until([&] { return !store->health(); });
    CHECK(store->health().error().code == ServiceCode::store_unavailable);
    fs::remove(folder.path() / "tmp");
    fs::create_directory(folder.path() / "tmp");
    wait_until([&] { return bool(store->health()); });
  }
  CHECK(store->put(id_of('b'), bytes_of('b'), "{}"));
}

TEST_CASE("queries on a resident mesh go on while the store fails") {
  const TemporaryFolder folder;
  Service service(folder.path());
  const std::string id = service.upload(glb_of(shapes::plane(4, 4)));
  const std::string other = glb_of(shapes::plane(5, 5));
  REQUIRE(service.get("/v1/meshes/" + id + "/distance?from=v:0").status == 200);
  fs::remove_all(folder.path() / "tmp");
  std::ofstream(folder.path() / "tmp") << "in the way";
  fs::remove(object_of(folder.path(), id));
  CHECK(service.get("/v1/meshes/" + id + "/distance?from=v:1").status == 200);
  const HttpResponse refused = service.ask("POST", "/v1/meshes", other);
  CHECK(refused.status == 500);
  CHECK(body_of(refused)["code"] == "store_failed");
  CHECK(service.get("/v1/meshes/" + id + "/source").status == 500);
  // Found damaged and out of the store, but whole in memory; until it is removed.
  CHECK(service.get("/v1/meshes/" + id + "/distance?from=v:2").status == 200);
  // Nor does a question about a part of it, which is cut out of what is in memory, take that away.
  CHECK(service.get("/v1/meshes/" + id + "/distance?from=v:2&forbid=faces:17").status == 200);
  CHECK(service.get("/v1/meshes/" + id + "/distance?from=v:4").status == 200);
  CHECK(service.get("/v1/meshes/" + id).status == 404);
  (void)service.ask("DELETE", "/v1/meshes/" + id);
  CHECK(service.get("/v1/meshes/" + id + "/distance?from=v:3").status == 404);
}
