// Names in JSON that come twice, and names that are chosen against a hash table.
#include "proto/wire/json_outline.h"

#include <doctest/doctest.h>

#include <cstdint>
#include <cstring>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "proto/wire/input_codes.h"
#include "proto/wire/parameters.h"
#include "tests/bench/processor_time.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;

namespace {

// Names of 16 letters that have one and the same std::hash in libstdc++, which is MurmurHash64A
// with a seed that everybody knows: the first 8 letters are any, and the others are solved for.
class CollidingNames {
 public:
  explicit CollidingNames(std::uint32_t seed) : random_(seed), wanted_(random_()) {}

  std::string next() {
    static constexpr char kLetters[] =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_";
    while (true) {
      char name[16];
      for (int i = 0; i < 8; ++i) name[i] = kLetters[random_() % 64];
      std::uint64_t first;
      std::memcpy(&first, name, 8);
      const std::uint64_t state = (kStart ^ mixed(first)) * kFactor;
      const std::uint64_t second = unmixed(state ^ wanted_);
      std::memcpy(name + 8, &second, 8);
      bool is_plain = true;
      for (const char c : name) is_plain &= c >= ' ' && c <= '~' && c != '"' && c != '\\';
      if (is_plain) return {name, 16};
    }
  }

 private:
  static constexpr std::uint64_t kFactor = 0xc6a4a7935bd1e995;
  static constexpr std::uint64_t kStart = 0xc70f6907 ^ (16 * kFactor);

  static std::uint64_t mixed(std::uint64_t k) {
    k *= kFactor;
    k ^= k >> 47U;
    return k * kFactor;
  }
  static std::uint64_t unmixed(std::uint64_t k) {
    std::uint64_t inverse = kFactor;
    for (int i = 0; i < 6; ++i) inverse *= 2 - kFactor * inverse;
    k *= inverse;
    k ^= k >> 47U;
    return k * inverse;
  }

  std::mt19937_64 random_;
  std::uint64_t wanted_;
};

}  // namespace

TEST_CASE("names that collide in a hash table cost no more than others") {
  CollidingNames names(fixtures::test_seed());
  std::string body = "{";
  std::string first;
  std::set<std::string> taken;
  while (taken.size() < 12'000) {
    const std::string name = names.next();
    if (!taken.insert(name).second) continue;  // one run in a thousand draws a name twice
    if (first.empty()) first = name;
    body += '"' + name + "\":1,";
  }
  std::string others = "{";
  for (std::size_t i = 0; i < taken.size(); ++i) {
    others += "\"name " + std::to_string(i) + "\":1,";
  }
  // A hash table takes some hundred times as much processor time for names that collide.
  const double usual =
      bench::processor_ms_of([&] { CHECK(proto::Parameters::from_json(others + "\"last\":1}")); });
  const double colliding =
      bench::processor_ms_of([&] { CHECK(proto::Parameters::from_json(body + "\"last\":1}")); });
  CHECK(colliding < 20 * usual);
  const auto repeated = proto::Parameters::from_json(body + '"' + first + "\":1}");
  REQUIRE_FALSE(repeated);
  CHECK(repeated.error().code == InputCode::bad_syntax);
  CHECK(repeated.error().parameter == first);
}
