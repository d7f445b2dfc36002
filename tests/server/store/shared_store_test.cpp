// Two servers on one bucket. Whatever fails, and in whatever order their requests
// arrive, an upload that either of them has acknowledged is there afterwards, whole,
// unless somebody asked for its removal meanwhile.
//
// GEODESICD_SEED=N repeats a random run.
#include <doctest/doctest.h>
#include <pthread.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <new>
#include <optional>
#include <random>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "proto/wire/input_codes.h"
#include "server/base/service_codes.h"
#include "server/metrics/metrics.h"
#include "server/query/mesh_catalog.h"
#include "server/store/mesh_store.h"
#include "server/store/monitor.h"
#include "tests/fixtures/wait_until.h"
#include "tests/server/routes/service_fixture.h"
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

enum class Deed : std::uint8_t { add, read, remove };
enum class Found : std::uint8_t { nothing, whole, damaged, source_only };

std::string name_of(Deed deed) {
  return deed == Deed::add ? "add" : deed == Deed::read ? "read" : "remove";
}

// What happens during a deed of the first server. Calls are counted from 0; those of the
// second server have a count of their own.
struct Plan {
  Found found = Found::nothing;
  Deed first = Deed::add;
  Deed second = Deed::add;
  bool has_options = true;
  int call = 0;           // of the first, during which the second does its deed whole
  bool is_after = false;  // after its effect rather than before it
  std::map<int, FakeS3::Act> first_fails;
  std::map<int, FakeS3::Act> second_fails;
};

std::string text_of(const Plan& plan) {
  std::string text = "found " + std::to_string(static_cast<int>(plan.found)) + ", " +
                     name_of(plan.first) + " with " + name_of(plan.second) +
                     (plan.is_after ? " after call " : " before call ") +
                     std::to_string(plan.call) + (plan.has_options ? ", with options" : "");
  for (const auto& [call, act] : plan.first_fails) {
    text += ", call " + std::to_string(call) + " fails " + std::to_string(static_cast<int>(act));
  }
  for (const auto& [call, act] : plan.second_fails) {
    text += ", the other's " + std::to_string(call) + " " + std::to_string(static_cast<int>(act));
  }
  return text;
}

class Servers {
 public:
  // Whether each deed was acknowledged; nothing: it was not done.
  struct Outcome {
    bool first = false;
    std::optional<bool> second;
  };

  Outcome run(const Plan& plan) {
    s3_.follow({});
    const std::string id = id_of(plan);
    for (const std::string& key : {source(id), "meta/" + id + ".json", "quarantine/" + id}) {
      s3_.erase(key);
    }
    if (plan.found != Found::nothing) {
      const auto store = s3_.open();
      REQUIRE(deed(*store, Deed::add, plan));
      if (plan.found == Found::source_only) s3_.erase("meta/" + id + ".json");
      if (plan.found == Found::damaged) s3_.put(source(id), bytes_.substr(0, bytes_.size() / 2));
    }
    const auto first = s3_.open();
    const auto second = s3_.open();
    Outcome outcome;
    int firsts = 0;
    int seconds = 0;
    bool is_second = false;  // calls come one at a time
    const auto act = [](const std::map<int, FakeS3::Act>& fails, int call) {
      const auto found = fails.find(call);
      return found == fails.end() ? FakeS3::Act::serve : found->second;
    };
    const auto intrude = [&] {
      is_second = true;
      s3_.settle();
      outcome.second = deed(*second, plan.second, plan);
      s3_.settle();
      is_second = false;
    };
    FakeS3::Script script;
    script.before = [&](const FakeS3::Call&) {
      if (is_second) return act(plan.second_fails, seconds++);
      if (firsts == plan.call && !plan.is_after) intrude();
      return act(plan.first_fails, firsts++);
    };
    script.after = [&](const FakeS3::Call&) {
      if (!is_second && firsts - 1 == plan.call && plan.is_after) intrude();
    };
    s3_.follow(std::move(script));
    outcome.first = deed(*first, plan.first, plan);
    s3_.follow({});
    return outcome;
  }

  // Whether a server that starts now finds the mesh whole: listed, described, its bytes
  // right, and read as it was asked to be.
  bool is_there(const Plan& plan) {
    const auto store = s3_.open();
    Metrics metrics("test");
    MeshCatalog catalog(*store, pool_, {}, metrics);
    const std::string id = id_of(plan);
    const auto bytes = catalog.source(id);
    const auto mesh = catalog.adjacency(id, {});
    return store->use(id) == true && catalog.metadata(id, {}) && bytes && *bytes == bytes_ &&
           mesh && (*mesh)->mesh().vertex_count() == 16;
  }

  bool add_again(const Plan& plan) {
    const auto store = s3_.open();
    return deed(*store, Deed::add, plan);
  }

 private:
  static std::string source(const std::string& id) { return "objects/" + id; }
  proto::ImportOptions options_of(const Plan& plan) const {
    proto::ImportOptions options;
    if (plan.has_options) options.scale = 0.001;
    return options;
  }
  std::string id_of(const Plan& plan) const {
    return mesh_id(sha256_hex(bytes_), proto::canonical_text(options_of(plan)));
  }

  bool deed(MeshStore& store, Deed what, const Plan& plan) {
    Metrics metrics("test");
    MeshCatalog catalog(store, pool_, {}, metrics);
    if (what == Deed::add) return static_cast<bool>(catalog.add(bytes_, options_of(plan), {}));
    if (what == Deed::read) return static_cast<bool>(catalog.source(id_of(plan)));
    return static_cast<bool>(catalog.remove(id_of(plan)));
  }

  const std::string bytes_ = glb_of(shapes::plane(4, 4));
  FakeS3 s3_;
  ComputePool pool_{1, 64};
};

// What must be so afterwards.
void check(Servers& servers, const Plan& plan) {
  CAPTURE(text_of(plan));
  const Servers::Outcome outcome = servers.run(plan);
  const bool removed =
      plan.first == Deed::remove || (plan.second == Deed::remove && outcome.second);
  const bool first_added = plan.first == Deed::add && outcome.first;
  const bool second_added = plan.second == Deed::add && outcome.second.value_or(false);
  const bool was_there = plan.found == Found::whole;
  // A removal before the other's last call may come before or after the upload.
  if (!removed && (first_added || second_added || was_there)) CHECK(servers.is_there(plan));
  // Whatever is left is no obstacle to the next upload.
  CHECK(servers.add_again(plan));
  CHECK(servers.is_there(plan));
}

std::uint64_t seed_of_this_run() {
  if (const char* const given = std::getenv("GEODESICD_SEED"))
    return std::strtoull(given, nullptr, 10);
  return std::random_device{}();
}

const std::vector<FakeS3::Act> kFailures = {FakeS3::Act::refuse, FakeS3::Act::serve_and_refuse};

}  // namespace

TEST_CASE("one upload within another, each call of the first failing in turn, loses nothing") {
  Servers servers;
  for (const Found found : {Found::nothing, Found::source_only, Found::damaged}) {
    for (int call = 0; call < 6; ++call) {
      for (const bool is_after : {false, true}) {
        Plan plan;
        plan.found = found;
        plan.call = call;
        plan.is_after = is_after;
        check(servers, plan);
        for (int failing = call; failing < 6; ++failing) {
          for (const FakeS3::Act act : kFailures) {
            plan.first_fails = {{failing, act}};
            check(servers, plan);
          }
        }
      }
    }
  }
}

TEST_CASE("an upload while another server finds the old bytes damaged stays") {
  Servers servers;
  for (int call = 0; call < 5; ++call) {
    for (const bool is_after : {false, true}) {
      Plan plan;
      plan.found = Found::damaged;
      plan.first = Deed::read;
      plan.call = call;
      plan.is_after = is_after;
      check(servers, plan);
    }
  }
}

TEST_CASE("whatever two servers do to one mesh, and whatever fails, acknowledged uploads stay") {
  const std::uint64_t seed = seed_of_this_run();
  MESSAGE("GEODESICD_SEED=" << seed);
  std::mt19937_64 random(seed);
  const auto any = [&](int n) { return std::uniform_int_distribution(0, n - 1)(random); };
  Servers servers;
  for (int round = 0; round < 300; ++round) {
    Plan plan;
    plan.found = static_cast<Found>(any(4));
    plan.first = static_cast<Deed>(any(3));
    plan.second = static_cast<Deed>(any(3));
    plan.has_options = any(2) == 0;
    plan.call = any(8);
    plan.is_after = any(2) == 0;
    for (int i = any(3); i > 0; --i) plan.first_fails[any(8)] = kFailures[any(2)];
    for (int i = any(3); i > 0; --i) plan.second_fails[any(8)] = kFailures[any(2)];
    check(servers, plan);
  }
}

TEST_CASE("a mesh larger than a mebibyte is whole where HEAD tells no length") {
  FakeS3 s3;
  std::string bytes(3 << 20, '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i)
    bytes[i] = static_cast<char>(i * 2654435761u >> 13);
  const std::string id = sha256_hex(bytes);
  REQUIRE(s3.open()->put(id, bytes, "{}"));
  for (const bool length_of_get : {true, false}) {
    for (const bool tags : {true, false}) {
      CAPTURE(length_of_get);
      CAPTURE(tags);
      s3.tells_length_of_head = false;
      s3.tells_length_of_get = length_of_get;
      s3.tells_tags = tags;
      const auto store = s3.open();
      REQUIRE(store->is_stored(id) == true);
      CHECK(store->stats().bytes == bytes.size());
      CHECK((store->get_source(id) == bytes));
      CHECK(store->stats().corrupt == 0);
    }
  }
  // Nor do lists that say less than is there.
  const auto store = s3.open();
  s3.put("objects/" + id, "short");
  REQUIRE(store->list("", 10));
  REQUIRE(s3.open()->is_stored(id) == true);
  s3.put("objects/" + id, bytes);
  CHECK((store->get_source(id) == bytes));
  CHECK(s3.object("objects/" + id));
}

TEST_CASE("what a server finds damaged it deletes for nobody, and serves once it is put again") {
  for (const bool tags : {true, false}) {
    CAPTURE(tags);
    FakeS3 s3;
    s3.tells_tags = tags;
    const std::string bytes = "a mesh of some length";
    const std::string id = sha256_hex(bytes);
    const auto one = s3.open();
    const auto two = s3.open();
    REQUIRE(one->put(id, bytes, "{}"));
    s3.put("objects/" + id, "a mesh of some lengtH");
    CHECK(one->get_source(id).error().code == InputCode::store_corrupt);
    CHECK(s3.object("quarantine/" + id) == "a mesh of some lengtH");
    if (tags) {
      // As long as the same bytes are there, it is known to be no mesh.
      CHECK(one->get_source(id).error().code == ServiceCode::mesh_unknown);
      CHECK(one->list("", 10)->empty());
      CHECK(one->is_stored(id) == false);
    }
    CHECK(one->is_damaged(id));
    // The other one has not read it: it writes the bytes rather than believe in them.
    REQUIRE(two->put(id, bytes, "{}"));
    CHECK(s3.object("objects/" + id) == bytes);
    CHECK(one->is_stored(id) == true);
    CHECK_FALSE(one->is_damaged(id));
    CHECK(one->get_source(id) == bytes);
    CHECK(two->get_source(id) == bytes);
  }
}

TEST_CASE("a mesh that this server knows to be whole is not written again") {
  FakeS3 s3;
  const std::string id = sha256_hex("x");
  const auto one = s3.open();
  REQUIRE(one->put(id, "x", "{}"));
  std::atomic<int> writes = 0;
  FakeS3::Script script;
  script.before = [&](const FakeS3::Call& call) {
    writes += call.method == "PUT" && call.key.starts_with("objects/");
    return FakeS3::Act::serve;
  };
  s3.follow(std::move(script));
  REQUIRE(one->put(id, "x", "{}"));
  CHECK(writes == 0);
  const auto two = s3.open();
  REQUIRE(two->put(id, "x", "{}"));
  CHECK(writes == 1);
  REQUIRE(two->put(id, "x", "{}"));
  CHECK(writes == 1);
  const auto three = s3.open();
  CHECK(three->get_source(id) == "x");
  REQUIRE(three->is_stored(id) == true);
  CHECK(three->is_surely_whole(id));
}

TEST_CASE("a name that one server gave is not written over by what another remembers") {
  FakeS3 s3;
  ComputePool pool(1, 64);
  Metrics metrics("test");
  const auto one = s3.open();
  const auto two = s3.open();
  MeshCatalog first(*one, pool, {}, metrics);
  MeshCatalog second(*two, pool, {}, metrics);
  const std::string bytes = glb_of(shapes::plane(4, 4));
  const auto upload = first.add(bytes, {}, {});
  REQUIRE(upload);
  REQUIRE(second.metadata(upload->id, {}));  // without a name, and remembered so
  REQUIRE(first.rename(upload->id, "ann's", {}));
  const auto again = second.add(bytes, {}, {}, "bob's");
  REQUIRE(again);
  CHECK(json::parse(again->metadata)["name"] == "ann's");
  CHECK(json::parse(*second.metadata(upload->id, {}))["name"] == "ann's");
  REQUIRE(second.rename(upload->id, "bob's", {}));
  REQUIRE(first.add(bytes, {}, {}));
  CHECK(json::parse(*s3.object("meta/" + upload->id + ".json"))["name"] == "bob's");
}

TEST_CASE("a stored mesh is there whether its name can be written or not") {
  FakeS3 s3;
  ComputePool pool(1, 64);
  Metrics metrics("test");
  const auto store = s3.open();
  MeshCatalog catalog(*store, pool, {}, metrics);
  const std::string bytes = glb_of(shapes::plane(4, 4));
  const auto upload = catalog.add(bytes, {}, {});
  REQUIRE(upload);
  FakeS3::Script script;
  script.before = [](const FakeS3::Call& call) {
    return call.method == "PUT" ? FakeS3::Act::refuse : FakeS3::Act::serve;
  };
  s3.follow(std::move(script));
  const auto again = catalog.add(bytes, {}, {}, "a name");
  REQUIRE(again);
  CHECK_FALSE(again->created);
  CHECK_FALSE(json::parse(again->metadata).contains("name"));
  CHECK_FALSE(catalog.rename(upload->id, "a name", {}));  // who asks for nothing else is told
}

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

TEST_CASE(
    "lists go on across pages, and a server's own removal is not forgotten by one under way") {
  FakeS3 s3;
  std::map<std::string, std::string> meshes;
  for (int i = 0; i < 60; ++i) meshes.emplace(sha256_hex(std::to_string(i)), std::to_string(i));
  const auto one = s3.open();
  for (const auto& [id, bytes] : meshes) REQUIRE(one->put(id, bytes, "{}"));
  s3.put("objects/no-id-of-ours", "");
  const auto two = s3.open();
  std::vector<std::string> listed;
  for (std::string after;; after = listed.back()) {
    const auto page = two->list(after, 7);
    REQUIRE(page);
    listed.insert(listed.end(), page->begin(), page->end());
    if (page->size() < 7) break;
  }
  REQUIRE(listed.size() == meshes.size());
  CHECK(std::equal(listed.begin(), listed.end(), meshes.begin(),
                   [](const std::string& id, const auto& mesh) { return id == mesh.first; }));

  const auto three = s3.open();
  const std::string& id = listed[5];
  FakeS3::Script script;
  script.after = [&](const FakeS3::Call& call) {
    if (call.key.empty()) CHECK(three->remove(id) == true);  // the list is made, and not yet read
  };
  s3.follow(script);
  REQUIRE(three->list("", 60));
  CHECK_FALSE(three->contains(id));
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
    REQUIRE_THROWS_AS(std::async(std::launch::async, [] {}), std::system_error);
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

TEST_CASE("of a job nothing is read that is larger than it may be: it is as if it were not there") {
  FakeS3 s3;
  const auto store = s3.open();
  const std::string id(48, 'a');
  const auto is_read = [&](ObjectKind kind, std::uint64_t most, std::size_t size) {
    s3.put("jobs/" + name_of_job_object(kind, id), std::string(size, 'x'));
    const auto object = store->storage().read(kind, id, most);
    REQUIRE(object);
    if (*object) CHECK((*object)->bytes.size() == size);
    return object->has_value();
  };
  for (const ObjectKind kind : kJobObjects) {
    for (const std::uint64_t most : {std::uint64_t{1000}, kMostJobBytes}) {
      CAPTURE(most);
      CHECK(is_read(kind, most, most));
      CHECK_FALSE(is_read(kind, most, most + 1));
      CHECK_FALSE(is_read(kind, most, 2 << 20));
    }
  }
}

TEST_CASE("a budget for a storage that others use is refused at the start") {
  FakeS3 s3;
  const auto store = s3.try_open({1000, WhenFull::evict});
  REQUIRE_FALSE(store);
  CHECK(store.error().detail.find("give the bucket a quota") != std::string::npos);
}
