#include "server/routes/access.h"

#include <doctest/doctest.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/base/sha256.h"
#include "tests/server/routes/service_fixture.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

Tokens tokens_of(const std::string& text) {
  auto tokens = Tokens::parse(text, "file");
  REQUIRE(tokens);
  return std::move(*tokens);
}

HttpRequest asking(std::string method, std::string path, std::vector<NameValue> headers = {}) {
  HttpRequest request;
  request.method = std::move(method);
  request.target = request.path = std::move(path);
  request.headers = std::move(headers);
  request.id = "test";
  request.caller.client = "192.0.2.1";
  return request;
}

}  // namespace

TEST_CASE("what is new and forgotten is closed") {
  const Scopes open;
  const Scopes read = Scope::read;
  const Scopes admin = Scope::admin;
  for (const char* path : {"/", "/docs", "/docs/api/app.js", "/openapi.json", "/openapi.yaml",
                           "/livez", "/readyz", "/v1/methods", "/docs/errors/"}) {
    CAPTURE(path);
    CHECK(needed_scopes("GET", path) == open);
    CHECK(needed_scopes("HEAD", path) == open);
    CHECK(needed_scopes("POST", path) == read);
    CHECK(needed_scopes("DELETE", path) == admin);
    CHECK(needed_scopes("OPTIONS", path) == open);
  }
  for (const char* path : {"", "*", "//", "/docsx", "/docs2/", "/v1", "/v1/methods/",
                           "/v2/anything", "/openapi.yml", "/livez/", "/metricsx", "/debugger"}) {
    CAPTURE(path);
    CHECK(needed_scopes("GET", path) == read);
    CHECK(needed_scopes("SEARCH", path) == read);
    CHECK(needed_scopes("PATCH", path) == Scopes(Scope::upload));
    CHECK(needed_scopes("DELETE", path) == admin);
    CHECK(needed_scopes("PUT", path) == Scopes(Scope::upload));
  }
  for (const char* path : {"/metrics", "/debug", "/debug/cache", "/debug/"}) {
    CAPTURE(path);
    for (const char* method : {"GET", "HEAD", "POST", "PUT", "DELETE"}) {
      CHECK(needed_scopes(method, path) == admin);
    }
  }
  // Names are compared as they are: nothing is opened by writing it otherwise.
  CHECK(needed_scopes("get", "/") == read);
  CHECK(needed_scopes("options", "/v1/status") == read);
  CHECK(needed_scopes("delete", "/v1/meshes/x") == read);  // and no route answers to it
}

TEST_CASE("a token's turn in queues is its own, from wherever it comes") {
  Access access;
  HttpRequest before = asking("GET", "/v1/status");
  CHECK_FALSE(access.check(before));
  CHECK(before.caller.client == "192.0.2.1");
  CHECK_FALSE(access.is_on());

  access.set_tokens(tokens_of("192.0.2.9 read " + sha256_hex("geo_a")));
  CHECK(access.is_on());
  HttpRequest with = asking("GET", "/v1/status", {{"Authorization", "Bearer geo_a"}});
  CHECK(access.admits(with));
  CHECK_FALSE(access.check(with));
  CHECK(with.caller.client == "token:192.0.2.9");  // not that of the address
  HttpRequest refused = asking("GET", "/v1/status");
  CHECK_FALSE(access.admits(refused));
  CHECK(access.check(refused));
  HttpRequest open = asking("GET", "/");
  CHECK_FALSE(access.check(open));
  CHECK(open.caller.client == "192.0.2.1");

  access.set_tokens(std::nullopt);
  CHECK_FALSE(access.check(refused));
}

TEST_CASE("a token ends at its moment and not before") {
  std::chrono::system_clock::time_point now = *parse_moment("2030-01-30T23:59:59Z");
  Access access([&] { return now; });
  access.set_tokens(tokens_of("ann read " + sha256_hex("geo_a") + " expires=2030-01-31"));
  HttpRequest request = asking("GET", "/v1/meshes", {{"authorization", "Bearer geo_a"}});
  CHECK_FALSE(access.check(request));
  now += std::chrono::seconds(1);
  auto refusal = access.check(request);
  REQUIRE(refusal);
  CHECK(refusal->status == 401);
  CHECK(header_of(*refusal, "WWW-Authenticate") ==
        R"(Bearer realm="geodesicd", error="invalid_token")");
  // Nothing tells an expired token from one that never was.
  HttpRequest unknown = asking("GET", "/v1/meshes", {{"Authorization", "Bearer geo_b"}});
  CHECK(*access.check(unknown)->body == *refusal->body);
  now = *parse_moment("2040-01-01");
  HttpRequest upload = asking("PUT", "/v1/meshes/x", {{"authorization", "Bearer geo_a"}});
  CHECK(access.check(upload)->status == 401);  // and not 403: it holds nothing any more
}

TEST_CASE("the header has one form, and what it held is not repeated") {
  Access access;
  access.set_tokens(tokens_of("ann read " + sha256_hex("geo_a")));
  const auto status = [&](std::vector<NameValue> headers) {
    HttpRequest request = asking("GET", "/v1/status", std::move(headers));
    const auto refusal = access.check(request);
    if (!refusal) return std::string();
    CHECK(refusal->status == 401);
    CHECK(refusal->body->find("geo_") == std::string::npos);
    CHECK(refusal->body->find("c2VjcmV0") == std::string::npos);
    CHECK(refusal->route == "(refused)");  // the log names no target
    return header_of(*refusal, "WWW-Authenticate");
  };
  const std::string absent = R"(Bearer realm="geodesicd")";
  const std::string invalid = absent + R"(, error="invalid_token")";
  CHECK(status({{"Authorization", "Bearer geo_a"}}).empty());
  CHECK(status({{"AUTHORIZATION", "bearer  geo_a "}}).empty());
  CHECK(status({}) == absent);
  CHECK(status({{"Authorization", ""}}) == absent);
  CHECK(status({{"Authorization", "Basic c2VjcmV0"}}) == absent);
  CHECK(status({{"Authorization", "geo_a"}}) == absent);
  CHECK(status({{"Authorization", "Bearergeo_a"}}) == absent);
  CHECK(status({{"Proxy-Authorization", "Bearer geo_a"}}) == absent);
  CHECK(status({{"X-Api-Key", "geo_a"}}) == absent);
  CHECK(status({{"Cookie", "token=geo_a"}}) == absent);
  CHECK(status({{"Authorization", "Bearer"}}) == invalid);
  CHECK(status({{"Authorization", "Bearer "}}) == invalid);
  CHECK(status({{"Authorization", "Bearer geo_b"}}) == invalid);
  CHECK(status({{"Authorization", "Bearer geo_a geo_a"}}) == invalid);
  CHECK(status({{"Authorization", "Bearer geo_a, Bearer geo_b"}}) == invalid);
  CHECK(status({{"Authorization", "Bearer geo_a"}, {"Authorization", "Bearer geo_a"}}) == invalid);
}
