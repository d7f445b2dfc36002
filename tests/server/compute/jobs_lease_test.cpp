// Jobs that nobody asks about any more.
#include <doctest/doctest.h>

#include <chrono>
#include <string>
#include <thread>

#include "server/base/service_codes.h"
#include "tests/fixtures/wait_until.h"
#include "tests/server/compute/jobs_fixture.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using geodesic::fixtures::wait_until;

namespace {

Jobs::Limits lease_of(std::chrono::milliseconds lease) {
  Jobs::Limits limits = limits_of(8, 2);
  limits.lease = lease;
  return limits;
}

// Without a look at any one job.
void wait_until_cancelled(Jobs& jobs, std::uint64_t count) {
  wait_until([&] { return jobs.stats().cancelled >= count; });
}

}  // namespace

TEST_CASE("AJobThatNobodyAsksAboutIsCancelledWhetherItRunsOrWaits") {
  JobsFixture fixture(lease_of(50ms));
  // Of one client one runs, and the other waits for as long as that one runs.
  const auto kept = fixture.try_start("/hold/kept", "ann", "", JobLease::none);
  REQUIRE(kept);
  fixture.gate.begun(1);
  const std::string waiting = fixture.start("/hold/waiting", "ann", std::string(50'000, 'x'));
  const std::string running = fixture.start("/hold/running", "bob");
  wait_until_cancelled(fixture.jobs, 2);
  for (const std::string& id : {running, waiting}) {
    const auto job = fixture.jobs.find(id);
    REQUIRE(job);
    CHECK(job->state == JobState::cancelled);
    CHECK(job->lease == 50ms);
    const auto result = fixture.jobs.result(id);
    REQUIRE_FALSE(result);
    CHECK(result.error().code == ServiceCode::job_cancelled);
    CHECK(result.error().detail.find("nobody asked") != std::string::npos);
  }
  for (const std::string& path : fixture.gate.begun(1)) CHECK(path != "/hold/waiting");
  CHECK(fixture.jobs.stats().queued == 0);
  CHECK(fixture.jobs.stats().bytes < 20'000);  // its body is gone
  // The threads and the places are free again.
  const auto next = fixture.try_start("/x", "bob", "", JobLease::none);
  REQUIRE(next);
  fixture.wait_for(next->id, JobState::done);
  fixture.gate.let_go("/hold/kept");
  fixture.wait_for(kept->id, JobState::done);
}

TEST_CASE("JobsThatLostTheirLeaseLeaveNothingBehind") {
  Jobs::Limits limits = lease_of(5ms);
  limits.keep = 20ms;
  JobsFixture fixture(limits);
  for (std::uint64_t i = 1; i <= 20; ++i) {
    fixture.start("/hold", "ann", std::string(10'000, 'x'));
    wait_until_cancelled(fixture.jobs, i);
  }
  // Kept for a while, and then forgotten with all that they were charged.
  wait_until([&] { return fixture.jobs.stats().ended == 0; });
  CHECK(fixture.jobs.stats().bytes == 0);
}

TEST_CASE("WhoAsksOrWatchesRenewsTheLease") {
  bool stood_still = true;  // a machine that stood still tells nothing about the lease
  for (std::chrono::milliseconds lease = 1500ms; stood_still && lease < 60s; lease *= 2) {
    auto last = std::chrono::steady_clock::now();
    const auto end = last + 2 * lease + 500ms;
    stood_still = false;
    const auto look_at_the_clock = [&] {
      const auto now = std::chrono::steady_clock::now();
      stood_still = stood_still || now - last > lease / 2;
      last = now;
    };
    JobsFixture fixture(lease_of(lease));
    const std::string asked = fixture.start("/hold1", "ann");
    const std::string watched = fixture.start("/hold2", "bob");
    const auto handle = fixture.jobs.hold(watched);
    if (!handle) {
      look_at_the_clock();
      REQUIRE(stood_still);
      continue;
    }
    JobReport seen = fixture.jobs.report(handle);
    while (last < end) {
      look_at_the_clock();
      (void)fixture.jobs.find(asked);
      seen = fixture.jobs.wait_for_news(handle, seen, 20ms);
    }
    const std::uint64_t cancelled = fixture.jobs.stats().cancelled;
    look_at_the_clock();
    if (stood_still) continue;
    CHECK(cancelled == 0);
    fixture.gate.let_go("/hold1");
    fixture.gate.let_go("/hold2");
    fixture.wait_for(asked, JobState::done);
    fixture.wait_for(watched, JobState::done);
  }
  CHECK_FALSE(stood_still);
}

TEST_CASE("AJobWithoutALeaseGoesOnAndWhatHasEndedIsKept") {
  JobsFixture fixture(lease_of(20ms));
  const auto kept = fixture.try_start("/hold", "ann", "", JobLease::none);
  REQUIRE(kept);
  CHECK_FALSE(kept->lease);
  fixture.start("/hold/other", "bob");
  wait_until([&] {
    const Jobs::Stats now = fixture.jobs.stats();  // of one moment
    return now.running + now.queued <= 1;
  });
  CHECK(fixture.jobs.stats().cancelled == 1);
  std::this_thread::sleep_for(200ms);
  CHECK(fixture.jobs.stats().running == 1);
  fixture.gate.let_go("/hold");
  CHECK(fixture.wait_for(kept->id, JobState::done).status == 200);
}

TEST_CASE("TheResultOfAJobThatEndedInTimeOutlivesTheLease") {
  // So long that no machine stands still for it before the job is done.
  constexpr auto kLease = 3s;
  JobsFixture fixture(lease_of(kLease));
  const std::string ended = fixture.start("/x", "bob");
  fixture.wait_for(ended, JobState::done);
  std::this_thread::sleep_for(kLease + 100ms);
  (void)fixture.jobs.stats();  // looks for leases that are over
  CHECK(fixture.jobs.result(ended));
}
