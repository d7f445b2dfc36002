// No more jobs than allowed, each client its share, and nothing kept for ever.
#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "server/base/service_codes.h"
#include "server/compute/pool.h"
#include "tests/fixtures/wait_until.h"
#include "tests/server/compute/jobs_fixture.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using geodesic::fixtures::is_soon;
using geodesic::fixtures::wait_until;

TEST_CASE("NoMoreJobsWaitAndRunThanAllowed") {
  JobsFixture fixture(limits_of(4, 2));
  for (const std::string client : {"ann", "bob", "cid", "dan"}) fixture.start("/hold", client);
  const auto refused = fixture.try_start("/x", "eve");
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ServiceCode::overloaded);
  CHECK(refused.error().limit == 4);
  fixture.gate.let_go("/hold");
  wait_until([&] { return fixture.jobs.stats().ended >= 4; });
  CHECK(fixture.try_start("/x", "eve"));
}

TEST_CASE("AGreedyClientHasHalfOfTheJobsAndHalfOfTheThreads") {
  JobsFixture fixture(limits_of(8, 4));
  for (int i = 0; i < 4; ++i) fixture.start("/hold greedy", "greedy");
  const auto refused = fixture.try_start("/hold greedy", "greedy");
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ServiceCode::too_many_requests);
  // Two of them run; somebody else's begins at once, whatever waits.
  fixture.gate.begun(2);
  fixture.wait_for(fixture.start("/x", "modest"), JobState::done);
  CHECK(fixture.jobs.stats().running == 2);
  CHECK(fixture.jobs.stats().queued == 2);
}

TEST_CASE("ClientsTakeTurnsAtASingleThread") {
  JobsFixture fixture(limits_of(16, 1));
  fixture.start("/hold", "ann");
  fixture.gate.begun(1);
  for (const std::string path : {"/a1", "/a2", "/a3"}) fixture.start(path, "ann");
  for (const std::string path : {"/b1", "/b2"}) fixture.start(path, "bob");
  fixture.start("/c1", "cid");
  fixture.gate.let_go("/hold");
  CHECK(fixture.gate.begun(7) ==
        std::vector<std::string>{"/hold", "/b1", "/c1", "/a1", "/b2", "/a2", "/a3"});
}

TEST_CASE("TheOldestRepliesMakeRoomForNewOnes") {
  Jobs::Limits limits;
  limits.bytes = 100'000;
  JobsFixture fixture(limits);
  std::vector<std::string> ids;
  for (int i = 0; i < 4; ++i) {
    ids.push_back(fixture.start("/x", "", std::string(30'000, 'x')));
    fixture.wait_for(ids.back(), JobState::done);
  }
  CHECK_FALSE(fixture.jobs.find(ids[0]));
  CHECK_FALSE(fixture.jobs.find(ids[1]));
  CHECK(fixture.jobs.result(ids[2])->body->size() == 30'000);
  CHECK(fixture.jobs.result(ids[3])->body->size() == 30'000);
  CHECK(fixture.jobs.stats().bytes <= limits.bytes);
}

TEST_CASE("AReplyThatIsTooLargeToKeepIsAnError") {
  Jobs::Limits limits;
  limits.bytes = 50'000;
  Jobs jobs(limits, [](HttpRequest&) {
    HttpResponse response;
    response.stream = [](std::string& chunk) {
      chunk = std::string(1000, 'x');
      return true;  // for ever
    };
    return response;
  });
  const auto started = jobs.start(HttpRequest());
  REQUIRE(started);
  const JobReport report = ended(jobs, started->id);
  CHECK(report.state == JobState::failed);
  CHECK(report.status == 413);
  CHECK(jobs.result(started->id)->body->find("too_large") != std::string::npos);
}

TEST_CASE("AStreamThatSaysItIsTooLargeToKeepIsNotComputed") {
  Jobs::Limits limits;
  limits.bytes = 50'000;
  std::atomic<int> chunks{0};
  Jobs jobs(limits, [&](HttpRequest&) {
    HttpResponse response;
    response.stream_bytes = 60'000;
    response.stream = [&](std::string& chunk) {
      chunk = std::string(1000, 'x');
      return ++chunks < 60;
    };
    return response;
  });
  const auto started = jobs.start(HttpRequest());
  REQUIRE(started);
  const JobReport report = ended(jobs, started->id);
  CHECK(report.status == 413);
  CHECK(chunks == 0);
}

// Jobs that gather at the same time have one memory, not one each.
TEST_CASE("WhatJobsGatherIsChargedAsItGrows") {
  Jobs::Limits limits;
  limits.bytes = 100'000;
  limits.running = 4;
  std::atomic<int> full{0};
  std::atomic<bool> go_on{false};
  Jobs jobs(limits, [&](HttpRequest&) {
    HttpResponse response;
    response.stream = [&, n = 0](std::string& chunk) mutable {
      if (n == 40) {
        ++full;
        wait_until([&] { return go_on.load(); });
        return false;
      }
      chunk = std::string(1000, 'x');
      return ++n <= 40;
    };
    return response;
  });
  const auto start = [&](const char* client) {
    HttpRequest request;
    request.caller.client = client;
    const auto report = jobs.start(std::move(request));
    REQUIRE(report);
    return jobs.hold(report->id);
  };
  const auto first = start("ann");
  CHECK(is_soon([&] { return full == 1; }));
  const auto second = start("bob");
  CHECK(is_soon([&] { return full == 2; }));
  CHECK(jobs.stats().bytes >= 80'000);
  const auto third = start("cid");
  CHECK(is_soon([&] { return full == 3 || has_ended(jobs.report(third).state); }));
  CHECK(full == 2);
  CHECK(jobs.stats().bytes <= limits.bytes);
  go_on = true;
  for (const auto& job : {first, second, third}) {
    CHECK(is_soon([&] { return has_ended(jobs.report(job).state); }));
  }
  CHECK(jobs.report(first).status == 200);
  CHECK(jobs.report(second).status == 200);
  CHECK(jobs.report(third).status == 503);
}

TEST_CASE("ResultsOfOneClientDoNotPushOutThoseOfAnother") {
  Jobs::Limits limits;
  limits.bytes = 100'000;
  Jobs jobs(limits, [](HttpRequest& request) {
    HttpResponse response;
    response.set_body(std::string(request.caller.client == "ann" ? 1000 : 30'000, 'x'),
                      "text/plain");
    return response;
  });
  const auto run = [&](const char* client) {
    HttpRequest request;
    request.caller.client = client;
    const auto report = jobs.start(std::move(request));
    REQUIRE(report);
    const auto job = jobs.hold(report->id);
    JobReport now = jobs.report(job);
    while (!has_ended(now.state)) now = jobs.wait_for_news(job, now, kJobPatience);
    return report->id;
  };
  const std::string first = run("ann");
  std::vector<std::string> of_bob;
  for (int i = 0; i < 6; ++i) of_bob.push_back(run("bob"));
  CHECK(jobs.result(first));
  CHECK_FALSE(jobs.result(of_bob.front()));
  CHECK(jobs.result(of_bob.back()));
  CHECK(jobs.stats().bytes <= limits.bytes);
}

TEST_CASE("BodiesThatWaitHaveABudgetToo") {
  Jobs::Limits limits;
  limits.bytes = 100'000;
  limits.running = 1;
  JobsFixture fixture(limits);
  const std::string held = fixture.start("/hold", "ann", std::string(60'000, 'x'));
  const auto refused = fixture.try_start("/x", "bob", std::string(60'000, 'x'));
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ServiceCode::overloaded);
  CHECK(fixture.jobs.remove(held));
  wait_until([&] { return fixture.try_start("/x", "bob", std::string(60'000, 'x')).has_value(); });
}

TEST_CASE("WhatHasEndedIsForgottenAfterItsTime") {
  Jobs::Limits limits;
  limits.keep = 20ms;
  JobsFixture fixture(limits);
  const std::string id = fixture.start("/hold");
  const auto job = fixture.jobs.hold(id);
  REQUIRE(job);
  fixture.gate.let_go("/hold");
  wait_until([&] { return !fixture.jobs.find(id); });
  CHECK(fixture.jobs.stats().bytes == 0);
  CHECK(fixture.jobs.report(job).state == JobState::done);  // for who holds it
}

TEST_CASE("APatientCallerWaitsForASlotHoweverLongThatTakes") {
  ComputePool pool(1, ComputePool::QueueLimits{8, 0, 1ms});
  std::atomic<bool> begun{false};
  std::atomic<bool> go_on{false};
  Caller patient;
  patient.is_patient = true;
  Result<int> held = 0;
  std::thread holder([&] {
    const auto hold = [&](Worker&) -> Result<int> {
      begun = true;
      wait_until([&] { return go_on.load(); });
      return 6;
    };
    held = pool.run(hold, patient);
  });
  wait_until([&] { return begun.load(); });
  Result<int> found = 0;
  std::thread waiter([&] { found = pool.run([](Worker&) -> Result<int> { return 7; }, patient); });
  wait_until([&] { return pool.stats().queued != 0; });
  // Somebody else gives up first, and so would have the other one.
  const auto impatient = pool.run([](Worker&) -> Result<int> { return 8; });
  REQUIRE_FALSE(impatient);
  CHECK(impatient.error().code == ServiceCode::overloaded);
  go_on = true;
  waiter.join();
  holder.join();
  CHECK(held == 6);
  CHECK(found == 7);
}
