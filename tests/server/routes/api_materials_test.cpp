// Faces by the names that their file has for them: whatever names them, a query about them is what
// it is about their numbers.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/test_seed.h"
#include "tests/server/routes/plane_service.h"
#include "tests/server/routes/random_scenes.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

std::string escaped(const std::string& text) {
  std::string url;
  for (const char c : text) {
    char code[4];
    std::snprintf(code, sizeof code, "%%%02X",
                  static_cast<unsigned>(static_cast<unsigned char>(c)));
    url += code;
  }
  return url;
}

// The same faces by name, in a URL and in JSON, and by number.
struct Named {
  std::string text;
  json value;
  std::vector<std::uint32_t> faces;
};

std::string numbers_text(const Named& named) {
  std::string text = "faces:";
  for (const std::uint32_t face : named.faces) text += std::to_string(face) + ",";
  text.pop_back();
  return text;
}

// All that a scene's metadata and its document, by which alone its materials go here, can name.
std::vector<Named> all_names(const json& mesh, const ordered_json& document) {
  std::vector<Named> all{{"material:none", {{"material", nullptr}}, {}},
                         {"material:red", {{"material", "red"}}, {}},
                         {"material:\"\"", {{"material", ""}}, {}}};
  const std::string glass = document["materials"][1]["name"];
  all.push_back({"material:" + glass, {{"material", glass}}, {}});
  for (int i = 0; i < 4; ++i) {
    all.push_back({"material:" + std::to_string(i), {{"material", i}}, {}});
  }
  std::vector<std::string> names;
  for (const json& part : mesh["parts"]) {
    const std::string name = part["name"];
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  for (const std::string& name : names) {
    all.push_back({"part:" + name, {{"part", name}}, {}});
  }
  for (const json& part : mesh["parts"]) {
    const auto& primitive =
        document["meshes"][part["mesh"].get<int>()]["primitives"][part["primitive"].get<int>()];
    const int material = primitive.value("material", -1);
    CHECK(part["material"] == (material < 0 ? json() : json(material)));
    const auto count = part["face_count"].get<std::uint32_t>();
    for (std::uint32_t f = part["first_face"]; count + part["first_face"].get<std::uint32_t>() > f;
         ++f) {
      const auto add = [&](const json& value) {
        for (Named& one : all) {
          if (one.value == value) one.faces.push_back(f);
        }
      };
      add({{"part", part["name"]}});
      if (material < 0) {
        add({{"material", nullptr}});
      } else {
        add({{"material", material}});
        add({{"material", document["materials"][material].value("name", "")}});
      }
    }
  }
  return all;
}

// How many queries were answered.
int check_same_answers(Service& service, const std::string& base, const Named& named) {
  CAPTURE(named.text);
  int answered = 0;
  const auto same = [&](const std::string& path, const std::string& before, const std::string& name,
                        const json& body, const std::string& key, const json& prefix) {
    const std::string start = base + path + before + "&" + name + "=";
    const std::string weight = prefix.is_null() ? "" : "3*";
    const HttpResponse by_name = service.get(start + escaped(weight + named.text));
    json with = body;
    with[key] = prefix.is_null() ? named.value : json{{"weight", prefix}, {"region", named.value}};
    const HttpResponse by_json = service.ask("POST", base + path, with.dump());
    CHECK(by_json.status == by_name.status);
    if (named.faces.empty()) {
      // A weight of no face, and nothing that is forbidden, change nothing.
      if (name == "within" || name == "from") {
        check_problem(by_name, 422, "value_out_of_range", name == "from" ? "from[0]" : name);
      } else {
        CHECK(by_name.status == 200);
      }
      return;
    }
    const HttpResponse by_number = service.get(start + weight + numbers_text(named));
    CHECK(by_name.status == by_number.status);
    if (by_number.status == 200) {
      CHECK(*by_name.body == *by_number.body);
      CHECK(*by_json.body == *by_number.body);
      ++answered;
    } else {
      const json problem = body_of(by_number);
      check_problem(by_name, problem["status"], problem["code"].get<std::string>(),
                    problem.value("parameter", ""));
      CHECK(body_of(by_name)["detail"] == problem["detail"]);
    }
  };
  same("/samples", "?count=3", "within", {{"count", 3}}, "within", nullptr);
  same("/samples", "?count=3", "forbid", {{"count", 3}}, "forbid", nullptr);
  same("/distance", "?method=exact", "from", {{"method", "exact"}}, "from", nullptr);
  same("/distance", "?from=p:0,0,0", "weights", {{"from", "p:0,0,0"}}, "weights", 3);
  return answered;
}

}  // namespace

TEST_CASE("FacesByNameAreThoseByNumber") {
  const std::uint32_t seed = fixtures::test_seed();
  std::mt19937 random(seed);
  int answered = 0;
  for (int round = 0; round < fixtures::all_or(12, 3); ++round) {
    CAPTURE(seed);
    CAPTURE(round);
    const RandomScene scene(random);
    const auto container = static_cast<RandomScene::Container>(round % 3);
    const TemporaryFolder folder;
    std::string base;
    json mesh;
    {
      Service service(folder.path());
      base = "/v1/meshes/" + service.upload(scene.file(container));
      mesh = body_of(service.get(base));
      const std::vector<Named> all = all_names(mesh, scene.document());
      for (const Named& named : all) answered += check_same_answers(service, base, named);
      REQUIRE(mesh["materials"].size() == 4);
      for (std::size_t i = 0; i < 4; ++i) {
        CHECK(mesh["materials"][i]["name"] == scene.document()["materials"][i].value("name", ""));
        CHECK(mesh["materials"][i]["face_count"] == all[4 + i].faces.size());
      }
    }
    // Another service knows nothing but what is stored, and what an older one has stored names no
    // materials.
    for (const bool is_old : {false, true}) {
      if (is_old) {
        const std::string id = mesh["id"];
        json stored = mesh;
        for (const char* key : {"state", "prepared", "materials"}) stored.erase(key);
        for (json& part : stored["parts"]) part.erase("material");
        std::ofstream(folder.path() / "meta" / id.substr(0, 2) / (id + ".json")) << stored.dump();
      }
      Service service(folder.path());
      for (const Named& named : all_names(mesh, scene.document())) {
        answered += check_same_answers(service, base, named);
      }
      CHECK(body_of(service.get(base)).contains("materials") != is_old);
    }
  }
  CHECK(answered > fixtures::all_or(100, 25));
}

TEST_CASE("MaterialsOfAnObjAreThoseOfItsFaces") {
  const TemporaryFolder folder;
  Service service(folder.path());
  // A roof of two faces, a pane of one, a wall of none and a door that nobody says of what.
  const std::string obj =
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\nf 1 2 3\n"
      "usemtl roof tiles\nf 1 3 4\nusemtl glass\nf 2 5 3\nusemtl roof tiles\nf 5 6 3\n";
  const json mesh = body_of(service.ask("POST", "/v1/meshes", obj));
  const std::string base = "/v1/meshes/" + mesh["id"].get<std::string>();
  CHECK(mesh["materials"] == json::array({{{"name", "roof tiles"}, {"face_count", 2}},
                                          {{"name", "glass"}, {"face_count", 1}}}));
  CHECK(mesh["parts"][0]["material"].is_null());
  const auto reached = [&](const std::string& region) {
    return body_of(service.get(base + "/distance?from=v:2&method=exact" + region))["reached"];
  };
  CHECK(reached("") == 6);
  CHECK(reached("&within=material:roof%20tiles") == reached("&within=faces:1,3"));
  CHECK(reached("&forbid=material:glass&forbid=material:none") == reached("&within=faces:1,3"));
  CHECK(reached("&within=material:none") == 3);
  check_problem(service.get(base + "/distance?from=v:2&within=material:gras"), 422,
                "value_out_of_range", "within.material");
  const json problem = body_of(service.get(base + "/distance?from=v:2&within=material:gras"));
  CHECK(problem["detail"] == R"(the mesh has no material "gras"; it has "glass", "roof tiles")");
  check_problem(service.get(base + "/distance?from=v:2&forbid=material:2"), 422,
                "index_out_of_range", "forbid.material");
  check_problem(service.get(base + "/distance?from=material:2"), 422, "index_out_of_range",
                "from[0].material");
  check_problem(service.get(base + "/distance?from=v:2&weights=2*material:tin"), 422,
                "value_out_of_range", "weights[0].material");
  check_problem(service.get(base + "/distance?from=v:2&within=material:"), 400, "bad_syntax",
                "within");
}

TEST_CASE("WhereAFileHasNoMaterialsAllFacesHaveNone") {
  PlaneService plane;
  CHECK(body_of(plane.service.get(plane.base))["materials"] == json::array());
  CHECK(plane.ask("/distance?from=v:0&within=material:none")["reached"] == 120);
  plane.check_refused("/distance?from=v:0&forbid=material:none", 422, "value_out_of_range",
                      "forbid");
  plane.check_refused("/distance?from=v:0&forbid=material:glass", 422, "value_out_of_range",
                      "forbid.material");
  plane.check_same("/distance?from=part:test", R"({"from":{"part":"test"}})");
  plane.check_same("/distance?from=v:0&weights=2*material:none",
                   R"({"from":"v:0","weights":{"weight":2,"region":{"material":null}}})");
}

TEST_CASE("MaterialsAreKnownOnceAndGoWithTheirMesh") {
  const TemporaryFolder folder;
  Service service(folder.path());
  const std::string id =
      service.upload("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 2 4 3\n");
  const auto ask = [&](const std::string& region) {
    return service.get("/v1/meshes/" + id + "/distance?from=v:0&within=" + region).status;
  };
  const auto makes = [&] { return service.catalog.adjacency_cache().makes; };
  const auto before = makes();
  CHECK(ask("material:a") == 200);
  CHECK(makes() == before + 1);  // what is left of the mesh, and nothing else
  CHECK(service.ask("DELETE", "/v1/meshes/" + id).status == 204);
  CHECK(service.catalog.adjacency_cache().entries == 0);
  CHECK(ask("material:a") == 404);
}
