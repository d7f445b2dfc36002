// A connection is taken while memory runs out, at each allocation in turn: its socket is
// closed once, and never twice. Between the two another thread may have got its number.
#include <doctest/doctest.h>
#include <netinet/in.h>
#include <poll.h>
#include <spdlog/spdlog.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdlib>
#include <new>
#include <thread>
#include <utility>

#include "server/edge/workers.h"

namespace {

thread_local int allocations_left = -1;  // of this thread, until one fails; -1: none does
std::atomic<int> closed_in_vain{0};

// Two ends of a connection. The address of the first, as the second sees it, is an IPv4 one
// in IPv6: so long that a string of it takes memory, after the socket has an owner.
std::pair<geodesic::server::UniqueFd, geodesic::server::UniqueFd> pair() {
  using geodesic::server::UniqueFd;
  const UniqueFd listener(::socket(AF_INET6, SOCK_STREAM | SOCK_CLOEXEC, 0));
  const int off = 0;
  ::setsockopt(listener.get(), IPPROTO_IPV6, IPV6_V6ONLY, &off, sizeof off);
  sockaddr_in6 any{};
  any.sin6_family = AF_INET6;
  socklen_t size = sizeof any;
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  UniqueFd peer(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (::bind(listener.get(), reinterpret_cast<sockaddr*>(&any), sizeof any) == 0 &&
      ::listen(listener.get(), 1) == 0 &&
      ::getsockname(listener.get(), reinterpret_cast<sockaddr*>(&any), &size) == 0) {
    here.sin_port = any.sin6_port;
    if (::connect(peer.get(), reinterpret_cast<sockaddr*>(&here), sizeof here) == 0) {
      return {std::move(peer), UniqueFd(::accept(listener.get(), nullptr, nullptr))};
    }
  }
  MESSAGE("no IPv6 here: the address is short, and takes no memory");
  int ends[2] = {-1, -1};
  (void)::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends);
  return {UniqueFd(ends[0]), UniqueFd(ends[1])};
}

}  // namespace

void* operator new(std::size_t size) {
  if (allocations_left >= 0 && allocations_left-- == 0) throw std::bad_alloc();
  if (void* const memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t /*size*/) noexcept { std::free(memory); }

// In the place of the C library's.
extern "C" int close(int file) {
  const auto result = static_cast<int>(::syscall(SYS_close, file));
  if (result != 0 && errno == EBADF) ++closed_in_vain;
  return result;
}

using namespace geodesic::server;
using namespace std::chrono_literals;

TEST_CASE("a connection for which there is no memory is closed once") {
  spdlog::set_level(spdlog::level::off);
  HttpOptions options;
  options.io_threads = 2;
  options.max_connections = 1000;
  HttpEdge edge{std::move(options), [](Exchange&) {}};
  HttpWorkers workers(edge);
  REQUIRE(workers.start());
  int refused = 0;
  bool is_taken = false;
  for (int allocations = 0; allocations < 1000 && !is_taken; ++allocations) {
    CAPTURE(allocations);
    auto [peer, connection] = pair();
    bool has_thrown = false;
    allocations_left = allocations;
    try {
      workers.adopt(std::move(connection));
    } catch (const std::bad_alloc&) {
      has_thrown = true;
    }
    const bool was_enough = allocations_left >= 0;
    allocations_left = -1;
    CHECK_FALSE(has_thrown);
    pollfd query{peer.get(), POLLIN | POLLRDHUP, 0};
    is_taken = ::poll(&query, 1, 0) == 0;
    if (was_enough) CHECK(is_taken);
    refused += !is_taken;
    CHECK(closed_in_vain == 0);
  }
  CHECK(is_taken);
  CHECK(refused >= 2);
  CHECK(workers.connections() <= 1);
  edge.stopping = true;
  workers.stop(0ms);
  CHECK(closed_in_vain == 0);
}
