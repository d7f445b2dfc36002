// A bucket behind the directories of prepared meshes: what one machine has prepared, another one
// fetches, and no fault of the bucket changes an answer or holds one up for long.
#include "server/prepared/prepared_bucket.h"

#include <doctest/doctest.h>
#include <sys/stat.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <memory>
#include <random>
#include <semaphore>
#include <set>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "core/mesh/shapes.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/test_seed.h"
#include "tests/server/prepared/prepared_fixture.h"
#include "tests/server/store/fake_s3.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using geodesic::fixtures::test_seed;
using Clock = std::chrono::steady_clock;

namespace {

// Erases a mesh on a thread of the bucket's. A transfer that this breaks off does not wait for that
// thread; a test has to, before it lets go of the files.
class EraseInBetween {
 public:
  explicit EraseInBetween(PreparedFiles& files) : files_(files) {}
  void do_it() {
    files_.erase(kId);
    done_.release();
  }
  void wait() { REQUIRE(done_.try_acquire_for(std::chrono::seconds(20))); }

 private:
  PreparedFiles& files_;
  std::counting_semaphore<> done_{0};
};

std::unique_ptr<PreparedFiles> opened_on(const TemporaryFolder& folder, const FakeS3& bucket,
                                         char build = '1',
                                         const PreparedFiles::Limits& limits = {}) {
  auto location = parse_s3_url(bucket.url(), FakeS3::environment);
  REQUIRE(location);
  return opened(folder, limits, std::string(32, build),
                std::make_unique<PreparedBucket>(std::move(*location)));
}

std::string key_of(const std::string& id, char build = '1') {
  return "prepared/" + id + "." + std::string(12, build);
}

// A mesh in the bucket, which a machine of its own has put there.
std::shared_ptr<const Adjacency> put(const FakeS3& bucket, const TriangleSoup& soup,
                                     const std::string& id = kId) {
  const TemporaryFolder folder;
  const auto adjacency = prepared(soup);
  const auto files = opened_on(folder, bucket);
  files->keep(id, adjacency);
  files->wait();
  CHECK(files->stats().uploaded == 1);
  CHECK(files->stats().bucket_failed == 0);
  return adjacency;
}

void check_nothing(const Result<std::shared_ptr<const Adjacency>>& found) {
  REQUIRE(found);
  CHECK(!*found);
}

}  // namespace

TEST_CASE("WhatOneMachineHasPreparedAnotherOneFetches") {
  FakeS3 bucket;
  for (std::uint32_t i = 0; i < 20; ++i) {
    CAPTURE(i);
    const std::string id = kId + std::to_string(i);
    const auto adjacency = put(bucket, fixtures::RandomMesh(test_seed() + i).soup(), id);
    const TemporaryFolder folder;
    const auto files = opened_on(folder, bucket);
    const auto found = files->find(id, kNeverStop);
    REQUIRE((found && *found));
    fixtures::check_same(*adjacency, **found);
    CHECK(files->stats().fetched == 1);
    CHECK(files->stats().found == 1);
    CHECK(files->stats().missing == 0);
    // It is in the directory now.
    bucket.erase(key_of(id));
    const auto again = files->find(id, kNeverStop);
    CHECK((again && *again));
    CHECK(files->stats().fetched == 1);
  }
}

TEST_CASE("WhatTheBucketHasIsNotUploadedAgain") {
  std::atomic<int> uploads{0};
  FakeS3 bucket;
  bucket.follow({.before = [&](const FakeS3::Call& call) {
    uploads += call.method == "PUT" ? 1 : 0;
    return FakeS3::Act::serve;
  }});
  const auto adjacency = put(bucket, shapes::plane(9, 9));
  const TemporaryFolder folder;
  const auto files = opened_on(folder, bucket);
  files->keep(kId, adjacency);
  files->wait();
  CHECK(files->stats().written == 1);
  CHECK(uploads == 1);
}

TEST_CASE("WhatIsDamagedInTheBucketIsNotUsedAndIsReplaced") {
  std::mt19937 random(test_seed());
  FakeS3 bucket;
  const auto adjacency = put(bucket, fixtures::RandomMesh(test_seed()).soup());
  const std::string whole = *bucket.object(key_of(kId));
  const TemporaryFolder folder;
  const auto files = opened_on(folder, bucket);
  for (int i = 0; i < 60; ++i) {
    std::string damaged = whole;
    if (i % 3 == 0) {
      damaged.resize(1 + random() % (whole.size() - 1));
    } else {
      char& byte = damaged[random() % (i % 2 == 0 ? whole.size() : 512)];
      byte = static_cast<char>(static_cast<unsigned char>(byte) ^ (1U << random() % 8));
    }
    bucket.put(key_of(kId), damaged);
    check_nothing(files->find(kId, kNeverStop));
    CHECK(bucket.object(key_of(kId)) == damaged);  // it may have been this machine's disk
    CHECK(count_files(folder) == 0);
  }
  CHECK(files->stats().bucket_damaged == 60);
  CHECK(files->stats().missing == 60);
  CHECK(files->stats().damaged == 0);
  CHECK(files->stats().bucket_failed == 0);
  files->keep(kId, adjacency);
  files->wait();
  CHECK(bucket.object(key_of(kId)) == whole);
}

TEST_CASE("AnotherBuildsObjectIsNotFetched") {
  FakeS3 bucket;
  const auto adjacency = put(bucket, shapes::plane(9, 9));
  const TemporaryFolder folder;
  const auto files = opened_on(folder, bucket, '2');
  check_nothing(files->find(kId, kNeverStop));
  CHECK(files->stats().missing == 1);
  CHECK(bucket.object(key_of(kId)));
}

TEST_CASE("ADeletedMeshLeavesTheBucketWithTheObjectsOfAllBuilds") {
  FakeS3 bucket;
  const std::string other(64, 'b');
  const auto adjacency = put(bucket, shapes::plane(9, 9));
  put(bucket, shapes::plane(5, 5), other);
  const TemporaryFolder folder;
  const auto files = opened_on(folder, bucket, '2');
  files->keep(kId, adjacency);
  files->wait();
  CHECK(bucket.keys().size() == 3);
  files->erase(kId);
  CHECK(bucket.keys() == std::vector{key_of(other)});
}

TEST_CASE("WhatIsDeletedWhileItIsUploadedDoesNotStay") {
  FakeS3 bucket;
  const TemporaryFolder folder;
  const auto files = opened_on(folder, bucket);
  const auto adjacency = prepared(shapes::plane(9, 9));
  EraseInBetween erase(*files);
  bucket.follow({.before = [&](const FakeS3::Call& call) {
    if (call.method == "PUT") erase.do_it();  // nothing is there yet
    return FakeS3::Act::serve;
  }});
  files->keep(kId, adjacency);
  files->wait();
  erase.wait();
  CHECK(bucket.keys().empty());
  CHECK(count_files(folder) == 0);
}

TEST_CASE("ABucketThatFailsOnlyCostsTime") {
  FakeS3 bucket;
  const auto adjacency = put(bucket, shapes::plane(9, 9));
  const TemporaryFolder folder;
  const auto files = opened_on(folder, bucket);
  FakeS3::Act act = FakeS3::Act::serve;
  SUBCASE("it refuses") { act = FakeS3::Act::refuse; }
  SUBCASE("it is too busy") { act = FakeS3::Act::later; }
  SUBCASE("it breaks off") { act = FakeS3::Act::break_off; }
  SUBCASE("it does not tell lengths") { bucket.tells_length_of_get = false; }
  SUBCASE("it has nothing but the name") { bucket.put(key_of(kId), ""); }
  bucket.follow({.before = [act](const FakeS3::Call&) { return act; }});
  check_nothing(files->find(kId, kNeverStop));
  CHECK(files->stats().bucket_failed == 1);
  CHECK(count_files(folder) == 0);  // no part of it
  // And what is prepared anew is kept here all the same.
  files->keep(kId, adjacency);
  files->wait();
  CHECK(files->stats().written == 1);
  const auto found = files->find(kId, kNeverStop);
  CHECK((found && *found));
}

TEST_CASE("ABucketThatIsAwayOrSlowHoldsNobodyUpForLong") {
  std::atomic<bool> is_slow{true};
  std::atomic<bool> is_asked{false};
  FakeS3 bucket;
  put(bucket, shapes::plane(9, 9));
  bucket.follow({.before = [&](const FakeS3::Call& call) {
    is_asked = is_asked || call.method == "GET";
    const auto end = Clock::now() + std::chrono::seconds(20);
    while (call.method == "GET" && is_slow && Clock::now() < end) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return FakeS3::Act::serve;
  }});
  const TemporaryFolder folder;
  SUBCASE("it is given up") {
    const auto files = opened_on(folder, bucket);
    const auto began = Clock::now();
    check_nothing(files->find(kId, kNeverStop));
    CHECK(Clock::now() - began < std::chrono::seconds(15));
    // And is left alone for some seconds.
    check_nothing(files->find(kId, kNeverStop));
    CHECK(files->stats().bucket_failed == 2);
  }
  SUBCASE("whoever is told to stop does") {
    const auto files = opened_on(folder, bucket);
    const auto found = files->find(kId, [&] { return is_asked.load(); });
    REQUIRE(!found);
    CHECK(found.error().code == ErrorCode::cancelled);
    CHECK(files->stats().bucket_failed == 0);
  }
  is_slow = false;
  CHECK(count_files(folder) == 0);
}

TEST_CASE("WhatWasWrittenWhileTheBucketWasAwayIsUploadedLater") {
  FakeS3 bucket;
  const auto adjacency = prepared(shapes::plane(9, 9));
  const TemporaryFolder folder;
  const auto find = [&](PreparedFiles& files) {
    const auto found = files.find(kId, kNeverStop);
    CHECK((found && *found));
    files.wait();
  };
  SUBCASE("it refused") {
    const auto files = opened_on(folder, bucket);
    bucket.follow({.before = [](const FakeS3::Call&) { return FakeS3::Act::refuse; }});
    files->keep(kId, adjacency);
    files->wait();
    CHECK(files->stats().written == 1);
    CHECK(files->stats().bucket_failed == 1);
    CHECK(bucket.keys().empty());
    bucket.follow({});
    find(*files);
  }
  SUBCASE("there was none") {
    {
      const auto files = opened(folder);
      files->keep(kId, adjacency);
      files->wait();
    }
    const auto files = opened_on(folder, bucket);
    find(*files);
    CHECK(files->stats().uploaded == 1);
  }
  SUBCASE("it had another file of that name") {
    put(bucket, shapes::plane(9, 9));
    const std::string whole = *bucket.object(key_of(kId));
    bucket.put(key_of(kId), whole.substr(1));
    const auto files = opened_on(folder, bucket);
    files->keep(kId, adjacency);
    files->wait();
    CHECK(bucket.object(key_of(kId)) == whole);
  }
  CHECK(bucket.object(key_of(kId)) == bytes_of_file(only_file(folder)));
  // Once it is known to be there, it is not asked for.
  const auto files = opened_on(folder, bucket);
  std::atomic<int> calls{0};
  bucket.follow({.before = [&](const FakeS3::Call&) {
    ++calls;
    return FakeS3::Act::serve;
  }});
  for (int i = 0; i < 3; ++i) find(*files);
  CHECK(calls == 1);
  CHECK(files->stats().uploaded == 0);
}

TEST_CASE("ABucketThatDoesNotTellWhatItHasIsWrittenTo") {
  FakeS3 bucket;
  const auto adjacency = prepared(shapes::plane(9, 9));
  const TemporaryFolder folder;
  const auto files = opened_on(folder, bucket);
  SUBCASE("nobody may ask") {
    bucket.follow({.before = [](const FakeS3::Call& call) {
      return call.method == "HEAD" ? FakeS3::Act::refuse : FakeS3::Act::serve;
    }});
  }
  SUBCASE("it has it, but tells no length") {
    put(bucket, shapes::plane(9, 9));
    bucket.tells_length_of_head = false;
  }
  files->keep(kId, adjacency);
  files->wait();
  CHECK(bucket.object(key_of(kId)) == bytes_of_file(only_file(folder)));
  CHECK(files->stats().bucket_failed == 0);
}

TEST_CASE("AnUploadThatHangsEndsWithTheServerAndWithItsMesh") {
  std::atomic<bool> is_over{false};
  std::atomic<bool> is_asked{false};
  FakeS3 bucket;
  bucket.follow({.before = [&](const FakeS3::Call& call) {
    if (call.method != "PUT") return FakeS3::Act::serve;
    is_asked = true;
    const auto end = Clock::now() + std::chrono::seconds(40);
    while (!is_over && Clock::now() < end)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return FakeS3::Act::refuse;
  }});
  const TemporaryFolder folder;
  auto files = opened_on(folder, bucket);
  // The mesh is held no longer than it takes to write its file.
  auto adjacency = prepared(shapes::plane(9, 9));
  const std::weak_ptr<const Adjacency> held = adjacency;
  files->keep(kId, adjacency);
  while (!is_asked) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  adjacency.reset();
  CHECK(held.expired());
  const auto began = Clock::now();
  SUBCASE("the server") { files.reset(); }
  SUBCASE("the mesh") {
    files->erase(kId);
    files->wait();
    CHECK(count_files(folder) == 0);
    CHECK(files->stats().bucket_failed == 0);
  }
  CHECK(Clock::now() - began < std::chrono::seconds(8));  // the upload may take ten
  is_over = true;
}

TEST_CASE("AFileThatIsFetchedHasItsRoomFromTheStart") {
  FakeS3 bucket;
  const auto first = put(bucket, shapes::terrain(20, 2, test_seed()));
  const std::uint64_t size = bucket.object(key_of(kId))->size();
  const std::string other(64, 'b');
  put(bucket, shapes::terrain(20, 2, test_seed() + 1), other);
  const TemporaryFolder folder;
  // Room for one and a half.
  const auto files = opened_on(folder, bucket, '1', {.bytes = size + size / 2, .fewest_faces = 0});
  std::atomic<int> asked{0};
  bucket.follow({.before = [&](const FakeS3::Call&) {  // so that both come at once
    ++asked;
    const auto end = Clock::now() + std::chrono::seconds(1) / 2;
    while (asked < 2 && Clock::now() < end) std::this_thread::yield();
    return FakeS3::Act::serve;
  }});
  std::uint64_t most = 0;
  const auto measure = [&] {
    std::uint64_t bytes = 0;
    std::set<ino_t> seen;  // one that is renamed meanwhile is met twice
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder.path())) {
      struct stat file {};
      if (::stat(entry.path().c_str(), &file) != 0 || !S_ISREG(file.st_mode)) continue;
      if (seen.insert(file.st_ino).second) bytes += static_cast<std::uint64_t>(file.st_size);
    }
    most = std::max(most, bytes);
    return false;
  };
  // While both come, asked every few milliseconds.
  std::thread another([&] { (void)files->find(other, kNeverStop); });
  (void)files->find(kId, measure);
  another.join();
  measure();
  CHECK(most <= size + size / 2);
  CHECK(most >= size);
}

TEST_CASE("WhatGoesWhileItIsFetchedDoesNotComeBack") {
  FakeS3 bucket;
  const auto adjacency = put(bucket, shapes::plane(9, 9));
  const TemporaryFolder folder;
  const auto files = opened_on(folder, bucket);
  SUBCASE("the mesh") {
    EraseInBetween erase(*files);
    bucket.follow({.after = [&](const FakeS3::Call& call) {
      if (call.method == "GET" && !call.key.empty()) erase.do_it();
    }});
    check_nothing(files->find(kId, kNeverStop));
    erase.wait();
    CHECK(bucket.keys().empty());
  }
  SUBCASE("its file, by another server of the directory") {
    const auto others = opened(folder);
    bool is_begun = false;
    const auto stop = [&] {
      if (count_files(folder) > 0 && !is_begun) {
        is_begun = true;
        others->erase(kId);
      }
      return false;
    };
    // It may have come as a whole before anybody was asked.
    const auto found = files->find(kId, stop);
    CHECK(found);
    CHECK(files->stats().bucket_failed == 0);
    if (is_begun && !*found) CHECK(count_files(folder) == 0);
    return;
  }
  CHECK(count_files(folder) == 0);
}

TEST_CASE("WithoutRoomNothingIsFetched") {
  FakeS3 bucket;
  const auto adjacency = put(bucket, shapes::plane(9, 9));
  const TemporaryFolder folder;
  const auto files = opened_on(folder, bucket, '1', {.bytes = 100, .fewest_faces = 0});
  check_nothing(files->find(kId, kNeverStop));
  CHECK(files->stats().not_written == 1);
  CHECK(files->stats().bucket_failed == 0);
  CHECK(count_files(folder) == 0);
}

TEST_CASE("WhatCouldNotBeErasedIsErasedByTheNextDelete") {
  FakeS3 bucket;
  const TemporaryFolder store;
  const TemporaryFolder folder;
  const auto files = opened_on(folder, bucket);
  server::test::Service server(store.path(), {});
  server.catalog.keep_prepared_in(*files);
  const std::string id = server.upload(server::test::glb_of(shapes::plane(9, 9)));
  files->wait();
  REQUIRE(bucket.keys() == std::vector{key_of(id)});
  bucket.follow({.before = [](const FakeS3::Call& call) {
    return call.method == "DELETE" ? FakeS3::Act::refuse : FakeS3::Act::serve;
  }});
  CHECK(server.ask("DELETE", "/v1/meshes/" + id).status == 204);
  CHECK(count_files(folder) == 0);
  CHECK(bucket.keys().size() == 1);
  CHECK(files->stats().bucket_failed == 1);
  bucket.follow({});
  CHECK(server.ask("DELETE", "/v1/meshes/" + id).status == 404);
  CHECK(bucket.keys().empty());
}
