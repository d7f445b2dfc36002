#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "tests/fixtures/sanitizers.h"
#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

TEST_CASE("DistanceFieldInSourceVertexOrder") {
  PlaneService plane;
  const HttpResponse response = plane.service.get(plane.base + "/distance?from=v:0");
  CHECK(response.status == 200);
  CHECK(header_of(response, "Geo-Cache") == "miss");
  const json reply = body_of(response);
  CHECK(reply["method"] == "auto");
  CHECK(reply["count"] == 120);
  CHECK(reply["reached"] == 120);
  CHECK(reply["max"] == doctest::Approx(std::hypot(11, 9)));
  CHECK(reply["farthest"] == 119);
  CHECK(reply["from"][0]["vertex"] == 0);
  for (int i = 0; i < 120; ++i) {
    CHECK(reply["distances"][i] == doctest::Approx(std::hypot(i % 12, i / 12)));
  }
  CHECK(header_of(plane.service.get(plane.base + "/distance?from=v:0"), "Geo-Cache") == "hit");
}

TEST_CASE("BinaryFieldsAreTheBareArray") {
  PlaneService plane;
  const json reply = body_of(plane.service.get(plane.base + "/distance?from=v:5&method=wavefront"));
  const HttpResponse f64 =
      plane.service.get(plane.base + "/distance?from=v:5&method=wavefront&format=f64");
  CHECK(f64.content_type == "application/octet-stream");
  CHECK(header_of(f64, "Geo-Dtype") == "<f8");
  CHECK(header_of(f64, "Geo-Shape") == "120");
  CHECK(reply["distances"].get<std::vector<double>>() == numbers_of<double>(f64));
  CHECK(std::stod(header_of(f64, "Geo-Max")) == reply["max"].get<double>());
  const HttpResponse f32 =
      plane.service.ask("GET", plane.base + "/distance?from=v:5&method=wavefront", {},
                        {{"Accept", "application/octet-stream"}});
  CHECK(header_of(f32, "Geo-Dtype") == "<f4");
  const auto narrow = numbers_of<float>(f32);
  REQUIRE(narrow.size() == 120);
  for (int i = 0; i < 120; ++i) CHECK(narrow[i] == reply["distances"][i].get<float>());
}

TEST_CASE("GetAndPostSayTheSame") {
  PlaneService plane;
  plane.check_same("/distance?from=v:3&from=v:100&max=4",
                   R"({"from":[{"vertex":3},{"vertex":100}],"max":4})");
  plane.check_same("/distance?from=f:40,0.25,0.25&at=v:1&at=p:2,3,1",
                   R"({"from":{"face":40,"bary":[0.25,0.25,0.5]},"at":["v:1",{"xyz":[2,3,1]}]})");
  plane.check_same("/path?from=v:0&to=v:119&precision=9",
                   R"({"from":"v:0","to":"v:119","precision":9})");
  plane.check_same("/nearest?point=p:1,2,3", R"({"point":[{"xyz":[1,2,3]}]})");
}

TEST_CASE("PathIsAPolylineOfItsLength") {
  PlaneService plane;
  const json reply = body_of(plane.service.get(plane.base + "/path?from=v:0&to=p:7.25,5.5,4"));
  CHECK(reply["reachable"] == true);
  CHECK(reply["refine"] == "shortest");
  CHECK(reply["length"] == doctest::Approx(std::hypot(7.25, 5.5)));
  CHECK(reply["to"]["snap_distance"] == 4);
  const json& points = reply["points"];
  CHECK(length_of(points) == doctest::Approx(reply["length"].get<double>()).epsilon(1e-12));
  const HttpResponse f64 =
      plane.service.get(plane.base + "/path?from=v:0&to=p:7.25,5.5,4&format=f64");
  CHECK(header_of(f64, "Geo-Shape") == std::to_string(points.size()) + ",3");
  CHECK(numbers_of<double>(f64).size() == 3 * points.size());
}

TEST_CASE("PathAndFieldAgree") {
  const TemporaryFolder folder;
  Service service(folder.path());
  const std::string base = "/v1/meshes/" + service.upload(glb_of(shapes::icosphere(4)));
  for (const int to : {7, 300, 1999}) {
    const std::string target = std::to_string(to);
    const double whole =
        body_of(service.get(base + "/distance?from=v:1"))["distances"][to].get<double>();
    const double at =
        body_of(service.get(base + "/distance?from=v:1&at=v:" + target))["distances"][0];
    const double path = body_of(service.get(base + "/path?from=v:1&to=v:" + target))["length"];
    CHECK(at == whole);
    CHECK(path == doctest::Approx(whole).epsilon(0.01));
  }
}

TEST_CASE("WhatIsUnreachableIsNullNeverZero") {
  const TemporaryFolder folder;
  Service service(folder.path());
  TriangleSoup soup = shapes::plane(3, 3);
  const TriangleSoup other = shapes::plane(2, 2);
  for (const Vec3 p : other.positions) soup.positions.push_back(p + Vec3{0, 0, 5});
  for (const auto& t : other.faces) soup.faces.push_back({t[0] + 9, t[1] + 9, t[2] + 9});
  const std::string base = "/v1/meshes/" + service.upload(glb_of(soup));
  const json field = body_of(service.get(base + "/distance?from=v:0"));
  CHECK(field["reached"] == 9);
  CHECK(field["distances"][9].is_null());
  CHECK(std::isinf(numbers_of<float>(service.get(base + "/distance?from=v:0&format=f32"))[9]));
  const HttpResponse path = service.get(base + "/path?from=v:0&to=v:10");
  CHECK(path.status == 200);
  CHECK(body_of(path)["reachable"] == false);
  CHECK(body_of(path)["length"].is_null());
  CHECK(body_of(path)["points"].empty());
  const json at = body_of(service.get(base + "/distance?from=v:0&at=v:10"));
  CHECK(at["distances"][0].is_null());
  CHECK(at["max"].is_null());
}

TEST_CASE("AQueryWhoseClientIsGoneStops") {
  PlaneService plane;
  const std::string base = plane.add(shapes::terrain(120, 3, 1));
  plane.service.ask("POST", base + "/prepare");
  for (const std::string target :
       {"/distance?from=v:0", "/distance?from=v:1&at=v:9000", "/path?from=v:2&to=v:14399",
        "/table?from=v:3&to=v:14399", "/isolines?from=v:4&count=3", "/samples?count=9"}) {
    CAPTURE(target);
    HttpRequest request;
    request.method = "GET";
    request.target = base + target;
    request.path = request.target.substr(0, request.target.find('?'));
    request.query = *parse_query(request.target.substr(request.target.find('?') + 1));
    request.id = "test";
    request.caller = [] { return true; };
    check_problem(plane.service.routes.answer(request), 499, "cancelled");
    // Nothing of it was kept, and the next client gets an answer.
    CHECK(plane.service.get(request.target).status == 200);
  }
}

TEST_CASE("MaxBoundsTheField") {
  PlaneService plane;
  const json reply = body_of(plane.service.get(plane.base + "/distance?from=v:0&max=3.5"));
  CHECK(reply["max"] <= 3.5);
  CHECK(reply["distances"][3] == doctest::Approx(3));
  CHECK(reply["distances"][4].is_null());
}

TEST_CASE("SourcesMayHaveOffsets") {
  PlaneService plane;
  const json reply = body_of(
      plane.service.ask("POST", plane.base + "/distance",
                        R"({"from":[{"vertex":0,"offset":2},{"vertex":11}],"at":["v:1","v:10"]})"));
  CHECK(reply["distances"][0] == doctest::Approx(3));
  CHECK(reply["distances"][1] == doctest::Approx(1));
}

TEST_CASE("WeldedVerticesGetEqualValues") {
  const TemporaryFolder folder;
  Service service(folder.path());
  const TriangleSoup soup{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}, {1, 1, 0}, {0, 1, 0}},
                          {{0, 1, 2}, {3, 4, 5}, {0, 3, 1}}};
  const std::string base = "/v1/meshes/" + service.upload(glb_of(soup));
  const json reply = body_of(service.get(base + "/distance?from=v:3"));
  CHECK(reply["count"] == 6);
  CHECK(reply["from"][0]["vertex"] == 3);
  CHECK(reply["distances"][0] == 0);
  CHECK(reply["distances"][2] == reply["distances"][4]);
  CHECK(reply["distances"][5] == 1);
  // A face that welding has made an edge is still a place.
  const json nearest = body_of(service.get(base + "/nearest?point=f:2,0.25,0.25"));
  CHECK(nearest["points"][0]["xyz"] == json::parse("[0.5,0,0]"));
}

// The cache counts its fields, not what it knows them by.
TEST_CASE("AFieldIsKnownByLittleHoweverManySourcesItHas") {
  PlaneService plane;
  const auto cached = [&]() -> json {
    return body_of(plane.service.get("/debug/cache"))["fields"];
  };
  json from = json::array();
  for (int i = 0; i < 1000; ++i) {
    from.push_back("f:" + std::to_string(i % 198) + ",0.1," + std::to_string(0.2 + i / 2000.0));
  }
  const auto ask = [&](const json& sources) {
    const HttpResponse response = plane.service.ask(
        "POST", plane.base + "/distance", json{{"from", sources}, {"method", "dijkstra"}}.dump());
    REQUIRE(response.status == 200);
    return header_of(response, "Geo-Cache");
  };
  CHECK(ask(from) == "miss");
  CHECK(ask(from) == "hit");
  from.back() = "f:7,0.1,0.25";
  CHECK(ask(from) == "miss");
  CHECK(ask(from) == "hit");
  CHECK(ask({"v:0"}) == "miss");
  REQUIRE(cached().size() == 3);
  for (const json& entry : cached()) {
    const auto key = entry["key"].get<std::string>();
    CHECK(key.size() <= 512);
    CHECK(key.starts_with(plane.id + "/"));
  }
  // By its beginning, they go with their mesh.
  CHECK(plane.service.ask("DELETE", plane.base).status == 204);
  CHECK(cached().empty());
}

TEST_CASE("AMillionVerticesUploadPrepareAndAnswer") {
  constexpr std::uint32_t side = geodesic::fixtures::all_or(1000, 200);
  const TemporaryFolder folder;
  Service service(folder.path());
  const std::string base =
      "/v1/meshes/" + service.upload(glb_of(shapes::terrain(side, side / 50.0, 1)));
  const json mesh = body_of(service.get(base));
  CHECK(mesh["vertices"] == side * side);
  CHECK(mesh["components"] == 1);
  CHECK(body_of(service.ask("POST", base + "/prepare"))["prepared"] == true);
  const HttpResponse field = service.get(base + "/distance?from=v:0&format=f32");
  const auto distances = numbers_of<float>(field);
  REQUIRE(distances.size() == side * side);
  for (const float d : distances) REQUIRE(std::isfinite(d));
  const json path =
      body_of(service.get(base + "/path?from=v:0&to=v:" + std::to_string(side * side - 1)));
  CHECK(path["reachable"] == true);
  CHECK(path["length"] == doctest::Approx(distances.back()).epsilon(0.01));
  CHECK(path["length"] > side * std::sqrt(2) - 2);
}
