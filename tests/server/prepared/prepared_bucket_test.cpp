// A bucket behind the directories of prepared meshes: what one machine has prepared, another one
// fetches, and no fault of the bucket changes an answer or holds one up for long.
#include "server/prepared/prepared_bucket.h"

#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <random>
#include <string>
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

std::unique_ptr<PreparedFiles> opened_on(const TemporaryFolder& folder, const FakeS3& bucket,
                                         char build = '1') {
  auto location = parse_s3_url(bucket.url(), FakeS3::environment);
  REQUIRE(location);
  return opened(folder, {}, std::string(32, build),
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
    check_same(*adjacency, **found);
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

TEST_CASE("WhatIsDamagedInTheBucketIsNotUsedAndGoes") {
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
    CHECK(!bucket.object(key_of(kId)));
    CHECK(count_files(folder) == 0);
  }
  CHECK(files->stats().damaged == 60);
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
  bucket.follow({.before = [&](const FakeS3::Call& call) {
    if (call.method == "PUT") files->erase(kId);  // nothing is there yet
    return FakeS3::Act::serve;
  }});
  files->keep(kId, adjacency);
  files->wait();
  CHECK(bucket.keys().empty());
  CHECK(count_files(folder) == 0);
}

TEST_CASE("ABucketThatFailsOnlyCostsTime") {
  FakeS3 bucket;
  const auto adjacency = put(bucket, shapes::plane(9, 9));
  const TemporaryFolder folder;
  const auto files = opened_on(folder, bucket);
  SUBCASE("it refuses") {
    bucket.follow({.before = [](const FakeS3::Call&) { return FakeS3::Act::refuse; }});
    check_nothing(files->find(kId, kNeverStop));
    CHECK(files->stats().bucket_failed == 1);
  }
  SUBCASE("it refuses to send the object") {
    bucket.follow({.before = [](const FakeS3::Call& call) {
      return call.method == "GET" ? FakeS3::Act::refuse : FakeS3::Act::serve;
    }});
    check_nothing(files->find(kId, kNeverStop));
    CHECK(files->stats().bucket_failed == 1);
  }
  SUBCASE("the object goes between the two questions") {
    bucket.follow({.after = [&](const FakeS3::Call& call) {
      if (call.method == "HEAD") bucket.erase(key_of(kId));
    }});
    check_nothing(files->find(kId, kNeverStop));
    CHECK(files->stats().bucket_failed == 1);
  }
  SUBCASE("the object grows between the two questions") {
    bucket.follow({.after = [&](const FakeS3::Call& call) {
      if (call.method == "HEAD") bucket.put(key_of(kId), std::string(1 << 20, 'x'));
    }});
    check_nothing(files->find(kId, kNeverStop));
    CHECK(files->stats().bucket_failed == 1);
  }
  SUBCASE("it does not tell lengths") {
    bucket.tells_length_of_head = false;
    check_nothing(files->find(kId, kNeverStop));
  }
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
