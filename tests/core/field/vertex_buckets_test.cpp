#include "core/field/vertex_buckets.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/fixtures/random_meshes.h"

using namespace geodesic;
using fixtures::RandomMesh;

namespace {

// Takes everything; each bucket must hold what a sorted list has next, but for its width.
void check_order(VertexBuckets& buckets, const std::vector<double>& keys, double width) {
  std::vector<double> sorted = keys;
  std::sort(sorted.begin(), sorted.end());
  std::size_t done = 0;
  std::vector<std::uint32_t> taken;
  while (!buckets.empty()) {
    taken.clear();
    buckets.take(taken);
    REQUIRE(!taken.empty());
    for (const std::uint32_t v : taken) {
      CHECK(keys[v] >= sorted[done] * (1 - 1e-12));
      CHECK(keys[v] <= (sorted[done] + width) * (1 + 1e-12));
    }
    done += taken.size();
  }
  CHECK(done == keys.size());
}

}  // namespace

TEST_CASE("BucketsAreTakenInTheOrderOfTheirKeys") {
  RandomMesh random(5);
  // All in the ring; far beyond it; beyond what can be counted; and all in one bucket.
  for (const double largest : {100.0, 1e7, 1e300}) {
    for (const double width : {0.5, 3.0, 1e-12}) {
      CAPTURE(largest);
      CAPTURE(width);
      VertexBuckets buckets;
      buckets.reset(width);
      std::vector<double> keys;
      for (std::uint32_t v = 0; v < 3000; ++v) {
        keys.push_back(std::pow(random.unit(), 4) * largest);
        buckets.push(v, keys.back());
      }
      // Where buckets are not counted further, they share the last one.
      const double counted = largest / width > 1e18 ? largest : width;
      check_order(buckets, keys, counted);
    }
  }
}

TEST_CASE("AKeyThatWasLoweredWithinItsBucketWaitsThereOnce") {
  for (const double width : {1.0, 0.0}) {  // 0: all share one
    CAPTURE(width);
    VertexBuckets buckets;
    buckets.reset(width);
    buckets.push(7, 3.5);
    buckets.push(7, 3.25, 3.5);
    std::vector<std::uint32_t> taken;
    buckets.take(taken);
    CHECK(taken == std::vector<std::uint32_t>{7});
    CHECK(buckets.empty());
  }
  VertexBuckets buckets;
  buckets.reset(1);
  buckets.push(7, 3.5);
  buckets.push(7, 2.5, 3.5);
  std::vector<std::uint32_t> taken;
  buckets.take(taken);
  CHECK(taken == std::vector<std::uint32_t>{7});
  CHECK(!buckets.empty());  // it is in the other one still
}

TEST_CASE("AKeyBelowTheBucketThatWasTakenLastIsOfThatOne") {
  VertexBuckets buckets;
  buckets.reset(1);
  buckets.push(1, 10.5);
  std::vector<std::uint32_t> taken;
  buckets.take(taken);
  CHECK(taken == std::vector<std::uint32_t>{1});
  CHECK(buckets.empty());
  CHECK(!buckets.has_more_now());
  buckets.push(2, 3);
  buckets.push_back(3);
  buckets.push(4, 11);
  CHECK(buckets.has_more_now());
  buckets.push(3, 4, 10.9);  // waits there already
  CHECK(buckets.is_now(10.1));
  CHECK(!buckets.is_now(9.9));
  CHECK(!buckets.is_beyond(10));
  taken.clear();
  buckets.take(taken);
  std::sort(taken.begin(), taken.end());
  CHECK(taken == std::vector<std::uint32_t>{2, 3});
  CHECK(buckets.is_beyond(10.9));
  CHECK(buckets.is_beyond(-1));
  CHECK(!buckets.is_beyond(11));
}

TEST_CASE("WithoutAWidthAllKeysShareABucket") {
  for (const double width : {0.0, std::numeric_limits<double>::quiet_NaN(), 1e-320}) {
    VertexBuckets buckets;
    buckets.reset(width);
    for (std::uint32_t v = 0; v < 10; ++v) buckets.push(v, 1e60 * v);
    std::vector<std::uint32_t> taken;
    buckets.take(taken);
    CHECK(taken.size() == 10);
    CHECK(buckets.empty());
  }
}
