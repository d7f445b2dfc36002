// Bodies taken out of a connection's bytes, however those are cut into pieces.
#include "server/edge/body.h"

#include <doctest/doctest.h>

#include <string>
#include <string_view>
#include <utility>

using namespace geodesic::server;
using State = HttpBody::State;

namespace {

struct Taken {
  State state;
  std::string body;
  std::string rest;
};

// `bytes` in pieces of `piece` bytes; what is left when the body is over, follows.
Taken take(HttpBody reader, std::string_view bytes, std::size_t piece) {
  Taken taken{State::more, {}, {}};
  while (taken.state == State::more && !bytes.empty()) {
    std::string_view part = bytes.substr(0, piece);
    bytes.remove_prefix(part.size());
    taken.state = reader.take(part, taken.body);
    taken.rest = std::string(part) + std::string(bytes);
    if (taken.state == State::more) CHECK(part.empty());
  }
  return taken;
}

void check_all_cuts(std::string_view bytes, State state, std::string_view body) {
  for (std::size_t piece = 1; piece <= bytes.size(); ++piece) {
    CAPTURE(bytes);
    CAPTURE(piece);
    const Taken taken = take(HttpBody::chunked(1000), bytes, piece);
    CHECK(taken.state == state);
    if (state == State::complete) CHECK(taken.body == body);
    CHECK(taken.body.size() <= 1000);
  }
}

}  // namespace

TEST_CASE("a counted body ends with its last byte") {
  for (std::size_t piece = 1; piece < 12; ++piece) {
    const Taken taken = take(HttpBody::counted(5), "helloGET /", piece);
    CHECK(taken.state == State::complete);
    CHECK(taken.body == "hello");
    CHECK(taken.rest == "GET /");
  }
  CHECK(take(HttpBody::counted(5), "hell", 2).state == State::more);
}

TEST_CASE("chunks are joined, and extensions and trailers are skipped") {
  check_all_cuts("5\r\nhello\r\n0\r\n\r\n", State::complete, "hello");
  check_all_cuts("005;a=b;c=\"d\"\r\nhello\r\nA\r\n0123456789\r\n0;x\r\nT: u\r\nV: w\r\n\r\n",
                 State::complete, "hello0123456789");
  check_all_cuts("0\r\n\r\n", State::complete, "");
  const Taken taken = take(HttpBody::chunked(10), "1\r\na\r\n0\r\n\r\nGET /next", 3);
  CHECK(taken.rest == "GET /next");
  CHECK(take(HttpBody::chunked(5), "5\r\nhello\r\n0\r\n\r\n", 99).state == State::complete);
}

TEST_CASE("chunks that could be read in two ways are refused, wherever they are cut") {
  for (const std::string_view bytes : {
           std::string_view("5\nhello\r\n0\r\n\r\n"),      // a bare LF
           std::string_view("5\r\nhello\n0\r\n\r\n"),      // … after the data
           std::string_view("5\r\nhello0\r\n\r\n"),        // nothing after the data
           std::string_view("5\r\nhello!\r\n0\r\n\r\n"),   // more than announced
           std::string_view("5\r\r\nhello\r\n0\r\n\r\n"),  // a CR too many
           std::string_view("5 \r\nhello\r\n"),            // a space after the number
           std::string_view(" 5\r\nhello\r\n"),            // … and before
           std::string_view("+5\r\nhello\r\n"),
           std::string_view("-5\r\nhello\r\n"),
           std::string_view("0x5\r\nhello\r\n"),
           std::string_view("5,5\r\nhello\r\n"),
           std::string_view("\r\nhello\r\n"),
           std::string_view(";a\r\nhello\r\n"),
           std::string_view("g\r\nhello\r\n"),
           std::string_view("5;a\x01\r\nhello\r\n"),
           std::string_view("5;\0\r\nhello\r\n", 12),
           std::string_view("0\r\nT: u\n\r\n"),
           std::string_view("0\r\nno colon\r\n\r\n"),
           std::string_view("0\r\nnocolon\r\n\r\n"),
           std::string_view("0\r\nT: u\r\n folded\r\n\r\n"),
           std::string_view("0\r\n T: u\r\n\r\n"),
           std::string_view("0\r\nT : u\r\n\r\n"),
           std::string_view("0\r\n: u\r\n\r\n"),
       }) {
    check_all_cuts(bytes, State::malformed, "");
  }
}

TEST_CASE("a chunk over the limit is refused when it is announced") {
  for (const std::string_view bytes : {"3e9\r\n", "ffffffffffffffff\r\n", "10000000000000000\r\n",
                                       "99999999999999999999999\r\n", "3e8;but not yet\r\n"}) {
    const bool fits = bytes.front() == '3' && bytes[2] == '8';
    CHECK(take(HttpBody::chunked(1000), bytes, 2).state == (fits ? State::more : State::too_large));
  }
  const std::string half = "1f4\r\n" + std::string(500, 'x') + "\r\n";
  CHECK(take(HttpBody::chunked(1000), half + half + "1\r\n", 7).state == State::too_large);
  CHECK(take(HttpBody::chunked(1000), half + half + "0\r\n\r\n", 7).state == State::complete);
}

TEST_CASE("lines and trailers without end are refused") {
  CHECK(take(HttpBody::chunked(9), "5;" + std::string(100'000, 'a'), 1000).state ==
        State::malformed);
  CHECK(take(HttpBody::chunked(9), std::string(100'000, '0'), 1000).state == State::malformed);
  std::string trailers = "0\r\n";
  for (int i = 0; i < 10'000; ++i) trailers += "A: b\r\n";
  CHECK(take(HttpBody::chunked(9), trailers, 1000).state == State::malformed);
}

TEST_CASE("a promise of many bytes takes no memory") {
  HttpBody reader = HttpBody::counted(std::uint64_t{1} << 40);
  std::string body;
  std::string_view few = "abc";
  CHECK(reader.take(few, body) == State::more);
  CHECK(body.capacity() <= 1u << 17);
}
