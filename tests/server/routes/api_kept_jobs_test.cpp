// Jobs that outlive the server that took them: another one, on the same store, has what they came
// to, or begins them again.
#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "server/base/sha256.h"
#include "server/store/job_records.h"
#include "tests/fixtures/test_seed.h"
#include "tests/fixtures/wait_until.h"
#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using namespace std::chrono_literals;
using geodesic::fixtures::test_seed;
using geodesic::fixtures::wait_until;

namespace {

// A server that keeps its jobs in its store, until another one takes its place.
struct KeepingServer : Service {
  KeepingServer(const std::filesystem::path& folder, const JobRecords::Limits& limits,
                const Config& config = {})
      : Service(folder, config), records(store->storage(), limits) {
    routes.keep_jobs_in(records);
  }
  ~KeepingServer() { routes.end_jobs(); }  // while the records are there

  JobRecords records;
};

struct OneAfterTheOther {
  explicit OneAfterTheOther(JobRecords::Limits of = {}) : limits(of) {
    server = std::make_unique<KeepingServer>(folder.path(), limits);
    base = "/v1/meshes/" + server->upload(glb_of(shapes::terrain(30, 5, test_seed())));
  }
  // What a client sees of it is that it answers no more.
  void replace() {
    server.reset();
    server = std::make_unique<KeepingServer>(folder.path(), limits);
  }
  std::string begin(const std::string& method, const std::string& target,
                    const std::string& body = {}, std::vector<NameValue> headers = {}) {
    headers.emplace_back("Prefer", "respond-async, keep");
    const HttpResponse response = server->ask(method, target, body, std::move(headers));
    CAPTURE(target);
    REQUIRE(response.status == 202);
    return header_of(response, "Location");
  }
  // One that lasts until it is stopped.
  std::string begin_long() { return begin("GET", base + "/samples?count=900&method=exact"); }
  json job(const std::string& place) {
    const HttpResponse response = server->get(place);
    REQUIRE(response.status == 200);
    return body_of(response);
  }
  json wait(const std::string& place) {
    wait_until([&] { return !job(place)["finished"].is_null(); });
    return job(place);
  }
  // Files below the store's folder of jobs.
  [[nodiscard]] std::vector<std::filesystem::path> kept() const {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path() / "jobs")) {
      files.push_back(entry.path());
    }
    return files;
  }

  JobRecords::Limits limits;
  TemporaryFolder folder;
  std::unique_ptr<KeepingServer> server;
  std::string base;
};

std::string contents_of(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {(std::istreambuf_iterator<char>(in)), {}};
}

}  // namespace

TEST_CASE("WhatAJobCameToIsHadFromTheNextServer") {
  OneAfterTheOther servers;
  const std::string upload = glb_of(shapes::terrain(60, 5, test_seed() + 1));
  REQUIRE(upload.size() > 70'000);  // an object of its own
  const std::vector<std::pair<std::string, std::string>> questions{
      {servers.base + "/distance?from=v:3", ""},
      {servers.base + "/distance?from=v:900", ""},  // there is none
      {servers.base + "/samples?count=5", ""},
      {servers.base + "/distance", R"({"from": ["v:7"], "format": "f32"})"},
      {servers.base + "/batch", "{\"path\": {\"from\": \"v:1\", \"to\": \"v:9\"}}\n"},
      {"/v1/meshes", upload}};
  for (const auto& [target, body] : questions) {
    CAPTURE(target);
    const std::string place = servers.begin(body.empty() ? "GET" : "POST", target, body);
    const json job = servers.wait(place);
    const HttpResponse here = servers.server->get(place + "/result");
    servers.replace();
    json other = servers.job(place);
    CHECK(other == job);
    const HttpResponse there = servers.server->get(place + "/result");
    CHECK(there.status == here.status);
    CHECK(there.headers == here.headers);
    CHECK(there.content_type == here.content_type);
    REQUIRE(there.body);
    CHECK(*there.body == *here.body);
  }
}

TEST_CASE("WhatHasNotEndedIsBegunAgainByTheNextServer") {
  OneAfterTheOther servers;
  const std::string place = servers.begin_long();
  const std::string waiting =
      servers.begin("POST", servers.base + "/distance", R"({"from": ["v:5"]})");
  const json before = servers.job(place);
  CHECK(before["attempt"] == 1);
  CHECK(before["kept"] == true);
  for (int attempt = 2; attempt <= 3; ++attempt) {
    servers.replace();
    const json after = servers.job(place);
    CHECK(after["attempt"] == attempt);
    CHECK(after["created"] == before["created"]);
    CHECK(after["target"] == before["target"]);
    CHECK(servers.job(place)["attempt"] == attempt);  // to ask is not to begin
  }
  CHECK(servers.wait(waiting)["state"] == "done");
  const HttpResponse direct =
      servers.server->ask("POST", servers.base + "/distance", R"({"from": ["v:5"]})");
  CHECK(*servers.server->get(waiting + "/result").body == *direct.body);
  CHECK(servers.server->ask("DELETE", place).status == 204);
}

TEST_CASE("WhoIsAboutToStopDoesNotCallAJobCancelled") {
  OneAfterTheOther servers;
  const std::string place = servers.begin_long();
  servers.server->routes.start_draining();
  for (const char* part : {"", "/result", "/events"}) {
    CAPTURE(part);
    const HttpResponse refused = servers.server->get(place + part);
    check_problem(refused, 503, "draining");
    CHECK_FALSE(header_of(refused, "Retry-After").empty());
  }
}

TEST_CASE("WhoWatchesAgainIsToldWhatIsNew") {
  OneAfterTheOther servers;
  const std::string place = servers.begin_long();
  const auto first_event = [&](const std::string& last) {
    std::vector<NameValue> headers;
    if (!last.empty()) headers.emplace_back("Last-Event-ID", last);
    const HttpResponse events = servers.server->ask("GET", place + "/events", "", headers);
    REQUIRE(events.stream);
    std::string chunk;
    while (events.stream(chunk) && chunk.starts_with(":")) chunk.clear();
    return chunk;
  };
  const auto id_of = [](const std::string& event) {
    const std::size_t begin = event.find("\nid: ") + 5;
    return event.substr(begin, event.find('\n', begin) - begin);
  };
  const std::string seen = first_event("");
  CHECK(id_of(first_event(id_of(seen))) != id_of(seen));
  servers.replace();
  const std::string next = first_event(id_of(seen));
  CHECK(id_of(next) != id_of(seen));
  CHECK(next.find(R"("attempt":2)") != std::string::npos);
  CHECK(servers.server->ask("DELETE", place).status == 204);
}

TEST_CASE("WhatIsDeletedOrTooOldIsNotKept") {
  OneAfterTheOther servers({.bytes = 1 << 20, .keep = 1s});
  const std::string deleted = servers.begin("GET", servers.base + "/samples?count=5");
  const std::string old = servers.begin("GET", servers.base + "/samples?count=6");
  servers.wait(deleted);
  servers.wait(old);
  CHECK(servers.kept().size() == 4);  // questions and replies
  CHECK(servers.server->ask("DELETE", deleted).status == 204);
  CHECK(servers.kept().size() == 2);
  wait_until([&] {
    servers.server->records.tidy();
    return servers.kept().empty();
  });
  servers.replace();
  check_problem(servers.server->get(deleted), 404, "job_unknown");
  check_problem(servers.server->get(old + "/result"), 404, "job_unknown");
}

TEST_CASE("JobsTakeNoMoreOfTheStoreThanTheirBudget") {
  OneAfterTheOther servers({.bytes = 100'000, .keep = 1h});
  for (int i = 0; i < 12; ++i) {
    servers.wait(
        servers.begin("GET", servers.base + "/distance?format=f32&from=v:" + std::to_string(i)));
    servers.wait(servers.begin(
        "GET", servers.base + "/samples?method=dijkstra&count=" + std::to_string(300 + i)));
  }
  servers.server->records.tidy();
  std::uintmax_t bytes = 0;
  for (const auto& path : servers.kept()) bytes += std::filesystem::file_size(path);
  CHECK(bytes > 10'000);
  CHECK(bytes <= 100'000);
}

TEST_CASE("NoCredentialsAreKept") {
  OneAfterTheOther servers;
  const std::string place = servers.begin("GET", servers.base + "/samples?count=900&method=exact",
                                          "", {{"aUTHORIZATION", "Bearer 0123456789"}});
  REQUIRE_FALSE(servers.kept().empty());
  for (const auto& path : servers.kept()) {
    CHECK(contents_of(path).find("0123456789") == std::string::npos);
  }
  CHECK(servers.server->ask("DELETE", place).status == 204);
}

TEST_CASE("ARecordThatIsDamagedIsNeverTaken") {
  std::mt19937 random(test_seed());
  OneAfterTheOther servers;
  const std::string target = servers.base + "/distance?from=v:5";
  const HttpResponse direct = servers.server->get(target);
  for (int time = 0; time < 20; ++time) {
    const bool has_ended = time % 2 == 0;
    const std::string place = has_ended ? servers.begin("GET", target) : servers.begin_long();
    if (has_ended) servers.wait(place);
    const std::string id = place.substr(place.rfind('/') + 1);
    servers.server.reset();
    for (const auto& path : servers.kept()) {
      if (!path.filename().string().starts_with(id)) continue;
      std::string bytes = contents_of(path);
      if (random() % 3 == 0) {
        bytes.resize(random() % bytes.size());
      } else {
        bytes[random() % bytes.size()] ^= static_cast<char>(1U << (random() % 8));
      }
      std::ofstream(path, std::ios::binary) << bytes;
    }
    servers.server = std::make_unique<KeepingServer>(servers.folder.path(), servers.limits);
    check_problem(servers.server->get(place), 404, "job_unknown");
  }
}

// Who may write to the store is not to end the server by it.
TEST_CASE("ARecordThatIsNestedDeeplyOrLargeIsNoRecord") {
  OneAfterTheOther servers;
  const std::string id(48, 'a');
  // Lists of one list, as MessagePack and as CBOR have them; CBOR's strings of strings.
  for (const char part : {'\x91', '\x81', '\x7f', '\x5f'}) {
    for (const char version : {'1', '2'}) {
      for (const std::size_t size : {250'000, 2 << 20}) {
        CAPTURE(static_cast<int>(part));
        CAPTURE(version);
        CAPTURE(size);
        const std::string rest(size, part);
        std::ofstream(servers.folder.path() / "jobs" / (id + ".job"), std::ios::binary)
            << "geodesicd job " << version << '\n'
            << sha256_hex(rest) << rest;
        check_problem(servers.server->get("/v1/jobs/" + id), 404, "job_unknown");
      }
    }
  }
}

TEST_CASE("WhatIsLargerThanItMayBeIsNotRead") {
  constexpr std::uintmax_t kVast = std::uintmax_t{1} << 40;  // a file of holes
  OneAfterTheOther servers;
  const std::string question = R"({"count": 900, "method": "exact"})" + std::string(70'000, ' ');
  for (const char* ending : {".job", ".body"}) {
    CAPTURE(ending);
    const std::string place = servers.begin("POST", servers.base + "/samples", question);
    servers.server.reset();
    const std::string id = place.substr(place.rfind('/') + 1);
    const auto path = servers.folder.path() / "jobs" / (id + ending);
    REQUIRE(std::filesystem::exists(path));
    std::filesystem::resize_file(path, kVast);
    servers.server = std::make_unique<KeepingServer>(servers.folder.path(), servers.limits);
    check_problem(servers.server->get(place), 404, "job_unknown");
  }
}

// An older server finds the records of a newer one, and the other way round.
TEST_CASE("AJobOfAnotherVersionIsUnknown") {
  OneAfterTheOther servers;
  const std::string target = servers.base + "/samples?count=5";
  const std::string begin = "geodesicd job 2\n";
  for (const char version : {'1', '3'}) {
    CAPTURE(version);
    const std::string place = servers.begin("GET", target);
    servers.wait(place);
    servers.server.reset();
    for (const auto& path : servers.kept()) {
      std::string bytes = contents_of(path);
      REQUIRE(bytes.size() > begin.size());
      bytes[begin.size() - 2] = version;
      std::ofstream(path, std::ios::binary) << bytes;
    }
    servers.server = std::make_unique<KeepingServer>(servers.folder.path(), servers.limits);
    check_problem(servers.server->get(place), 404, "job_unknown");
    // It can be asked again.
    CHECK(servers.wait(servers.begin("GET", target))["state"] == "done");
  }
}

TEST_CASE("OfWhatIsOldOnlyJobsAreErased") {
  OneAfterTheOther servers;
  const auto old = std::filesystem::file_time_type::clock::now() - std::chrono::hours(72);
  const std::string id(48, '7');
  for (const std::string& name : {id + ".job", id + ".end", id + ".reply", id + ".body", id,
                                  id + ".txt", std::string("notes.job"), "x" + id + ".job"}) {
    const auto path = servers.folder.path() / "jobs" / name;
    std::ofstream(path) << "something";
    std::filesystem::last_write_time(path, old);
  }
  const std::string recent = servers.begin("GET", servers.base + "/samples?count=5");
  servers.wait(recent);
  servers.server->records.tidy();
  CHECK(servers.kept().size() == 6);  // four that are no job's, and two of the recent one
  CHECK(servers.job(recent)["state"] == "done");
}

TEST_CASE("WhatIsDeletedStaysAwayWhoeverAsksMeanwhile") {
  OneAfterTheOther servers;
  for (int time = 0; time < 30; ++time) {
    const std::string place = servers.begin("GET", servers.base + "/samples?count=5");
    servers.wait(place);
    if (time % 2 == 0) servers.replace();
    std::atomic<bool> is_over = false;
    std::thread asker([&] {
      while (!is_over) (void)servers.server->get(place);
    });
    CHECK(servers.server->ask("DELETE", place).status == 204);
    is_over = true;
    asker.join();
    check_problem(servers.server->get(place), 404, "job_unknown");
  }
}
