#include <doctest/doctest.h>

#include <algorithm>
#include <filesystem>
#include <regex>
#include <string>
#include <vector>

#include "server/http/problem.h"
#include "tests/server/routes/service_fixture.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

TEST_CASE("TheContractIsServedAsYamlAndAsJson") {
  const TemporaryFolder folder;
  Service service(folder.path());
  const HttpResponse yaml = service.get("/openapi.yaml");
  CHECK(yaml.content_type == "application/yaml");
  CHECK(yaml.body->starts_with("openapi: 3.1"));
  // What browsers say they accept; they would save application/yaml and not show it.
  const HttpResponse shown =
      service.ask("GET", "/openapi.yaml", {},
                  {{"Accept", "text/html,application/xhtml+xml,application/xml;q=0.9,*/*;q=0.8"}});
  CHECK(shown.content_type == "text/plain; charset=utf-8");
  CHECK(*shown.body == *yaml.body);
  CHECK(header_of(shown, "Vary").find("Accept,") != std::string::npos);
  const HttpResponse reply = service.get("/openapi.json");
  CHECK(reply.content_type == "application/json");
  const json contract = body_of(reply);
  CHECK(contract["openapi"] == "3.1.0");
  CHECK(contract["info"]["title"] == "geodesicd");
  CHECK(contract["servers"][0]["url"] == "/");
  CHECK(contract["paths"].contains("/v1/meshes/{id}/distance"));
  CHECK(contract["paths"]["/v1/meshes"]["get"]["parameters"][0]["schema"]["maximum"] == 1000);
}

TEST_CASE("EveryErrorCodeIsInTheContractWithItsStatus") {
  const TemporaryFolder folder;
  Service service(folder.path());
  const json contract = body_of(service.get("/openapi.json"));
  const json& codes = contract["components"]["schemas"]["ErrorCode"]["enum"];
  std::vector<std::string> known;
  for (const ErrorCode code : all_error_codes()) known.emplace_back(code.name());
  CHECK(codes.get<std::vector<std::string>>() == known);
}

TEST_CASE("ThePageOfTheContractNeedsNothingFromElsewhere") {
  const TemporaryFolder folder;
  Service service(folder.path());
  const HttpResponse page = service.get("/docs/api/");
  CHECK(page.status == 200);
  CHECK(page.content_type == "text/html; charset=utf-8");
  const std::string policy = header_of(page, "Content-Security-Policy");
  CHECK(policy.find("default-src 'none'") != std::string::npos);
  CHECK(policy.find("unsafe") == std::string::npos);
  CHECK(policy.find("http") == std::string::npos);
  // No script or style within it, which the policy would not run.
  CHECK(page.body->find("<style") == std::string::npos);
  CHECK(page.body->find(" style=") == std::string::npos);
  const std::regex inner_script("<script(?![^>]*src=)");
  CHECK_FALSE(std::regex_search(*page.body, inner_script));

  // Whatever it loads is here.
  const std::regex reference("(?:src|href)=\"([^\"]+)\"|from '(\\./[^']+)'");
  std::vector<std::string> files;
  const auto gather = [&](const std::string& text, const std::string& place) {
    for (std::sregex_iterator at(text.begin(), text.end(), reference), end; at != end; ++at) {
      std::string file = (*at)[1].matched ? (*at)[1].str() : (*at)[2].str();
      if (file == "data:," || file.starts_with("#")) continue;
      CHECK_FALSE(file.starts_with("/"));  // it would not hold below a prefix
      std::string path = std::filesystem::path(place + file).lexically_normal().generic_string();
      // Those two are the viewer's page and the guide's.
      if (path != "/" && path != "/docs/") files.push_back(std::move(path));
    }
  };
  gather(*page.body, "/docs/api/");
  for (std::size_t i = 0; i < files.size() && i < 50; ++i) {
    CAPTURE(files[i]);
    REQUIRE(files[i].starts_with("/"));
    const HttpResponse file = service.get(files[i]);
    CHECK(file.status == 200);
    CHECK(header_of(file, "X-Content-Type-Options") == "nosniff");
    if (files[i].ends_with(".js")) {
      CHECK(file.content_type == "text/javascript; charset=utf-8");
      gather(*file.body, "/docs/api/");
    }
    if (files[i].ends_with(".css")) CHECK(file.content_type == "text/css; charset=utf-8");
  }
  CHECK(std::count(files.begin(), files.end(), "/docs/api/text.js") > 0);
  CHECK(service.get("/docs/api/none.js").status == 404);
  CHECK(service.ask("POST", "/docs/api/").status == 405);
}

TEST_CASE("AWrongAddressBelowTheGuideIsAPageForBrowsersAndAProblemForOthers") {
  const TemporaryFolder folder;
  Service service(folder.path());
  const std::vector<NameValue> browser{{"Accept", "text/html,application/xhtml+xml,*/*;q=0.8"}};
  for (const std::string way : {"", "start/", "start/x/", "a//b/"}) {
    const std::string path = "/docs/" + way + "none";
    CAPTURE(path);
    const HttpResponse page = service.ask("GET", path, {}, browser);
    CHECK(page.status == 404);
    CHECK(page.content_type == "text/html; charset=utf-8");
    CHECK(page.route == "/docs/{page}");
    CHECK(header_of(page, "Content-Security-Policy").starts_with("default-src 'none'"));
    CHECK(header_of(page, "Vary").find("Accept") != std::string::npos);
    // Relative, so that they hold below a prefix; each leads to what is there.
    const std::regex reference("href=\"([^\"]+)\"");
    std::size_t links = 0;
    for (std::sregex_iterator at(page.body->begin(), page.body->end(), reference), end; at != end;
         ++at) {
      const std::string to = (*at)[1].str();
      CAPTURE(to);
      if (to == "data:,") continue;
      REQUIRE(to.starts_with("."));
      // A browser counts an empty segment as one.
      std::string from = "/docs/" + way;
      if (const std::size_t empty = from.find("//"); empty != std::string::npos) {
        from.insert(empty + 1, "x");
      }
      const std::string found =
          std::filesystem::path(from + to).lexically_normal().generic_string();
      CHECK(service.ask("GET", found, {}, browser).status < 400);
      ++links;
    }
    CHECK(links == 5);
    CHECK(service.get(path).content_type == "application/problem+json");
    CHECK(service.ask("POST", path, {}, browser).status == 404);
  }
  CHECK(service.ask("GET", "/none", {}, browser).content_type == "application/problem+json");
}
