// A glTF document with its buffers in files, packed into a GLB: what decodes from it,
// and what is refused.
#include "proto/gltf_file/pack.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "proto/wire/input_codes.h"
#include "tests/proto/gltf_file/fixture.h"

using namespace geodesic;
using namespace geodesic::proto;

namespace {

std::string text_of(const Bytes& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// A triangle whose positions and indices are in two files, and a third buffer in the
// document itself.
struct Parts {
  json document;
  std::string positions;
  std::string indices;

  [[nodiscard]] Result<std::string> packed(const NamedFiles& files) const {
    return pack_gltf(document.dump(), files, DecodeLimits{});
  }
  [[nodiscard]] Result<std::string> packed() const {
    return packed({{"a b.bin", positions}, {"indices.bin", indices}});
  }
};

Parts three_buffers() {
  Parts parts;
  parts.positions = "????" + text_of(bytes_of(std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0}));
  parts.indices = text_of(bytes_of(std::vector<std::uint16_t>{2, 1, 0}));
  auto f = one_triangle();
  f.document["nodes"].push_back({{"mesh", 1}});
  f.document["meshes"].push_back(f.document["meshes"][0]);
  f.document["meshes"][1]["primitives"][0]["attributes"]["POSITION"] = 2;
  f.document["accessors"].push_back(f.document["accessors"][0]);
  f.document["accessors"][2]["bufferView"] = 2;
  f.document["bufferViews"] = {{{"buffer", 0}, {"byteOffset", 4}, {"byteLength", 36}},
                               {{"buffer", 2}, {"byteLength", 6}},
                               {{"buffer", 1}, {"byteLength", 36}}};
  const Bytes inner = bytes_of(std::vector<float>{5, 0, 0, 6, 0, 0, 5, 1, 0});
  f.document["buffers"] = {
      {{"byteLength", 40}, {"uri", "./data/a%20b.bin"}},
      {{"byteLength", 36}, {"uri", "data:application/octet-stream;base64," + base64(inner)}},
      {{"byteLength", 6}, {"uri", "indices.bin"}}};
  f.document["images"] = {{{"uri", "wood.png"}}};
  parts.document = f.document;
  return parts;
}

void check_not_packed(const Result<std::string>& packed, ErrorCode code, const std::string& named) {
  REQUIRE_FALSE(packed.has_value());
  CAPTURE(packed.error().detail);
  CHECK(packed.error().code.name() == code.name());
  CHECK(packed.error().detail.find(named) != std::string::npos);
}

}  // namespace

TEST_CASE("buffers in files become one binary chunk, and nothing else changes") {
  const auto packed = three_buffers().packed();
  if (!packed) FAIL(packed.error().detail);
  const auto mesh = decode(bytes_of(*packed));
  if (!mesh) FAIL(mesh.error().detail);
  CHECK(mesh->format == MeshFormat::glb);
  CHECK(mesh->soup.positions ==
        std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 0, 0}, {6, 0, 0}, {5, 1, 0}});
  CHECK(mesh->soup.faces == std::vector<std::array<std::uint32_t, 3>>{{2, 1, 0}, {5, 4, 3}});
  CHECK(packed->find("wood.png") != std::string::npos);
}

TEST_CASE("the same files give the same bytes, whatever else comes with them") {
  const Parts parts = three_buffers();
  const auto once = parts.packed();
  const auto again = parts.packed({{"indices.bin", parts.indices},
                                   {"data/a b.bin", parts.positions},
                                   {"wood.png", "not a picture"},
                                   {"notes.txt", ""}});
  REQUIRE(once.has_value());
  REQUIRE(again.has_value());
  CHECK(*once == *again);
}

TEST_CASE("what needs no packing is packed too") {
  const auto packed = pack_gltf(text_of(one_triangle().gltf()), {}, DecodeLimits{});
  REQUIRE(packed.has_value());
  CHECK(decode(bytes_of(*packed))->soup.faces.size() == 1);
  const auto empty = pack_gltf(R"({"asset":{"version":"2.0"}})", {}, DecodeLimits{});
  REQUIRE(empty.has_value());
  CHECK(decode(bytes_of(*empty)).error().code == ErrorCode::no_triangles);
}

TEST_CASE("a file that is missing is named") {
  const Parts parts = three_buffers();
  check_not_packed(parts.packed({{"indices.bin", parts.indices}}), InputCode::external_uri,
                   "buffer 0 is in ./data/a%20b.bin, which is not among the parts");
  for (const char* uri : {"../../etc/passwd", "file:///etc/passwd", "https://example.org/a.bin"}) {
    Parts other = parts;
    other.document["buffers"][2]["uri"] = uri;
    check_not_packed(other.packed(), InputCode::external_uri, "buffer 2 is in");
  }
}

TEST_CASE("views can't reach from one file into the next") {
  const auto spoilt = [](const char* pointer, const json& value) {
    Parts parts = three_buffers();
    parts.document[json::json_pointer(pointer)] = value;
    return parts.packed();
  };
  constexpr auto wrong = ErrorCode::mesh_invalid;
  check_not_packed(spoilt("/bufferViews/0/byteLength", 37), wrong, "bufferView 0 reaches beyond");
  check_not_packed(spoilt("/bufferViews/0/byteOffset", 9007199254740992), wrong, "bufferView 0");
  check_not_packed(spoilt("/bufferViews/1/byteOffset", -1), wrong, "bufferView 1");
  check_not_packed(spoilt("/bufferViews/1/buffer", 3), wrong, "bufferView 1 refers to a buffer");
  check_not_packed(spoilt("/buffers/0/byteLength", 41), wrong, "buffer 0 claims more bytes");
  check_not_packed(spoilt("/buffers/0/byteLength", "40"), wrong, "buffer 0 claims");
  check_not_packed(spoilt("/buffers/0", 7), wrong, "buffers is no array of objects");
  check_not_packed(spoilt("/bufferViews", 7), wrong, "bufferViews is no array of objects");
  check_not_packed(pack_gltf("{\"asset\":", {}, DecodeLimits{}), wrong, "does not parse");
  check_not_packed(pack_gltf(std::string(100'000, '['), {}, DecodeLimits{}), wrong, "nested");
  check_not_packed(pack_gltf(R"({"asset)", {}, DecodeLimits{}), wrong, "has no end");
}

TEST_CASE("a file that many buffers are in is there once") {
  const std::string file(1000, 'x');
  json document = {{"asset", {{"version", "2.0"}}}};
  for (int i = 0; i < 1000; ++i) {
    document["buffers"].push_back({{"uri", "a.bin"}, {"byteLength", 1000 - i % 3}});
    document["bufferViews"].push_back({{"buffer", i}, {"byteOffset", 990}, {"byteLength", 8}});
  }
  const auto packed = pack_gltf(document.dump(), {{"a.bin", file}}, DecodeLimits{});
  REQUIRE(packed);
  CHECK(packed->size() < document.dump().size() + 2 * file.size());
  CHECK(packed->find("\"buffers\":[{\"byteLength\":1000}]") != std::string::npos);

  for (int i = 0; i < 1000; ++i) document["buffers"][i]["byteLength"] = i + 1;
  document.erase("bufferViews");
  check_not_packed(pack_gltf(document.dump(), {{"a.bin", file}}, DecodeLimits{}),
                   ErrorCode::too_large, "ever longer parts of one file");
}

TEST_CASE("an object of very many members is not packed, for each is looked for among all") {
  constexpr std::size_t kMost = 4096;
  json document = {{"asset", {{"version", "2.0"}}}};
  for (std::size_t i = 0; i < kMost; ++i) document["extras"]["name " + std::to_string(i)] = i;
  CHECK(pack_gltf(document.dump(), {}, DecodeLimits{}).has_value());
  document["extras"]["one more"] = 0;
  const auto packed = pack_gltf(document.dump(), {}, DecodeLimits{});
  check_not_packed(packed, ErrorCode::too_large, "too many members");
  CHECK(packed.error().limit == kMost);
  CHECK(packed.error().actual == kMost + 1);
}

TEST_CASE("a name that comes twice is refused, not packed as one of the two") {
  const Parts parts = three_buffers();
  std::string text = parts.document.dump();
  text.insert(1, R"("buffers":[],)");
  check_not_packed(pack_gltf(text, {{"a b.bin", parts.positions}, {"indices.bin", parts.indices}},
                             DecodeLimits{}),
                   invalid, "the name buffers twice");
}
