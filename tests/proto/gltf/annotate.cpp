// Documents that make room for attributes of ours, and files that cannot have them.
#include "proto/gltf/annotate.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "proto/wire/input_codes.h"
#include "tests/proto/gltf_file/fixture.h"

using namespace geodesic;
using namespace geodesic::proto;

namespace {

const std::vector<VertexAttribute> heat{{"_HEAT", 1}};

Result<GltfAnnotation> annotated(const GltfFixture& f, const DecodeLimits& limits = {}) {
  return annotate_gltf(f.glb(), limits, {}, heat);
}

void check_cannot_hold(const GltfFixture& f, const std::string& named,
                       const DecodeLimits& limits = {}) {
  REQUIRE(decode_mesh(f.glb(), limits));
  const auto annotation = annotated(f, limits);
  REQUIRE_FALSE(annotation.has_value());
  CAPTURE(annotation.error().detail);
  CHECK(annotation.error().code == InputCode::not_acceptable);
  CHECK(annotation.error().parameter == "format");
  CHECK(annotation.error().detail.find(named) != std::string::npos);
}

}  // namespace

TEST_CASE("values are added behind the binary chunk, or in a buffer of their own") {
  const auto f = one_triangle();
  const auto in_chunk = annotated(f);
  REQUIRE(in_chunk);
  CHECK(in_chunk->values_at == GltfAnnotation::kInChunk);
  CHECK(in_chunk->runs == std::vector<VertexRun>{{0, 3}});
  const json document = json::parse(in_chunk->json);
  const std::size_t chunk = (f.binary.size() + 3) / 4 * 4;
  CHECK(document["buffers"][0]["byteLength"] == chunk + 12);
  CHECK(document["bufferViews"].back()["byteOffset"] == chunk);
  CHECK(document["accessors"].back()["count"] == 3);

  const auto in_text = annotate_gltf(f.gltf(), {}, {}, heat);
  REQUIRE(in_text);
  CHECK(in_text->json.substr(in_text->values_at).starts_with("\"}]"));
  CHECK(in_text->json.substr(0, in_text->values_at).ends_with(";base64,"));
  CHECK(json::parse(in_text->json)["buffers"].size() == 2);
}

TEST_CASE("a buffer of the binary chunk that claims more than there is gets no values") {
  auto f = one_triangle();
  f.document["buffers"] = json::array({{{"byteLength", 1000}}});
  CHECK_FALSE(decode_mesh(f.glb(), DecodeLimits{}));
  CHECK_FALSE(annotated(f));
}

TEST_CASE("what would not be read again is refused") {
  // As many objects as may be: a buffer, two views, two accessors, a mesh with its primitive, a
  // node.
  DecodeLimits limits;
  limits.max_gltf_objects = 8;
  check_cannot_hold(one_triangle(), "uploaded again", limits);
  limits.max_gltf_objects = 10;
  CHECK(annotated(one_triangle(), limits));
}

TEST_CASE("a mesh that many nodes share does not make a file of any size") {
  auto f = one_triangle();
  f.document["meshes"][0]["extras"] = std::string(std::size_t{1} << 20, 'x');
  for (int i = 0; i < 70; ++i) f.node({{"mesh", 0}});
  check_cannot_hold(f, "share meshes");
}

TEST_CASE("an object of very many members is refused, for each is looked for among all") {
  auto f = one_triangle();
  for (int i = 0; i < 5000; ++i) f.document["extras"]["name " + std::to_string(i)] = i;
  check_cannot_hold(f, "members");
}

TEST_CASE("an attribute of the name is not overwritten") {
  auto f = one_triangle();
  f.document["meshes"][0]["primitives"][0]["attributes"]["_HEAT"] = 0;
  const auto annotation = annotated(f);
  REQUIRE_FALSE(annotation.has_value());
  CHECK(annotation.error().code == ErrorCode::value_out_of_range);
  CHECK(annotation.error().parameter == "attribute");
}

TEST_CASE("instances of one node have no place for their values") {
  auto f = one_triangle();
  const auto moved = f.positions({0, 0, 0, 5, 0, 0});
  f.document["nodes"][0]["extensions"] = {
      {"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", moved}}}}}};
  check_cannot_hold(f, "node 0 draws its mesh several times");
  // One instance has.
  f.document["accessors"][moved]["count"] = 1;
  CHECK(annotated(f));
}
