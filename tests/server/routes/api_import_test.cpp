#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "tests/server/routes/service_fixture.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

// Two triangles that make up a square, with vertices of their own, a hair apart.
TriangleSoup nearly_a_square() {
  return {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 1e-4}, {1, 1, 1e-4}, {0, 1, 0}},
          {{0, 1, 2}, {3, 4, 5}}};
}

json distances(Service& service, const std::string& id) {
  return body_of(service.get("/v1/meshes/" + id + "/distance?from=v:1"))["distances"];
}

}  // namespace

TEST_CASE("OptionsMakeAnotherMeshOfTheSameBytes") {
  const TemporaryFolder folder;
  Service service(folder.path());
  const std::string glb = glb_of(nearly_a_square());
  const std::string digest = sha256_hex(glb);
  const json apart = body_of(service.ask("POST", "/v1/meshes", glb));
  CHECK(apart["id"] == digest);
  CHECK(apart["import"] == json::object());
  CHECK(apart["components"] == 2);

  const HttpResponse first = service.ask("POST", "/v1/meshes?weld=0.001", glb);
  CHECK(first.status == 201);
  const json joined = body_of(first);
  const std::string id = joined["id"];
  CHECK(id.size() == 64 + 1 + 32);
  CHECK(id.starts_with(digest + "~"));
  CHECK(header_of(first, "Location") == "/v1/meshes/" + id);
  CHECK(joined["import"] == json{{"weld", "0.001"}});
  CHECK(joined["components"] == 1);
  CHECK(joined["report"][0]["code"] == "vertices_moved");
  CHECK(joined["report"][0]["count"] == 2);
  CHECK(service.ask("POST", "/v1/meshes?weld=1e-3", glb).status == 200);
  CHECK(*service.get("/v1/meshes/" + id + "/source").body == glb);
  CHECK(distances(service, digest)[5].is_null());
  CHECK(distances(service, id)[5].get<double>() == doctest::Approx(std::sqrt(2.0)).epsilon(1e-3));
  CHECK(body_of(service.get("/v1/meshes"))["meshes"].size() == 2);

  CHECK(service.ask("DELETE", "/v1/meshes/" + id).status == 204);
  CHECK(service.get("/v1/meshes/" + id).status == 404);
  CHECK(service.get("/v1/meshes/" + digest).status == 200);
}

TEST_CASE("OptionsSurviveARestartAndEviction") {
  const TemporaryFolder folder;
  const std::string glb = glb_of(nearly_a_square());
  std::string id;
  json before;
  {
    Service service(folder.path());
    id = body_of(service.ask("POST", "/v1/meshes?weld=0.001&scale=1000&up=z", glb))["id"];
    before = distances(service, id);
    CHECK(before[2].get<double>() == doctest::Approx(1000));
  }
  Config config;
  config.mesh_cache_bytes = 0;
  config.adjacency_cache_bytes = 0;
  config.field_cache_bytes = 0;
  Service service(folder.path(), config);
  CHECK(body_of(service.get("/v1/meshes/" + id))["state"] == "stored");
  for (int i = 0; i < 2; ++i) CHECK(distances(service, id) == before);
  const json mesh = body_of(service.get("/v1/meshes/" + id));
  CHECK(mesh["import"] == json{{"scale", 1000}, {"up", "z"}, {"weld", "0.001"}});
  CHECK(mesh["bbox"]["min"] == json{0, 0, -1000});
}

TEST_CASE("WithoutItsDescriptionNobodyKnowsHowAMeshWasToBeRead") {
  const TemporaryFolder folder;
  const std::string glb = glb_of(nearly_a_square());
  const std::string id = mesh_id(sha256_hex(glb), R"({"scale":2})");
  {
    Service service(folder.path());
    CHECK(service.ask("POST", "/v1/meshes?scale=2", glb).status == 201);
  }
  std::filesystem::remove(folder.path() / "meta" / id.substr(0, 2) / (id + ".json"));
  Service service(folder.path());
  CHECK(service.get("/v1/meshes/" + id).status == 404);
  CHECK(service.get("/v1/meshes/" + id + "/distance?from=v:0").status == 404);
  CHECK(service.ask("POST", "/v1/meshes?scale=2", glb).status == 201);
  CHECK(body_of(service.get("/v1/meshes/" + id))["area"] == doctest::Approx(4));
}

TEST_CASE("AMeshOfAnOldShorterIdIsStillThereAndNewOnesGetLongerIds") {
  const TemporaryFolder folder;
  const std::string glb = glb_of(nearly_a_square());
  const std::string id = mesh_id(sha256_hex(glb), R"({"scale":2})");
  const std::string old_id = id.substr(0, 64 + 1 + 12);
  {
    Service service(folder.path());
    CHECK(service.ask("POST", "/v1/meshes?scale=2", glb).status == 201);
  }
  // As the version before has stored it.
  namespace fs = std::filesystem;
  const std::string shard = id.substr(0, 2);
  fs::rename(folder.path() / "objects" / shard / id, folder.path() / "objects" / shard / old_id);
  fs::rename(folder.path() / "meta" / shard / (id + ".json"),
             folder.path() / "meta" / shard / (old_id + ".json"));
  Service service(folder.path());
  CHECK(body_of(service.get("/v1/meshes"))["meshes"].size() == 1);
  CHECK(service.get("/v1/meshes/" + old_id).status == 200);
  CHECK(*service.get("/v1/meshes/" + old_id + "/source").body == glb);
  const json before = distances(service, old_id);
  CHECK(before[0].get<double>() == doctest::Approx(2));
  CHECK(service.get("/v1/meshes/" + id).status == 404);
  CHECK(body_of(service.ask("POST", "/v1/meshes?scale=2", glb))["id"] == id);
  CHECK(distances(service, id) == before);
  CHECK(service.ask("DELETE", "/v1/meshes/" + old_id).status == 204);
  CHECK(service.get("/v1/meshes/" + id).status == 200);
}

TEST_CASE("AnIdNeverAnswersForOtherOptionsThanItsOwn") {
  const TemporaryFolder folder;
  const std::string glb = glb_of(nearly_a_square());
  const std::string digest = sha256_hex(glb);
  std::string twice;
  {
    Service service(folder.path());
    twice = body_of(service.ask("POST", "/v1/meshes?scale=2", glb))["id"];
    CHECK(service.ask("POST", "/v1/meshes?scale=3", glb).status == 201);
    CHECK(service.ask("POST", "/v1/meshes", glb).status == 201);
  }
  const std::string thrice = mesh_id(digest, R"({"scale":3})");
  // As if two options had one digest: the description is another's.
  const auto meta = [&](const std::string& id) {
    return folder.path() / "meta" / id.substr(0, 2) / (id + ".json");
  };
  for (const std::string& id : {twice, digest}) {
    std::filesystem::copy_file(meta(thrice), meta(id),
                               std::filesystem::copy_options::overwrite_existing);
  }
  Service service(folder.path());
  CHECK(service.get("/v1/meshes/" + twice).status == 404);
  CHECK(service.get("/v1/meshes/" + twice + "/distance?from=v:0").status == 404);
  CHECK(service.ask("POST", "/v1/meshes?scale=2", glb).status == 201);
  CHECK(body_of(service.get("/v1/meshes/" + twice))["import"] == json{{"scale", 2}});
  CHECK(distances(service, twice)[0].get<double>() == doctest::Approx(2));
  CHECK(distances(service, thrice)[0].get<double>() == doctest::Approx(3));
  // Read with no options, bytes tell all that there is to tell.
  CHECK(body_of(service.get("/v1/meshes/" + digest))["import"] == json::object());
  CHECK(distances(service, digest)[0].get<double>() == doctest::Approx(1));
}

TEST_CASE("OptionsThatCannotBeAreRefusedNamingTheParameter") {
  const TemporaryFolder folder;
  Service service(folder.path());
  const std::string glb = glb_of(nearly_a_square());
  const auto check = [&](const std::string& parameter, const std::string& value, int status) {
    const HttpResponse response = service.ask("POST", "/v1/meshes?" + parameter + "=" + value, glb);
    CHECK(response.status == status);
    CHECK(body_of(response)["parameter"] == parameter);
  };
  check("weld", "loose", 400);
  check("scene", "", 400);
  check("up", "w", 422);
  check("scale", "0", 422);
  const HttpResponse unknown = service.ask("POST", "/v1/meshes?welding=off", glb);
  CHECK(unknown.status == 400);
  CHECK(body_of(unknown)["code"] == "unknown_parameter");
  const HttpResponse missing = service.ask("POST", "/v1/meshes?node=nobody", glb);
  CHECK(missing.status == 422);
  CHECK(body_of(missing)["parameter"] == "node");
  CHECK(body_of(service.get("/v1/meshes"))["meshes"].empty());
}

TEST_CASE("PutTakesTheDigestOfTheBytesOrTheWholeId") {
  const TemporaryFolder folder;
  Service service(folder.path());
  const std::string glb = glb_of(nearly_a_square());
  const std::string digest = sha256_hex(glb);
  const std::string id = mesh_id(digest, R"({"weld":"off"})");
  const HttpResponse plain = service.ask("PUT", "/v1/meshes/" + digest + "?weld=off", glb);
  CHECK(plain.status == 201);
  CHECK(body_of(plain)["id"] == id);
  CHECK(service.ask("PUT", "/v1/meshes/" + id + "?weld=off", glb).status == 200);
  CHECK(service.ask("PUT", "/v1/meshes/" + id, glb).status == 422);
  CHECK(service.ask("PUT", "/v1/meshes/" + id + "?weld=0.5", glb).status == 422);
}
