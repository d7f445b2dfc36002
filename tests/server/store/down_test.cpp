// What is still answered while the store answers for some of its meshes, or for none.
#include <doctest/doctest.h>

#include <chrono>
#include <future>
#include <string>
#include <thread>

#include "tests/server/routes/plane_service.h"
#include "tests/server/store/fake_s3.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

TEST_CASE("a list is 503 while the store as a whole does not work, and else tells of each mesh") {
  FakeS3 s3;
  std::string one;
  std::string other;
  {
    Service first(s3.open());
    one = first.upload(glb_of(shapes::plane(4, 4)));
    other = first.upload(glb_of(shapes::plane(5, 4)));
  }
  // Another process, which knows that they are there and has read neither.
  Service service(s3.open());
  const auto refuse = [&](const std::string& what, bool with_the_bucket) {
    s3.follow({[=](const FakeS3::Call& call) {
                 const bool hit = call.key.find(what) != std::string::npos ||
                                  (with_the_bucket && call.key.empty());
                 return hit ? FakeS3::Act::refuse : FakeS3::Act::serve;
               },
               nullptr});
  };
  // The bucket answers: it is a matter of these meshes, though they are all there are.
  refuse(".json", false);
  for (const std::string page_of : {"", "?limit=1"}) {
    const HttpResponse listed = service.get("/v1/meshes" + page_of);
    REQUIRE(listed.status == 200);
    const json page = body_of(listed);
    CHECK(page["meshes"].empty());
    CHECK(page["undescribed"].size() == (page_of.empty() ? 2 : 1));
    CHECK(page["undescribed"][0]["problem"]["code"] == "store_failed");
  }
  refuse("", true);
  for (const std::string page_of : {"", "?limit=1"}) {
    const HttpResponse down = service.get("/v1/meshes" + page_of);
    check_problem(down, 503, "store_unavailable");
  }
  refuse(one, false);
  const json half = body_of(service.get("/v1/meshes"));
  REQUIRE(half["meshes"].size() == 1);
  CHECK(half["meshes"][0]["id"] == other);
  REQUIRE(half["undescribed"].size() == 1);
  CHECK(half["undescribed"][0]["id"] == one);
  refuse("nothing has this name", false);
  CHECK(body_of(service.get("/v1/meshes"))["meshes"].size() == 2);
  // What is in memory is described and asked, whatever has become of the store; a list would be
  // of what this server happens to know.
  const std::string question = "/v1/meshes/" + one + "/distance?from=v:0";
  REQUIRE(service.get(question).status == 200);
  refuse("", true);
  CHECK(service.get("/v1/meshes/" + one).status == 200);
  CHECK(service.get(question + "&at=v:3").status == 200);
  check_problem(service.get("/v1/meshes"), 503, "store_unavailable");
}

TEST_CASE("the status says how many computations do not answer") {
  const TemporaryFolder folder;
  Service service(folder.path());
  std::promise<void> end;
  auto stuck = std::async(std::launch::async, [&] {
    Caller short_of_time;
    short_of_time.deadline = Caller::Clock::now() + std::chrono::milliseconds(20);
    return service.pool.run(
        [&](Worker&) -> Result<int> {
          end.get_future().wait();
          return 1;
        },
        short_of_time);
  });
  const auto compute = [&] { return body_of(service.get("/v1/status"))["compute"]; };
  for (int i = 0; i < 2000 && compute()["unanswering"] == 0; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  CHECK(compute()["unanswering"] == 1);
  CHECK(compute()["unanswered"] == 1);
  end.set_value();
  CHECK(stuck.get() == 1);
  CHECK(compute()["unanswering"] == 0);
  CHECK(compute()["unanswered"] == 1);
}
