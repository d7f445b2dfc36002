// The progress of jobs as server-sent events, read from a socket.
#include <doctest/doctest.h>

#include <chrono>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "tests/fixtures/wait_until.h"
#include "tests/server/edge/fixture.h"
#include "tests/server/routes/service_fixture.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using geodesic::fixtures::wait_until;

namespace {

constexpr auto kEventPatience = 120s;  // far more than any of this takes

struct Event {
  std::string name;
  std::string id;
  json job;
};

// The events of a stream; comments are left out.
std::vector<Event> events_of(const std::string& body) {
  std::vector<Event> events;
  Event event;
  for (std::size_t at = 0; at < body.size();) {
    const std::size_t end = body.find('\n', at);
    REQUIRE(end != std::string::npos);
    const std::string line = body.substr(at, end - at);
    at = end + 1;
    if (line.starts_with("event: ")) event.name = line.substr(7);
    if (line.starts_with("id: ")) event.id = line.substr(4);
    if (line.starts_with("data: ")) event.job = json::parse(line.substr(6));
    if (line.empty() && !event.name.empty()) events.push_back(std::exchange(event, {}));
  }
  return events;
}

struct Watched {
  Watched() : service(folder.path()), server(Edge::patient(), handler()) {
    const Result<int> bound = server.start();
    REQUIRE(bound);
    port = *bound;
  }
  HttpHandler handler() {
    return [this](HttpRequest& request) { return service.routes.answer(request); };
  }
  RawReply ask(const std::string& bytes) {
    RawClient client(port);
    client.send(bytes);
    return client.receive(false, kEventPatience);
  }
  std::string begin(const std::string& target) {
    const RawReply reply = ask(get(target, "Prefer: respond-async\r\n"));
    REQUIRE(reply.status == 202);
    return reply.headers.at("location");
  }
  std::string begin_for_ever() {
    const std::string id = service.upload(glb_of(shapes::terrain(60, 5, 3)));
    return begin("/v1/meshes/" + id + "/samples?count=10000&method=exact");
  }

  TemporaryFolder folder;
  Service service;
  HttpServer server;
  int port = 0;
};

void check_ends_with(const std::vector<Event>& events, const std::string& name) {
  REQUIRE_FALSE(events.empty());
  double progress = 0;
  for (std::size_t i = 0; i + 1 < events.size(); ++i) {
    CHECK(events[i].name == "progress");
    CHECK_FALSE(events[i].id.empty());
    CHECK(events[i].id != "end");
    CHECK(events[i].job["progress"] >= progress);
    progress = events[i].job["progress"];
  }
  CHECK(events.back().name == name);
  CHECK(events.back().id == "end");
  CHECK(events.back().job["state"] == name);
}

}  // namespace

TEST_CASE("AStreamTellsProgressAndEndsWithTheJob") {
  Watched watched;
  const std::string id = watched.service.upload(glb_of(shapes::terrain(60, 5, 3)));
  const std::string place = watched.begin("/v1/meshes/" + id + "/samples?count=30&method=exact");
  const RawReply reply = watched.ask(get(place + "/events"));
  CHECK(reply.status == 200);
  CHECK(reply.headers.at("content-type") == "text/event-stream");
  CHECK(reply.headers.at("cache-control") == "no-store");
  CHECK(reply.headers.count("content-encoding") == 0);
  const std::vector<Event> events = events_of(reply.body);
  check_ends_with(events, "done");
  CHECK(events.back().job["progress"] == 1);
  CHECK(events.back().job["result"] == place + "/result");
  CHECK(watched.ask(get(place + "/result")).status == 200);

  // Who comes late hears the end at once; a browser that comes again is sent away.
  check_ends_with(events_of(watched.ask(get(place + "/events")).body), "done");
  CHECK(watched.ask(get(place + "/events", "Last-Event-ID: end\r\n")).status == 204);
}

TEST_CASE("TheLastEventOfAJobThatFails") {
  Watched watched;
  const std::string id = watched.service.upload(glb_of(shapes::icosphere(1)));
  const std::string place = watched.begin("/v1/meshes/" + id + "/distance?from=v:100000");
  const std::vector<Event> events = events_of(watched.ask(get(place + "/events")).body);
  check_ends_with(events, "failed");
  CHECK(events.back().job["status"] == 422);
}

TEST_CASE("CancellingEndsTheStream") {
  Watched watched;
  const std::string place = watched.begin_for_ever();
  RawClient reader(watched.port);
  reader.send(get(place + "/events"));
  const RawReply cancelled =
      watched.ask("DELETE " + place + " HTTP/1.1\r\n" + std::string(host) + "\r\n");
  CHECK(cancelled.status == 204);
  check_ends_with(events_of(reader.receive(false, kEventPatience).body), "cancelled");
}

TEST_CASE("DrainingEndsTheStream") {
  Watched watched;
  const std::string place = watched.begin_for_ever();
  RawClient reader(watched.port);
  reader.send(get(place + "/events"));
  wait_until([&] { return watched.service.pool.stats().running == 1; });
  watched.service.routes.start_draining();
  check_ends_with(events_of(reader.receive(false, kEventPatience).body), "cancelled");
  CHECK(watched.server.stop(kEventPatience));
}

TEST_CASE("AReaderWhoHangsUpIsNoticedAndTheJobGoesOn") {
  Watched watched;
  const std::string place = watched.begin_for_ever();
  {
    RawClient reader(watched.port);
    reader.send(get(place + "/events"));
    pollfd query{reader.socket(), POLLIN, 0};
    REQUIRE(::poll(&query, 1, 60'000) == 1);  // the stream has begun
  }
  wait_until([&] { return watched.server.stats().connections == 0; });
  CHECK(watched.ask(get(place)).body.find("\"finished\":null") != std::string::npos);
  wait_until([&] { return watched.service.pool.stats().running == 1; });
  watched.ask("DELETE " + place + " HTTP/1.1\r\n" + std::string(host) + "\r\n");
  wait_until([&] { return watched.service.pool.stats().running == 0; });
}
