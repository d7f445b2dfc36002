// Accepting connections when the system will not have it.
#include "server/edge/listener.h"

#include <doctest/doctest.h>
#include <sys/socket.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <memory>
#include <string>
#include <utility>

#include "tests/fixtures/wait_until.h"
#include "tests/server/edge/fixture.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using geodesic::fixtures::wait_until;

namespace {

// An edge whose accept fails with `error` for as long as `failures` is above zero.
struct Failing {
  explicit Failing(int error_number) : error(error_number) {}

  HttpOptions options() {
    HttpOptions options = Edge::patient();
    options.accept = [this](int socket) {
      if (failures > 0) {
        --failures;
        errno = error;
        return -1;
      }
      is_waiting = true;
      const int connection = ::accept4(socket, nullptr, nullptr, SOCK_CLOEXEC);
      is_waiting = false;
      return connection;
    };
    options.failed = [this](const std::string& why) {
      reason = why;
      has_failed = true;
    };
    return options;
  }

  // From the next but one connection on: an accept that has begun brings the next.
  void fail(int times) {
    wait_until([&] { return is_waiting.load(); });
    failures = times;
  }

  std::atomic<int> error;
  std::atomic<bool> is_waiting{false};
  std::atomic<int> failures{0};
  std::string reason;
  std::atomic<bool> has_failed{false};
};

bool is_served(const Edge& edge) {
  RawClient client(edge.port);
  client.send(get("/x"));
  return client.receive().status == 200;
}

}  // namespace

TEST_CASE("whatever keeps a connection from being accepted for a while is waited out") {
  for (const int error : {EMFILE, ENFILE, ENOMEM, ENOBUFS, ECONNABORTED, EPROTO, EPERM, ENETDOWN,
                          EHOSTUNREACH, EAGAIN, EINTR, EIO, ENOSPC, 9999}) {
    CAPTURE(error);
    Failing failing(error);
    Edge edge(failing.options());
    for (const int failures : {1, 5}) {
      failing.fail(failures);
      CHECK(is_served(edge));  // the first by an accept that had begun before
      CHECK(is_served(edge));
    }
    const HttpServer::Stats stats = edge.server.stats();
    CHECK(stats.accept_failures == (error == EINTR ? 0 : 6));
    CHECK(stats.is_accepting);
    CHECK_FALSE(failing.has_failed);
    CHECK(edge.server.stop(10s));
    CHECK_THROWS(RawClient(edge.port));  // nobody listens any more
  }
}

TEST_CASE("connections that wait in vain are told of, and the server can be stopped") {
  Failing failing(ENFILE);
  Edge edge(failing.options());
  CHECK(is_served(edge));
  failing.fail(1 << 30);
  RawClient last(edge.port);  // by the accept that had begun
  RawClient waiting(edge.port);
  waiting.send(get("/x"));
  wait_until([&] { return !edge.server.stats().is_accepting; });
  // It is tried again and again, but not all the time.
  const std::uint64_t before = edge.server.stats().accept_failures;
  std::this_thread::sleep_for(500ms);
  CHECK(edge.server.stats().accept_failures < before + 50);
  failing.failures = 0;
  CHECK(waiting.receive().status == 200);
  wait_until([&] { return edge.server.stats().is_accepting; });

  failing.fail(1 << 30);
  RawClient another(edge.port);
  RawClient one_more(edge.port);
  wait_until([&] { return !edge.server.stats().is_accepting; });
  edge.server.stop(0ms);
  CHECK_FALSE(failing.has_failed);
}

TEST_CASE("a listening socket that is dead is told of with a reason") {
  for (const int error : {EBADF, EINVAL, ENOTSOCK, EOPNOTSUPP, EFAULT}) {
    CAPTURE(error);
    Failing failing(error);
    Edge edge(failing.options());
    failing.fail(1 << 30);
    RawClient last(edge.port);
    last.send(get("/x"));
    CHECK(last.receive().status == 200);
    wait_until([&] { return failing.has_failed.load(); });
    CHECK_FALSE(failing.reason.empty());
    CHECK_FALSE(edge.server.stats().is_accepting);
    CHECK(edge.server.stats().accept_failures == 1);
    // Who is connected is served on.
    last.send(get("/x"));
    CHECK(last.receive().status == 200);
    edge.server.stop(0ms);
  }
}
