// Threads that help a computation: each part is done once, whoever comes or goes.
#include "core/base/team.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "tests/fixtures/helping_threads.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::HelpingThreads;
using fixtures::test_seed;

TEST_CASE("EachPartIsDoneOnceWhoeverHelps") {
  std::mt19937 random(test_seed());
  for (const std::size_t threads : {1, 2, 3, 8}) {
    CAPTURE(threads);
    Team team(threads);
    const HelpingThreads helping(team, threads - 1);
    const Cancel never;
    Poll poll(never);
    std::vector<int> done(Team::kMostParts);
    std::vector<int> expected(Team::kMostParts);
    for (int step = 0; step < 2000; ++step) {
      const std::size_t parts = random() % (Team::kMostParts + 1);
      for (std::size_t part = 0; part < parts; ++part) ++expected[part];
      team.run(parts, poll, [&](std::size_t part, Poll&) { ++done[part]; });
      // What parts wrote is there as soon as the step is.
      REQUIRE(done == expected);
    }
  }
}

TEST_CASE("ThreadsMayComeAndGoDuringAComputation") {
  Team team(4);
  std::atomic<bool> is_over{false};
  std::vector<std::thread> threads;
  for (std::uint32_t i = 0; i < 3; ++i) {
    threads.emplace_back([&team, &is_over, seed = test_seed() + i] {
      std::mt19937 random(seed);
      while (!is_over) {
        int left = static_cast<int>(random() % 3);
        team.help([&] { return left-- == 0; });
        std::this_thread::sleep_for(std::chrono::microseconds(random() % 50));
      }
    });
  }
  const Cancel never;
  Poll poll(never);
  std::array<std::size_t, 7> sums{};
  constexpr std::size_t kSteps = 3000;
  for (std::size_t step = 0; step < kSteps; ++step) {
    team.run(sums.size(), poll, [&sums, step](std::size_t part, Poll&) { sums[part] += step; });
  }
  is_over = true;
  team.end();
  for (std::thread& thread : threads) thread.join();
  for (const std::size_t sum : sums) CHECK(sum == kSteps * (kSteps - 1) / 2);
}

TEST_CASE("WhatAPartThrowsIsThrownOnceAllAreDone") {
  Team team(3);
  const HelpingThreads helping(team, 2);
  const Cancel never;
  Poll poll(never);
  for (int step = 0; step < 200; ++step) {
    std::array<std::atomic<int>, 9> done{};
    const auto run = [&] {
      team.run(done.size(), poll, [&done, step](std::size_t part, Poll&) {
        ++done[part];
        if (step % 2 == 0 && part % 4 == 1) throw std::runtime_error("part");
      });
    };
    if (step % 2 == 0) {
      CHECK_THROWS_WITH(run(), "part");
    } else {
      CHECK_NOTHROW(run());
    }
    // Without help it is a loop, which the first one that throws ends.
    if (step % 2 == 1) {
      for (const auto& each : done) CHECK(each == 1);
    }
  }
}

TEST_CASE("WhoeverHelpsStopsWithTheComputation") {
  Team team(2);
  const HelpingThreads helping(team, 1);
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(30);
  const Cancel cancel([&] { return std::chrono::steady_clock::now() > end; });
  Poll poll(cancel);
  // Without end but for that.
  team.run(2, poll, [](std::size_t, Poll& asked) {
    while (!asked.ask()) {
    }
  });
  CHECK(poll.stopped());
}

TEST_CASE("AComputationGoesOnAloneWhereThoseWhoHelpAreLate") {
  Team team(2);
  const HelpingThreads helping(team, 1);
  const Cancel never;
  Poll poll(never);
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!team.is_over() && std::chrono::steady_clock::now() < end) {
    const auto self = std::this_thread::get_id();
    team.run(2, poll, [self](std::size_t, Poll&) {
      if (std::this_thread::get_id() != self) {
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
      }
    });
  }
  CHECK(team.is_over());
  // All the same it ends.
  int done = 0;
  team.run(5, poll, [&done](std::size_t, Poll&) { ++done; });
  CHECK(done == 5);
}

TEST_CASE("WhatThoseWhoHelpTakeIsAskedForWhenTheStepIsDone") {
  constexpr std::uint64_t kBytes = 1000;
  std::uint64_t most = 0;
  MemoryBudget budget([&most](std::uint64_t bytes) -> std::optional<Error> {
    most = std::max(most, bytes);
    return bytes > 5 * kBytes ? std::optional(Error{ErrorCode::internal, "enough", {}, {}, {}})
                              : std::nullopt;
  });
  const Cancel cancel([] { return false; }, {}, &budget);
  Poll poll(cancel);
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  const auto self = std::this_thread::get_id();
  while (!poll.stopped() && std::chrono::steady_clock::now() < end) {
    // On a busy machine those who help are late and let go: then another team begins anew.
    most = 0;
    Team team(2);
    const HelpingThreads helping(team, 1);
    while (!poll.stopped() && !team.is_over() && std::chrono::steady_clock::now() < end) {
      team.run(2, poll, [self](std::size_t, Poll& asked) {
        if (std::this_thread::get_id() != self) CHECK(asked.may_take(kBytes));
      });
    }
  }
  CHECK(poll.stopped());
  CHECK(most == 6 * kBytes);
}

TEST_CASE("SmallMeshesAreNotDividedUnlessThatIsAskedFor") {
  CHECK(Team(8).parts_for(Team::kFewestVertices - 1) == 1);
  CHECK(Team(8).parts_for(Team::kFewestVertices) == 8);
  CHECK(Team(1).parts_for(Team::kFewestVertices) == 1);
  CHECK(Team(1000).parts_for(Team::kFewestVertices) == Team::kMostParts);
  CHECK(Team(8, 0).parts_for(1) == 8);
}

TEST_CASE("RangesCoverAllAndFewThingsAreOneRange") {
  Team team(3, 100);
  const Cancel cancel([] { return false; }, {}, nullptr, &team);
  Poll poll(cancel);
  for (const std::size_t count : {0, 1, 99, 100, 1001}) {
    CAPTURE(count);
    std::vector<int> seen(count);
    std::vector<int> ranges(count_ranges(count, poll));
    CHECK((ranges.size() == 1) == (count < 100));
    run_in_ranges(count, poll, [&](std::size_t range, std::size_t begin, std::size_t end, Poll&) {
      ++ranges[range];
      for (std::size_t i = begin; i < end; ++i) ++seen[i];
    });
    CHECK(std::all_of(seen.begin(), seen.end(), [](int times) { return times == 1; }));
    CHECK(std::all_of(ranges.begin(), ranges.end(), [](int times) { return times == 1; }));
  }
}
