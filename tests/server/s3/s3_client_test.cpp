// Requests to object storage that misbehaves: what each one ends by, and when nobody asks any more.
#include "server/s3/s3_client.h"

#include <doctest/doctest.h>
#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <random>
#include <string>
#include <thread>
#include <utility>

#include "server/base/service_codes.h"
#include "server/base/unique_fd.h"
#include "tests/fixtures/test_seed.h"
#include "tests/server/routes/service_fixture.h"
#include "tests/server/store/fake_s3.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using geodesic::fixtures::test_seed;

namespace {

using std::chrono::milliseconds;
using S3Clock = std::chrono::steady_clock;

constexpr milliseconds kBriefly(300);
// Far more than anything bounded takes, on a machine that does other things too.
constexpr std::chrono::seconds kLong(20);

S3Client client_of(const FakeS3& s3) {
  auto location = parse_s3_url(s3.url(), FakeS3::environment);
  REQUIRE(location);
  return S3Client(std::move(*location));
}

S3Request request_of(const std::string& method, milliseconds within = milliseconds(0)) {
  S3Request request;
  request.method = method;
  request.key = "key";
  request.within = within;
  return request;
}

// Hangs until it goes, or for a long time.
struct Hanging {
  std::atomic<bool> is_over{false};
  std::atomic<int> calls{0};
  FakeS3::Script script() {
    return {.before = [this](const FakeS3::Call&) {
      ++calls;
      const auto end = S3Clock::now() + 2 * kLong;
      while (!is_over && S3Clock::now() < end) std::this_thread::sleep_for(milliseconds(5));
      return FakeS3::Act::serve;
    }};
  }
};

ErrorCode code_of(const Result<S3Reply>& reply) {
  REQUIRE(!reply);
  return reply.error().code;
}

// A file of its own, without a name.
UniqueFd file_of(const std::string& bytes) {
  const TemporaryFolder folder;
  UniqueFd file(
      ::open((folder.path() / "file").c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600));
  REQUIRE(file);
  REQUIRE(::pwrite(file.get(), bytes.data(), bytes.size(), 0) ==
          static_cast<ssize_t>(bytes.size()));
  return file;
}

std::string bytes_in(const UniqueFd& file) {
  std::string bytes(static_cast<std::size_t>(::lseek(file.get(), 0, SEEK_END)), '\0');
  REQUIRE(::pread(file.get(), bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size()));
  return bytes;
}

std::string random_bytes(std::size_t count, std::mt19937& random) {
  std::string bytes(count, '\0');
  for (char& byte : bytes) byte = static_cast<char>(random());
  return bytes;
}

}  // namespace

TEST_CASE("ARequestWithATimeOfItsOwnEndsInItAndThenNobodyAsks") {
  Hanging hanging;
  FakeS3 s3;
  s3.follow(hanging.script());
  const std::string bytes(100'000, 'x');
  const UniqueFd file = file_of(bytes);
  for (const std::string method : {"GET", "HEAD", "PUT", "DELETE"}) {
    CAPTURE(method);
    auto fresh = client_of(s3);
    S3Request request = request_of(method, kBriefly);
    if (method == "PUT") request.body_file = S3Request::File{file.get(), bytes.size()};
    const int before = hanging.calls;
    const auto began = S3Clock::now();
    CHECK(code_of(fresh.send(request)) == ServiceCode::store_unavailable);
    CHECK(S3Clock::now() - began < kLong);
    CHECK(code_of(fresh.send(request_of("GET"))) == ServiceCode::store_unavailable);
    CHECK(hanging.calls == before + 1);  // one try, and then none
  }
  hanging.is_over = true;
}

TEST_CASE("WhoeverIsToldToStopDoes") {
  Hanging hanging;
  FakeS3 s3;
  auto client = client_of(s3);
  SUBCASE("while it waits for a reply") { s3.follow(hanging.script()); }
  SUBCASE("while it waits for its next try") {
    s3.follow({.before = [&](const FakeS3::Call&) {
      return hanging.is_over ? FakeS3::Act::serve : FakeS3::Act::later;
    }});
  }
  const auto began = S3Clock::now();
  S3Request request = request_of("GET");
  request.stop = [&] { return S3Clock::now() > began + milliseconds(50); };
  CHECK(code_of(client.send(request)) == ErrorCode::cancelled);
  CHECK(S3Clock::now() - began < kLong);
  hanging.is_over = true;
  // That is no fault of the storage.
  CHECK(client.send(request_of("GET")));
}

TEST_CASE("LaterMeansAnotherTryOrNone") {
  std::atomic<int> calls{0};
  FakeS3 s3;
  s3.follow({.before = [&](const FakeS3::Call&) {
    ++calls;
    return FakeS3::Act::later;
  }});
  auto client = client_of(s3);
  CHECK(code_of(client.send(request_of("GET"))) == ServiceCode::store_unavailable);
  CHECK(calls == 3);
  CHECK(code_of(client.send(request_of("GET", kLong))) == ServiceCode::store_unavailable);
  CHECK(calls == 4);
  CHECK(code_of(client.send(request_of("GET", kLong))) == ServiceCode::store_unavailable);
  CHECK(calls == 4);  // it rests
}

TEST_CASE("AReplyToWhatWasAskedBeforeItFailedDoesNotEndTheRest") {
  std::atomic<bool> is_asked{false};
  std::atomic<bool> may_answer{false};
  FakeS3 s3;
  s3.follow({.before = [&](const FakeS3::Call& call) {
    is_asked = is_asked || call.method == "HEAD";
    const auto end = S3Clock::now() + 2 * kLong;
    while (!may_answer && S3Clock::now() < end) std::this_thread::sleep_for(milliseconds(5));
    return FakeS3::Act::serve;
  }});
  auto client = client_of(s3);
  std::thread early([&] { CHECK(client.send(request_of("HEAD"))); });
  while (!is_asked) std::this_thread::sleep_for(milliseconds(5));
  CHECK(code_of(client.send(request_of("GET", kBriefly))) == ServiceCode::store_unavailable);
  may_answer = true;
  early.join();
  CHECK(code_of(client.send(request_of("GET"))) == ServiceCode::store_unavailable);
}

TEST_CASE("FilesGoAndComeAsTheyAre") {
  std::mt19937 random(test_seed());
  FakeS3 s3;
  auto client = client_of(s3);
  for (int i = 0; i < 20; ++i) {
    const std::string bytes = random_bytes(1 + random() % (i % 4 == 0 ? 3'000'000 : 3'000), random);
    CAPTURE(bytes.size());
    const UniqueFd from = file_of(bytes);
    S3Request put = request_of("PUT");
    put.body_file = S3Request::File{from.get(), bytes.size()};
    REQUIRE(client.send(put));
    CHECK(s3.object("key") == bytes);
    const UniqueFd to = file_of("");
    S3Request get = request_of("GET");
    get.open_file = [&](std::uint64_t length) {
      CHECK(length == bytes.size());
      return to.get();
    };
    REQUIRE(client.send(get));
    CHECK(bytes_in(to) == bytes);
  }
}

TEST_CASE("AFileIsOnlyOpenedForWhatIsThere") {
  FakeS3 s3;
  s3.put("key", std::string(50'000, 'x'));
  auto client = client_of(s3);
  const UniqueFd to = file_of("");
  int opened = 0;
  S3Request request = request_of("GET");
  request.open_file = [&](std::uint64_t) -> std::optional<int> {
    ++opened;
    return to.get();
  };
  SUBCASE("there is none") {
    s3.erase("key");
    const auto reply = client.send(request);
    REQUIRE(reply);
    CHECK(reply->status == 404);
    CHECK(opened == 0);
  }
  SUBCASE("there are no bytes") {
    s3.put("key", "");
    CHECK(client.send(request));
    CHECK(opened == 0);
  }
  SUBCASE("it is refused") {
    request.open_file = [&](std::uint64_t) { return std::optional<int>(); };
    CHECK(code_of(client.send(request)) == ServiceCode::store_full);
    CHECK(client.send(request_of("HEAD")));  // no fault of the storage
  }
  SUBCASE("whoever opens it throws") {
    request.open_file = [&](std::uint64_t) -> std::optional<int> { throw std::bad_alloc(); };
    CHECK(code_of(client.send(request)) == ServiceCode::store_failed);
    CHECK(client.send(request_of("HEAD")));
  }
  SUBCASE("the disk fails") {
    const UniqueFd full(::open("/dev/full", O_WRONLY | O_CLOEXEC));
    request.open_file = [&](std::uint64_t) { return full.get(); };
    CHECK(code_of(client.send(request)) == ServiceCode::store_full);
    CHECK(client.send(request_of("HEAD")));
  }
  SUBCASE("the storage refuses") {
    s3.follow({.before = [](const FakeS3::Call&) { return FakeS3::Act::refuse; }});
    CHECK(code_of(client.send(request)) == ServiceCode::store_failed);
    CHECK(opened == 0);
  }
  SUBCASE("it does not tell the length") {
    s3.tells_length_of_get = false;
    CHECK(code_of(client.send(request)) == ServiceCode::store_failed);
    CHECK(opened == 0);
  }
  SUBCASE("it breaks off") {
    s3.follow({.before = [](const FakeS3::Call&) { return FakeS3::Act::break_off; }});
    CHECK(code_of(client.send(request)) == ServiceCode::store_unavailable);
    CHECK(opened == 1);
  }
}

TEST_CASE("AFileThatIsCutShortIsNoFaultOfTheStorage") {
  FakeS3 s3;
  auto client = client_of(s3);
  const UniqueFd file = file_of(std::string(1000, 'x'));
  S3Request request = request_of("PUT");
  request.body_file = S3Request::File{file.get(), 2000};
  CHECK(code_of(client.send(request)) == ServiceCode::store_failed);
  CHECK(!s3.object("key"));
  CHECK(client.send(request_of("GET")));
}
