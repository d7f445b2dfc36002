// Long work over the API: the same reply later, and no more of it than is wanted.
#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <regex>
#include <string>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using namespace std::chrono_literals;

namespace {

constexpr auto kPatience = 120s;  // far more than any of this takes

struct JobService : PlaneService {
  using PlaneService::PlaneService;

  HttpResponse ask_later(const std::string& method, const std::string& target,
                         const std::string& body = {}, std::vector<NameValue> headers = {}) {
    headers.emplace_back("Prefer", "respond-async");
    return service.ask(method, target, body, std::move(headers));
  }
  // The place of the job that it becomes.
  std::string begin(const std::string& method, const std::string& target,
                    const std::string& body = {}, std::vector<NameValue> headers = {}) {
    const HttpResponse response = ask_later(method, target, body, std::move(headers));
    CAPTURE(target);
    REQUIRE(response.status == 202);
    const std::string place = header_of(response, "Location");
    CHECK(place == "/v1/jobs/" + body_of(response)["id"].get<std::string>());
    CHECK(header_of(response, "Preference-Applied") == "respond-async");
    CHECK(header_of(response, "Cache-Control") == "no-store");
    CHECK(response.content_type == "application/json");
    return place;
  }
  // The job once `wanted(job)` is true of it.
  template <class Wanted>
  json wait_until(const std::string& place, Wanted wanted) {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (true) {
      const HttpResponse response = service.get(place);
      REQUIRE(response.status == 200);
      json job = body_of(response);
      if (wanted(job)) return job;
      REQUIRE(std::chrono::steady_clock::now() < end);
      std::this_thread::sleep_for(2ms);
    }
  }
  json wait(const std::string& place) {
    return wait_until(place, [](const json& job) { return !job["finished"].is_null(); });
  }
  // A computation that nobody can wait for, of which much is cheap to stop.
  std::string begin_for_ever() {
    return begin("GET", add(shapes::terrain(60, 5, 3)) + "/samples?count=10000&method=exact");
  }
  // Until no more jobs than that wait or hold a thread, whatever their state.
  void wait_until_idle(std::uint64_t but = 0) {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    const auto held = [&] {
      const json jobs = body_of(service.get("/v1/status"))["jobs"];
      return jobs["queued"].get<std::uint64_t>() + jobs["running"].get<std::uint64_t>();
    };
    while (held() > but) {
      REQUIRE(std::chrono::steady_clock::now() < end);
      std::this_thread::sleep_for(1ms);
    }
  }
};

// All but what differs from one reply to the next by its nature.
std::vector<NameValue> lasting_headers(const HttpResponse& response) {
  std::vector<NameValue> headers = response.headers;
  std::erase_if(headers, [](const NameValue& header) {
    return header.first == "Server-Timing" || header.first == "Cache-Control";
  });
  std::sort(headers.begin(), headers.end());
  return headers;
}

void check_same_reply(const HttpResponse& direct, const HttpResponse& later) {
  CHECK(later.status == direct.status);
  CHECK(later.content_type == direct.content_type);
  REQUIRE(direct.body);
  REQUIRE(later.body);
  CHECK(*later.body == *direct.body);
  CHECK(lasting_headers(later) == lasting_headers(direct));
}

}  // namespace

TEST_CASE("AJobsResultIsTheDirectReplyByteForByte") {
  JobService jobs;
  for (const std::string target :
       {"/distance?from=v:3", "/distance?from=v:3&format=f32",
        "/path?from=v:0&to=v:77&method=exact", "/table?from=v:1&from=v:2&to=v:9",
        "/isolines?from=v:0&count=3", "/samples?count=5",
        "/trace?from=v:50&direction=1,0.3,0&length=3", "/nearest?point=p:1,2,3"}) {
    CAPTURE(target);
    CHECK(jobs.service.get(jobs.base + target).status == 200);  // now the caches have it
    const HttpResponse direct = jobs.service.get(jobs.base + target);
    const std::string place = jobs.begin("GET", jobs.base + target);
    const json job = jobs.wait(place);
    CHECK(job["state"] == "done");
    CHECK(job["progress"] == 1);
    CHECK(job["status"] == 200);
    CHECK(job["result"] == place + "/result");
    CHECK(job["target"] == jobs.base + target);
    CHECK(job["method"] == "GET");
    for (int time = 0; time < 2; ++time) {
      check_same_reply(direct, jobs.service.get(place + "/result"));
    }
  }
}

TEST_CASE("AJobsResultIsPackedAsItsReaderWishesAndKeptByNobody") {
  JobService jobs;
  const std::string target = jobs.base + "/distance?from=v:3";
  const std::vector<NameValue> wish{{"Accept-Encoding", "gzip"}};
  CHECK(jobs.service.get(target).status == 200);
  const HttpResponse direct = jobs.service.ask("GET", target, {}, wish);
  CHECK(header_of(direct, "Content-Encoding") == "gzip");
  const HttpResponse plain = jobs.service.get(target);
  // Whatever whoever asked for it would have taken.
  for (const std::vector<NameValue>& asked : {wish, std::vector<NameValue>()}) {
    const std::string place = jobs.begin("GET", target, {}, asked);
    jobs.wait(place);
    const HttpResponse packed = jobs.service.ask("GET", place + "/result", {}, wish);
    check_same_reply(direct, packed);
    const HttpResponse unpacked = jobs.service.get(place + "/result");
    check_same_reply(plain, unpacked);
    // Who knows the id knows the result: no cache on the way is to have it.
    CHECK(header_of(packed, "Cache-Control") == "no-store");
    CHECK(header_of(unpacked, "Cache-Control") == "no-store");
  }
}

TEST_CASE("WhatAClientHadBeforeDoesNotKeepAResultFromIt") {
  JobService jobs;
  const std::string target = jobs.base + "/distance?from=v:3";
  const std::string tag = header_of(jobs.service.get(target), "ETag");
  REQUIRE_FALSE(tag.empty());
  const std::vector<NameValue> headers{{"If-None-Match", tag}};
  CHECK(jobs.service.ask("GET", target, {}, headers).status == 304);
  const std::string place = jobs.begin("GET", target, {}, headers);
  CHECK(jobs.wait(place)["status"] == 200);
  CHECK(jobs.service.ask("GET", place + "/result", {}, headers).status == 200);
}

TEST_CASE("UploadsQueriesByPostBatchesAndPreparingMayBeJobs") {
  JobService jobs;
  const std::string glb = glb_of(shapes::icosphere(2));
  const std::string id = sha256_hex(glb);
  const std::string upload = jobs.begin("POST", "/v1/meshes", glb);
  CHECK(jobs.wait(upload)["status"] == 201);
  const HttpResponse created = jobs.service.get(upload + "/result");
  CHECK(created.status == 201);
  CHECK(header_of(created, "Location") == "/v1/meshes/" + id);
  CHECK(body_of(created)["id"] == id);

  const std::string put = jobs.begin("PUT", "/v1/meshes/" + id, glb);
  CHECK(jobs.wait(put)["status"] == 200);
  const std::string prepare = jobs.begin("POST", "/v1/meshes/" + id + "/prepare");
  CHECK(jobs.wait(prepare)["status"] == 200);
  CHECK(body_of(jobs.service.get(prepare + "/result"))["prepared"] == true);

  const std::string query = R"({"from":{"vertex":0},"at":{"vertex":9}})";
  const std::string post = jobs.begin("POST", jobs.base + "/distance", query);
  CHECK(jobs.wait(post)["status"] == 200);
  CHECK(*jobs.service.get(post + "/result").body ==
        *jobs.service.ask("POST", jobs.base + "/distance", query).body);

  const std::string lines = R"({"query":"distance","from":{"vertex":0},"at":{"vertex":9}})"
                            "\n"
                            R"({"query":"magic"})"
                            "\n";
  const std::string batch = jobs.begin("POST", jobs.base + "/batch", lines);
  CHECK(jobs.wait(batch)["status"] == 200);
  const HttpResponse replies = jobs.service.get(batch + "/result");
  CHECK(replies.content_type == "application/x-ndjson");
  CHECK(std::count(replies.body->begin(), replies.body->end(), '\n') == 2);
}

TEST_CASE("TimesAreInOrderAndInRfc3339") {
  JobService jobs;
  const json job = jobs.wait(jobs.begin("GET", jobs.base + "/distance?from=v:0"));
  const std::regex moment(R"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z)");
  for (const char* const name : {"created", "started", "finished"}) {
    CHECK(std::regex_match(job[name].get<std::string>(), moment));
  }
  CHECK(job["created"] <= job["started"]);
  CHECK(job["started"] <= job["finished"]);
}

TEST_CASE("PreferIsReadAsRfc7240Says") {
  JobService jobs;
  const std::string target = jobs.base + "/distance?from=v:0";
  const auto status = [&](const std::string& value) {
    return jobs.service.ask("GET", target, {}, {{"prefer", value}}).status;
  };
  for (const std::string yes :
       {"respond-async", "Respond-ASYNC", "respond-async, wait=10", "wait=10 ,\trespond-async ",
        "respond-async; foo=\"a,b\"", "foo=\"a, \\\" b\", respond-async", "respond-async=\"\"",
        ",, respond-async", "return=minimal;x=\"respond\", respond-async"}) {
    CAPTURE(yes);
    CHECK(status(yes) == 202);
  }
  for (const std::string no : {"", "wait=10", "respond-asynchronously", "respond-async=no",
                               "foo=\"respond-async\"", "foo=\"a, respond-async, b\"",
                               "foo; respond-async", "foo=respond-async", "\"respond-async\""}) {
    CAPTURE(no);
    CHECK(status(no) == 200);
  }
  const std::vector<NameValue> twice{{"Prefer", "wait=5"}, {"Prefer", "respond-async"}};
  CHECK(jobs.service.ask("GET", target, {}, twice).status == 202);
}

TEST_CASE("AJobHasALeaseUnlessItIsToBeKept") {
  Config config;
  config.job_lease_seconds = 7;
  JobService jobs(config);
  const std::string target = jobs.base + "/distance?from=v:0";
  const auto begin = [&](const std::string& prefer) {
    HttpResponse begun = jobs.service.ask("GET", target, {}, {{"Prefer", prefer}});
    REQUIRE(begun.status == 202);
    return begun;
  };
  const HttpResponse leased = begin("respond-async");
  CHECK(body_of(leased)["lease_seconds"] == 7);
  CHECK(header_of(leased, "Preference-Applied") == "respond-async");
  const HttpResponse kept = begin("keep, respond-async");
  CHECK(body_of(kept)["lease_seconds"] == nullptr);
  CHECK(header_of(kept, "Preference-Applied") == "respond-async, keep");
  CHECK(jobs.service.ask("GET", target, {}, {{"Prefer", "keep"}}).status == 200);
  CHECK(body_of(jobs.service.get("/v1/status"))["limits"]["job_lease_seconds"] == 7);
}

TEST_CASE("WhatCannotTakeLongIsNeverAJob") {
  JobService jobs;
  for (const std::string& target :
       {std::string("/"), std::string("/v1/meshes"), std::string("/v1/status"),
        std::string("/v1/methods"), jobs.base, jobs.base + "/source"}) {
    CAPTURE(target);
    CHECK(jobs.ask_later("GET", target).status == 200);
  }
  CHECK(jobs.ask_later("HEAD", jobs.base + "/distance?from=v:0").status == 200);
  CHECK(jobs.ask_later("GET", jobs.base + "/prepare").status == 405);
  CHECK(jobs.ask_later("PUT", jobs.base + "/distance").status == 405);
  CHECK(jobs.ask_later("GET", jobs.base + "/magic").status == 404);
  CHECK(jobs.ask_later("DELETE", jobs.base).status == 204);
}

TEST_CASE("AnErrorIsTheRequestsOwn") {
  JobService jobs;
  for (const auto& [target, status, code] :
       {std::tuple{jobs.base + "/distance", 400, "bad_syntax"},
        std::tuple{jobs.base + "/distance?from=v:500", 422, "index_out_of_range"},
        std::tuple{jobs.base + "/distance?from=v:0&colour=red", 400, "unknown_parameter"},
        std::tuple{"/v1/meshes/" + std::string(64, '0') + "/path?from=v:0&to=v:1", 404,
                   "mesh_unknown"}}) {
    CAPTURE(target);
    const std::string place = jobs.begin("GET", target);
    const json job = jobs.wait(place);
    CHECK(job["state"] == "failed");
    CHECK(job["status"] == status);
    const HttpResponse direct = jobs.service.get(target);
    check_same_reply(direct, jobs.service.get(job["result"].get<std::string>()));
    CHECK(direct.content_type == "application/problem+json");
    CHECK(body_of(direct)["code"] == code);
  }
}

TEST_CASE("MetricsCountJobsByHowTheyEnded") {
  JobService jobs;
  const auto shows = [&](const std::string& line) {
    const std::string text = *jobs.service.get("/metrics").body;
    return text.find("\n" + line + "\n") != std::string::npos;
  };
  CHECK(shows("geodesicd_jobs_total{outcome=\"done\"} 0"));
  jobs.wait(jobs.begin("GET", jobs.base + "/path?from=v:0&to=v:9"));
  jobs.wait(jobs.begin("GET", jobs.base + "/path?from=v:0&to=v:999999"));
  const std::string cancelled = jobs.begin_for_ever();
  CHECK(jobs.service.ask("DELETE", cancelled).status == 204);
  jobs.wait_until_idle();
  CHECK(shows("geodesicd_jobs_total{outcome=\"done\"} 1"));
  CHECK(shows("geodesicd_jobs_total{outcome=\"failed\"} 1"));
  CHECK(shows("geodesicd_jobs_total{outcome=\"cancelled\"} 1"));
  CHECK(shows("geodesicd_jobs_total{outcome=\"refused\"} 0"));
  CHECK(shows("geodesicd_jobs{state=\"ended\"} 3"));
  CHECK(shows("geodesicd_jobs{state=\"running\"} 0"));
}

TEST_CASE("AJobsIdBeginsWithWhatABalancerGoesBy") {
  JobService jobs;
  const auto digits = [](const std::string& place) { return place.substr(9, 16); };
  const std::string first = jobs.begin("GET", jobs.base + "/distance?from=v:0");
  const std::string second = jobs.begin("POST", jobs.base + "/prepare");
  CHECK(digits(first) == jobs.id.substr(0, 16));
  CHECK(digits(second) == jobs.id.substr(0, 16));
  CHECK(first != second);
  CHECK(first.size() == 9 + 48);
  // An upload names no mesh: the request has an id of its own.
  const std::string glb = glb_of(shapes::plane(3, 4));
  const auto uploaded_by = [&](const std::string& request) {
    HttpRequest asked;
    asked.id = request;
    asked.method = "POST";
    asked.target = asked.path = "/v1/meshes";
    asked.body = glb;
    asked.headers = {{"Prefer", "respond-async"}};
    return header_of(jobs.service.routes.answer(asked), "Location");
  };
  const std::string place = uploaded_by("0123456789abcdeffedcba9876543210");
  CHECK(digits(place) == "0123456789abcdef");
  CHECK(jobs.wait(place)["state"] == "done");
  for (const std::string other : {"0123", "not-hexadecimal-at-all", ""}) {
    const std::string drawn = uploaded_by(other);
    CHECK(drawn.size() == 9 + 48);
    CHECK(drawn.find_first_not_of("0123456789abcdef", 9) == std::string::npos);
    CHECK(jobs.service.get(drawn).status == 200);
  }
}

TEST_CASE("UnknownJobs") {
  JobService jobs;
  const std::string unknown = "/v1/jobs/" + std::string(48, '0');
  check_problem(jobs.service.get(unknown), 404, "job_unknown");
  check_problem(jobs.service.get(unknown + "/result"), 404, "job_unknown");
  check_problem(jobs.service.get(unknown + "/events"), 404, "job_unknown");
  CHECK(jobs.service.ask("DELETE", unknown).status == 204);  // idempotent
  check_problem(jobs.service.get("/v1/jobs/x"), 404, "job_unknown");
  check_problem(jobs.service.ask("DELETE", "/v1/jobs/x"), 404, "job_unknown");
  check_problem(jobs.service.get("/v1/jobs"), 404, "route_unknown");
  check_problem(jobs.service.get(unknown + "/magic"), 404, "route_unknown");
  check_problem(jobs.service.get(unknown + "/result/x"), 404, "route_unknown");
  const HttpResponse post = jobs.service.ask("POST", unknown);
  check_problem(post, 405, "method_not_allowed");
  CHECK(header_of(post, "Allow") == "GET, HEAD, DELETE, OPTIONS");
  check_problem(jobs.service.ask("DELETE", unknown + "/result"), 405, "method_not_allowed");
}

TEST_CASE("ALongComputationTellsItsProgressAndStopsWhenCancelled") {
  JobService jobs;
  const std::string place = jobs.begin_for_ever();
  double progress = 0;
  while (progress == 0) {
    const json job = jobs.wait_until(
        place, [](const json& seen) { return seen["state"] == "running" && seen["progress"] > 0; });
    CHECK(job["result"].is_null());
    CHECK(job["status"].is_null());
    CHECK(job["finished"].is_null());
    progress = job["progress"].get<double>();
  }
  const json later =
      jobs.wait_until(place, [&](const json& job) { return job["progress"] > progress; });
  CHECK(later["progress"] < 1);
  check_problem(jobs.service.get(place + "/result"), 409, "job_unfinished");

  CHECK(jobs.service.ask("DELETE", place).status == 204);
  const json cancelled = body_of(jobs.service.get(place));
  CHECK(cancelled["state"] == "cancelled");
  CHECK(cancelled["result"].is_null());
  check_problem(jobs.service.get(place + "/result"), 409, "job_cancelled");
  jobs.wait_until_idle();
  CHECK(jobs.service.pool.stats().running == 0);
  // Once more forgets it; and then there is nothing left to do.
  CHECK(jobs.service.ask("DELETE", place).status == 204);
  check_problem(jobs.service.get(place), 404, "job_unknown");
  CHECK(jobs.service.ask("DELETE", place).status == 204);
}

TEST_CASE("AFinishedJobCanBeForgotten") {
  JobService jobs;
  const std::string place = jobs.begin("GET", jobs.base + "/distance?from=v:0");
  jobs.wait(place);
  CHECK(jobs.service.ask("DELETE", place).status == 204);
  check_problem(jobs.service.get(place + "/result"), 404, "job_unknown");
}

TEST_CASE("EveryQueryTellsHowFarItHasCome") {
  JobService jobs;
  const std::string base = jobs.add(shapes::terrain(100, 5, 3));
  const std::string mesh = base.substr(base.rfind('/') + 1);
  for (const std::string query :
       {"distance?from=v:0&method=dijkstra", "distance?from=v:1&from=v:9000",
        "distance?from=v:2&method=novotni", "distance?from=v:3&method=fast_marching",
        "distance?from=v:4&method=steiner", "path?from=v:5&to=v:9999&via=v:5000",
        "table?from=v:0&from=v:1&from=v:2&to=v:9999", "isolines?from=v:7&count=4",
        "samples?count=4", "distance?from=v:8&method=exact&max=40",
        "path?from=v:9&to=v:9999&method=steiner"}) {
    CAPTURE(query);
    HttpRequest request;
    request.method = "GET";
    request.target = request.path = base + "/" + query;
    request.path = request.path.substr(0, request.path.find('?'));
    request.query = *parse_query(query.substr(query.find('?') + 1));
    std::vector<double> told;
    request.caller.progress = [&](double done) { told.push_back(done); };
    CHECK(jobs.service.routes.answer(request).status == 200);
    REQUIRE(told.size() > 1);
    CHECK(std::is_sorted(told.begin(), told.end()));
    CHECK(told.front() >= 0);
    CHECK(told.back() > 0.1);
    CHECK(told.back() <= 1);
  }
}

TEST_CASE("ABatchTellsHowManyOfItsLinesAreDone") {
  JobService jobs;
  HttpRequest request;
  request.method = "POST";
  request.target = request.path = jobs.add(shapes::terrain(100, 5, 3)) + "/batch";
  for (int i = 0; i < 4; ++i) {
    request.body += R"({"query":"distance","from":"v:)" + std::to_string(i) + "\"}\n";
  }
  std::vector<double> told;
  request.caller.progress = [&](double done) { told.push_back(done); };
  HttpResponse response = jobs.service.routes.answer(request);
  REQUIRE(response.stream);
  double most = 0;
  for (int line = 1; line <= 4; ++line) {
    std::string chunk;
    REQUIRE(response.stream(chunk));
    CHECK(std::is_sorted(told.begin(), told.end()));
    CHECK(told.back() > most);
    most = line / 4.0;
    CHECK(told.back() <= most);
  }
}

TEST_CASE("NoMoreJobsThanAllowed") {
  Config config;
  config.max_jobs = 3;
  JobService jobs(config, 3);  // one is free, however soon both jobs begin
  const std::string first = jobs.begin_for_ever();
  const std::string second = jobs.begin_for_ever();
  // One client, whose share is half of them.
  const HttpResponse greedy = jobs.ask_later("GET", jobs.base + "/distance?from=v:0");
  check_problem(greedy, 429, "too_many_requests");
  CHECK(body_of(greedy)["limit"] == 2);
  CHECK_FALSE(header_of(greedy, "Retry-After").empty());
  // Whoever waits for the reply needs no job.
  CHECK(jobs.service.get(jobs.base + "/distance?from=v:0").status == 200);
  CHECK(jobs.service.ask("DELETE", first).status == 204);
  jobs.wait_until_idle(1);  // the handler has noticed
  CHECK(jobs.wait(jobs.begin("GET", jobs.base + "/distance?from=v:0"))["state"] == "done");
}

TEST_CASE("NoJobsAtAllAreOverloaded") {
  Config config;
  config.max_jobs = 0;
  JobService jobs(config);
  const HttpResponse refused = jobs.ask_later("GET", jobs.base + "/distance?from=v:0");
  check_problem(refused, 503, "overloaded");
  CHECK_FALSE(header_of(refused, "Retry-After").empty());
}

TEST_CASE("DrainingCancelsJobsAndTakesNoMore") {
  JobService jobs;
  const std::string place = jobs.begin_for_ever();
  jobs.wait_until(place, [](const json& job) { return job["state"] == "running"; });
  jobs.service.routes.start_draining();
  CHECK(body_of(jobs.service.get(place))["state"] == "cancelled");
  check_problem(jobs.ask_later("GET", jobs.base + "/distance?from=v:0"), 503, "draining");
  jobs.wait_until_idle();
  CHECK(jobs.service.get(jobs.base + "/distance?from=v:0").status == 200);
}

TEST_CASE("BoundsOfJobsCanBeRead") {
  Config config;
  config.max_jobs = 7;
  JobService jobs(config);
  const std::string place = jobs.begin("GET", jobs.base + "/distance?from=v:0");
  jobs.wait(place);
  const json status = body_of(jobs.service.get("/v1/status"));
  CHECK(status["limits"]["max_jobs"] == 7);
  CHECK(status["limits"]["job_result_bytes"] == 268435456);
  CHECK(status["limits"]["job_seconds"] == 600);
  CHECK(status["jobs"]["ended"] == 1);
  CHECK(status["jobs"]["bytes"] > 0);
}
