// Fields written into the file that was uploaded, read back by another reader of glTF.
#include <doctest/doctest.h>

#include <cstring>
#include <map>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "tests/fixtures/test_seed.h"
#include "tests/server/routes/plane_service.h"
#include "tests/server/routes/random_scenes.h"

#define TINYGLTF_NO_FS
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_USE_CPP14
#include <tiny_gltf.h>

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

// A GLB taken apart; of a .gltf only the JSON.
struct Parts {
  ordered_json document;
  std::string binary;
  std::string others;  // behind the binary chunk, or behind the JSON
};

std::uint32_t u32_at(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

Parts parts_of(const std::string& file) {
  Parts parts;
  if (!file.starts_with("glTF")) {
    parts.document = ordered_json::parse(file);
    return parts;
  }
  REQUIRE(u32_at(file, 8) % 4 == 0);
  REQUIRE(u32_at(file, 8) <= file.size());
  std::size_t at = 12;
  parts.document = ordered_json::parse(file.substr(20, u32_at(file, 12)));
  at += 8 + u32_at(file, 12);
  if (file.substr(at + 4, 4) == std::string("BIN\0", 4)) {
    parts.binary = file.substr(at + 8, u32_at(file, at));
    at += 8 + parts.binary.size();
  }
  parts.others = file.substr(at);
  return parts;
}

// The reader takes no chunk of others where there is no binary one, and no accessor without a view,
// as there are with Draco data.
std::string as_the_reader_takes_it(const std::string& file) {
  Parts parts = parts_of(file);
  for (ordered_json& accessor : parts.document["accessors"]) {
    if (!accessor.contains("bufferView")) accessor["bufferView"] = 0;
  }
  std::string json = parts.document.dump();
  if (!file.starts_with("glTF")) return json;
  json.resize((json.size() + 3) / 4 * 4, ' ');
  std::string glb("glTF\2\0\0\0", 8);
  const auto append = [&](std::size_t value) {
    for (int i = 0; i < 4; ++i) glb += static_cast<char>(value >> (8 * i) & 0xFF);
  };
  append(20 + json.size() + (parts.binary.empty() ? 0 : 8 + parts.binary.size()));
  append(json.size());
  glb += "JSON" + json;
  if (parts.binary.empty()) return glb;
  append(parts.binary.size());
  glb.append("BIN\0", 4);
  return glb + parts.binary;
}

tinygltf::Model model_of(const std::string& whole) {
  const std::string file = as_the_reader_takes_it(whole);
  tinygltf::TinyGLTF reader;
  tinygltf::Model model;
  std::string error;
  std::string warning;
  const bool is_glb = file.starts_with("glTF");
  const bool read =
      is_glb ? reader.LoadBinaryFromMemory(&model, &error, &warning,
                                           reinterpret_cast<const unsigned char*>(file.data()),
                                           u32_at(file, 8))
             : reader.LoadASCIIFromString(&model, &error, &warning, file.data(),
                                          static_cast<unsigned>(file.size()), "");
  CAPTURE(error);
  REQUIRE(read);
  return model;
}

std::vector<float> values_of(const tinygltf::Model& model, int index) {
  const auto& accessor = model.accessors.at(static_cast<std::size_t>(index));
  const auto& view = model.bufferViews.at(static_cast<std::size_t>(accessor.bufferView));
  const auto& bytes = model.buffers.at(static_cast<std::size_t>(view.buffer)).data;
  REQUIRE(accessor.componentType == 5126);
  const auto components = static_cast<std::size_t>(
      tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type)));
  const auto stride = static_cast<std::size_t>(accessor.ByteStride(view));
  REQUIRE(accessor.byteOffset + (accessor.count - 1) * stride + 4 * components <= view.byteLength);
  REQUIRE(view.byteOffset + view.byteLength <= bytes.size());
  std::vector<float> values(accessor.count * components);
  for (std::size_t i = 0; i < accessor.count; ++i) {
    std::memcpy(&values[i * components],
                bytes.data() + view.byteOffset + accessor.byteOffset + i * stride, 4 * components);
  }
  return values;
}

// Of all source vertices, in their order; what points and lines have is NaN.
std::vector<float> read_back(const std::string& file, const std::string& name,
                             std::size_t components, int only_below = -1) {
  const tinygltf::Model model = model_of(file);
  std::vector<float> values;
  std::vector<std::pair<int, bool>> pending;
  const auto push = [&](const std::vector<int>& nodes, bool is_wanted) {
    for (auto it = nodes.rbegin(); it != nodes.rend(); ++it) pending.emplace_back(*it, is_wanted);
  };
  push(model.scenes.at(0).nodes, only_below < 0);
  while (!pending.empty()) {
    const auto [n, was_wanted] = pending.back();
    pending.pop_back();
    const bool is_wanted = was_wanted || n == only_below;
    const auto& node = model.nodes.at(static_cast<std::size_t>(n));
    push(node.children, is_wanted);
    if (node.mesh < 0) continue;
    for (const auto& primitive : model.meshes.at(static_cast<std::size_t>(node.mesh)).primitives) {
      const auto found = primitive.attributes.find(name);
      const bool has_it = found != primitive.attributes.end();
      const int mode = primitive.mode < 0 ? 4 : primitive.mode;
      if (!is_wanted || mode < 4) {
        CHECK_FALSE(has_it);
        if (!is_wanted) continue;
      }
      const auto& position =
          model.accessors.at(static_cast<std::size_t>(primitive.attributes.at("POSITION")));
      if (mode < 4) {
        values.insert(values.end(), components * position.count,
                      std::numeric_limits<float>::quiet_NaN());
        continue;
      }
      REQUIRE(has_it);
      const auto own = values_of(model, found->second);
      CHECK(own.size() == components * position.count);
      values.insert(values.end(), own.begin(), own.end());
    }
  }
  return values;
}

// The document without the attributes, which is to be the one that was uploaded but for meshes
// that were copied at the end.
ordered_json without(ordered_json document, const ordered_json& before,
                     const std::vector<std::string>& names) {
  for (ordered_json& mesh : document["meshes"]) {
    for (ordered_json& primitive : mesh["primitives"]) {
      for (const std::string& name : names) primitive["attributes"].erase(name);
    }
  }
  for (std::size_t n = 0; n < document["nodes"].size(); ++n) {
    ordered_json& node = document["nodes"][n];
    if (!node.contains("mesh") || node["mesh"] == before["nodes"][n]["mesh"]) continue;
    CHECK(document["meshes"][node["mesh"].get<std::size_t>()] ==
          before["meshes"][before["nodes"][n]["mesh"].get<std::size_t>()]);
    node["mesh"] = before["nodes"][n]["mesh"];
  }
  for (const char* array : {"meshes", "accessors", "bufferViews", "buffers"}) {
    REQUIRE(document[array].size() >= before[array].size());
    document[array].erase(document[array].begin() + static_cast<long>(before[array].size()),
                          document[array].end());
  }
  document["buffers"][0]["byteLength"] = before["buffers"][0]["byteLength"];
  return document;
}

void check_all_else_is_as_it_was(const std::string& was, const std::string& is,
                                 const std::vector<std::string>& names) {
  const Parts before = parts_of(was);
  const Parts after = parts_of(is);
  CHECK(without(after.document, before.document, names).dump() == before.document.dump());
  CHECK(after.binary.substr(0, before.binary.size()) == before.binary);
  CHECK(after.others == before.others);
}

std::string floats_as_bytes(const std::vector<float>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(float)};
}

// What a field has in the file where its float is `value`.
float in_file(float value) { return std::isinf(value) ? -1 : value; }

}  // namespace

TEST_CASE("AFieldIsReadBackFromTheFileAndAllElseOfItIsAsItWas") {
  std::mt19937 random(fixtures::test_seed());
  const TemporaryFolder folder;
  Service service(folder.path());
  for (int round = 0; round < 24; ++round) {
    CAPTURE(round);
    const RandomScene scene(random);
    const auto container = static_cast<RandomScene::Container>(round % 3);
    const std::string file = scene.file(container);
    const std::string options = round % 4 == 3   ? "?node=0&scale=2"
                                : round % 4 == 2 ? "?weld=off"
                                                 : "";
    const HttpResponse uploaded = service.ask("POST", "/v1/meshes" + options, file);
    REQUIRE(uploaded.status == 201);
    const json mesh = body_of(uploaded);
    const std::string base = "/v1/meshes/" + mesh["id"].get<std::string>();
    const std::string question = "/distance?from=f:0,0.25,0.25&method=exact&format=";
    const HttpResponse field = service.get(base + question + "f32");
    REQUIRE(field.status == 200);
    const HttpResponse annotated = service.get(base + question + "annotated");
    REQUIRE(annotated.status == 200);
    CHECK(annotated.content_type ==
          (container == RandomScene::Container::gltf ? "model/gltf+json" : "model/gltf-binary"));
    CHECK(header_of(annotated, "Geo-Max") == header_of(field, "Geo-Max"));
    const std::string& now = *annotated.body;
    check_all_else_is_as_it_was(file, now, {"_GEODESIC_DISTANCE"});

    const std::vector<float> expected = numbers_of<float>(field);
    const std::vector<float> got =
        read_back(now, "_GEODESIC_DISTANCE", 1, options.starts_with("?node") ? 0 : -1);
    REQUIRE(got.size() == expected.size());
    for (std::size_t v = 0; v < got.size(); ++v) {
      if (!std::isnan(got[v])) CHECK(got[v] == in_file(expected[v]));
    }
    // Uploaded again, it is the same surface.
    const HttpResponse again = service.ask("POST", "/v1/meshes" + options, now);
    REQUIRE(again.status == 201);
    const std::string second = "/v1/meshes/" + body_of(again)["id"].get<std::string>();
    CHECK(*service.get(second + question + "f32").body == *field.body);
    check_problem(service.get(second + question + "annotated"), 422, "value_out_of_range",
                  "attribute");
    const HttpResponse other = service.get(second + question + "annotated&attribute=_Other_1");
    REQUIRE(other.status == 200);
    check_all_else_is_as_it_was(now, *other.body, {"_Other_1"});
    CHECK(floats_as_bytes(read_back(*other.body, "_GEODESIC_DISTANCE", 1,
                                    options.starts_with("?node") ? 0 : -1)) ==
          floats_as_bytes(got));
  }
}

TEST_CASE("LabelsAreAnAttributeBesideTheDistances") {
  PlaneService plane;
  const std::string before = *plane.service.get(plane.base + "/source").body;
  const std::string question = "/distance?from=v:0&from=v:119&max=4&labels=1";
  const json said = plane.ask(question);
  const HttpResponse reply = plane.service.get(plane.base + question + "&format=annotated");
  REQUIRE(reply.status == 200);
  check_all_else_is_as_it_was(before, *reply.body, {"_GEODESIC_DISTANCE", "_GEODESIC_SOURCE"});
  const auto distances = read_back(*reply.body, "_GEODESIC_DISTANCE", 1);
  const auto labels = read_back(*reply.body, "_GEODESIC_SOURCE", 1);
  REQUIRE(distances.size() == 120);
  REQUIRE(labels.size() == 120);
  int unreached = 0;
  for (std::size_t v = 0; v < 120; ++v) {
    if (said["labels"][v].is_null()) {
      ++unreached;
      CHECK(labels[v] == -1);
      CHECK(distances[v] == -1);
    } else {
      CHECK(labels[v] == said["labels"][v].get<float>());
      CHECK(distances[v] == said["distances"][v].get<float>());
    }
  }
  CHECK(unreached > 0);
  const HttpResponse named = plane.service.get(plane.base + question +
                                               "&format=annotated&attribute=_A&label_attribute=_B");
  REQUIRE(named.status == 200);
  CHECK(floats_as_bytes(read_back(*named.body, "_A", 1)) == floats_as_bytes(distances));
  CHECK(floats_as_bytes(read_back(*named.body, "_B", 1)) == floats_as_bytes(labels));
}

TEST_CASE("ACarriedDirectionIsAnAttributeBesideTheMap") {
  PlaneService plane;
  const std::string before = *plane.service.get(plane.base + "/source").body;
  const std::string asked = "/logmap?from=v:53&radius=3&transport=1";
  const json map = plane.ask(asked);
  const HttpResponse reply = plane.service.get(plane.base + asked + "&format=annotated");
  REQUIRE(reply.status == 200);
  check_all_else_is_as_it_was(before, *reply.body, {"_GEODESIC_LOGMAP", "_GEODESIC_DIRECTION"});
  CHECK(read_back(*reply.body, "_GEODESIC_LOGMAP", 3).size() == 360);
  const auto values = read_back(*reply.body, "_GEODESIC_DIRECTION", 3);
  REQUIRE(values.size() == 360);
  std::size_t placed = 0;
  for (std::size_t v = 0; v < 120; ++v) {
    const bool has_place = placed < map["vertices"].size() && map["vertices"][placed] == v;
    for (std::size_t k = 0; k < 3; ++k) {
      CHECK(values[3 * v + k] == (has_place ? map["directions"][placed][k].get<float>() : 0.0F));
    }
    if (has_place) ++placed;
  }
  CHECK(placed == map["vertices"].size());
  plane.check_refused(asked + "&format=annotated&attribute=_GEODESIC_DIRECTION", 422,
                      "value_out_of_range", "attribute");
}

TEST_CASE("AMapIsAnAttributeOfThreeFloats") {
  PlaneService plane;
  const std::string before = *plane.service.get(plane.base + "/source").body;
  const json map = plane.ask("/logmap?from=v:53&radius=3");
  const HttpResponse reply =
      plane.service.get(plane.base + "/logmap?from=v:53&radius=3&format=annotated");
  REQUIRE(reply.status == 200);
  check_all_else_is_as_it_was(before, *reply.body, {"_GEODESIC_LOGMAP"});
  const auto values = read_back(*reply.body, "_GEODESIC_LOGMAP", 3);
  REQUIRE(values.size() == 360);
  std::size_t placed = 0;
  for (std::size_t v = 0; v < 120; ++v) {
    if (placed < map["vertices"].size() && map["vertices"][placed] == v) {
      CHECK(values[3 * v] == map["coordinates"][placed][0].get<float>());
      CHECK(values[3 * v + 1] == map["coordinates"][placed][1].get<float>());
      CHECK(values[3 * v + 2] == map["distances"][placed].get<float>());
      ++placed;
    } else {
      CHECK(values[3 * v] == 0);
      CHECK(values[3 * v + 1] == 0);
      CHECK(values[3 * v + 2] == -1);
    }
  }
  CHECK(placed == map["vertices"].size());
  CHECK(placed > 20);
}

// Draco orders vertices anew. Held against the plane, where distances are known.
TEST_CASE("ValuesBesideDracoDataAreInTheOrderOfItsVertices") {
  const TemporaryFolder folder;
  Service service(folder.path());
  const auto drc = proto::encode_drc(shapes::plane(7, 5), 0).value();
  const auto decoded = proto::decode_draco(drc, {1000, 1000}).value();
  const std::string bytes(reinterpret_cast<const char*>(drc.data()), drc.size());
  ordered_json document = ordered_json::parse(R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],
    "extensionsRequired":["KHR_draco_mesh_compression"],
    "accessors":[{"componentType":5126,"count":35,"type":"VEC3"}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0},"extensions":{
      "KHR_draco_mesh_compression":{"bufferView":0,"attributes":{"POSITION":0}}}}]}],
    "buffers":[{"byteLength":1}],"bufferViews":[{"buffer":0,"byteLength":1}],
    "scenes":[{"nodes":[0]}]})");
  document["buffers"][0]["byteLength"] = bytes.size();
  document["bufferViews"][0]["byteLength"] = bytes.size();
  std::string text = document.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  std::string padded = bytes;
  padded.resize((padded.size() + 3) / 4 * 4);
  std::string glb("glTF\2\0\0\0", 8);
  const auto append = [&](std::size_t value) {
    for (int i = 0; i < 4; ++i) glb += static_cast<char>(value >> (8 * i) & 0xFF);
  };
  append(28 + text.size() + padded.size());
  append(text.size());
  glb += "JSON" + text;
  append(padded.size());
  glb.append("BIN\0", 4);
  glb += padded;
  const std::string base = "/v1/meshes/" + service.upload(glb);
  const HttpResponse reply = service.get(base + "/distance?from=v:3&method=exact&format=annotated");
  REQUIRE(reply.status == 200);
  const auto values = read_back(*reply.body, "_GEODESIC_DISTANCE", 1);
  REQUIRE(values.size() == decoded.positions.size());
  for (std::size_t v = 0; v < values.size(); ++v) {
    CHECK(static_cast<double>(values[v]) ==
          doctest::Approx(distance(decoded.positions[v], decoded.positions[3])));
  }
}

TEST_CASE("NodesThatShareAMeshGetOneEach") {
  const TemporaryFolder folder;
  Service service(folder.path());
  const std::string text =
      R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0,1]}],
      "nodes":[{"mesh":0},{"mesh":0,"translation":[1,0,0]},{"mesh":0}],
      "meshes":[{"name":"m","primitives":[{"attributes":{"POSITION":0}}]}],
      "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
      "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,
      "uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})";
  const auto document_at = [&](const std::string& options) {
    const HttpResponse uploaded = service.ask("POST", "/v1/meshes" + options, text);
    REQUIRE(uploaded.status == 201);
    const HttpResponse reply =
        service.get("/v1/meshes/" + body_of(uploaded)["id"].get<std::string>() +
                    "/distance?from=v:0&format=annotated");
    REQUIRE(reply.status == 200);
    return ordered_json::parse(*reply.body);
  };
  // The third node is in no scene, so it keeps the mesh as it was.
  const ordered_json both = document_at("");
  REQUIRE(both["meshes"].size() == 3);
  CHECK(both["nodes"][0]["mesh"] == 1);
  CHECK(both["nodes"][1]["mesh"] == 2);
  CHECK(both["nodes"][2]["mesh"] == 0);
  CHECK_FALSE(both["meshes"][0]["primitives"][0]["attributes"].contains("_GEODESIC_DISTANCE"));
  CHECK(both["meshes"][1]["name"] == "m");
  const ordered_json one = document_at("?node=1");
  REQUIRE(one["meshes"].size() == 2);
  CHECK(one["nodes"][0]["mesh"] == 0);
  CHECK(one["nodes"][1]["mesh"] == 1);
}

TEST_CASE("TheMemoryForAnAnnotatedFileIsAskedForAndGivenBack") {
  Config config;
  config.reply_memory_bytes = 4000;
  config.reply_cache_bytes = 0;
  PlaneService small(config);
  REQUIRE(small.service.get(small.base + "/distance?from=v:0&format=f32").status == 200);
  check_problem(small.service.get(small.base + "/distance?from=v:0&format=annotated"), 422,
                "too_much_memory");
  PlaneService plane;
  {
    const HttpResponse reply =
        plane.service.get(plane.base + "/distance?from=v:0&format=annotated");
    REQUIRE(reply.status == 200);
  }
  CHECK(body_of(plane.service.get("/v1/status"))["replies"]["bytes"] == 0);
}

TEST_CASE("AFileThatCouldNotBeUploadedAgainIsRefused") {
  const TemporaryFolder folder;
  const std::string glb = glb_of(shapes::plane(40, 40));
  Config config;
  config.max_body_bytes = glb.size() + 100;
  Service narrow(folder.path(), config);
  const std::string path = "/v1/meshes/" + narrow.upload(glb) + "/distance?from=v:0&format=";
  CHECK(narrow.get(path + "f32").status == 200);
  const HttpResponse refused = narrow.get(path + "annotated");
  check_problem(refused, 406, "not_acceptable", "format");
  CHECK(body_of(refused)["limit"] == config.max_body_bytes);
}

TEST_CASE("DistancesOfPointsAreNoneOfTheFilesVertices") {
  PlaneService plane;
  for (const char* more : {"", "&labels=1"}) {
    plane.check_refused(std::string("/distance?from=v:0&format=annotated&at=v:1") + more, 406,
                        "not_acceptable", "format");
  }
}

TEST_CASE("WhereAnimationsNameMeshesNoneIsCopied") {
  const TemporaryFolder folder;
  Service service(folder.path());
  for (const bool is_shared : {true, false}) {
    CAPTURE(is_shared);
    const std::string id = service.upload(
        R"({"asset":{"version":"2.0"},"extensionsUsed":["KHR_animation_pointer"],"scenes":[{"nodes":[0,1]}],
      "nodes":[{"mesh":0},{)" +
        std::string(is_shared ? R"("mesh":0,)" : "") + R"("translation":[1,0,0]}],
      "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
      "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
      "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,
      "uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})");
    const HttpResponse reply =
        service.get("/v1/meshes/" + id + "/distance?from=v:0&format=annotated");
    if (is_shared) {
      check_problem(reply, 406, "not_acceptable", "format");
    } else {
      CHECK(reply.status == 200);
    }
  }
}

TEST_CASE("WhatCannotBeAnnotatedIsRefused") {
  PlaneService plane;
  plane.check_refused("/distance?from=v:0&at=v:1&format=annotated", 406, "not_acceptable",
                      "format");
  plane.check_refused("/path?from=v:0&to=v:1&format=annotated", 406, "not_acceptable", "format");
  for (const std::string name : {"POSITION", "_", "_a-b", "_%C3%A9", "TEXCOORD_0", ""}) {
    plane.check_refused("/distance?from=v:0&format=annotated&attribute=" + name, 422,
                        "value_out_of_range", "attribute");
  }
  plane.check_refused("/distance?from=v:0&format=annotated&attribute=_" + std::string(64, 'a'), 422,
                      "value_out_of_range", "attribute");
  plane.check_refused(
      "/distance?from=v:0&format=annotated&labels=1&attribute=_A&label_attribute=_A", 422,
      "value_out_of_range", "label_attribute");
  plane.check_refused("/distance?from=v:0&format=f32&attribute=_A", 400, "unknown_parameter",
                      "attribute");
  plane.check_refused("/distance?from=v:0&format=annotated&label_attribute=_A", 400,
                      "unknown_parameter", "label_attribute");
  const std::string obj = plane.service.upload("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  const HttpResponse of_obj =
      plane.service.get("/v1/meshes/" + obj + "/distance?from=v:0&format=annotated");
  check_problem(of_obj, 406, "not_acceptable", "format");
  CHECK(body_of(of_obj)["detail"].get<std::string>().find("format=glb") != std::string::npos);
  check_problem(plane.service.get("/v1/meshes/" + std::string(64, '0') +
                                  "/distance?from=v:0&format=annotated"),
                404, "mesh_unknown");
  // One node that is there twice has one mesh.
  const std::string twice = plane.service.upload(
      R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0,1]}],
      "nodes":[{"children":[2]},{"children":[2],"translation":[1,0,0]},{"mesh":0}],
      "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
      "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
      "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,
      "uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})");
  check_problem(plane.service.get("/v1/meshes/" + twice + "/distance?from=v:0&format=annotated"),
                406, "not_acceptable", "format");
  // By POST it is the same file.
  plane.check_same("/distance?from=v:0&labels=1&format=annotated&attribute=_A&label_attribute=_B",
                   R"({"from":"v:0","labels":true,"format":"annotated","attribute":"_A",
                       "label_attribute":"_B"})");
}
