// The options of an upload: how they are read and written down, and what they do.
#include "proto/wire/import_options.h"

#include <doctest/doctest.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "proto/encode/encode_mesh.h"
#include "proto/mesh/mesh_findings.h"
#include "proto/mesh/metadata.h"
#include "proto/wire/input_codes.h"
#include "tests/proto/gltf_file/fixture.h"

using namespace geodesic;
using namespace geodesic::proto;

namespace {

using Query = std::vector<std::pair<std::string, std::string>>;

Result<ImportOptions> read(const Query& query) {
  auto parameters = Parameters::from_query(query);
  return read_import_options(parameters);
}

std::string canonical(const Query& query) {
  const auto options = read(query);
  if (!options) FAIL(options.error().detail);
  return canonical_text(*options);
}

// Two scenes: in the first node 0 has children 1 and 2, in the second 3 alone.
GltfFixture two_scenes() {
  GltfFixture f;
  f.mesh({GltfFixture::primitive(f.positions({0, 0, 0, 1, 0, 0, 0, 1, 0}))});
  f.node({{"name", "root"}, {"children", {1, 2}}, {"translation", {10, 0, 0}}});
  f.node({{"name", "left"}, {"mesh", 0}});
  f.node({{"name", "right"}, {"mesh", 0}, {"translation", {0, 5, 0}}});
  f.node({{"name", "other"}, {"mesh", 0}, {"translation", {0, 0, 7}}});
  f.document["scenes"] = {{{"name", "main"}, {"nodes", {0}}}, {{"name", "2"}, {"nodes", {3}}}};
  f.document["scene"] = 0;
  return f;
}

Result<DecodedMesh> with(const GltfFixture& f, const Query& query) {
  return decode_mesh(f.glb(), DecodeLimits{}, read(query).value());
}

std::vector<MeshFinding> examined(const TriangleSoup& soup) {
  auto mesh = Mesh::build(soup);
  REQUIRE(mesh);
  return examine(Adjacency::build(std::make_shared<const Mesh>(std::move(*mesh))));
}

const MeshFinding& of_code(const std::vector<MeshFinding>& findings, const std::string& code) {
  for (const MeshFinding& finding : findings) {
    if (finding.code == code) return finding;
  }
  FAIL("no finding " << code);
  return findings.front();
}

std::vector<std::vector<std::uint32_t>> numbers_of(const MeshFinding& finding) {
  std::vector<std::vector<std::uint32_t>> numbers;
  for (const MeshExample& example : finding.examples) numbers.push_back(example.numbers);
  return numbers;
}

using Numbers = std::vector<std::vector<std::uint32_t>>;

}  // namespace

TEST_CASE("options that say the same have the same text, and defaults have none") {
  CHECK(canonical({}).empty());
  CHECK(canonical({{"weld", "0"}, {"up", "y"}, {"scale", "1.0"}}).empty());
  CHECK(canonical({{"scale", "1e-3"}, {"weld", "0.010"}}) == R"({"scale":0.001,"weld":"0.01"})");
  CHECK(canonical({{"weld", "1e-2"}, {"scale", "0.0010"}}) == R"({"scale":0.001,"weld":"0.01"})");
  CHECK(canonical({{"scene", "01"}}) == canonical({{"scene", "1"}}));
  CHECK(canonical({{"node", "a\"b\u00e9"}, {"scene", "x"}, {"up", "z"}, {"weld", "off"}}) ==
        "{\"node\":\"a\\\"b\u00e9\",\"scene\":\"x\",\"up\":\"z\",\"weld\":\"off\"}");
}

TEST_CASE("the text gives the options back") {
  for (const Query& query :
       {Query{{"scene", "3"}, {"node", "a~b"}, {"weld", "off"}, {"up", "x"}, {"scale", "25.4"}},
        Query{{"weld", "1e-7"}}, Query{{"node", "\u00fc"}}}) {
    const auto options = read(query);
    REQUIRE(options);
    auto parameters = Parameters::from_json(canonical_text(*options));
    REQUIRE(parameters);
    CHECK(read_import_options(*parameters).value() == *options);
  }
}

TEST_CASE("options that can't be are refused, naming the parameter") {
  const auto check = [](const Query& all, ErrorCode code) {
    for (const auto& [name, value] : all) {
      CAPTURE(name);
      CAPTURE(value);
      const auto options = read({{name, value}});
      REQUIRE_FALSE(options);
      CHECK(options.error().code == code);
      CHECK(options.error().parameter == name);
    }
  };
  check({{"scene", ""},
         {"node", ""},
         {"node", "\xff"},
         {"weld", "on"},
         {"weld", "nan"},
         {"weld", ""},
         {"scale", "big"},
         {"scale", "inf"},
         {"scene", std::string(600, 'a')}},
        InputCode::bad_syntax);
  check({{"weld", "-1"},
         {"weld", "1e99"},
         {"weld", "1e-99"},
         {"up", "Z"},
         {"up", "-y"},
         {"scale", "0"},
         {"scale", "-1"},
         {"scale", "1e99"}},
        ErrorCode::value_out_of_range);
  CHECK_FALSE(read({{"up", "y"}, {"up", "z"}}));
}

TEST_CASE("a length or a factor out of bounds is told its bounds, and those are true") {
  struct Bounds {
    const char* name;
    const char* least;
    const char* most;
    std::vector<const char*> beyond;
  };
  for (const Bounds& one :
       {Bounds{"weld", "1e-60", "1e60", {"1e-300", "9e-61", "1.1e60", "-1e-60"}},
        Bounds{"scale", "1e-30", "1e30", {"1e-300", "9e-31", "1.1e30", "-1", "0"}}}) {
    CAPTURE(one.name);
    CHECK(read({{one.name, one.least}}));
    CHECK(read({{one.name, one.most}}));
    for (const char* const value : one.beyond) {
      CAPTURE(value);
      const auto refused = read({{one.name, value}});
      REQUIRE_FALSE(refused);
      CHECK(refused.error().code == ErrorCode::value_out_of_range);
      CHECK(refused.error().detail.find(one.least) != std::string::npos);
      CHECK(refused.error().detail.find(one.most) != std::string::npos);
    }
  }
  CHECK(read({{"weld", "0"}}));
  CHECK(read({{"weld", "-0"}}));
}

TEST_CASE("a scene is chosen by index or name, a name of digits by index alone") {
  const auto f = two_scenes();
  CHECK(with(f, {})->soup.faces.size() == 2);
  CHECK(with(f, {{"scene", "0"}})->soup.faces.size() == 2);
  CHECK(with(f, {{"scene", "main"}})->soup.faces.size() == 2);
  CHECK(with(f, {{"scene", "1"}})->soup.positions[0] == Vec3{0, 0, 7});
  for (const char* scene : {"2", "third"}) {
    const auto missing = with(f, {{"scene", scene}});
    REQUIRE_FALSE(missing);
    CHECK(missing.error().code == ErrorCode::value_out_of_range);
    CHECK(missing.error().parameter == "scene");
  }
}

TEST_CASE("a long name that may be chosen is found, and told up to 200 bytes") {
  auto f = two_scenes();
  const std::string name = std::string(500, 'n') + "\u00e4";
  f.document["scenes"][1]["name"] = "s" + name;
  f.document["nodes"][3]["name"] = name;
  const auto mesh = with(f, {{"scene", "s" + name}, {"node", name}});
  REQUIRE(mesh);
  CHECK(mesh->soup.positions[0] == Vec3{0, 0, 7});
  CHECK(mesh->parts.at(0).name == std::string(197, 'n') + "\u2026");
}

TEST_CASE("a node is drawn with its children, where its parents put it") {
  const auto f = two_scenes();
  const auto right = with(f, {{"node", "right"}});
  REQUIRE(right);
  CHECK(right->soup.positions == std::vector<Vec3>{{10, 5, 0}, {11, 5, 0}, {10, 6, 0}});
  CHECK(right->parts[0].node == 2);
  CHECK(with(f, {{"node", "0"}})->soup.faces.size() == 2);
  CHECK(with(f, {{"node", "other"}, {"scene", "1"}})->soup.faces.size() == 1);
  for (const char* node : {"4", "nobody", "other"}) {  // the last is in the other scene
    const auto missing = with(f, {{"node", node}});
    REQUIRE_FALSE(missing);
    CHECK(missing.error().code == ErrorCode::value_out_of_range);
    CHECK(missing.error().parameter == "node");
  }
}

TEST_CASE("what points up in the file points along y afterwards, and nothing is mirrored") {
  const auto f = one_triangle();
  const auto turned = [&](const char* up) {
    return with(f, {{"up", up}, {"scale", "2"}})->soup.positions;
  };
  using Points = std::vector<Vec3>;
  CHECK(turned("y") == Points{{0, 0, 0}, {2, 0, 0}, {0, 2, 0}});
  CHECK(turned("z") == Points{{0, 0, 0}, {2, 0, 0}, {0, 0, -2}});
  CHECK(turned("x") == Points{{0, 0, 0}, {0, 2, 0}, {-2, 0, 0}});
  for (const auto& [up, axis] : std::vector<std::pair<UpAxis, Vec3>>{
           {UpAxis::x, {1, 0, 0}}, {UpAxis::y, {0, 1, 0}}, {UpAxis::z, {0, 0, 1}}}) {
    ImportOptions options;
    options.up = up;
    TriangleSoup soup{{axis, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {}};
    place(soup, options);
    CHECK(soup.positions[0] == Vec3{0, 1, 0});
    CHECK(dot(cross(soup.positions[1], soup.positions[2]), soup.positions[3]) == 1);
  }
}

TEST_CASE("a Draco file has no scenes to choose from") {
  const TriangleSoup soup{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  const auto drc = encode_drc(soup, 0);
  REQUIRE(drc);
  for (const char* name : {"scene", "node"}) {
    const auto mesh = decode_mesh(*drc, DecodeLimits{}, read({{name, "0"}}).value());
    REQUIRE_FALSE(mesh);
    CHECK(mesh.error().code == ErrorCode::value_out_of_range);
    CHECK(mesh.error().parameter == name);
  }
}

TEST_CASE("the report counts what is odd about a mesh, with the first of each kind") {
  // Two squares apart from each other, the second of faces of their own; and a fin on
  // the first one's diagonal, twice.
  const TriangleSoup soup{
      {{0, 0, 0},
       {1, 0, 0},
       {1, 1, 0},
       {0, 1, 0},
       {0.5, 0.5, 1},  // 0 - 4
       {5, 0, 0},
       {6, 0, 0},
       {6, 1, 0},
       {5, 0, 0},
       {6, 1, 0},
       {5, 1, 0},
       {9, 9, 9}},  // - 11
      {{0, 1, 2}, {0, 2, 3}, {0, 2, 4}, {4, 2, 0}, {5, 6, 7}, {8, 9, 10}, {5, 8, 6}, {0, 1, 1}}};
  const auto findings = examined(soup);
  CHECK(of_code(findings, "vertices_welded").count == 2);
  CHECK(numbers_of(of_code(findings, "vertices_welded")) == Numbers{{5, 8}, {7, 9}});
  CHECK(numbers_of(of_code(findings, "faces_dropped")) == Numbers{{6}, {7}});
  CHECK(numbers_of(of_code(findings, "faces_duplicate")) == Numbers{{3}});
  CHECK(numbers_of(of_code(findings, "edges_non_manifold")) == Numbers{{0, 2}});
  CHECK(numbers_of(of_code(findings, "vertices_isolated")) == Numbers{{11}});
  CHECK(numbers_of(of_code(findings, "components")) == Numbers{{0}, {5}});
  CHECK(of_code(findings, "components").text ==
        "2 components: distances between them are infinite.");
}

TEST_CASE("examples are the first in the file, five at most") {
  TriangleSoup soup;
  for (std::uint32_t i = 0; i < 20; ++i) {
    const double x = 100.0 * (19 - i);  // so that the curve goes the other way
    soup.positions.insert(soup.positions.end(), {{x, 0, 0}, {x + 1, 0, 0}, {x + 2, 0, 0}});
    soup.faces.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const auto findings = examined(soup);
  CHECK(of_code(findings, "faces_without_area").count == 20);
  CHECK(numbers_of(of_code(findings, "faces_without_area")) == Numbers{{0}, {1}, {2}, {3}, {4}});
  CHECK(numbers_of(of_code(findings, "components")) == Numbers{{0}, {3}, {6}, {9}, {12}});
}

TEST_CASE("a closed surface in one piece has nothing to report, two cones tip to tip have") {
  const TriangleSoup tetrahedron{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
                                 {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
  CHECK(examined(tetrahedron).empty());
  TriangleSoup two = tetrahedron;
  for (const Vec3 p : {Vec3{-1, 0, 0}, Vec3{0, -1, 0}, Vec3{0, 0, -1}}) two.positions.push_back(p);
  for (const std::array<std::uint32_t, 3> face :
       {std::array{0U, 5U, 4U}, {0U, 4U, 6U}, {0U, 6U, 5U}, {4U, 5U, 6U}}) {
    two.faces.push_back(face);
  }
  CHECK(numbers_of(of_code(examined(two), "vertices_pinched")) == Numbers{{0}});
}

TEST_CASE("metadata tell the options, and give them back") {
  auto f = one_triangle();
  f.document["nodes"][0]["skin"] = 0;
  const ImportOptions options = read({{"scale", "3"}, {"weld", "off"}}).value();
  auto decoded_mesh = decode_mesh(f.glb(), DecodeLimits{}, options);
  REQUIRE(decoded_mesh);
  auto mesh = Mesh::build(decoded_mesh->soup, options.weld);
  REQUIRE(mesh);
  const auto adjacency = Adjacency::build(std::make_shared<const Mesh>(std::move(*mesh)));
  const std::string text = describe_mesh("id", 7, options, *decoded_mesh, adjacency);
  const json description = json::parse(text);
  CHECK(description["import"] == json{{"scale", 3}, {"weld", "off"}});
  CHECK(description["area"] == 4.5);
  CHECK(description["report"][0]["code"] == "skin_at_bind_pose");
  CHECK(description["report"][0]["examples"] == json::parse(R"([{"where":"node 0"}])"));
  CHECK(description["report"][1]["code"] == "boundaries");
  CHECK(import_options_of(text).value() == options);
  for (const char* other : {"", "{}", "[]", R"({"import":7})", R"({"import":{"up":"q"}})"}) {
    CHECK_FALSE(import_options_of(other));
  }
}
