#include "server/base/joint_caller.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <memory>
#include <random>
#include <thread>
#include <vector>

#include "tests/fixtures/test_seed.h"

using namespace geodesic::server;

// Whatever the steps, and however they are rounded.
TEST_CASE("WhatPartsTellAddsUpToNoMoreThanAllOfIt") {
  std::mt19937 random(geodesic::fixtures::test_seed());
  for (int round = 0; round < 200; ++round) {
    const std::size_t count = 1 + random() % 9;
    std::vector<double> told;
    Caller caller;
    caller.progress = [&](double done) { told.push_back(done); };
    const double begin = random() / 4294967296.0;
    const Caller rest = caller.part(begin, 1);
    JointCaller joint(rest, count);
    std::vector<std::unique_ptr<JointCaller::Part>> parts;
    std::vector<double> done(count, 0.0);
    for (std::size_t i = 0; i < count; ++i) {
      parts.push_back(std::make_unique<JointCaller::Part>(joint, i));
    }
    for (int step = 0; step < 100; ++step) {
      const std::size_t i = random() % count;
      done[i] += (1 - done[i]) * (random() / 4294967296.0);
      parts[i]->caller().progress(done[i]);
    }
    for (auto& part : parts) part->done(true);
    CHECK(std::is_sorted(told.begin(), told.end()));
    CHECK(told.front() >= begin);
    CHECK(told.back() <= 1);
    CHECK(told.back() == doctest::Approx(1));
  }
}

TEST_CASE("PartsOfManyThreadsTellOneAtATimeAndTheirTimesAddUp") {
  constexpr std::size_t kThreads = 4;
  constexpr std::size_t kParts = 25;  // of each
  Caller caller;
  caller.times = std::make_shared<StageTimes>();
  double last = 0;  // nothing but the promise keeps these threads apart
  caller.progress = [&](double done) {
    CHECK(done >= last);
    last = done;
  };
  JointCaller joint(caller, kThreads * kParts);
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      for (std::size_t i = 0; i < kParts; ++i) {
        JointCaller::Part part(joint, t * kParts + i);
        part.caller().progress(0.5);
        part.caller().times->add(Stage::solve, std::chrono::milliseconds(3));
        part.done(i != 7);
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(last == doctest::Approx(1));
  CHECK_FALSE(joint.all_hit());
  CHECK(caller.times->of(Stage::solve).count() == doctest::Approx(0.003 * kThreads * kParts));
}
