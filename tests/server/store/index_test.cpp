#include "server/store/index.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "server/base/service_codes.h"

using namespace geodesic;
using namespace geodesic::server;

namespace {

using Ids = std::vector<std::string>;

StoreBudget of(std::uint64_t bytes, WhenFull when_full) { return {bytes, when_full}; }

}  // namespace

TEST_CASE("without a budget there is always room") {
  StoreIndex index({});
  index.insert({"a", 1'000'000, 0});
  CHECK(index.reserve(std::uint64_t{1} << 40)->empty());
}

TEST_CASE("a store that refuses says by how much an upload is too large") {
  StoreIndex index(of(100, WhenFull::refuse));
  index.insert({"a", 60, 0});
  REQUIRE(index.reserve(40)->empty());
  const auto more = index.reserve(1);
  REQUIRE_FALSE(more);
  CHECK(more.error().code == ServiceCode::store_full);
  CHECK(more.error().limit == 100u);
  CHECK(more.error().actual == 101u);
  index.release(40);
  CHECK(index.reserve(40)->empty());
}

TEST_CASE("what was used longest ago goes first, and no more of it than needed") {
  StoreIndex index(of(100, WhenFull::evict));
  index.insert({"a", 30, 0});
  index.insert({"b", 30, 0});
  index.insert({"c", 30, 0});
  CHECK(index.use("a", 0) == StoreIndex::Use::known);
  CHECK(*index.reserve(11) == Ids{"b"});
  CHECK(*index.reserve(41) == Ids{"b", "c"});
  CHECK(index.erase("b"));
  CHECK(index.reserve(11)->empty());
}

TEST_CASE("uploads under way cannot be evicted for one another") {
  StoreIndex index(of(100, WhenFull::evict));
  REQUIRE(index.reserve(70)->empty());
  CHECK(index.reserve(40).error().code == ServiceCode::store_full);
  CHECK(index.reserve(101).error().code == ServiceCode::store_full);
  index.release(70);
  CHECK(index.reserve(40)->empty());
}

TEST_CASE("a use is worth noting once a minute") {
  StoreIndex index({});
  index.insert({"a", 1, 1000});
  CHECK(index.use("a", 1059) == StoreIndex::Use::known);
  CHECK(index.use("a", 1060) == StoreIndex::Use::worth_noting);
  CHECK(index.use("a", 1119) == StoreIndex::Use::known);
  CHECK(index.use("a", 1120) == StoreIndex::Use::worth_noting);
  CHECK(index.use("b", 1120) == StoreIndex::Use::unknown);
}

TEST_CASE("what was used since the storage was asked is to be confirmed") {
  StoreIndex index({});
  for (const char* const id : {"a", "b", "c"}) index.insert({id, 1, 0}, 1000);
  CHECK(index.use("a", 1001) == StoreIndex::Use::worth_noting);
  CHECK(index.use("b", 1029) == StoreIndex::Use::worth_noting);
  CHECK(index.unconfirmed(1029, 30, 10).empty());
  CHECK(index.unconfirmed(1030, 30, 10) == Ids{"b", "a"});
  CHECK(index.unconfirmed(1030, 30, 1) == Ids{"b"});
  index.insert({"b", 1, 0}, 1030);
  CHECK(index.unconfirmed(1030, 30, 10) == Ids{"a"});
  // Confirmed and not used again: nobody needs to know.
  CHECK(index.unconfirmed(2000, 30, 10) == Ids{"a"});
}

TEST_CASE("of too many meshes the one used longest ago is not known any more") {
  StoreIndex index({}, 3);
  for (const char* const id : {"a", "b", "c"}) CHECK_FALSE(index.insert({id, 10, 0}));
  (void)index.use("a", 1);
  CHECK(index.insert({"d", 10, 0}) == "b");
  CHECK_FALSE(index.insert({"d", 5, 0}));
  CHECK(index.list("", 10) == Ids{"a", "c", "d"});
  CHECK(index.stats().bytes == 25);
}

TEST_CASE("bytes follow every change") {
  StoreIndex index({});
  index.insert({"a", 10, 0});
  index.insert({"b", 5, 0});
  index.insert({"a", 20, 0});
  CHECK(index.stats().bytes == 25);
  CHECK(index.bytes_of("a") == 20u);
  CHECK(index.erase("a"));
  CHECK_FALSE(index.erase("a"));
  CHECK_FALSE(index.bytes_of("a"));
  CHECK(index.stats().bytes == 5);
  CHECK(index.size() == 1);
}
