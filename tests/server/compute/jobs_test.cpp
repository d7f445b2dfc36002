// Jobs from their start to their end.
#include "server/compute/jobs.h"

#include <doctest/doctest.h>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "server/base/service_codes.h"
#include "tests/fixtures/wait_until.h"
#include "tests/server/compute/jobs_fixture.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using geodesic::fixtures::wait_until;

TEST_CASE("AJobGoesFromQueuedToDoneAndKeepsItsReply") {
  JobsFixture fixture;
  const std::string id = fixture.start("/hold", "ann");
  const JobReport running = fixture.wait_for(id, JobState::running);
  CHECK(running.method == "POST");
  CHECK(running.target == "/hold");
  CHECK(running.status == 0);
  REQUIRE(running.started);
  CHECK(*running.started >= running.created);
  CHECK_FALSE(running.finished);
  const auto early = fixture.jobs.result(id);
  REQUIRE_FALSE(early);
  CHECK(early.error().code == ServiceCode::job_unfinished);

  fixture.gate.let_go("/hold");
  const JobReport done = fixture.wait_for(id, JobState::done);
  CHECK(done.status == 200);
  CHECK(done.progress == 1);
  REQUIRE(done.finished);
  CHECK(*done.finished >= *done.started);
  for (int time = 0; time < 2; ++time) {
    const auto reply = fixture.jobs.result(id);
    REQUIRE(reply);
    CHECK(*reply->body == "of /hold");
  }
}

TEST_CASE("ARefusedRequestIsAFailedJobWithThatReply") {
  JobsFixture fixture;
  const std::string id = fixture.start("/fail");
  CHECK(fixture.wait_for(id, JobState::failed).status == 422);
  CHECK(*fixture.jobs.result(id)->body == "no");
}

TEST_CASE("AHandlerThatThrowsIsAFailedJobThatSaysNothingOfIt") {
  JobsFixture fixture;
  const std::string id = fixture.start("/throw");
  CHECK(fixture.wait_for(id, JobState::failed).status == 500);
  const auto reply = fixture.jobs.result(id);
  REQUIRE(reply);
  CHECK(reply->body->find("secret") == std::string::npos);
  CHECK(reply->body->find("internal") != std::string::npos);
}

TEST_CASE("IdsAreUnlikeEachOther") {
  JobsFixture fixture(limits_of(1000, 1));
  std::set<std::string> ids;
  for (int i = 0; i < 100; ++i) {
    const std::string id = fixture.start("/x");
    CHECK(id.size() == 32);
    CHECK(id.find_first_not_of("0123456789abcdef") == std::string::npos);
    ids.insert(id);
  }
  CHECK(ids.size() == 100);
}

TEST_CASE("CancellingARunningJobTellsItsHandlerAndOnceMoreForgetsIt") {
  JobsFixture fixture;
  const std::string id = fixture.start("/hold");
  fixture.wait_for(id, JobState::running);
  CHECK(fixture.jobs.remove(id));
  const JobReport cancelled = fixture.wait_for(id, JobState::cancelled);
  CHECK(cancelled.finished);
  CHECK(cancelled.status == 0);
  CHECK(fixture.jobs.result(id).error().code == ServiceCode::job_cancelled);
  CHECK(fixture.jobs.remove(id));
  CHECK_FALSE(fixture.jobs.find(id));
  CHECK_FALSE(fixture.jobs.remove(id));
  CHECK(fixture.jobs.result(id).error().code == ServiceCode::job_unknown);
  // The thread is free again: the handler has noticed.
  fixture.wait_for(fixture.start("/x"), JobState::done);
}

TEST_CASE("CancellingAQueuedJobKeepsItFromRunning") {
  JobsFixture fixture(limits_of(8, 1));
  const std::string first = fixture.start("/hold");
  fixture.gate.begun(1);
  const std::string second = fixture.start("/never");
  CHECK(fixture.jobs.stats().queued == 1);
  CHECK(fixture.jobs.remove(second));
  fixture.wait_for(second, JobState::cancelled);
  CHECK(fixture.jobs.stats().queued == 0);
  fixture.gate.let_go("/hold");
  fixture.wait_for(first, JobState::done);
  fixture.wait_for(fixture.start("/x"), JobState::done);
  CHECK(fixture.gate.begun(2) == std::vector<std::string>{"/hold", "/x"});
}

TEST_CASE("ProgressNeverFallsAndIsOneAtTheEnd") {
  std::mutex mutex;
  std::condition_variable changed;
  int step = 0;  // odd: the handler's turn
  const auto turn_of = [&](int mine) {
    std::unique_lock lock(mutex);
    REQUIRE(changed.wait_for(lock, kJobPatience, [&] { return step == mine; }));
  };
  const auto pass_to = [&](int next) {
    const std::lock_guard lock(mutex);
    step = next;
    changed.notify_all();
  };
  Jobs jobs({}, [&](HttpRequest& request) {
    const std::vector<double> told{0.25, 0.125, 0.5, 7};
    for (int i = 0; i < 4; ++i) {
      turn_of(2 * i + 1);
      request.caller.progress(told[static_cast<std::size_t>(i)]);
      pass_to(2 * i + 2);
    }
    turn_of(9);
    return Gate::answer(404, "");
  });
  const auto started = jobs.start(HttpRequest());
  REQUIRE(started);
  CHECK(started->progress == 0);
  const std::vector<double> known{0.25, 0.25, 0.5, 1};
  for (int i = 0; i < 4; ++i) {
    pass_to(2 * i + 1);
    turn_of(2 * i + 2);
    CHECK(jobs.find(started->id)->progress == known[static_cast<std::size_t>(i)]);
  }
  pass_to(9);
}

TEST_CASE("WhoWaitsForNewsHearsOfProgress") {
  std::atomic<bool> go_on{false};
  Jobs jobs({}, [&](HttpRequest& request) {
    request.caller.progress(0.5);
    wait_until([&] { return go_on || request.caller(); });
    return Gate::answer(200, "");
  });
  const auto started = jobs.start(HttpRequest());
  REQUIRE(started);
  const auto job = jobs.hold(started->id);
  JobReport report = *started;
  while (report.progress < 0.5) {
    const JobReport next = jobs.wait_for_news(job, report, kJobPatience);
    REQUIRE(next != report);  // or nothing has happened for so long
    report = next;
  }
  CHECK(report.state == JobState::running);
  // Nothing new: so it is told what it knows.
  CHECK(jobs.wait_for_news(job, report, 1ms) == report);
  go_on = true;
  CHECK(jobs.wait_for_news(job, report, kJobPatience).state == JobState::done);
}

TEST_CASE("AStreamedReplyIsKeptAsAWhole") {
  Jobs jobs({}, [](HttpRequest&) {
    HttpResponse response;
    response.content_type = "application/x-ndjson";
    response.stream = [n = 0](std::string& chunk) mutable {
      chunk = std::to_string(n) + "\n";
      return n++ < 3;
    };
    return response;
  });
  const auto started = jobs.start(HttpRequest());
  REQUIRE(started);
  CHECK(ended(jobs, started->id).state == JobState::done);
  CHECK(*jobs.result(started->id)->body == "0\n1\n2\n");
  CHECK_FALSE(jobs.result(started->id)->stream);
}

TEST_CASE("StoppingCancelsAllAndRefusesMore") {
  JobsFixture fixture(limits_of(8, 1));
  const std::string running = fixture.start("/hold");
  fixture.gate.begun(1);
  const std::string queued = fixture.start("/never");
  fixture.jobs.stop();
  fixture.wait_for(running, JobState::cancelled);
  fixture.wait_for(queued, JobState::cancelled);
  CHECK(fixture.gate.begun(1) == std::vector<std::string>{"/hold"});
  CHECK(fixture.jobs.stats().running == 0);
  const auto refused = fixture.try_start("/x");
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ServiceCode::draining);
  fixture.jobs.stop();
}

TEST_CASE("ManyClientsStartWatchAndCancelAtOnce") {
  JobsFixture fixture(limits_of(64, 3));
  std::vector<std::thread> clients;
  std::atomic<int> ended{0};
  for (int c = 0; c < 8; ++c) {
    clients.emplace_back([&, c] {
      for (int i = 0; i < 50; ++i) {
        HttpRequest request;
        request.path = i % 3 == 0 ? "/hold" : "/x";
        request.caller.client = std::to_string(c);
        const auto started = fixture.jobs.start(std::move(request));
        if (!started) continue;
        const auto job = fixture.jobs.hold(started->id);
        if (i % 3 == 0) fixture.jobs.remove(started->id);
        if (!job) continue;
        JobReport report = fixture.jobs.report(job);
        while (!has_ended(report.state)) report = fixture.jobs.wait_for_news(job, report, 1s);
        ++ended;
        if (i % 2 == 0) fixture.jobs.remove(started->id);
      }
    });
  }
  for (std::thread& client : clients) client.join();
  CHECK(ended == 400);
  fixture.jobs.stop();
  const Jobs::Stats stats = fixture.jobs.stats();
  CHECK(stats.running == 0);
  CHECK(stats.queued == 0);
  CHECK(stats.bytes <= 4096 * stats.ended + 400 * 10);
}
