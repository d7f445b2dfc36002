// What a server reads and writes in a bucket that others use too, and what it refuses.
#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "proto/wire/input_codes.h"
#include "server/base/service_codes.h"
#include "server/base/sha256.h"
#include "server/compute/pool.h"
#include "server/metrics/metrics.h"
#include "server/query/mesh_catalog.h"
#include "server/store/budget.h"
#include "server/store/object_storage.h"
#include "tests/server/routes/service_fixture.h"
#include "tests/server/store/fake_s3.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

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
