// The store in object storage, against a real server: s3_test.py starts it and names
// it in GEODESIC_TEST_S3 (http://127.0.0.1:PORT), its process, which is to be paused,
// in GEODESIC_TEST_S3_PID, and a bucket in GEODESIC_TEST_S3_BUCKET.
#include <doctest/doctest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <future>
#include <map>
#include <string>
#include <vector>

#include "proto/wire/input_codes.h"
#include "server/base/service_codes.h"
#include "server/base/sha256.h"
#include "server/s3/s3_client.h"
#include "server/s3/s3_location.h"
#include "server/store/mesh_store.h"
#include "server/store/open_store.h"

using namespace geodesic;
using namespace geodesic::server;

namespace {

std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  REQUIRE_MESSAGE(value != nullptr, "run by s3_test.py, which sets " << name);
  return value;
}

Environment with(std::map<std::string, std::string> changed) {
  return [changed = std::move(changed)](const std::string& name) -> std::optional<std::string> {
    const auto found = changed.find(name);
    return found != changed.end() ? found->second : process_environment()(name);
  };
}

// A prefix of its own for each test: they share the bucket.
std::string url_of(const std::string& prefix, const std::string& more = {}) {
  return "s3://" + variable("GEODESIC_TEST_S3_BUCKET") + "/" + prefix +
         "?endpoint=" + variable("GEODESIC_TEST_S3") + more;
}

std::unique_ptr<MeshStore> opened(const std::string& url) {
  auto store = open_store(url, {}, process_environment());
  REQUIRE_MESSAGE(store, (store ? "" : store.error().detail));
  return std::move(*store);
}

S3Location location_of(const std::string& url) {
  auto location = parse_s3_url(url, process_environment());
  REQUIRE(location);
  return *location;
}

// What is in the bucket under a key; empty if nothing is.
std::string object(S3Client& client, const std::string& key) {
  S3Request request;
  request.key = client.location().prefix + key;
  const auto reply = client.send(request);
  REQUIRE(reply);
  return reply->status == 404 ? std::string() : reply->body;
}

void overwrite(S3Client& client, const std::string& key, std::string_view bytes) {
  S3Request request;
  request.method = "PUT";
  request.key = client.location().prefix + key;
  request.body = bytes;
  REQUIRE(client.send(request));
}

// The server answers nothing while this lives, but keeps its port.
class Paused {
 public:
  Paused() : process_(std::stoi(variable("GEODESIC_TEST_S3_PID"))) {
    REQUIRE(::kill(process_, SIGSTOP) == 0);
  }
  ~Paused() { ::kill(process_, SIGCONT); }
  Paused(const Paused&) = delete;
  Paused& operator=(const Paused&) = delete;

 private:
  pid_t process_;
};

// Whether the store is well, once the server has got over what it missed.
bool is_well_again(MeshStore& store) {
  for (int i = 0; i < 60; ++i) {
    if (store.check()) return true;
  }
  return false;
}

}  // namespace

TEST_CASE("S3: what was put comes back, from another process's store too") {
  const std::string bytes("glTF\0\xff mesh", 11);
  const std::string id = sha256_hex(bytes);
  const std::string url = url_of("round/trip");
  const auto store = opened(url);
  CHECK(store->size() == 0);
  CHECK(store->use(id) == false);
  REQUIRE(store->put(id, bytes, "{\"vertices\":3}"));
  CHECK(store->get_source(id) == bytes);
  const auto other = opened(url);
  CHECK(other->list("", 10) == std::vector<std::string>{id});
  CHECK(other->get_source(id) == bytes);
  CHECK(*other->get_metadata(id) == "{\"vertices\":3}");
  CHECK(store->remove(id) == true);
  CHECK(store->remove(id) == false);
  CHECK(store->get_source(id).error().code == ServiceCode::mesh_unknown);
  // The other one finds out when it asks.
  CHECK(other->get_source(id).error().code == ServiceCode::mesh_unknown);
  CHECK_FALSE(other->contains(id));
  CHECK(opened(url)->list("", 10)->empty());
}

TEST_CASE("S3: large and empty files come back as they were") {
  const auto store = opened(url_of("sizes"));
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{5} << 20}) {
    CAPTURE(size);
    std::string bytes(size, '\0');
    for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<char>(i * 2654435761u >> 13);
    const std::string id = sha256_hex(bytes);
    REQUIRE(store->put(id, bytes, "{}"));
    CHECK((store->get_source(id) == bytes));
  }
}

TEST_CASE("S3: lists go on from page to page") {
  const std::string url = url_of("pages");
  std::vector<std::string> ids;
  {
    const auto store = opened(url);
    std::vector<std::future<Result<void>>> puts;
    for (int i = 0; i < 40; ++i) {
      const std::string bytes = std::to_string(i);
      ids.push_back(sha256_hex(bytes));
      puts.push_back(std::async(std::launch::async, [&store, bytes] {
        return store->put(sha256_hex(bytes), bytes, "{}");
      }));
    }
    for (auto& put : puts) REQUIRE(put.get());
  }
  // The server's pages have 5 keys.
  std::sort(ids.begin(), ids.end());
  const auto store = opened(url);
  CHECK(store->stats().meshes == 0);
  std::vector<std::string> listed;
  for (std::string after; listed.size() < ids.size(); after = listed.back()) {
    const auto page = store->list(after, 7);
    REQUIRE(page);
    REQUIRE_FALSE(page->empty());
    listed.insert(listed.end(), page->begin(), page->end());
  }
  CHECK(listed == ids);
  CHECK(store->list(ids.back(), 7)->empty());
  CHECK(store->list("", 100) == ids);
  CHECK(store->stats().bytes == 30 * 2 + 10);
}

TEST_CASE("S3: what another process uploads, renames and removes is seen") {
  const std::string url = url_of("two");
  const auto one = opened(url);
  const auto two = opened(url);
  const std::string id = sha256_hex("x");
  REQUIRE(one->put(id, "x", "{}"));
  CHECK(two->list("", 10) == std::vector<std::string>{id});
  CHECK(two->get_metadata(id) == "{}");
  REQUIRE(one->put_metadata(id, "{\"name\":\"other\"}"));
  REQUIRE(two->confirm_used(std::chrono::seconds(0)));
  CHECK(two->get_metadata(id) == "{\"name\":\"other\"}");
  CHECK(one->remove(id) == true);
  CHECK(two->contains(id));
  CHECK(two->list("", 10)->empty());
  REQUIRE(two->confirm_used(std::chrono::seconds(0)));
  CHECK_FALSE(two->contains(id));
  REQUIRE(one->put(id, "x", "{}"));
  CHECK(two->is_stored(id) == true);
  CHECK(one->remove(id) == true);
  // Known to the one that does not know better; but putting it stores it again.
  CHECK(two->contains(id));
  REQUIRE(two->put(id, "x", "{}"));
  CHECK(one->get_source(id) == "x");
}

TEST_CASE("S3: damaged bytes are put into quarantine and not served") {
  const std::string url = url_of("rot");
  S3Client client(location_of(url));
  const auto store = opened(url);
  const std::string bytes = "a mesh of some length";
  const std::string id = sha256_hex(bytes);
  for (const std::string& damaged : {std::string("a mesh"), std::string("a mesh of some lengtH"),
                                     std::string(), std::string(3 << 20, 'x')}) {
    CAPTURE(damaged.size());
    REQUIRE(store->put(id, bytes, "{}"));
    overwrite(client, "objects/" + id, damaged);
    const auto got = store->get_source(id);
    REQUIRE_FALSE(got);
    CHECK(got.error().code == InputCode::store_corrupt);
    CHECK((object(client, "quarantine/" + id) == damaged.substr(0, 1 << 20)));
    // Not deleted, for another process may have put the mesh again meanwhile.
    CHECK((object(client, "objects/" + id) == damaged.substr(0, 1 << 20)));
    CHECK(store->get_source(id).error().code == ServiceCode::mesh_unknown);
    CHECK(store->is_stored(id) == false);
    CHECK(store->list("", 10)->empty());
  }
  CHECK(store->stats().corrupt == 4);
  REQUIRE(store->put(id, bytes, "{}"));
  CHECK(store->get_source(id) == bytes);
  // Another process that has read nothing of it writes it again.
  overwrite(client, "objects/" + id, "damaged again");
  REQUIRE(opened(url)->put(id, bytes, "{}"));
  CHECK(store->get_source(id) == bytes);
}

TEST_CASE("S3: a budget, for which nobody could count, is refused at the start") {
  const auto store = open_store(url_of("budget"), {2500, WhenFull::evict}, process_environment());
  REQUIRE_FALSE(store);
  CHECK(store.error().detail.find("--store-max-bytes is for a directory") != std::string::npos);
}

TEST_CASE("S3: every way to name the bucket is signed as the server reads it") {
  const std::string id = sha256_hex("x");
  const std::string endpoint = variable("GEODESIC_TEST_S3");
  const std::string port = endpoint.substr(endpoint.rfind(':') + 1);
  const std::string bucket = variable("GEODESIC_TEST_S3_BUCKET");
  for (const std::string& url :
       {url_of(""), url_of("a-b_c.d~e/F/09/"),
        "s3://" + bucket + "?endpoint=http%3A%2F%2Flocalhost%3A" + port,
        // BUCKET.localhost is this machine for libcurl.
        "s3://" + bucket + "/v?style=virtual&endpoint=http://localhost:" + port}) {
    CAPTURE(url);
    const auto store = opened(url);
    REQUIRE(store->put(id, "x", "{}"));
    CHECK(store->get_source(id) == "x");
    CHECK(store->remove(id) == true);
    CHECK(store->check());
  }
  // A session's token is one more header to sign.
  const auto store = open_store(url_of("session"), {}, with({{"AWS_SESSION_TOKEN", "a/b+c=="}}));
  REQUIRE(store);
  REQUIRE((*store)->put(id, "x", "{}"));
  CHECK((*store)->get_source(id) == "x");
}

TEST_CASE("S3: a store that cannot be opened says why, and tells no secret") {
  const auto wrong = open_store(url_of(""), {}, with({{"AWS_SECRET_ACCESS_KEY", "hush-hush"}}));
  REQUIRE_FALSE(wrong);
  CHECK(wrong.error().code == ServiceCode::store_failed);
  CHECK(wrong.error().detail.find("SignatureDoesNotMatch") != std::string::npos);
  CHECK(wrong.error().detail.find("hush") == std::string::npos);
  const auto missing = open_store("s3://nosuchbucket?endpoint=" + variable("GEODESIC_TEST_S3"), {},
                                  process_environment());
  REQUIRE_FALSE(missing);
  CHECK(missing.error().detail ==
        "cannot use s3://nosuchbucket/ as the store: the bucket of the object store is not there");
  // Nobody listens at port 1.
  const auto down =
      open_store("s3://bucket?endpoint=http://127.0.0.1:1", {}, process_environment());
  REQUIRE_FALSE(down);
  CHECK(down.error().code == ServiceCode::store_unavailable);
  CHECK(down.error().detail.find("cannot be reached") != std::string::npos);
}

TEST_CASE("S3: when the server hangs, errors are soon and clear, and it comes back") {
  const auto store = opened(url_of("hang", "&timeout=1"));
  const std::string id = sha256_hex("x");
  REQUIRE(store->put(id, "x", "{}"));
  {
    const Paused paused;
    const auto first = store->get_source(id);
    REQUIRE_FALSE(first);
    CHECK(first.error().code == ServiceCode::store_unavailable);
    CHECK(first.error().detail.find("127.0.0.1") == std::string::npos);
    // From now on nobody waits: a thousand requests would take an hour.
    for (int i = 0; i < 1000; ++i) {
      CHECK(store->get_source(id).error().code == ServiceCode::store_unavailable);
    }
    CHECK(store->use(sha256_hex("y")).error().code == ServiceCode::store_unavailable);
    CHECK(store->put(sha256_hex("y"), "y", "{}").error().code == ServiceCode::store_unavailable);
    CHECK(store->remove(id).error().code == ServiceCode::store_unavailable);
    CHECK(store->contains(id));
    CHECK(store->list("", 10).error().code == ServiceCode::store_unavailable);
    CHECK_FALSE(store->check());
    CHECK(store->health().error().code == ServiceCode::store_unavailable);
  }
  CHECK(is_well_again(*store));
  CHECK(store->health());
  CHECK(store->get_source(id) == "x");
  REQUIRE(store->put(sha256_hex("y"), "y", "{}"));
}

TEST_CASE("S3: a hundred requests at once to a server that hangs are answered all the same") {
  const auto store = opened(url_of("crowd", "&timeout=1"));
  const std::string id = sha256_hex("x");
  REQUIRE(store->put(id, "x", "{}"));
  std::atomic<int> unavailable{0};
  {
    const Paused paused;
    std::vector<std::thread> crowd;
    for (int i = 0; i < 100; ++i) {
      crowd.emplace_back([&] {
        const auto got = store->get_source(id);
        if (!got && got.error().code == ServiceCode::store_unavailable) ++unavailable;
      });
    }
    for (std::thread& one : crowd) one.join();
  }
  CHECK(unavailable == 100);
  CHECK(is_well_again(*store));
  CHECK(store->get_source(id) == "x");
}

TEST_CASE("S3: puts, reads and removals at once do no harm") {
  const auto store = opened(url_of("busy"));
  std::vector<std::future<int>> workers;
  for (int t = 0; t < 6; ++t) {
    workers.push_back(std::async(std::launch::async, [&, t] {
      int wrong = 0;
      for (int i = 0; i < 4; ++i) {
        const std::string bytes(10'000, static_cast<char>('a' + (i + t) % 3));
        const std::string id = sha256_hex(bytes);
        if (t < 3) wrong += !store->put(id, bytes, "{}");
        if (t == 3) wrong += !store->remove(id);
        const auto got = store->get_source(id);
        if (got ? *got != bytes : got.error().code != ServiceCode::mesh_unknown) ++wrong;
      }
      return wrong;
    }));
  }
  for (auto& worker : workers) CHECK(worker.get() == 0);
  CHECK(store->stats().corrupt == 0);
}
