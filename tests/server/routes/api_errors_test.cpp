// Bad input, each with its status, code and parameter; afterwards the service
// answers as before and nothing of a failed upload remains.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "server/edge/server.h"
#include "tests/server/edge/raw_client.h"
#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

TEST_CASE("UploadOfWhatIsNoMesh") {
  PlaneService plane;
  plane.check_refused_upload("", 415, "format_unknown");
  plane.check_refused_upload("hello", 415, "format_unknown");
  plane.check_refused_upload(std::string(1000, '\0'), 415, "format_unknown");
}

TEST_CASE("UploadTruncatedAtEveryLength") {
  PlaneService plane;
  const std::string glb = glb_of(shapes::plane(2, 2));
  for (std::size_t length = 0; length < glb.size(); ++length) {
    const HttpResponse response = plane.service.ask("POST", "/v1/meshes", glb.substr(0, length));
    CHECK(response.status >= 400);
    CHECK(response.status < 500);
  }
  CHECK(plane.service.store->size() == 1);
  CHECK(plane.folder.files().size() == 3);
  CHECK(plane.service.ask("POST", "/v1/meshes", glb).status == 201);
}

TEST_CASE("UploadWithAnIndexOutOfRange") {
  PlaneService plane;
  TriangleSoup soup = shapes::plane(3, 3);
  soup.faces[2][1] = 9;
  plane.check_refused_upload(glb_of(soup), 422, "index_out_of_range");
}

TEST_CASE("UploadWithAPositionThatIsNotANumber") {
  PlaneService plane;
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    TriangleSoup soup = shapes::plane(3, 3);
    soup.positions[4].y = bad;
    plane.check_refused_upload(glb_of(soup), 422, "mesh_invalid");
  }
}

TEST_CASE("UploadWithoutTriangles") {
  PlaneService plane;
  plane.check_refused_upload(
      R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"name":"empty"}]})", 422,
      "no_triangles");
}

TEST_CASE("UploadOverTheLimits") {
  Config config;
  config.max_vertices = 200;
  config.max_faces = 300;
  PlaneService plane(config);
  plane.check_refused_upload(glb_of(shapes::plane(30, 30)), 422, "too_many_vertices");
  TriangleSoup soup = shapes::plane(12, 10);
  const auto faces = soup.faces;
  soup.faces.insert(soup.faces.end(), faces.begin(), faces.end());
  plane.check_refused_upload(glb_of(soup), 422, "too_many_faces");
}

TEST_CASE("UnknownMesh") {
  PlaneService plane;
  const std::string other = "/v1/meshes/" + std::string(64, '0');
  for (const std::string& target :
       {other, other + "/source", other + "/distance?from=v:0", other + "/path?from=v:0&to=v:1",
        other + "/nearest?point=v:0", std::string("/v1/meshes/abc"),
        std::string("/v1/meshes/..%2f..%2fetc"), std::string("/v1/meshes/")}) {
    check_problem(plane.service.get(target), 404, "mesh_unknown");
  }
}

TEST_CASE("UnknownRouteAndWrongMethod") {
  PlaneService plane;
  check_problem(plane.service.get("/nothing"), 404, "route_unknown");
  check_problem(plane.service.get(plane.base + "/nothing"), 404, "route_unknown");
  check_problem(plane.service.get(plane.base + "/path/more"), 404, "route_unknown");
  const HttpResponse wrong = plane.service.ask("DELETE", plane.base + "/distance");
  check_problem(wrong, 405, "method_not_allowed");
  CHECK(header_of(wrong, "Allow") == "GET, HEAD, POST, OPTIONS");
  check_problem(plane.service.ask("PATCH", "/v1/meshes"), 405, "method_not_allowed");
  check_problem(plane.service.ask("POST", "/livez"), 405, "method_not_allowed");
}

TEST_CASE("PointsOutOfRange") {
  PlaneService plane;
  const auto problem = [&](const std::string& target, int status, std::string_view code,
                           std::string_view parameter) {
    check_problem(plane.service.get(plane.base + target), status, code, parameter);
  };
  problem("/distance?from=v:120", 422, "index_out_of_range", "from[0]");
  problem("/distance?from=v:0&from=v:18446744073709551615", 422, "index_out_of_range", "from[1]");
  problem("/distance?from=v:0&at=f:198,1,0", 422, "index_out_of_range", "at[0]");
  problem("/path?from=v:0&to=v:4294967296", 422, "index_out_of_range", "to");
  problem("/path?from=f:0,0.7,0.7&to=v:1", 422, "value_out_of_range", "from");
  problem("/nearest?point=p:1e300,0,0", 422, "value_out_of_range", "point[0]");
  check_problem(plane.service.ask("POST", plane.base + "/nearest",
                                  R"({"point":{"xyz":[0,0,2],"max_snap":1}})"),
                422, "snap_too_far", "point[0]");
}

TEST_CASE("ParametersThatDoNotParse") {
  PlaneService plane;
  const auto problem = [&](const std::string& target, std::string_view code,
                           std::string_view parameter, int status = 400) {
    check_problem(plane.service.get(plane.base + target), status, code, parameter);
  };
  problem("/distance", "bad_syntax", "from");
  problem("/path?from=v:0", "bad_syntax", "to");
  problem("/path?from=v:0&from=v:1&to=v:2", "bad_syntax", "from");
  for (const std::string point : {"0", "v:", "v:-1", "v:1.5", "v:1x", "x:1", "f:1", "f:1,0.5",
                                  "p:1,2", "p:1,2,3,4", "p:nan,0,0", "p:1e999,0,0", "v:0x10"}) {
    problem("/distance?from=" + point, "bad_syntax", "from[0]");
  }
  problem("/distance?from=v:0&max=much", "bad_syntax", "max");
  problem("/distance?from=v:0&max=-1", "value_out_of_range", "max", 422);
  problem("/distance?from=v:0&form=v:1", "unknown_parameter", "form");
  problem("/distance?from=v:0&method=magic", "method_unknown", "method", 422);
  problem("/path?from=v:0&to=v:1&refine=best", "value_out_of_range", "refine", 422);
  problem("/distance?from=v:0&format=xml", "not_acceptable", "format", 406);
  problem("/distance?from=v:0&precision=40", "value_out_of_range", "precision", 422);
  problem("/nearest?point=v:0&format=f32", "not_acceptable", "format", 406);
  check_problem(
      plane.service.ask("GET", plane.base + "/distance?from=v:0", {}, {{"Accept", "text/html"}}),
      406, "not_acceptable", "Accept");
}

TEST_CASE("MorePointsThanARequestMayHave") {
  PlaneService plane;
  json many = json::array();
  for (int i = 0; i < 1001; ++i) many.push_back("v:1");
  const HttpResponse response =
      plane.service.ask("POST", plane.base + "/distance", json{{"from", many}}.dump());
  check_problem(response, 413, "too_large", "from");
  CHECK(body_of(response)["limit"] == 1000);
  CHECK(body_of(response)["actual"] == 1001);
  many.erase(0);
  CHECK(plane.service.ask("POST", plane.base + "/distance", json{{"from", many}}.dump()).status ==
        200);
}

TEST_CASE("BodiesThatAreNotJson") {
  PlaneService plane;
  const auto problem = [&](const std::string& body, std::string_view code,
                           std::string_view parameter) {
    check_problem(plane.service.ask("POST", plane.base + "/distance", body), 400, code, parameter);
  };
  problem("", "bad_syntax", "body");
  problem("{", "bad_syntax", "body");
  problem("[]", "bad_syntax", "body");
  problem("\"from\"", "bad_syntax", "body");
  problem("{\"from\":\"\xff\xfe\"}", "bad_syntax", "body");
  problem(R"({"from":"v:0"} trailing)", "bad_syntax", "body");
  problem("{\"from\":" + std::string(100'000, '[') + std::string(100'000, ']') + "}", "bad_syntax",
          "body");
  // Of two values, nobody can know which one is meant.
  problem(R"({"from":"v:0","from":"v:1"})", "bad_syntax", "from");
  problem(R"({"from":"v:0","method":"exact","method":"exact"})", "bad_syntax", "method");
  problem(R"({"from":"v:0","fr\u006fm":"v:1"})", "bad_syntax", "from");
  problem(R"({"from":{"vertex":1,"vertex":2}})", "bad_syntax", "vertex");
  problem(R"({"from":["v:0",{"vertex":1,"offset":1,"vertex":1}]})", "bad_syntax", "vertex");
  problem(R"({"from":{"ray":{"origin":[0,0,1],"origin":[0,0,2],"direction":[0,0,-1]}}})",
          "bad_syntax", "origin");
  problem(R"({"":1,"":2})", "bad_syntax", "");
  CHECK(
      plane.service.ask("POST", plane.base + "/distance", R"({"from":[{"vertex":1},{"vertex":1}]})")
          .status == 200);
  problem(R"({"from":1})", "bad_syntax", "from[0]");
  problem(R"({"from":{"vertex":-1}})", "bad_syntax", "from[0].vertex");
  problem(R"({"from":{"vertex":0.5}})", "bad_syntax", "from[0].vertex");
  problem(R"({"from":{"face":1,"bary":[1]}})", "bad_syntax", "from[0].bary");
  problem(R"({"from":{"xyz":[1,2,null]}})", "bad_syntax", "from[0].xyz");
  problem(R"({"from":{"vertex":1,"vertexx":1}})", "unknown_parameter", "from[0].vertexx");
  problem(R"({"from":"v:0","max":"lots"})", "bad_syntax", "max");
  problem(R"({"from":"v:0","to":"v:0"})", "unknown_parameter", "to");
}

TEST_CASE("ABodyTooLargeIsRefusedAtTheEdge") {
  Config config;
  config.max_body_bytes = 1000;
  config.max_json_bytes = 100;
  const TemporaryFolder folder;
  Service service(folder.path(), config);
  HttpOptions options;
  options.io_threads = 2;
  options.max_body = [&](std::string_view method, std::string_view path) {
    return service.routes.max_body(method, path);
  };
  HttpServer server(options, [&](HttpRequest& request) { return service.routes.answer(request); });
  const auto port = server.start();
  REQUIRE(port);
  const auto reply_to = [&](const std::string& path, std::size_t length) {
    RawClient client(*port);
    client.send("POST " + path + " HTTP/1.1\r\nHost: x\r\nContent-Length: " +
                std::to_string(length) + "\r\n\r\n" + std::string(length, 'x'));
    return client.receive();
  };
  const RawReply upload = reply_to("/v1/meshes", 1001);
  CHECK(upload.status == 413);
  CHECK(json::parse(upload.body)["code"] == "too_large");
  CHECK(json::parse(upload.body)["limit"] == 1000);
  CHECK(reply_to("/v1/meshes", 1000).status == 415);
  CHECK(reply_to("/v1/meshes/" + std::string(64, '0') + "/path", 101).status == 413);
  CHECK(service.store->size() == 0);
  server.stop(std::chrono::seconds(1));
}

TEST_CASE("WhatTakesNoParametersRefusesThemUnderV1") {
  PlaneService plane;
  const auto job =
      plane.service.ask("POST", plane.base + "/prepare", {}, {{"Prefer", "respond-async"}});
  REQUIRE(job.status == 202);
  const std::string made = header_of(job, "Location");
  const std::vector<std::pair<std::string, std::string>> paths{{"GET", plane.base},
                                                               {"GET", plane.base + "/source"},
                                                               {"GET", plane.base + "/geometry"},
                                                               {"GET", "/v1/meshes"},
                                                               {"GET", "/v1/status"},
                                                               {"GET", "/v1/methods"},
                                                               {"GET", made},
                                                               {"GET", made + "/result"},
                                                               {"GET", made + "/events"},
                                                               {"DELETE", made},
                                                               {"DELETE", plane.base},
                                                               {"POST", plane.base + "/prepare"},
                                                               {"POST", plane.base + "/batch"},
                                                               {"POST", "/v1/meshes"},
                                                               {"GET", plane.base + "/path"}};
  for (const auto& [method, path] : paths) {
    CAPTURE(path);
    // A path that asks for `from` and `to` misses them first.
    const std::string others = path.ends_with("/path") ? "from=v:0&to=v:1&" : "";
    for (const std::string name : {"x", "From", ""}) {
      check_problem(plane.service.ask(method, path + "?" + others + name + "=1"), 400,
                    "unknown_parameter", name);
    }
    if (method == "GET") {
      CHECK(plane.service.ask("HEAD", path + "?x=1").status == 400);
    }
  }
  for (const char* body : {"junk", "{}", "{\"x\":1}"}) {
    check_problem(plane.service.ask("POST", plane.base + "/prepare", body), 400, "bad_syntax",
                  "body");
  }
  // Nothing of that did anything.
  CHECK(plane.service.get(plane.base).status == 200);
  CHECK(plane.service.get(made).status == 200);
  for (const char* probe : {"/livez", "/readyz", "/metrics", "/", "/openapi.yaml"}) {
    CHECK(plane.service.get(probe + std::string("?x=1")).status == 200);
  }
}
