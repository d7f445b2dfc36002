// A store asks its storage again about the meshes in use, which shows what other servers did.
#include <doctest/doctest.h>
#include <pthread.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "server/base/sha256.h"
#include "server/store/mesh_store.h"
#include "server/store/monitor.h"
#include "server/store/object_storage.h"
#include "tests/fixtures/wait_until.h"
#include "tests/server/store/fake_s3.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

// A storage that has every mesh, and starts no threads. It calls what it is given: when it is asked
// for a mesh, and when it is checked.
class CallingStorage final : public ObjectStorage {
 public:
  CallingStorage(std::function<void()> found, std::function<void()> checked)
      : found_(std::move(found)), checked_(std::move(checked)) {}
  [[nodiscard]] std::string name() const override { return "calls"; }
  [[nodiscard]] bool is_shared() const override { return true; }
  [[nodiscard]] Result<std::vector<StoredMesh>> list(std::string_view /*after*/,
                                                     std::size_t /*most*/) override {
    return std::vector<StoredMesh>();
  }
  [[nodiscard]] Result<std::optional<StoredMesh>> find(std::string_view id) override {
    found_();
    return StoredMesh{std::string(id), 1, 0, "1"};
  }
  [[nodiscard]] Result<std::optional<std::string>> metadata_version(
      std::string_view /*id*/) override {
    return std::string("1");
  }
  [[nodiscard]] Result<std::string> write(ObjectKind /*kind*/, std::string_view /*id*/,
                                          std::string_view /*bytes*/) override {
    return std::string("1");
  }
  [[nodiscard]] Result<std::optional<StoredObject>> read(
      ObjectKind /*kind*/, std::string_view /*id*/, std::uint64_t /*expected_bytes*/) override {
    return StoredObject{"{}", "1"};
  }
  [[nodiscard]] Result<void> erase(std::string_view /*id*/) override { return {}; }
  [[nodiscard]] Result<void> quarantine(std::string_view /*id*/,
                                        std::string_view /*damaged*/) override {
    return {};
  }
  [[nodiscard]] Result<void> erase_job(std::string_view /*id*/,
                                       std::span<const ObjectKind> /*kinds*/) override {
    return {};
  }
  [[nodiscard]] Result<void> erase_old_jobs(std::chrono::seconds /*age*/) override { return {}; }
  void note_use(std::string_view /*id*/) override {}
  [[nodiscard]] Result<void> check() override {
    checked_();
    return {};
  }

 private:
  const std::function<void()> found_;
  const std::function<void()> checked_;
};

std::unique_ptr<MeshStore> calling_store(std::function<void()> found,
                                         std::function<void()> checked) {
  auto store =
      MeshStore::open(std::make_unique<CallingStorage>(std::move(found), std::move(checked)), {});
  REQUIRE(store);
  return std::move(*store);
}

// While it lives, no thread of this process can be started: there is no room for its stack.
class NoMoreThreads {
 public:
  NoMoreThreads() {
    pthread_attr_t vast{};
    REQUIRE(::pthread_getattr_default_np(&before_) == 0);
    REQUIRE(::pthread_getattr_default_np(&vast) == 0);
    REQUIRE(::pthread_attr_setstacksize(&vast, std::size_t{1} << 60) == 0);
    REQUIRE(::pthread_setattr_default_np(&vast) == 0);
    ::pthread_attr_destroy(&vast);
  }
  ~NoMoreThreads() {
    ::pthread_setattr_default_np(&before_);
    ::pthread_attr_destroy(&before_);
  }
  NoMoreThreads(const NoMoreThreads&) = delete;
  NoMoreThreads& operator=(const NoMoreThreads&) = delete;

 private:
  pthread_attr_t before_{};
};

}  // namespace

TEST_CASE(
    "what another server does to a mesh is seen once it is confirmed, and nothing else is asked") {
  FakeS3 s3;
  const std::string id = sha256_hex("x");
  const std::string idle = sha256_hex("y");
  const auto one = s3.open();
  REQUIRE(one->put(id, "x", "{}"));
  REQUIRE(one->put(idle, "y", "{}"));
  const auto two = s3.open();
  CHECK(two->size() == 0);  // it starts without a list
  REQUIRE(two->list("", 10)->size() == 2);
  REQUIRE(two->get_metadata(id) == "{}");

  std::vector<std::string> asked;  // calls come one at a time
  FakeS3::Script script;
  script.before = [&](const FakeS3::Call& call) {
    asked.push_back(call.method + " " + call.key);
    return FakeS3::Act::serve;
  };
  s3.follow(script);
  // Believed until it is old.
  REQUIRE(two->confirm_used(std::chrono::seconds(3600)));
  CHECK(two->use(id) == true);
  CHECK(asked.empty());
  // Only what was used, and its description only by its tag.
  REQUIRE(two->confirm_used(std::chrono::seconds(0)));
  CHECK(asked == std::vector<std::string>{"HEAD objects/" + id, "HEAD meta/" + id + ".json"});
  CHECK(two->get_metadata(id) == "{}");
  CHECK(asked.size() == 2);
  REQUIRE(two->confirm_used(std::chrono::seconds(0)));  // it was used since
  CHECK(asked.size() == 4);
  REQUIRE(two->confirm_used(std::chrono::seconds(0)));
  CHECK(asked.size() == 4);
  s3.follow({});

  CHECK(two->use(id) == true);
  REQUIRE(one->put_metadata(id, R"({"name":"other"})"));
  REQUIRE(two->confirm_used(std::chrono::seconds(0)));
  CHECK(two->get_metadata(id) == R"({"name":"other"})");
  REQUIRE(one->remove(id) == true);
  CHECK(two->use(id) == true);  // as far as it knows
  // A storage that fails takes nothing away.
  script.before = [](const FakeS3::Call&) { return FakeS3::Act::refuse; };
  s3.follow(script);
  CHECK_FALSE(two->confirm_used(std::chrono::seconds(0)));
  CHECK(two->use(id) == true);
  CHECK_FALSE(two->list("", 10));
  s3.follow({});
  REQUIRE(two->confirm_used(std::chrono::seconds(0)));
  CHECK(two->use(id) == false);
  CHECK(two->list("", 10) == std::vector<std::string>{idle});
}

TEST_CASE(
    "one mesh that cannot be asked about keeps no other from it, nor the store from being well") {
  FakeS3 s3;
  std::vector<std::string> ids;
  const auto one = s3.open();
  const auto two = s3.open();
  for (int i = 0; i < 40; ++i) {
    const std::string bytes = std::to_string(i);
    ids.push_back(sha256_hex(bytes));
    REQUIRE(one->put(ids.back(), bytes, "{}"));
    REQUIRE(two->get_metadata(ids.back()));
    REQUIRE(two->use(ids.back()) == true);
  }
  for (const std::string& id : ids) REQUIRE(one->remove(id));
  FakeS3::Script script;
  script.before = [&](const FakeS3::Call& call) {
    return call.key == "objects/" + ids[20] ? FakeS3::Act::refuse : FakeS3::Act::serve;
  };
  s3.follow(script);
  CHECK_FALSE(two->confirm_used(std::chrono::seconds(0)));
  for (const std::string& id : ids) {
    CAPTURE(id);
    CHECK(two->contains(id) == (id == ids[20]));
  }
  CHECK(two->check());
  CHECK(two->health());
  s3.follow({});
  CHECK(two->confirm_used(std::chrono::seconds(0)));
  CHECK_FALSE(two->contains(ids[20]));
}

TEST_CASE("where no thread can be started, one confirms all that is used") {
  std::atomic<int> asked = 0;
  const auto store = calling_store([&] { ++asked; }, [] {});
  constexpr int kMeshes = 20;
  for (int i = 0; i < kMeshes; ++i) {
    const std::string id = sha256_hex(std::to_string(i));
    REQUIRE(store->is_stored(id) == true);
    REQUIRE(store->use(id) == true);
  }
  asked = 0;
  Result<void> confirmed;
  {
    const NoMoreThreads none;
    REQUIRE_THROWS_AS((void)std::async(std::launch::async, [] {}), std::system_error);
    confirmed = store->confirm_used(std::chrono::seconds(0));
  }
  CHECK(confirmed);
  CHECK(asked == kMeshes);
}

TEST_CASE("a monitor goes on after a check for which there was no memory") {
  std::atomic<int> checks = 0;
  // The first is that of the start.
  const auto store = calling_store([] {},
                                   [&] {
                                     if (const int before = checks++; before > 0 && before < 3)
                                       throw std::bad_alloc();
                                   });
  std::atomic<int> times = 0;
  const StoreMonitor monitor(*store, std::chrono::milliseconds(1), [&] {
    if (++times == 1) throw std::bad_alloc();
  });
  geodesic::fixtures::wait_until([&] { return times >= 2; });
  CHECK(checks >= 5);
}
