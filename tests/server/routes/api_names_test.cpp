#include <doctest/doctest.h>

#include <string>

#include "tests/server/routes/service_fixture.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

TEST_CASE("AMeshIsCalledWhatItWasUploadedAs") {
  const TemporaryFolder folder;
  const std::string glb = glb_of(shapes::plane(5, 4));
  std::string id;
  {
    Service service(folder.path());
    const HttpResponse first = service.ask("POST", "/v1/meshes?name=my%20plane.glb", glb);
    CHECK(first.status == 201);
    id = body_of(first)["id"];
    CHECK(id == sha256_hex(glb));  // the name is no part of it
    CHECK(body_of(first)["name"] == "my plane.glb");
    // It has a name, and keeps it.
    const HttpResponse again = service.ask("POST", "/v1/meshes?name=other.glb", glb);
    CHECK(again.status == 200);
    CHECK(body_of(again)["name"] == "my plane.glb");
    CHECK(body_of(service.ask("POST", "/v1/meshes", glb))["name"] == "my plane.glb");
    // Read in another way it is another mesh, with a name of its own.
    const json metres = body_of(service.ask("POST", "/v1/meshes?scale=0.001&name=in%20m", glb));
    CHECK(metres["name"] == "in m");
    CHECK(metres["id"] != id);
    const json page = body_of(service.get("/v1/meshes"));
    REQUIRE(page["meshes"].size() == 2);
    CHECK(page["meshes"][0]["name"] == "my plane.glb");
    CHECK(page["meshes"][1]["name"] == "in m");
    CHECK(page["meshes"][1]["import"] == json{{"scale", 0.001}});
  }
  Service service(folder.path());
  CHECK(body_of(service.get("/v1/meshes/" + id))["name"] == "my plane.glb");
}

TEST_CASE("TheHeaderNamesAFileToo") {
  const TemporaryFolder folder;
  Service service(folder.path());
  const std::string glb = glb_of(shapes::plane(5, 4));
  // Known without a name, so it gets this one.
  CHECK_FALSE(body_of(service.ask("POST", "/v1/meshes", glb)).contains("name"));
  const json named = body_of(service.ask(
      "POST", "/v1/meshes", glb, {{"Content-Disposition", "attachment; filename=\"a/b.glb\""}}));
  CHECK(named["name"] == "b.glb");
  CHECK(body_of(service.get("/v1/meshes/" + sha256_hex(glb))) == named);
  // One that can be no name is none, and no error.
  const json unnamed = body_of(
      service.ask("POST", "/v1/meshes", glb_of(shapes::plane(6, 6)),
                  {{"Content-Disposition", "attachment; filename=" + std::string(201, 'a')}}));
  CHECK(unnamed["vertices"] == 36);
  CHECK_FALSE(unnamed.contains("name"));
  // The parameter counts before the header.
  const json other = body_of(service.ask(
      "PUT", "/v1/meshes/" + sha256_hex(glb_of(shapes::plane(3, 3))) + "?name=parameter",
      glb_of(shapes::plane(3, 3)), {{"Content-Disposition", "attachment; filename=header"}}));
  CHECK(other["name"] == "parameter");
}

TEST_CASE("ALongBodyAsksForMemoryBeforeItIsParsed") {
  const TemporaryFolder folder;
  Config config;
  config.reply_memory_bytes = 1'000'000;
  Service service(folder.path(), config);
  const std::string base = "/v1/meshes/" + service.upload(glb_of(shapes::plane(5, 4)));
  std::string values = "[]";
  for (int i = 0; i < 30'000; ++i) values += ",[]";
  const std::string body = R"({"name": "a", "x": [)" + values + "]}";
  CHECK(body_of(service.ask("PATCH", base, body))["code"] == "too_much_memory");
  CHECK(body_of(service.ask("POST", base + "/distance", body))["code"] == "too_much_memory");
  CHECK(service.ask("PATCH", base, R"({"name": "a"})").status == 200);
}

TEST_CASE("AMeshIsRenamedAndTheNameTakenAway") {
  const TemporaryFolder folder;
  Service service(folder.path());
  const json mesh = body_of(service.ask("POST", "/v1/meshes", glb_of(shapes::plane(5, 4))));
  const std::string base = "/v1/meshes/" + mesh["id"].get<std::string>();
  const auto called = [&](const std::string& body) { return service.ask("PATCH", base, body); };
  const HttpResponse renamed = called(R"({"name": "größer"})");
  CHECK(renamed.status == 200);
  json expected = mesh;
  expected["name"] = "größer";
  CHECK(body_of(renamed) == expected);
  CHECK(body_of(service.get(base)) == expected);
  CHECK(body_of(service.ask("POST", base + "/prepare"))["name"] == "größer");
  for (const char* bad :
       {"", "[]", "{}", R"({"name": 7})", R"({"name": null})", R"({"name": "a\nb"})",
        R"({"name": "a", "id": "b"})", R"({"name": "a", "name": "b"})"}) {
    CAPTURE(bad);
    const HttpResponse refused = called(bad);
    CHECK(refused.status == 400);
    CHECK(body_of(service.get(base)) == expected);
  }
  CHECK(called(R"({"name": ")" + std::string(201, 'a') + R"("})").status == 400);
  CHECK(body_of(called(R"({"name": ""})")) == mesh);
  CHECK(body_of(service.get(base)) == mesh);
  CHECK(service.ask("PATCH", "/v1/meshes/" + std::string(64, 'a'), R"({"name": "a"})").status ==
        404);
  CHECK(service.ask("PATCH", base + "?name=a", R"({"name": "a"})").status == 400);
  CHECK(service.ask("POST", "/v1/meshes?name=a%0ab", glb_of(shapes::plane(3, 3))).status == 400);
  // Nothing of the refused one remains, and distances are those of the mesh.
  CHECK(body_of(service.get("/v1/meshes"))["meshes"].size() == 1);
  CHECK(service.get(base + "/distance?from=v:0&at=v:1").status == 200);
}
