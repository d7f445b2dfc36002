// What a file says of itself is told again in bounds: whatever names, parts and findings it has,
// the description of its mesh stays small, and so does any reply that has it.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <fstream>
#include <functional>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "proto/mesh/decoded_mesh.h"
#include "proto/mesh/metadata.h"
#include "proto/wire/cut_to.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/test_seed.h"
#include "tests/proto/gltf_file/fixture.h"
#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

constexpr std::size_t kMost = proto::kMostDescriptionBytes + 100;  // and its state

struct Case {
  std::string what;
  std::string file;
  std::uint64_t parts = 1;
};

std::string text_of(const proto::Bytes& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// One triangle, drawn by whatever the test makes of its document.
proto::GltfFixture triangle() {
  proto::GltfFixture f;
  f.mesh({proto::GltfFixture::primitive(f.positions({0, 0, 0, 3, 0, 0, 0, 4, 0}))});
  f.node({{"mesh", 0}});
  return f;
}

std::string drawn(proto::GltfFixture f, std::size_t times) {
  f.document["scenes"] = {{{"nodes", std::vector<int>(times, 0)}}};
  f.document["scene"] = 0;
  return text_of(f.glb());
}

std::string nodes_of(const std::string& name, int count) {
  proto::GltfFixture f = triangle();
  f.document["nodes"] = json::array();
  std::vector<int> numbers;
  for (int i = 0; i < count; ++i) {
    numbers.push_back(i);
    f.node({{"mesh", 0}, {"name", std::to_string(i) + name}, {"skin", 0}});
  }
  f.document["scenes"] = {{{"nodes", numbers}}};
  f.document["scene"] = 0;
  return text_of(f.glb());
}

const std::string kTriangleObj = "v 0 0 0\nv 3 0 0\nv 0 4 0\nf 1 2 3\n";

proto::GltfFixture mesh_called(const std::string& name) {
  proto::GltfFixture f = triangle();
  f.document["meshes"][0]["name"] = name;
  return f;
}

using Maker = std::function<Case()>;

// Every way to say much that a file has. Each is made when it is its turn: with a sanitizer that
// takes seconds.
std::vector<Maker> wordy_files() {
  std::vector<Maker> cases;
  const auto add = [&](std::string what, std::function<std::string()> file,
                       std::uint64_t parts = 1) {
    cases.push_back([=] { return Case{what, file(), parts}; });
  };
  add(
      "one node many times", [] { return drawn(triangle(), 200'000); }, 200'000);
  add(
      "many primitives",
      [] {
        proto::GltfFixture f = triangle();
        f.document["meshes"][0]["primitives"] =
            json(std::vector<json>(30'000, f.document["meshes"][0]["primitives"][0]));
        return drawn(f, 3);
      },
      90'000);
  add(
      "a long name many times",
      [] {
        proto::GltfFixture f = triangle();
        f.document["nodes"][0]["name"] = std::string(3'000'000, 'n');
        return drawn(f, 20'000);
      },
      20'000);
  add(
      "a long name of a mesh",
      [] { return drawn(mesh_called(std::string(3'000'000, '\x01')), 20'000); }, 20'000);
  add(
      "names that grow sixfold", [] { return nodes_of(std::string(190, '\x01'), 12'000); }, 12'000);
  add(
      "long names that all have numbers", [] { return nodes_of(std::string(190, '\x01'), 9'000); },
      9'000);
  add(
      "many names", [] { return nodes_of(std::string(60, 'n'), 12'000); }, 12'000);
  add("a cut within a character", [] {
    std::string umlauts;
    for (int i = 0; i < 100'000; ++i) umlauts += "ä";
    return drawn(mesh_called("a" + umlauts), 1);
  });
  add("an object's name", [] { return "o " + std::string(5'000'000, 'o') + "\n" + kTriangleObj; });
  add("a name that is no UTF-8",
      [] { return "o " + std::string(5'000'000, '\xbf') + "\n" + kTriangleObj; });
  add("much that is left out", [] {
    std::string lines = kTriangleObj;
    for (int i = 0; i < 100'000; ++i) lines += "l 1 2\ncurv 0 1 1 2\n";
    return lines;
  });
  add("a solid's name", [] {
    return "solid " + std::string(5'000'000, 's') +
           "\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n"
           "vertex 3 0 0\nvertex 0 4 0\nendloop\nendfacet\nendsolid\n";
  });
  return cases;
}

}  // namespace

TEST_CASE("AnyMeshIsDescribedInBounds") {
  const std::uint32_t seed = fixtures::test_seed();
  CAPTURE(seed);
  std::mt19937 random(seed);
  const TemporaryFolder folder;
  Service service(folder.path());
  std::vector<Maker> files = wordy_files();
  std::shuffle(files.begin(), files.end(), random);
  files.resize(fixtures::all_or<std::size_t>(files.size(), 1));
  for (const Maker& make : files) {
    const Case one = make();
    CAPTURE(one.what);
    const HttpResponse sent = service.ask("POST", "/v1/meshes", one.file);
    REQUIRE(sent.status == 201);
    CHECK(sent.body->size() < kMost);
    const json mesh = body_of(sent);
    CHECK(mesh["faces"] == one.parts);
    const std::size_t listed = mesh["parts"].size();
    CHECK(listed <= 10'000);
    CHECK(listed >= std::min<std::size_t>(one.parts, 1000));
    CHECK(mesh["parts"][listed - 1]["first_face"] == listed - 1);
    for (const json& part : mesh["parts"]) {
      CHECK(part["name"].get<std::string>().size() <= 3 * 200);  // no UTF-8: three bytes for one
    }
    // What is missing is said, and nothing is said where nothing is.
    CHECK(mesh.value("parts_total", listed) == one.parts);
    CHECK(mesh.contains("parts_total") == (listed < one.parts));
    bool is_found = false;
    for (const json& finding : mesh["report"]) {
      if (finding["code"] != "parts_not_listed") continue;
      is_found = true;
      CHECK(finding["count"] == one.parts - listed);
    }
    CHECK(is_found == (listed < one.parts));

    const std::string target = "/v1/meshes/" + mesh["id"].get<std::string>();
    const HttpResponse read = service.get(target);
    CHECK(*read.body == *sent.body);
    CHECK(static_cast<bool>(read.reserved) == (read.body->size() > (64U << 10)));
    const std::string tag = header_of(read, "ETag");
    const HttpResponse same = service.ask("GET", target, {}, {{"If-None-Match", tag}});
    CHECK(same.status == 304);
    CHECK_FALSE(same.body);
    CHECK(service.get(target + "/distance?from=v:0&at=v:1").status == 200);

    // All of the first 10,000 have numbers, listed or not; they have one face each.
    const std::size_t numbered = std::min<std::size_t>(one.parts, 10'000);
    const std::string query = target + "/nearest?point=p:1,1,0&within=";
    for (const std::size_t place : {std::size_t{0}, listed - 1, std::min(listed, numbered - 1),
                                    random() % numbered, numbered - 1}) {
      CAPTURE(place);
      const HttpResponse by_part = service.get(query + "part:" + std::to_string(place));
      CAPTURE(*by_part.body);
      REQUIRE(by_part.status == 200);
      CHECK(body_of(by_part)["points"][0]["face"] == place);
    }
    check_problem(service.get(query + "part:" + std::to_string(numbered)), 422,
                  "index_out_of_range", "within.part");
    // And names, unless there are more.
    const HttpResponse no_such = service.get(query + "part:nobody");
    if (one.parts > numbered) {
      check_problem(no_such, 413, "too_large", "within.part");
      CHECK(body_of(no_such)["limit"] == numbered);
      CHECK(body_of(no_such)["actual"] == one.parts);
    } else {
      check_problem(no_such, 422, "value_out_of_range", "within.part");
    }
  }
}

// However many materials there are and whatever they are called, the first ones can be asked for by
// number, listed or not. By name nobody can, for others may have it, too.
TEST_CASE("MaterialsAreDescribedInBounds") {
  const TemporaryFolder folder;
  Service service(folder.path());
  constexpr int kMaterials = 12'000;
  std::mt19937 random(fixtures::test_seed());
  std::vector<std::string> files;
  std::vector<std::string> names{"m", std::string(190, '\x01'), std::string(190, 'n')};
  std::shuffle(names.begin(), names.end(), random);
  names.resize(fixtures::all_or<std::size_t>(names.size(), 1));
  for (const std::string& name : names) {
    proto::GltfFixture f = triangle();
    const json primitive = f.document["meshes"][0]["primitives"][0];
    std::string obj = "v 0 0 0\nv 3 0 0\nv 0 4 0\n";
    f.document["meshes"][0]["primitives"] = json::array();
    for (int i = 0; i < kMaterials; ++i) {
      f.document["materials"].push_back({{"name", std::to_string(i) + name}});
      f.document["meshes"][0]["primitives"].push_back(primitive);
      f.document["meshes"][0]["primitives"].back()["material"] = i;
      obj += "usemtl " + std::to_string(i) + name + "\nf 1 2 3\n";
    }
    files.push_back(drawn(f, 1));
    files.push_back(obj);
    files.push_back("usemtl " + std::string(3'000'000, 'n') + "\n" + obj);
  }
  std::shuffle(files.begin(), files.end(), random);
  files.resize(fixtures::all_or<std::size_t>(files.size(), 1));
  for (const std::string& file : files) {
    const HttpResponse sent = service.ask("POST", "/v1/meshes", file);
    REQUIRE(sent.status == 201);
    CHECK(sent.body->size() < kMost);
    const json mesh = body_of(sent);
    const std::size_t listed = mesh["materials"].size();
    CHECK(listed > 150);
    CHECK(listed <= proto::kMostMaterials);
    std::size_t faces = 0;
    for (const json& material : mesh["materials"]) {
      CHECK(material["name"].get<std::string>().size() <= proto::kMostNameBytes);
      faces += material["face_count"].get<std::size_t>();
    }
    const json& report = mesh["report"];
    const auto missing = std::find_if(report.begin(), report.end(), [](const json& finding) {
      return finding["code"] == "materials_not_listed";
    });
    REQUIRE(missing != report.end());
    CHECK((*missing)["count"] == kMaterials - faces);
    const std::string query = "/v1/meshes/" + mesh["id"].get<std::string>() + "/distance?from=v:0";
    const std::string name = mesh["materials"][listed - 1]["name"];
    const json by_json =
        body_of(service.ask("POST", query.substr(0, query.find('?')),
                            json{{"from", "v:0"}, {"within", {{"material", name}}}}.dump()));
    CHECK(by_json["code"] == "too_large");
    CHECK(by_json["parameter"] == "within.material");
    CHECK(by_json["limit"] == proto::kMostMaterials);
    CHECK(by_json["actual"].get<int>() > 10'000);
    CHECK(by_json["actual"].get<int>() <= kMaterials + 1);  // an OBJ's last line may have no faces
    CHECK(service.get(query + "&within=material:9999").status == 200);
    check_problem(service.get(query + "&within=material:10000"), 422, "index_out_of_range",
                  "within.material");
  }
}

TEST_CASE("APageOfMeshesEndsWhereItIsLong") {
  const TemporaryFolder folder;
  Service service(folder.path());
  std::set<std::string> all;
  for (int i = 0; i < 5; ++i) {
    all.insert(service.upload(nodes_of(std::string(60 + i, 'n'), 5000)));
    all.insert(service.upload(glb_of(shapes::plane(3 + i, 3))));
  }
  std::set<std::string> seen;
  std::size_t pages = 0;
  std::string target = "/v1/meshes";
  while (!target.empty()) {
    const HttpResponse reply = service.get(target);
    REQUIRE(reply.status == 200);
    CHECK(reply.body->size() < kMost + (1U << 20));
    const json page = body_of(reply);
    CHECK(!page["meshes"].empty());
    for (const json& mesh : page["meshes"]) CHECK(seen.insert(mesh["id"]).second);
    target = page["next"].is_null() ? "" : "/v1/meshes?cursor=" + page["next"].get<std::string>();
    REQUIRE(++pages <= all.size());
  }
  CHECK(seen == all);
  CHECK(pages > 1);
}

TEST_CASE("WhatWasDescribedWithoutBoundsIsDescribedAnew") {
  for (const std::string options : {"", "?scale=2"}) {
    CAPTURE(options);
    const TemporaryFolder folder;
    std::string id;
    json before;
    {
      Service service(folder.path());
      before = body_of(service.ask("POST", "/v1/meshes" + options, glb_of(shapes::plane(4, 4))));
      id = before["id"];
    }
    json stored = before;
    stored.erase("state");
    stored.erase("prepared");
    stored["parts"] = std::vector<json>(30'000, before["parts"][0]);
    const auto path = folder.path() / "meta" / id.substr(0, 2) / (id + ".json");
    std::ofstream(path) << stored.dump();
    Service service(folder.path());
    const HttpResponse reply = service.get("/v1/meshes/" + id);
    REQUIRE(reply.status == 200);
    CHECK(reply.body->size() < kMost);
    const json after = body_of(reply);
    CHECK(after["import"] == before["import"]);
    CHECK(after["area"] == before["area"]);
    // Without options all is known again; with options, how many parts there were.
    if (options.empty()) {
      CHECK(after["parts"] == before["parts"]);
    } else {
      CHECK(after["parts_total"] == 30'000);
    }
    CHECK(std::filesystem::file_size(path) < kMost);
    CHECK(service.get("/v1/meshes/" + id + "/distance?from=v:0").status == 200);
  }
}

TEST_CASE("ARefusalRepeatsLittleOfWhatItRefuses") {
  PlaneService plane;
  const std::string word(1'000'000, 'w');
  proto::GltfFixture f = triangle();
  f.document["extensionsRequired"] = {word};
  f.document["extensionsUsed"] = {word};
  const std::vector<HttpResponse> refusals{
      plane.service.ask("POST", "/v1/meshes", drawn(f, 1)),
      plane.service.ask("POST", "/v1/meshes", "ply\nformat " + word + "\n"),
      plane.service.ask("POST", "/v1/meshes", kTriangleObj + "f " + word + " 1 2\n"),
      plane.service.ask("POST", plane.base + "/distance", R"({"from":"v:0",")" + word + "\":1}"),
      plane.service.ask("POST", plane.base + "/distance", R"({"from":")" + word + "\"}"),
      plane.service.ask("POST", plane.base + "/distance", R"({"from":{")" + word + "\":1}}"),
      plane.service.ask("POST", plane.base + "/distance",
                        R"({"from":"v:0","method":")" + word + "\"}")};
  for (const HttpResponse& refusal : refusals) {
    CAPTURE(refusal.body->substr(0, 300));
    CHECK(refusal.status >= 400);
    CHECK(refusal.body->size() < 4000);
    CHECK(body_of(refusal)["detail"].is_string());
  }
}

TEST_CASE("ATextIsShortenedBetweenCharacters") {
  using proto::cut_to;
  CHECK(cut_to("abc", 3) == "abc");
  CHECK(cut_to("abcd", 3) == "…");
  CHECK(cut_to("abcdef", 5) == "ab…");
  CHECK(cut_to("aäöü", 6) == "aä…");
  CHECK(cut_to("aäöüa", 7) == "aä…");
  CHECK(cut_to(std::string(20, '\x80'), 10).size() <= 10);  // no UTF-8
}
