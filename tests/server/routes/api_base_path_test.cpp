// A server that a proxy publishes below a path.
#include <doctest/doctest.h>

#include <algorithm>
#include <span>
#include <string>
#include <utility>

#include "server/config/options.h"
#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

TEST_CASE("LinksBeginWithTheBasePathAndRequestsMay") {
  for (const std::string base : {"/geo", "/tools/geo-1.0"}) {
    CAPTURE(base);
    const TemporaryFolder folder;
    Service service(folder.path());
    service.base_path = base;
    const std::string glb = glb_of(shapes::plane(12, 10));
    for (const std::string& sent : {std::string(), base}) {  // taken off by the proxy, or left on
      CAPTURE(sent);
      const HttpResponse uploaded = service.ask("POST", sent + "/v1/meshes", glb);
      REQUIRE(uploaded.status < 300);
      const std::string mesh = "/v1/meshes/" + sha256_hex(glb);
      CHECK(header_of(uploaded, "Location") == base + mesh);
      CHECK(service.get(sent + mesh + "/distance?from=v:0").status == 200);
      const HttpResponse begun =
          service.ask("GET", sent + mesh + "/distance?from=v:0", "", {{"Prefer", "respond-async"}});
      REQUIRE(begun.status == 202);
      const json job = body_of(begun);
      const std::string self = base + "/v1/jobs/" + job["id"].get<std::string>();
      CHECK(header_of(begun, "Location") == self);
      CHECK(job["events"] == self + "/events");
      const json problem = body_of(service.get(sent + mesh + "/path?from=v:0&to=v:999"));
      CHECK(problem["type"] == base + "/docs/errors/#index_out_of_range");
      CHECK(problem["instance"] == sent + mesh + "/path?from=v:0&to=v:999");
      const HttpResponse batch = service.ask("POST", sent + mesh + "/batch", "{}");
      std::string line;
      REQUIRE(batch.stream(line));
      CHECK(json::parse(line)["problem"]["type"].get<std::string>().starts_with(base + "/docs"));
    }
    // The page's links are relative, so that its own address ends with a slash.
    const HttpResponse page = service.get(base);
    CHECK(page.status == 308);
    CHECK(header_of(page, "Location") == base + "/");
    CHECK(service.get(base + "/").status == 200);
    CHECK(body_of(service.get("/openapi.json"))["servers"][0]["url"] == base);
    CHECK(service.get("/openapi.yaml").body->find("\nservers:\n  - url: " + base + "\n") !=
          std::string::npos);
    // Another path is another one.
    CHECK(service.get(base + "x/v1/meshes").status == 404);
    CHECK(service.get(base + base + "/v1/meshes").status == 404);
  }
}

TEST_CASE("TheBasePathByItselfNeedsNoToken") {
  const TemporaryFolder folder;
  Service service(folder.path());
  service.base_path = "/geo";
  auto tokens = Tokens::parse("ann read " + sha256_hex("a token") + "\n", "tokens");
  REQUIRE(tokens);
  service.routes.access().set_tokens(std::move(*tokens));
  CHECK(service.get("/geo").status == 308);
  CHECK(service.get("/geo/").status == 200);
  CHECK(service.get("/geo/v1/meshes").status == 401);
  CHECK(service.get("/geox").status == 401);
}

TEST_CASE("ABasePathIsSegmentsThatNeedNoEscape") {
  const std::span<const Option> all = options();
  const auto option = std::find_if(all.begin(), all.end(),
                                   [](const Option& one) { return one.name == "base-path"; });
  REQUIRE(option != all.end());
  Config config;
  for (const std::string good : {"", "/geo", "/a/b", "/v1x", "/geo/v1", "/~me/geo_1.2-x"}) {
    CAPTURE(good);
    CHECK(set_option(*option, good, "--base-path", config));
    CHECK(config.base_path == good);
  }
  for (const std::string bad :
       {"/", "geo", "/geo/", "//geo", "/a//b", "/a/../b", "/.", "/a b", "/a%20b", "/a?b", "/a#b",
        "/v1", "/docs", "/v1/x", "/metrics/geo", "/\xc3\xa4", "/a\r\nb", "http://h/geo"}) {
    CAPTURE(bad);
    CHECK_FALSE(set_option(*option, bad, "--base-path", config));
  }
  CHECK_FALSE(set_option(*option, "/" + std::string(200, 'a'), "--base-path", config));
}
