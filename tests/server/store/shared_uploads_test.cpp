// Two servers on one bucket. Whatever fails, and in whatever order their requests
// arrive, an upload that either of them has acknowledged is there afterwards, whole,
// unless somebody asked for its removal meanwhile.
//
// GEODESICD_SEED=N repeats a random run.
#include <doctest/doctest.h>

#include <cstdint>
#include <cstdlib>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "proto/wire/import_options.h"
#include "server/base/sha256.h"
#include "server/compute/pool.h"
#include "server/metrics/metrics.h"
#include "server/query/mesh_catalog.h"
#include "server/store/mesh_id.h"
#include "server/store/mesh_store.h"
#include "tests/server/routes/service_fixture.h"
#include "tests/server/store/fake_s3.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

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
