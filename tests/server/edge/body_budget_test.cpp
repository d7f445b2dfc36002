// Whose body must go when there is no room for all.
#include "server/edge/body_budget.h"

#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <deque>
#include <string>

using namespace geodesic::server;
using namespace std::chrono_literals;

namespace {

using Clock = BodyBudget::Clock;

struct Body {
  Body(BodyBudget& budget, const std::string& client, Clock::time_point now)
      : part(budget, unwanted) {
    part.begin(client, now);
  }
  std::atomic<bool> unwanted{false};
  BodyBudget::Part part;
};

}  // namespace

TEST_CASE("of the greediest client's bodies the slowest goes") {
  BodyBudget budget(1000, 5s);
  const Clock::time_point begin = Clock::now();
  std::deque<Body> bodies;
  for (int i = 0; i < 3; ++i) bodies.emplace_back(budget, "greedy", begin);
  CHECK(bodies[0].part.hold(300, begin));
  CHECK(bodies[1].part.hold(290, begin));
  CHECK(bodies[2].part.hold(300, begin + 60s));  // it still comes
  Body meek(budget, "meek", begin + 60s);
  CHECK(meek.part.hold(100, begin + 61s));
  CHECK(budget.bytes() == 990);
  CHECK(meek.part.hold(120, begin + 61s));
  CHECK((bodies[0].unwanted || bodies[1].unwanted));
  CHECK_FALSE(bodies[2].unwanted);
  CHECK(budget.bytes() <= 1000);
  // What was taken away does not come back, and counts no more.
  Body& gone = bodies[0].unwanted ? bodies[0] : bodies[1];
  CHECK_FALSE(gone.part.hold(301, begin + 62s));
  CHECK_FALSE(gone.part.complete());
  gone.part.release();
  CHECK_FALSE(gone.unwanted);
  const std::uint64_t left = budget.bytes();
  meek.part.release();
  CHECK(budget.bytes() == left - 120);
}

TEST_CASE("of one client's bodies none goes for another that comes no faster") {
  BodyBudget budget(1000, 5s);
  const Clock::time_point begin = Clock::now();
  Body first(budget, "a", begin);
  Body second(budget, "a", begin);
  CHECK(first.part.hold(600, begin + 1s));
  CHECK_FALSE(second.part.hold(600, begin + 1s));
  CHECK_FALSE(first.unwanted);
  second.part.release();
  // Once it has stalled, it does.
  Body third(budget, "a", begin + 60s);
  CHECK(third.part.hold(600, begin + 61s));
  CHECK(first.unwanted);
}

TEST_CASE("what is complete is not taken away, nor what is small") {
  BodyBudget budget(1000, 5s);
  const Clock::time_point begin = Clock::now();
  Body done(budget, "a", begin);
  CHECK(done.part.hold(700, begin));
  CHECK(done.part.complete());
  Body small(budget, "b", begin);
  CHECK(small.part.hold(10, begin));
  Body large(budget, "c", begin + 60s);
  CHECK_FALSE(large.part.hold(400, begin + 61s));  // and not one of b's few bytes
  CHECK_FALSE(done.unwanted);
  CHECK_FALSE(small.unwanted);
  large.part.release();
  CHECK(budget.bytes() == 710);
  // A body alone that is larger than all there may be.
  done.part.release();
  small.part.release();
  CHECK(budget.bytes() == 0);
  Body huge(budget, "a", begin);
  CHECK_FALSE(huge.part.hold(1001, begin));
  BodyBudget none(0, 5s);
  Body any(none, "a", begin);
  CHECK(any.part.hold(std::uint64_t{1} << 40, begin));
}
