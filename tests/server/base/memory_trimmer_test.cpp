#include "server/base/memory_trimmer.h"

#include <doctest/doctest.h>

#include <chrono>
#include <memory>
#include <thread>
#include <vector>

#include "server/base/process_usage.h"

using namespace geodesic::server;
using namespace std::chrono_literals;

TEST_CASE("WhatIsFreedAtTheEndOfAThreadsHeapGoesBackAtOnce") {
  const MemoryTrimmer trimmer(1h);
  // Large blocks that come and go must not raise the bound on what is kept.
  for (int i = 0; i < 4; ++i) {
    const auto block = std::make_unique<char[]>(30 << 20);
    static_cast<volatile char*>(block.get())[i] = 1;  // or the compiler leaves it out
  }
  double full = 0;
  std::thread([&] {
    std::vector<std::unique_ptr<char[]>> blocks(5'000);
    for (auto& block : blocks) block = std::make_unique<char[]>(8 << 10);  // 40 MB
    full = process_usage().resident_bytes;
  }).join();
  CHECK(process_usage().resident_bytes < full - 25e6);
}

TEST_CASE("MemoryThatIsFreedBetweenWhatIsInUseGoesBackToTheSystem") {
  constexpr std::size_t kBlock = 8 << 10;
  constexpr std::size_t kBlocks = 20'000;  // 160 MB
  const MemoryTrimmer trimmer(20ms);
  std::vector<std::unique_ptr<char[]>> blocks(kBlocks);
  std::thread([&] {  // in an arena of its own
    for (auto& block : blocks) {
      block = std::make_unique<char[]>(kBlock);
    }
  })
      .join();
  const double full = process_usage().resident_bytes;
  for (std::size_t i = 0; i < kBlocks; ++i) {
    if (i % 100 != 0) blocks[i].reset();
  }
  // A little work, less than a trim is worth at once; then the process rests.
  const double worked = process_usage().cpu_seconds + 0.03;
  while (process_usage().cpu_seconds < worked) {
  }
  const auto end = std::chrono::steady_clock::now() + 60s;
  while (process_usage().resident_bytes > full - 110e6 && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(10ms);
  }
  CHECK(process_usage().resident_bytes < full - 110e6);
}
