#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>

#include "tests/server/routes/plane_service.h"
#include "tests/server/routes/service_fixture.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

TEST_CASE("UploadAnswersWithMetadataAndIsIdempotent") {
  const TemporaryFolder folder;
  Service service(folder.path());
  const std::string glb = glb_of(shapes::plane(5, 4));
  const HttpResponse first = service.ask("POST", "/v1/meshes", glb);
  CHECK(first.status == 201);
  const json mesh = body_of(first);
  CHECK(mesh["id"] == sha256_hex(glb));
  CHECK(header_of(first, "Location") == "/v1/meshes/" + sha256_hex(glb));
  CHECK(mesh["vertices"] == 20);
  CHECK(mesh["faces"] == 24);
  CHECK(mesh["welded_vertices"] == 20);
  CHECK(mesh["components"] == 1);
  CHECK(mesh["boundary_loops"] == 1);
  CHECK(mesh["edges_non_manifold"] == 0);
  CHECK(mesh["faces_degenerate"] == 0);
  CHECK(mesh["area"] == 12);
  CHECK(mesh["bbox"] == json::parse(R"({"min":[0,0,0],"max":[4,3,0]})"));
  CHECK(mesh["format"] == "glb");
  CHECK(mesh["bytes"] == glb.size());
  CHECK(mesh["unit"] == "mesh");
  CHECK(mesh["state"] == "resident");
  CHECK(mesh["prepared"] == true);
  CHECK(mesh["parts"][0]["name"] == "test");
  CHECK(mesh["parts"][0]["vertex_count"] == 20);

  const HttpResponse again = service.ask("POST", "/v1/meshes", glb);
  CHECK(again.status == 200);
  CHECK(body_of(again) == mesh);
}

TEST_CASE("PutTakesOnlyTheBytesOfItsId") {
  const TemporaryFolder folder;
  Service service(folder.path());
  const std::string glb = glb_of(shapes::plane(3, 3));
  const std::string id = sha256_hex(glb);
  CHECK(service.ask("PUT", "/v1/meshes/" + id, glb).status == 201);
  CHECK(service.ask("PUT", "/v1/meshes/" + id, glb).status == 200);
  const HttpResponse wrong = service.ask("PUT", "/v1/meshes/" + std::string(64, 'a'), glb);
  CHECK(wrong.status == 422);
  CHECK(body_of(wrong)["code"] == "digest_mismatch");
  CHECK(service.get("/v1/meshes/" + std::string(64, 'a')).status == 404);
}

TEST_CASE("AMeshIsFoundAgainAfterARestart") {
  const TemporaryFolder folder;
  const std::string glb = glb_of(shapes::icosphere(2));
  std::string id;
  json distances;
  {
    Service service(folder.path());
    id = service.upload(glb);
    distances = body_of(service.get("/v1/meshes/" + id + "/distance?from=v:0"));
  }
  Service service(folder.path());
  const json mesh = body_of(service.get("/v1/meshes/" + id));
  CHECK(mesh["state"] == "stored");
  CHECK(mesh["prepared"] == false);
  CHECK(*service.get("/v1/meshes/" + id + "/source").body == glb);
  CHECK(body_of(service.get("/v1/meshes/" + id + "/distance?from=v:0")) == distances);
  CHECK(body_of(service.get("/v1/meshes/" + id))["prepared"] == true);
}

TEST_CASE("DeleteForgetsEverything") {
  const TemporaryFolder folder;
  Service service(folder.path());
  const std::string id = service.upload(glb_of(shapes::plane(3, 3)));
  CHECK(service.get("/v1/meshes/" + id + "/distance?from=v:0").status == 200);
  CHECK(service.ask("DELETE", "/v1/meshes/" + id).status == 204);
  CHECK(service.ask("DELETE", "/v1/meshes/" + id).status == 404);
  CHECK(service.get("/v1/meshes/" + id).status == 404);
  CHECK(service.get("/v1/meshes/" + id + "/distance?from=v:0").status == 404);
  CHECK(folder.files() == std::vector<std::string>{"lock"});
  CHECK(service.queries.field_cache().entries == 0);
}

TEST_CASE("ListsMeshesPageByPage") {
  const TemporaryFolder folder;
  Service service(folder.path());
  std::vector<std::string> ids;
  for (std::uint32_t n = 2; n < 7; ++n) ids.push_back(service.upload(glb_of(shapes::plane(n, 3))));
  std::sort(ids.begin(), ids.end());
  std::vector<std::string> listed;
  std::string target = "/v1/meshes?limit=2";
  for (int page = 0; page < 3; ++page) {
    const json reply = body_of(service.get(target));
    for (const json& mesh : reply["meshes"]) listed.push_back(mesh["id"]);
    CHECK(reply["next"].is_null() == (page == 2));
    if (page < 2) target = "/v1/meshes?limit=2&cursor=" + reply["next"].get<std::string>();
  }
  CHECK(listed == ids);
  CHECK(service.get("/v1/meshes?limit=0").status == 422);
  CHECK(service.get("/v1/meshes?cursor=nonsense").status == 400);
}

TEST_CASE("PrepareBuildsTheAdjacencyAgain") {
  const TemporaryFolder folder;
  std::string id;
  {
    Service service(folder.path());
    id = service.upload(glb_of(shapes::plane(6, 6)));
  }
  Service service(folder.path());
  CHECK(service.catalog.adjacency_cache().makes == 0);
  CHECK(body_of(service.ask("POST", "/v1/meshes/" + id + "/prepare"))["prepared"] == true);
  CHECK(service.catalog.adjacency_cache().makes == 1);
  CHECK(service.get("/v1/meshes/" + id + "/distance?from=v:0").status == 200);
  CHECK(service.catalog.adjacency_cache().makes == 1);
}

TEST_CASE("AnUploadWithoutItsDescriptionIsDescribedAnew") {
  const TemporaryFolder folder;
  std::string id;
  json before;
  {
    Service service(folder.path());
    id = service.upload(glb_of(shapes::plane(6, 6)));
    before = body_of(service.get("/v1/meshes/" + id));
  }
  std::filesystem::remove(folder.path() / "meta" / id.substr(0, 2) / (id + ".json"));
  Service service(folder.path());
  json after = body_of(service.get("/v1/meshes/" + id));
  CHECK(after["area"] == before["area"]);
  CHECK(after["boundary_loops"] == before["boundary_loops"]);
}

TEST_CASE("WarningsSayWhatAMeshMeansForDistances") {
  const TemporaryFolder folder;
  Service service(folder.path());
  TriangleSoup soup = shapes::plane(3, 3);
  const TriangleSoup other = shapes::plane(2, 2);
  for (const Vec3 p : other.positions) soup.positions.push_back(p + Vec3{0, 0, 5});
  for (const auto& t : other.faces) soup.faces.push_back({t[0] + 9, t[1] + 9, t[2] + 9});
  soup.positions.push_back({7, 7, 7});
  const std::string id = service.upload(glb_of(soup));
  const std::string warnings = body_of(service.get("/v1/meshes/" + id))["warnings"].dump();
  CHECK(warnings.find("2 components; distances between them are infinite") != std::string::npos);
  CHECK(warnings.find("1 vertex is in no face") != std::string::npos);
}

TEST_CASE("ReadinessFollowsTheStoreUnlessThatIsLeftOut") {
  const TemporaryFolder folder;
  Service service(folder.path());
  const std::string id = service.upload(glb_of(shapes::plane(3, 3)));
  std::filesystem::remove_all(folder.path());
  CHECK_FALSE(service.store->check());
  check_problem(service.get("/readyz"), 503, "store_unavailable");
  CHECK(service.get("/readyz?exclude=store").status == 200);
  CHECK(service.get("/v1/meshes/" + id + "/distance?from=v:0").status == 200);
  check_problem(service.get("/readyz?exclude=listener"), 422, "value_out_of_range", "exclude");
  CHECK(service.get("/readyz?now=1").status == 503);
}

TEST_CASE("ProbesStatusAndMethods") {
  const TemporaryFolder folder;
  Service service(folder.path());
  CHECK(service.get("/livez").status == 200);
  CHECK(service.get("/readyz").status == 200);
  const json methods = body_of(service.get("/v1/methods"))["methods"];
  CHECK(methods[0]["name"] == "auto");
  for (const json& method : methods) {
    CHECK(method["default"] == (method["name"] == "auto"));
    CHECK_FALSE(method["about"].get<std::string>().empty());
  }
  const json status = body_of(service.get("/v1/status"));
  CHECK(status["limits"]["max_vertices"] == 20'000'000);
  CHECK(status["caches"]["adjacency"]["entries"] == 0);
  CHECK(status["compute"]["unanswering"] == 0);
  CHECK(status["compute"]["unanswered"] == 0);
  service.routes.start_draining();
  CHECK(service.get("/readyz").status == 503);
  CHECK(service.get("/readyz?exclude=store").status == 503);
  CHECK(service.get("/livez").status == 200);
  CHECK(service.get("/openapi.yaml").body->starts_with("openapi: 3.1"));
}
