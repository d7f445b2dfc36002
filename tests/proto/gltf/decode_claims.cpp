// Claims of small files that come to gigabytes, and what glTF forbids beyond what reading
// would come upon.
#include <doctest/doctest.h>

#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/bench/processor_time.h"
#include "tests/proto/gltf/honest_file.h"
#include "tests/proto/gltf_file/fixture.h"

using namespace geodesic;
using namespace geodesic::proto;

namespace {

// The most resident memory since the last call, in bytes; 0 where that can't be told.
std::uint64_t peak_memory() {
  std::ifstream status("/proc/self/status");
  std::string word;
  std::uint64_t kilobytes = 0;
  while (status >> word) {
    if (word == "VmHWM:") status >> kilobytes;
  }
  std::ofstream("/proc/self/clear_refs") << 5;
  return kilobytes * 1024;
}

// Nodes that each draw the next one twice.
GltfFixture doubling(int nodes) {
  auto f = one_triangle();
  for (int i = 1; i < nodes; ++i) f.node({{"mesh", 0}});
  for (int i = 0; i + 1 < nodes; ++i) f.document["nodes"][i]["children"] = {i + 1, i + 1};
  return f;
}

}  // namespace

TEST_CASE("a few kilobytes that would be gigabytes are refused soon and in little memory") {
  const double honest_ms = ms_of_honest_file();
  std::vector<std::pair<const char*, Bytes>> files;
  files.emplace_back("nodes", doubling(40).glb());
  files.emplace_back("nodes beyond any number", doubling(60).glb());
  auto vertices = doubling(17);  // 131071 nodes
  vertices.document["accessors"][0] = {{"componentType", 5126},
                                       {"count", 4000},
                                       {"type", "VEC3"},
                                       {"sparse",
                                        {{"count", 1},
                                         {"indices", {{"bufferView", 1}, {"componentType", 5123}}},
                                         {"values", {{"bufferView", 0}}}}}};
  files.emplace_back("vertices", vertices.glb());
  auto instances = one_triangle();
  instances.document["accessors"].push_back(vertices.document["accessors"][0]);
  instances.document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", 2}};
  instances.document["accessors"][2]["count"] = 400'000'000;
  files.emplace_back("instances", instances.glb());
  Bytes draco = bytes_of("DRACO");
  for (const int byte : {2, 2, 1, 0, 0, 0, 0x80, 0xDA, 0xC4, 0x09, 0x80, 0xDA, 0xC4, 0x09}) {
    draco.push_back(static_cast<std::byte>(byte));
  }
  draco.resize(5000);
  files.emplace_back("Draco", draco);
  files.emplace_back("PLY", bytes_of("ply\nformat binary_little_endian 1.0\nelement vertex "
                                     "400000000\nproperty double x\nproperty double y\n"
                                     "property double z\nend_header\n"));
  std::string stl(80, ' ');
  stl += "\xff\xff\xff\x7f";
  files.emplace_back("STL", bytes_of(stl));
  for (const auto& [name, bytes] : files) {
    CAPTURE(name);
    CHECK(bytes.size() <= 6000);
    (void)peak_memory();
    const std::uint64_t before = peak_memory();
    CHECK(bench::processor_ms_of([&] { CHECK_FALSE(decode(bytes).has_value()); }) < honest_ms);
    CHECK(peak_memory() < before + 100'000'000);
  }
}

TEST_CASE("a file in which nothing is drawn is told what else is wrong with it") {
  const auto undrawn = [](const char* pointer, const json& value) {
    auto f = spoiled(pointer, value);
    f.document["nodes"][0].erase("mesh");
    return f;
  };
  check_refused(undrawn("/extras", 1), ErrorCode::no_triangles, "no triangles");
  check_refused(undrawn("/accessors/0/count", 300), invalid, "accessor 0 reaches");
  check_refused(undrawn("/accessors/0/normalized", true), invalid, "accessor 0: only 8 and 16");
  check_refused(undrawn("/bufferViews/0/byteLength", 300), invalid, "bufferView 0 reaches");
  check_refused(undrawn("/bufferViews/1/byteStride", 252), invalid,
                "bufferView 1: its `byteStride`");
  check_refused(undrawn("/accessors/1/componentType", 5122), invalid, "accessor 1 can't hold");
  auto f = undrawn("/extras", 1);
  f.document["meshes"][0]["primitives"][0]["indices"] = f.indices({0, 1, 3});
  check_refused(f, ErrorCode::index_out_of_range, "mesh 0, primitive 0: accessor 2: index 2 is 3");
}

TEST_CASE("the search for what is wrong ends at as many numbers as the largest mesh has") {
  DecodeLimits limits;
  limits.max_vertices = 10;
  limits.max_faces = 10;  // 60 numbers
  const auto of_sparse = [](int sound) {
    auto f = one_triangle();
    f.document["nodes"][0].erase("mesh");
    const auto good = f.view(bytes_of(std::vector<std::uint8_t>{2}));
    const auto bad = f.view(bytes_of(std::vector<std::uint8_t>{9}));
    for (int i = 0; i <= sound; ++i) {
      f.add("accessors",
            {{"componentType", 5126},
             {"count", 3},
             {"type", "VEC3"},
             {"sparse",
              {{"count", 1},
               {"indices", {{"bufferView", i < sound ? good : bad}, {"componentType", 5121}}},
               {"values", {{"bufferView", 0}}}}}});
    }
    return f;
  };
  check_refused(of_sparse(5), invalid, "sparse index 9 is not below", limits);
  check_refused(of_sparse(6), ErrorCode::no_triangles, "no triangles", limits);
  check_refused(of_sparse(6), invalid, "sparse index 9 is not below");
  const auto of_indices = [](int sound) {
    auto f = one_triangle();
    f.document["nodes"][0].erase("mesh");
    json& primitives = f.document["meshes"][0]["primitives"];
    for (int i = 1; i < sound; ++i) primitives.push_back(json(primitives[0]));
    primitives.push_back(GltfFixture::primitive(0, 4, f.indices({0, 1, 3})));
    return f;
  };
  check_refused(of_indices(19), ErrorCode::index_out_of_range, "index 2 is 3", limits);
  check_refused(of_indices(20), ErrorCode::no_triangles, "no triangles", limits);
}

TEST_CASE("a mesh of many primitives that many nodes draw is weighed once") {
  constexpr std::size_t kMany = 50'000;
  auto f = one_triangle();
  const json primitive = GltfFixture::primitive(0);
  const json heavy_node = {{"mesh", 0}};
  const json light_node = {{"mesh", 1}};
  f.document["meshes"][0]["primitives"] = std::vector<json>(kMany, primitive);
  f.mesh({primitive});
  f.document["nodes"] = std::vector<json>(kMany, light_node);
  const Bytes light = f.glb();
  const double light_ms = bench::processor_ms_of([&] { CHECK(decode(light).has_value()); });
  f.document["nodes"] = std::vector<json>(kMany, heavy_node);
  const Bytes heavy = f.glb();
  const double heavy_ms = bench::processor_ms_of(
      [&] { check_refused(heavy, ErrorCode::too_many_vertices, "too many vertices"); });
  CHECK(heavy_ms < 3 * light_ms);
}

TEST_CASE(
    "bounds of positions may be rounded; where they are those of something else, that is said") {
  const auto with = [](const json& min, const json& max) {
    auto f = one_triangle();
    f.document["accessors"][0]["min"] = min;
    f.document["accessors"][0]["max"] = max;
    return f;
  };
  CHECK(decode(with({0, 0, 0}, {1, 1, 0}).glb())->findings.empty());
  CHECK(decode(with({0.001, 0, -0.001}, {1, 1.002, 0}).glb())->findings.empty());
  CHECK(warns_of(decode(with({0, 0, 0}, {1, 1, 0.02}).glb()).value(), "has other positions"));
  CHECK(warns_of(decode(with({-3, 0, 0}, {1, 1, 0}).glb()).value(), "has other positions"));
  check_refused(with({0, 0}, {1, 1, 0}), invalid, "accessor 0: `min` is not an array of 3");
}

TEST_CASE("what glTF forbids of nodes, chunks and targets is refused, naming it") {
  auto f = one_triangle();
  f.document["nodes"][0] = {{"mesh", 0}, {"rotation", {0, 0, 0, 2}}};
  check_refused(f, invalid, "node 0: `rotation`");
  f.document["nodes"][0] = {{"mesh", 0},
                            {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}},
                            {"scale", {1, 1, 1}}};
  check_refused(f, invalid, "node 0 has a `matrix` and parts of one");
  f = one_triangle();
  f.document["meshes"][0]["primitives"].push_back(f.document["meshes"][0]["primitives"][0]);
  f.document["meshes"][0]["primitives"][1]["targets"] = {{{"POSITION", 0}}};
  check_refused(f, invalid, "mesh 0: its primitives have different numbers of morph targets");
  f = one_triangle();
  f.document["accessors"][0].erase("bufferView");
  f.document["accessors"][0]["byteOffset"] = 0;
  check_refused(f, invalid, "accessor 0 has a `byteOffset` but no `bufferView`");
  auto glb = one_triangle().glb();
  append_u32(glb, 4);
  append_u32(glb, 0x4E4F534A);
  append_u32(glb, 0x20202020);
  const auto size = static_cast<std::uint32_t>(glb.size());
  for (std::size_t i = 0; i < 4; ++i) glb[8 + i] = static_cast<std::byte>(size >> (8 * i));
  check_refused(glb, invalid, "chunk 2 is a JSON or BIN chunk");
  glb.pop_back();
  glb[8] = static_cast<std::byte>(size - 1);
  glb[glb.size() - 11] = std::byte{3};
  check_refused(glb, invalid, "chunk 2 has 3 bytes");
}
