// One pair is searched for, without a field; who asks for more from a source gets one.
#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <string_view>

#include "server/query/asked_sources.h"
#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

bool took(const HttpResponse& response, std::string_view stage) {
  return header_of(response, "Server-Timing").find(std::string(stage) + ";dur=") !=
         std::string::npos;
}

// A terrain large enough to be searched.
struct TerrainService : PlaneService {
  std::string terrain = add(shapes::terrain(90, 5, 3));
  HttpResponse from(const std::string& target) { return service.get(terrain + target); }
};

}  // namespace

TEST_CASE("TheFirstPathFromASourceIsSearchedForAndTheSecondLeavesAField") {
  TerrainService plane;
  for (const std::string method : {"wavefront", "auto", "dijkstra", "exact"}) {
    CAPTURE(method);
    const std::string by = "&method=" + method;
    const HttpResponse first = plane.from("/path?from=v:17&to=v:8000" + by);
    REQUIRE(first.status == 200);
    CHECK(header_of(first, "Geo-Cache") == "miss");
    CHECK(took(first, "search"));
    CHECK_FALSE(took(first, "solve"));
    const HttpResponse second = plane.from("/path?from=v:17&to=v:4000" + by);
    CHECK(header_of(second, "Geo-Cache") == "miss");
    CHECK(took(second, "solve"));
    CHECK_FALSE(took(second, "search"));
    const HttpResponse third = plane.from("/path?from=v:17&to=v:8001" + by);
    CHECK(header_of(third, "Geo-Cache") == "hit");
    CHECK_FALSE(took(third, "search"));
    // The same answer from the field, under another name so that it is computed.
    const json searched = body_of(first);
    const json again = body_of(plane.from("/path?from=v:17&via=v:17&to=v:8000" + by));
    CHECK(searched["length"].get<double>() ==
          doctest::Approx(again["length"].get<double>()).epsilon(1e-12));
    CHECK(searched["points"].size() == again["points"].size());
  }
}

TEST_CASE("OneDistanceIsSearchedForAsOnePathIs") {
  TerrainService plane;
  for (const std::string method : {"wavefront", "auto", "exact"}) {
    CAPTURE(method);
    const std::string by = "&method=" + method;
    const HttpResponse searched = plane.from("/distance?from=f:40,0.2,0.3&at=v:8000" + by);
    CHECK(took(searched, "search"));
    const double found = body_of(searched)["distances"][0];
    // Of a column of many, by a field that stops; then by the whole one.
    const json table =
        body_of(plane.from("/table?from=f:40,0.2,0.3&to=v:8000&to=v:1&to=v:99" + by));
    CHECK(found == doctest::Approx(table["distances"][0][0].get<double>()).epsilon(1e-12));
    const HttpResponse whole = plane.from("/distance?from=f:40,0.2,0.3&at=v:7000" + by);
    CHECK(took(whole, "solve"));
    const HttpResponse hit = plane.from("/distance?from=f:40,0.2,0.3&at=v:8000&at=v:7000" + by);
    CHECK(header_of(hit, "Geo-Cache") == "hit");
    CHECK(found == doctest::Approx(body_of(hit)["distances"][0].get<double>()).epsilon(1e-12));
  }
  const json near = body_of(plane.from("/distance?from=v:3&at=v:8000&max=2&labels=1"));
  CHECK(near["distances"][0].is_null());
  CHECK(near["labels"][0].is_null());
  const json labelled = body_of(plane.from("/distance?from=v:4&at=v:8&labels=1"));
  CHECK(labelled["labels"][0] == 0);
}

TEST_CASE("ATableOfOneColumnIsSearchedForRowByRow") {
  TerrainService plane;
  const HttpResponse table = plane.from("/table?from=v:1&from=v:8050&to=v:4321");
  CHECK(took(table, "search"));
  const json distances = body_of(table)["distances"];
  for (int i = 0; i < 2; ++i) {
    const std::string from = i == 0 ? "v:1" : "v:8050";
    const json whole = body_of(plane.from("/distance?from=" + from));
    CHECK(distances[i][0].get<double>() ==
          doctest::Approx(whole["distances"][4321].get<double>()).epsilon(1e-12));
  }
}

TEST_CASE("WhatHasAFieldOrIsSmallIsNotSearched") {
  TerrainService plane;
  plane.from("/distance?from=v:0");
  const HttpResponse hit = plane.from("/path?from=v:0&to=v:77");
  CHECK(header_of(hit, "Geo-Cache") == "hit");
  CHECK_FALSE(took(hit, "search"));
  // By a method that needs the whole field anyway.
  CHECK(took(plane.from("/path?from=v:5&to=v:77&method=fast_marching"), "solve"));
  CHECK(took(plane.service.get(plane.base + "/path?from=v:3&to=v:77"), "solve"));
}

TEST_CASE("SourcesAskedForAreForgottenOneByOne") {
  AskedSources asked(2);
  CHECK(asked.is_first("a"));
  CHECK_FALSE(asked.is_first("a"));
  CHECK(asked.is_first("b"));
  CHECK_FALSE(asked.is_first("a"));  // b is now the oldest
  CHECK(asked.is_first("c"));
  CHECK_FALSE(asked.is_first("a"));
  CHECK(asked.is_first("b"));
}
