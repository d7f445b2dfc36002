// What all replies have in common: tags and 304, gzip, other origins, traces, timings,
// deadlines.
#include <doctest/doctest.h>

#include <string>

#include "server/http/entity_tag.h"
#include "tests/server/http/gunzipped.h"
#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

HttpResponse conditional(PlaneService& plane, const std::string& target, const std::string& tag,
                         std::vector<NameValue> more = {}) {
  more.emplace_back("If-None-Match", tag);
  return plane.service.ask("GET", plane.base + target, {}, std::move(more));
}

}  // namespace

TEST_CASE("ATagSavesTheComputation") {
  PlaneService plane;
  const std::string target = "/distance?from=v:0";
  const HttpResponse first = plane.service.get(plane.base + target);
  const std::string tag = header_of(first, "ETag");
  CHECK(tag.starts_with("\""));
  CHECK(header_of(first, "Cache-Control") == "public, max-age=86400");
  CHECK(header_of(first, "Vary") == "Accept, Accept-Encoding");
  const auto finished = plane.service.pool.stats().finished;
  for (const std::string& known :
       {tag, "W/" + tag, "\"other\", " + tag, std::string("*"), packed_tag(tag)}) {
    CAPTURE(known);
    const HttpResponse again = conditional(plane, target, known);
    CHECK(again.status == 304);
    CHECK(header_of(again, "ETag") == (known == packed_tag(tag) ? known : tag));
    CHECK(header_of(again, "Cache-Control") == "public, max-age=86400");
    CHECK(header_of(again, "Vary") == header_of(first, "Vary"));
    CHECK_FALSE(again.body);
  }
  CHECK(plane.service.pool.stats().finished == finished);
  CHECK(conditional(plane, target, "\"other\"").status == 200);
  // HEAD as GET.
  CHECK(plane.service.ask("HEAD", plane.base + target, {}, {{"If-None-Match", tag}}).status == 304);
  // A mesh that is gone is gone, whatever the client has of it.
  REQUIRE(plane.service.ask("DELETE", plane.base).status == 204);
  CHECK(conditional(plane, target, tag).status == 404);
}

// By its tag a cache knows which of its replies is still good, and by Vary for whom.
TEST_CASE("WhatIsNotModifiedHasTheTagAndTheVaryOfWhatTheClientHas") {
  PlaneService plane;
  for (const std::string& target :
       {plane.base + "/distance?from=v:0", plane.base + "/path?from=v:0&to=v:77",
        std::string("/v1/methods"), std::string("/openapi.yaml"), plane.base}) {
    CAPTURE(target);
    const auto ask = [&](const std::string& accepted, const std::string& known) {
      std::vector<NameValue> headers{{"Accept-Encoding", accepted}};
      if (!known.empty()) headers.emplace_back("If-None-Match", known);
      return plane.service.ask("GET", target, {}, std::move(headers));
    };
    for (const std::string accepted : {"gzip", "identity"}) {
      CAPTURE(accepted);
      const HttpResponse whole = ask(accepted, "");
      REQUIRE(whole.status == 200);
      const std::string bare = header_of(ask("identity", ""), "ETag");
      const std::string tag = header_of(whole, "ETag");
      CHECK(tag == (header_of(whole, "Content-Encoding") == "gzip" ? packed_tag(bare) : bare));
      const auto check = [&](const std::string& known, const std::string& expected) {
        CAPTURE(known);
        const HttpResponse again = ask(accepted, known);
        CHECK(again.status == 304);
        CHECK(header_of(again, "ETag") == expected);
        CHECK(header_of(again, "Vary") == header_of(whole, "Vary"));
        CHECK(again.content_type.empty());
      };
      check(tag, tag);
      check("\"other\", " + tag, tag);
      check("*", tag);
      check(bare, bare);  // from before it took gzip
      check(bare + ", " + tag, tag);
      check(packed_tag(bare), packed_tag(bare));
      if (accepted == "identity") check(packed_tag(bare) + ", " + bare, bare);
    }
  }
  CHECK(header_of(plane.service.ask("GET", "/openapi.yaml", {}, {{"Accept-Encoding", "gzip"}}),
                  "Content-Encoding") == "gzip");
}

TEST_CASE("AConditionSparesOnlyWhatWouldBeASuccess") {
  PlaneService plane;
  const std::vector<NameValue> any{{"If-None-Match", "*"}};
  const std::string nobody = "/v1/meshes/" + std::string(64, '0');
  for (const std::string& target :
       {plane.base, plane.base + "/source", plane.base + "/geometry", std::string("/v1/meshes"),
        plane.base + "/distance?from=v:0", plane.base + "/distance?from=v:0&format=png&width=64",
        plane.base + "/path?from=v:0&to=v:7", std::string("/openapi.yaml"),
        plane.base + "/distance?from=v:999",
        plane.base + "/trace?from=v:0&direction=0,0,0&length=1",
        plane.base + "/nearest?point=ray:9,9,9,0,0,1", plane.base + "/samples?count=0",
        plane.base + "/geometry?format=obj", plane.base + "/isolines?from=v:0&step=1e-300", nobody,
        nobody + "/source", nobody + "/geometry", nobody + "/distance?from=v:0"}) {
    CAPTURE(target);
    for (const char* method : {"GET", "HEAD"}) {
      // Cold, and where all is in the caches.
      for (int i = 0; i < 2; ++i) {
        const HttpResponse met = plane.service.ask(method, target, {}, any);
        const HttpResponse plain = plane.service.get(target);
        CHECK(met.status == (plain.status == 200 ? 304 : plain.status));
        CHECK((plain.status == 200) != (plain.status >= 400));
        if (plain.status != 200) continue;
        CHECK_FALSE(met.body);
        CHECK_FALSE(met.file);
        CHECK(header_of(met, "ETag") == header_of(plain, "ETag"));
        CHECK(header_of(met, "Cache-Control") == header_of(plain, "Cache-Control"));
      }
    }
  }
}

TEST_CASE("EachRepresentationHasItsOwnTag") {
  PlaneService plane;
  const auto tag = [&](const std::string& target, std::vector<NameValue> headers = {}) {
    return header_of(plane.service.ask("GET", plane.base + target, {}, std::move(headers)), "ETag");
  };
  const std::string json = tag("/distance?from=v:0");
  CHECK(tag("/distance?from=v:0&format=json") == json);
  CHECK(tag("/distance?max=1&from=v:0") == tag("/distance?from=v:0&max=1"));
  CHECK(tag("/distance?from=v:0&deadline_ms=9000") == json);
  CHECK(tag("/distance?from=v:1") != json);
  CHECK(tag("/distance?from=v:0&method=exact") != json);
  CHECK(tag("/distance?from=v:0&precision=4") != json);
  CHECK(tag("/distance?from=v:0&format=f32") != json);
  CHECK(tag("/distance?from=v:0&format=f32") ==
        tag("/distance?from=v:0", {{"Accept", "application/octet-stream"}}));
  CHECK(tag("/distance?from=v:0&format=f64") != tag("/distance?from=v:0&format=f32"));
  CHECK(tag("/distance?from=v:0&from=v:1&labels=1") != tag("/distance?from=v:1&from=v:0&labels=1"));
  CHECK(tag("/table?from=v:0") != json);
  const std::string packed = tag("/distance?from=v:0", {{"Accept-Encoding", "gzip"}});
  CHECK(packed == packed_tag(json));
  // POST has none: nobody caches it.
  const HttpResponse post =
      plane.service.ask("POST", plane.base + "/distance", R"({"from":"v:0"})");
  CHECK(header_of(post, "ETag").empty());
  CHECK(header_of(post, "Cache-Control").empty());
}

TEST_CASE("WhatIsNoQueryIsTaggedByItsBytes") {
  PlaneService plane;
  for (const std::string& path : {plane.base, std::string("/v1/methods"), std::string("/v1/meshes"),
                                  std::string("/openapi.yaml"), std::string("/")}) {
    CAPTURE(path);
    const HttpResponse first = plane.service.get(path);
    const std::string tag = header_of(first, "ETag");
    CHECK_FALSE(tag.empty());
    const HttpResponse again = plane.service.ask("GET", path, {}, {{"If-None-Match", tag}});
    CHECK(again.status == 304);
    CHECK_FALSE(again.body);
  }
  const HttpResponse source = plane.service.get(plane.base + "/source");
  CHECK(header_of(source, "Cache-Control") == "public, max-age=31536000, immutable");
  CHECK(conditional(plane, "/source", header_of(source, "ETag")).status == 304);
  CHECK(header_of(plane.service.get("/v1/status"), "Cache-Control") == "no-store");
  CHECK(header_of(plane.service.get("/v1/nothing"), "Cache-Control") == "no-store");
}

TEST_CASE("JsonIsPackedForThoseWhoTakeItAndArraysNever") {
  PlaneService plane;
  const std::string target = plane.base + "/distance?from=v:0";
  const HttpResponse plain = plane.service.get(target);
  REQUIRE(plain.body->size() > 1024);
  const HttpResponse packed =
      plane.service.ask("GET", target, {}, {{"Accept-Encoding", "br, gzip"}});
  CHECK(header_of(packed, "Content-Encoding") == "gzip");
  CHECK(packed.content_type == "application/json");
  CHECK(packed.body->size() < plain.body->size());
  CHECK(gunzipped(*packed.body) == *plain.body);
  CHECK(header_of(plain, "Content-Encoding").empty());
  // Packed once for all who ask the same, and still bare for the others.
  const HttpResponse again =
      plane.service.ask("GET", target, {}, {{"Accept-Encoding", "gzip, deflate"}});
  CHECK(again.body == packed.body);
  CHECK(header_of(again, "Content-Encoding") == "gzip");
  CHECK(header_of(again, "Geo-Cache") == "hit");
  CHECK(plane.service.get(target).body == plain.body);
  const HttpResponse small = plane.service.ask("GET", plane.base + "/nearest?point=v:0", {},
                                               {{"Accept-Encoding", "gzip"}});
  CHECK(header_of(small, "Content-Encoding").empty());
  CHECK(header_of(small, "Vary").find("Accept-Encoding") != std::string::npos);
  const HttpResponse array =
      plane.service.ask("GET", target + "&format=f64", {}, {{"Accept-Encoding", "gzip"}});
  CHECK(header_of(array, "Content-Encoding").empty());
  CHECK(array.body->size() == 960);
}

TEST_CASE("ALongQuestionIsKnownAgainToo") {
  PlaneService plane;
  std::string target = plane.base + "/distance?at=v:1";
  for (int i = 0; i < 100; ++i) target += "&from=v:" + std::to_string(i);
  const HttpResponse first = plane.service.get(target + "&at=v:100");
  const HttpResponse other = plane.service.get(target + "&at=v:101");
  REQUIRE(first.status == 200);
  CHECK(plane.service.get(target + "&at=v:100").body == first.body);
  CHECK(plane.service.get(target + "&at=v:101").body == other.body);
  CHECK(*first.body != *other.body);
  CHECK(header_of(first, "ETag") != header_of(other, "ETag"));
}

TEST_CASE("PagesOfOtherOriginsMayCallAndRead") {
  PlaneService plane;
  const HttpResponse reply = plane.service.ask("GET", plane.base + "/distance?from=v:0", {},
                                               {{"Origin", "https://example.org"}});
  CHECK(header_of(reply, "Access-Control-Allow-Origin") == "*");
  const std::string exposed = header_of(reply, "Access-Control-Expose-Headers");
  for (const char* name : {"ETag", "Location", "Server-Timing", "Geo-Cache", "Geo-Dtype",
                           "Geo-Shape", "Geo-Max", "Geo-Length", "X-Request-Id", "Retry-After"}) {
    CAPTURE(name);
    CHECK(exposed.find(name) != std::string::npos);
  }
  // Errors too, or the page could not say what is wrong.
  CHECK(header_of(plane.service.get("/v1/nothing"), "Access-Control-Allow-Origin") == "*");

  const std::vector<NameValue> question{{"Origin", "https://example.org"},
                                        {"Access-Control-Request-Method", "DELETE"},
                                        {"Access-Control-Request-Headers", "x-evil-echo"}};
  // To cancel a job; which pages may change meshes: api_origins_test.cpp.
  const HttpResponse preflight =
      plane.service.ask("OPTIONS", "/v1/jobs/" + std::string(48, '0'), {}, question);
  CHECK(preflight.status == 204);
  CHECK(header_of(preflight, "Access-Control-Allow-Origin") == "*");
  CHECK(header_of(preflight, "Access-Control-Allow-Methods").find("DELETE") != std::string::npos);
  const std::string allowed = header_of(preflight, "Access-Control-Allow-Headers");
  CHECK(allowed.find("Authorization") != std::string::npos);
  CHECK(allowed.find("evil") == std::string::npos);
}

TEST_CASE("OnlyTheOriginsNamedMayRead") {
  Config config;
  config.cors_origins = "https://a.example, https://b.example";
  PlaneService plane(config);
  const auto origin_of = [&](const char* origin) {
    return header_of(plane.service.ask("GET", "/v1/methods", {}, {{"Origin", origin}}),
                     "Access-Control-Allow-Origin");
  };
  CHECK(origin_of("https://a.example") == "https://a.example");
  CHECK(origin_of("https://b.example") == "https://b.example");
  CHECK(origin_of("https://c.example").empty());
  const HttpResponse reply = plane.service.get("/v1/methods");
  CHECK(header_of(reply, "Vary").find("Origin") != std::string::npos);
  const HttpResponse preflight = plane.service.ask(
      "OPTIONS", plane.base, {},
      {{"Origin", "https://c.example"}, {"Access-Control-Request-Method", "GET"}});
  CHECK(header_of(preflight, "Access-Control-Allow-Methods").empty());
}

TEST_CASE("OptionsTellsTheMethodsOfAPath") {
  PlaneService plane;
  const auto allow = [&](const std::string& path) {
    const HttpResponse reply = plane.service.ask("OPTIONS", path);
    CHECK(reply.status == 204);
    return header_of(reply, "Allow");
  };
  CHECK(allow(plane.base) == "GET, HEAD, PUT, PATCH, DELETE, OPTIONS");
  CHECK(allow(plane.base + "/path") == "GET, HEAD, POST, OPTIONS");
  CHECK(allow(plane.base + "/prepare") == "POST, OPTIONS");
  CHECK(allow("*") == "GET, HEAD, POST, PUT, PATCH, DELETE, OPTIONS");
  CHECK(plane.service.ask("OPTIONS", "/v1/nothing").status == 404);
}

TEST_CASE("ATraceIsKeptAndNonsenseIsNot") {
  PlaneService plane;
  const std::string good = "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01";
  const auto kept = [&](const std::string& sent) {
    return header_of(plane.service.ask("GET", "/v1/methods", {}, {{"traceparent", sent}}),
                     "traceparent");
  };
  CHECK(kept(good) == good);
  for (const char* bad : {"", "00", "00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-0",
                          "ff-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01",
                          "00-00000000000000000000000000000000-00f067aa0ba902b7-01",
                          "00-4bf92f3577b34da6a3ce929d0e0e4736-0000000000000000-01",
                          "00-4BF92F3577B34DA6A3CE929D0E0E4736-00f067aa0ba902b7-01",
                          "00_4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01"}) {
    CAPTURE(bad);
    CHECK(kept(bad).empty());
  }
}

TEST_CASE("TheReplySaysWhereTheTimeWent") {
  PlaneService plane;
  const std::string first =
      header_of(plane.service.get(plane.base + "/path?from=v:0&to=v:50"), "Server-Timing");
  for (const char* stage : {"queue;dur=", "solve;dur=", "trace;dur=", "encode;dur="}) {
    CAPTURE(stage);
    CHECK(first.find(stage) != std::string::npos);
  }
  const std::string second =
      header_of(plane.service.get(plane.base + "/path?from=v:0&to=v:60"), "Server-Timing");
  CHECK(second.find("solve") == std::string::npos);
  // From the store: read, decoded and prepared again.
  Config small;
  small.mesh_cache_bytes = small.adjacency_cache_bytes = 0;
  PlaneService cold(small);
  const std::string loaded =
      header_of(cold.service.get(cold.base + "/distance?from=v:0"), "Server-Timing");
  CHECK(loaded.find("load;dur=") != std::string::npos);
  CHECK(loaded.find("prepare;dur=") != std::string::npos);
}

TEST_CASE("ADeadlineEndsAQuery") {
  PlaneService plane;
  CHECK(plane.ask("/distance?from=v:0&deadline_ms=60000")["count"] == 120);
  const std::string large = plane.add(shapes::terrain(220, 20, 1));
  const HttpResponse late =
      plane.service.get(large + "/distance?from=v:0&method=chen_han&deadline_ms=1");
  check_problem(late, 504, "deadline");
  check_problem(
      plane.service.ask("POST", large + "/path",
                        R"({"from":"v:0","to":"v:48399","method":"chen_han","deadline_ms":1})"),
      504, "deadline");
  // It was not kept, and harms nobody after it.
  CHECK(plane.service.get(large + "/distance?from=v:0").status == 200);
  plane.check_refused("/distance?from=v:0&deadline_ms=0", 422, "value_out_of_range", "deadline_ms");
  plane.check_refused("/distance?from=v:0&deadline_ms=9000000", 422, "value_out_of_range",
                      "deadline_ms");
  plane.check_refused("/distance?from=v:0&deadline_ms=soon", 400, "bad_syntax", "deadline_ms");
}
