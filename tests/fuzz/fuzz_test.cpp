// Every target over its seeds, over what once broke it, and over some mutations of the seeds,
// others in each run.
#include <doctest/doctest.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "tests/fixtures/mutations.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/test_seed.h"
#include "tests/fuzz/targets.h"

using namespace geodesic;
using namespace geodesic::fuzz;
using fixtures::Bytes;

namespace {

// The fuzzers have more of them under sanitizers.
constexpr int kMutations = fixtures::all_or(8000, 2000);
constexpr int kMutationsOfHeaps = fixtures::all_or(2000, 500);  // of which each is eleven queries

Input input_of(const Bytes& bytes) {
  return {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
}

Bytes bytes_of(const std::string& text) {
  const auto* data = reinterpret_cast<const std::byte*>(text.data());
  return {data, data + text.size()};
}

// What is wrong with how the target takes it; empty: nothing.
std::string fault(const Target& target, const Bytes& bytes) {
  try {
    // A copy of just that size, so that a sanitizer sees the first byte too many.
    const Bytes exact(bytes.begin(), bytes.end());
    target.run(input_of(exact));
  } catch (const std::exception& error) {
    return error.what();
  }
  return {};
}

std::string hex(const Bytes& bytes) {
  std::string text;
  for (const std::byte one : bytes) {
    constexpr std::string_view digits = "0123456789abcdef";
    text += digits[std::to_integer<std::size_t>(one) >> 4U];
    text += digits[std::to_integer<std::size_t>(one) & 15U];
  }
  return text.substr(0, 2000);
}

}  // namespace

TEST_CASE("SeedsAreTakenAsTheyAre") {
  for (const Target& target : targets()) {
    const std::string name(target.name);
    CAPTURE(name);
    const auto seeds = target.seeds();
    CHECK(seeds.size() >= 4);
    for (const std::string& seed : seeds) CHECK(fault(target, bytes_of(seed)) == "");
  }
}

TEST_CASE("WhatOnceBrokeATargetDoesNotAgain") {
  std::size_t replayed = 0;
  for (const Target& target : targets()) {
    const auto folder = std::filesystem::path(FUZZ_FINDINGS) / target.name;
    if (!std::filesystem::is_directory(folder)) continue;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      CAPTURE(entry.path().string());
      std::ifstream in(entry.path(), std::ios::binary);
      const std::string text{std::istreambuf_iterator<char>(in), {}};
      CHECK(fault(target, bytes_of(text)) == "");
      ++replayed;
    }
  }
  MESSAGE(replayed, " findings replayed");
}

TEST_CASE("MutatedSeedsBreakNoTarget") {
  for (const Target& target : targets()) {
    const std::string name(target.name);
    CAPTURE(name);
    std::mt19937 random(fixtures::test_seed());
    std::vector<Bytes> seeds;
    for (const std::string& seed : target.seeds()) seeds.push_back(bytes_of(seed));
    int faults = 0;
    const int mutations = target.name == "heaps" ? kMutationsOfHeaps : kMutations;
    for (int i = 0; i < mutations && faults < 3; ++i) {
      const Bytes& seed = seeds[fixtures::below(seeds.size(), random)];
      const Bytes bytes =
          i % 8 == 7 ? fixtures::spliced(seed, seeds[fixtures::below(seeds.size(), random)], random)
                     : fixtures::mutated(seed, random);
      const std::string what = fault(target, bytes);
      if (what.empty()) continue;
      ++faults;
      FAIL_CHECK(what, " by mutation ", i, ": ", hex(bytes));
    }
  }
}
