// The viewer's files and the documentation's: served whole at their paths and nothing else, with a
// policy, and kept by browsers for as long as they hold.
#include "server/routes/static_files.h"

#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "server/routes/access.h"
#include "tests/server/http/gunzipped.h"
#include "tests/server/routes/service_fixture.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

void write(const std::filesystem::path& file, const std::string& text) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file, std::ios::binary) << text;
}

const std::string kPage = "<!doctype html><title>viewer</title>";
const std::string kScript = std::string(3000, ' ') + "export {};\n";

// A service with a viewer of two files, and others beside them that it must not serve.
struct Viewed {
  Viewed() : service(store.path()) {
    write(folder.path() / "dist/index.html", kPage);
    write(folder.path() / "dist/assets/page-1a2b.js", kScript);
    write(folder.path() / "dist/assets/page-1a2b.js.unknown", "no kind that is served");
    write(folder.path() / "secret.txt", "not the viewer's");
    std::filesystem::create_symlink("../secret.txt", folder.path() / "dist/link.txt");
    auto viewer = StaticFiles::load((folder.path() / "dist").string(), StaticFiles::kViewer);
    REQUIRE(viewer);
    service.routes.set_viewer(std::move(*viewer));
  }
  TemporaryFolder folder;
  TemporaryFolder store;
  Service service;
};

}  // namespace

TEST_CASE("TheViewerIsServedAtItsPaths") {
  Viewed viewed;
  const HttpResponse page = viewed.service.get("/");
  CHECK(page.status == 200);
  CHECK(*page.body == kPage);
  CHECK(page.content_type == "text/html; charset=utf-8");
  CHECK(header_of(page, "Cache-Control") == "no-cache");
  CHECK(header_of(page, "X-Content-Type-Options") == "nosniff");
  const std::string policy = header_of(page, "Content-Security-Policy");
  CHECK(policy.find("default-src 'none'") != std::string::npos);
  CHECK(policy.find("unsafe") == std::string::npos);

  const HttpResponse script = viewed.service.get("/assets/page-1a2b.js");
  CHECK(*script.body == kScript);
  CHECK(script.content_type == "text/javascript; charset=utf-8");
  CHECK(header_of(script, "Cache-Control") == "public, max-age=31536000, immutable");
  CHECK(viewed.service.ask("POST", "/assets/page-1a2b.js").status == 405);
}

TEST_CASE("TheViewersFilesArePackedOnceAndKnownAgain") {
  Viewed viewed;
  const std::string path = "/assets/page-1a2b.js";
  const HttpResponse packed = viewed.service.ask("GET", path, {}, {{"Accept-Encoding", "gzip"}});
  CHECK(header_of(packed, "Content-Encoding") == "gzip");
  CHECK(header_of(packed, "Vary") == "Accept-Encoding");
  CHECK(gunzipped(*packed.body) == kScript);
  CHECK(viewed.service.ask("GET", path, {}, {{"Accept-Encoding", "gzip"}}).body == packed.body);
  const std::string tag = header_of(viewed.service.get(path), "ETag");
  CHECK(header_of(packed, "ETag") != tag);
  for (const std::string& known : {tag, header_of(packed, "ETag")}) {
    const HttpResponse again = viewed.service.ask("GET", path, {}, {{"If-None-Match", known}});
    CHECK(again.status == 304);
    CHECK_FALSE(again.body);
  }
}

TEST_CASE("NothingBesideTheViewersFilesIsServed") {
  Viewed viewed;
  for (const char* path : {"/index.html", "/assets", "/assets/", "/assets/page-1a2b.js.unknown",
                           "/link.txt", "/secret.txt", "/../secret.txt", "/assets/../index.html",
                           "/assets/../../secret.txt", "//assets/page-1a2b.js"}) {
    CAPTURE(path);
    CHECK(viewed.service.get(path).status == 404);
  }
  // The API is still where it was.
  CHECK(viewed.service.get("/v1/methods").status == 200);
  CHECK(viewed.service.get("/docs/api/").status == 200);
}

TEST_CASE("TheViewerNeedsNoToken") {
  CHECK(needed_scopes("GET", "/").empty());
  CHECK(needed_scopes("GET", "/assets/page-1a2b.js").empty());
  CHECK_FALSE(needed_scopes("PUT", "/assets/page-1a2b.js").empty());
}

TEST_CASE("AFolderThatIsNoViewerIsRefused") {
  const TemporaryFolder folder;
  const auto empty = StaticFiles::load(folder.path().string(), StaticFiles::kViewer);
  REQUIRE_FALSE(empty);
  CHECK(empty.error().detail.find("index.html") != std::string::npos);
  CHECK_FALSE(StaticFiles::load((folder.path() / "none").string(), StaticFiles::kDocs));
  // Without one, a plain page.
  const TemporaryFolder store;
  Service service(store.path());
  CHECK(service.get("/").body->find("<title>geodesicd</title>") != std::string::npos);
}

TEST_CASE("TheDocumentationIsServedBelowDocs") {
  const TemporaryFolder folder;
  const TemporaryFolder store;
  write(folder.path() / "index.html", kPage);
  write(folder.path() / "errors/index.html", kPage + "errors");
  write(folder.path() / "api/index.html", kPage + "a page for readers without a server");
  write(folder.path() / "assets/bundle.js", kScript);
  auto docs = StaticFiles::load(folder.path().string(), StaticFiles::kDocs);
  REQUIRE(docs);
  Service service(store.path());
  service.routes.set_docs(std::move(*docs));

  CHECK(*service.get("/docs/").body == kPage);
  CHECK(*service.get("/docs/errors/").body == kPage + "errors");
  // Its files have no digest in their names.
  CHECK(header_of(service.get("/docs/assets/bundle.js"), "Cache-Control") == "no-cache");
  CHECK(header_of(service.get("/docs/"), "Content-Security-Policy").find("unsafe") ==
        std::string::npos);
  // The server's own page of the API goes before the site's.
  CHECK(service.get("/docs/api/").body->find("readers without") == std::string::npos);
  CHECK(service.get("/docs/api/").status == 200);
  // A folder without its slash leads to the one with it, by a way that holds behind any prefix.
  for (const auto& [path, to] : {std::pair{"/docs", "docs/"}, std::pair{"/docs/errors", "errors/"},
                                 std::pair{"/docs/api", "api/"}}) {
    CAPTURE(path);
    CHECK(service.get(path).status == 308);
    CHECK(header_of(service.get(path), "Location") == to);
  }
  for (const char* path : {"/docs/index.html", "/docs/assets", "/docs/assets/", "/docs/none/",
                           "/docs//", "/docs/../docs/", "/errors/", "/docserrors/"}) {
    CAPTURE(path);
    CHECK(service.get(path).status == 404);
  }
  CHECK(service.ask("POST", "/docs/errors/").status == 405);
}

TEST_CASE("WithoutDocumentationItsPathsLeadToThePageOfTheApi") {
  const TemporaryFolder store;
  Service service(store.path());
  for (const auto& [path, to] :
       {std::pair{"/docs/", "api/"}, std::pair{"/docs/errors/", "../api/"}}) {
    CAPTURE(path);
    const HttpResponse reply = service.get(path);
    CHECK(reply.status == 307);
    CHECK(header_of(reply, "Location") == to);
  }
  CHECK(service.get("/docs/start/").status == 404);
}
