// Which pages may change meshes: what a browser says of a page, and what comes of it.
#include <doctest/doctest.h>

#include <string>
#include <utility>
#include <vector>

#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

using Headers = std::vector<NameValue>;

Headers page(const char* origin, const char* host = "127.0.0.1:8080") {
  return {{"Host", host}, {"Origin", origin}};
}

// A service with a plane, and every request that would change what it keeps.
struct Changes {
  explicit Changes(const Config& config = {}) : plane(config) {}

  // Whether all of them are refused, and change nothing.
  bool are_refused(const Headers& headers) {
    const std::vector<std::pair<std::string, std::string>> requests{
        {"POST", "/v1/meshes"},
        {"PUT", "/v1/meshes/" + sha256_hex(other)},
        {"PUT", plane.base},
        {"PATCH", plane.base},
        {"DELETE", plane.base},
        {"DELETE", "/v1/meshes/" + std::string(64, '0')},
        {"POST", "/v1/meshes?units=m"},
        {"FROB", plane.base}};
    int refused = 0;
    for (const auto& [method, target] : requests) {
      CAPTURE(method);
      const HttpResponse reply = plane.service.ask(method, target, other, headers);
      if (reply.status != 403) continue;
      check_problem(reply, 403, "forbidden", "Origin");
      // The page can read why.
      CHECK(header_of(reply, "Access-Control-Allow-Origin") == "*");
      ++refused;
    }
    if (refused != 0) CHECK(refused == requests.size());
    if (refused != 0) CHECK(plane.service.store->size() == 1);
    return refused != 0;
  }

  PlaneService plane;
  const std::string other = glb_of(shapes::plane(3, 3));
};

}  // namespace

TEST_CASE("APageOfAnotherOriginMayNotChangeMeshes") {
  Changes changes;
  for (const char* origin :
       {"https://evil.example", "http://evil.example", "null", "file://", "", "http://",
        "http://127.0.0.1", "http://127.0.0.1:8081", "http://localhost:8080",
        "https://127.0.0.1:80800", "http://127.0.0.1:8080.evil.example",
        "http://evil.example/127.0.0.1:8080", "http://x@127.0.0.1:8080", "127.0.0.1:8080",
        "ftp://127.0.0.1:8080", "http://127.0.0.1:8080/", "chrome-extension://abc"}) {
    CAPTURE(origin);
    CHECK(changes.are_refused(page(origin)));
  }
  // Two of them, one of them ours.
  Headers two = page("http://127.0.0.1:8080");
  two.emplace_back("origin", "http://evil.example");
  CHECK(changes.are_refused(two));
  // What a browser says of it, even where it sends no Origin, or one that looks like ours.
  for (const char* site : {"cross-site", "same-site", "", "anything"}) {
    CHECK(changes.are_refused({{"Host", "h"}, {"Sec-Fetch-Site", site}}));
    Headers headers = page("http://h", "h");
    headers.emplace_back("Sec-Fetch-Site", site);
    CHECK(changes.are_refused(headers));
  }
  CHECK(changes.are_refused({{"Origin", "http://h"}}));  // for no host that anybody named
  CHECK(changes.are_refused({{"Origin", "null"}, {"Sec-Fetch-Site", "same-origin"}}));
}

TEST_CASE("OurOwnPagesAndCallersThatAreNoPagesMayChangeMeshes") {
  for (const Headers& headers :
       {Headers{}, Headers{{"Host", "h"}}, page("http://127.0.0.1:8080"),
        page("http://meshes.example", "meshes.example"),
        page("HTTPS://Meshes.Example", "meshes.example:443"),  // a proxy ends TLS
        page("https://meshes.example:443", "meshes.example"),
        page("http://meshes.example:80", "meshes.example"), page("http://[::1]:8080", "[::1]:8080"),
        Headers{{"Host", "h"}, {"Sec-Fetch-Site", "none"}},
        // A proxy put its own name for us into Host: the browser knows better.
        Headers{{"Host", "127.0.0.1:8080"},
                {"Origin", "https://meshes.example"},
                {"Sec-Fetch-Site", "same-origin"}}}) {
    Changes changes;
    CHECK_FALSE(changes.are_refused(headers));
    CHECK_FALSE(changes.plane.service.store->contains(changes.plane.id));  // it was deleted
  }
  // X-Forwarded-Proto and -Host make nobody's page ours.
  Changes changes;
  Headers forged = page("https://evil.example");
  forged.emplace_back("X-Forwarded-Host", "evil.example");
  forged.emplace_back("X-Forwarded-Proto", "https");
  forged.emplace_back("Forwarded", "host=evil.example");
  CHECK(changes.are_refused(forged));
}

TEST_CASE("AFlagOpensChangesToOrigins") {
  Config named;
  named.cors_write_origins = "https://a.example, https://b.example";
  for (const char* origin : {"https://a.example", "https://b.example"}) {
    CHECK_FALSE(Changes(named).are_refused(page(origin)));
    Headers headers = page(origin);
    headers.emplace_back("Sec-Fetch-Site", "cross-site");
    CHECK_FALSE(Changes(named).are_refused(headers));
  }
  CHECK(Changes(named).are_refused(page("https://c.example")));
  CHECK(Changes(named).are_refused(page("null")));
  Config any;
  any.cors_write_origins = "*";
  CHECK_FALSE(Changes(any).are_refused(page("https://evil.example")));
  CHECK_FALSE(Changes(any).are_refused(page("null")));
}

TEST_CASE("WhatOnlyReadsIsOpenToAnyPage") {
  PlaneService plane;
  for (const Headers& headers :
       {page("https://evil.example"), page("null"), Headers{{"Sec-Fetch-Site", "cross-site"}}}) {
    const auto ask = [&](const char* method, const std::string& target, const char* body = "") {
      return plane.service.ask(method, target, body, headers).status;
    };
    CHECK(ask("GET", plane.base) == 200);
    CHECK(ask("HEAD", plane.base + "/source") == 200);
    CHECK(ask("POST", plane.base + "/distance", R"({"from":"v:0"})") == 200);
    CHECK(ask("POST", plane.base + "/batch", "{}") == 200);
    CHECK(ask("POST", plane.base + "/prepare") < 300);
    CHECK(ask("DELETE", "/v1/jobs/" + std::string(48, '0')) == 204);
  }
}

TEST_CASE("APreflightPromisesWhatTheRequestWillFind") {
  Config config;
  config.cors_write_origins = "https://a.example";
  PlaneService plane(config);
  for (const char* origin : {"https://evil.example", "https://a.example", "http://h", "null"}) {
    for (const std::string method : {"GET", "POST", "PUT", "PATCH", "DELETE"}) {
      for (const std::string& path : {std::string("/v1/meshes"), plane.base, plane.base + "/path",
                                      "/v1/jobs/" + std::string(48, '0')}) {
        CAPTURE(origin);
        CAPTURE(method);
        CAPTURE(path);
        Headers headers = page(origin, "h");
        const bool refused =
            plane.service.ask(method, path, "", headers).status == 403;  // changes nothing
        headers.emplace_back("Access-Control-Request-Method", method);
        const HttpResponse preflight = plane.service.ask("OPTIONS", path, {}, headers);
        CHECK((preflight.status == 403) == refused);
        const std::string allowed =
            ", " + header_of(preflight, "Access-Control-Allow-Methods") + ",";
        if (refused) CHECK(allowed == ", ,");
        for (const std::string each : {"GET", "POST", "PUT", "DELETE"}) {
          if (refused) continue;
          const Headers bare = page(origin, "h");
          const bool can = plane.service.ask(each, "/nothing" + path, "", bare).status != 403 ||
                           !CrossOrigin::changes(each, path);
          if (!CrossOrigin::changes(each, path) || can) {
            CHECK(allowed.find(", " + each + ",") != std::string::npos);
          } else {
            CHECK(allowed.find(", " + each + ",") == std::string::npos);
          }
        }
        if (method == "DELETE" && !refused) plane.service.upload(glb_of(shapes::plane(12, 10)));
      }
    }
  }
}
