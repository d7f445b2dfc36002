// Damaged files: cut at every length, and mutated at random from fixed seeds.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "proto/encode/encode_mesh.h"
#include "tests/fixtures/mutations.h"
#include "tests/proto/gltf_file/fixture.h"

using namespace geodesic;
using namespace geodesic::proto;
using fixtures::misplaced;
using fixtures::mutated;

namespace {

TriangleSoup tetrahedron() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
          {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
}

// A file that uses most of the decoder: hierarchy, strip, sparse, quantised and
// Draco primitives.
GltfFixture rich() {
  auto f = one_triangle();
  const auto strip = f.positions({0, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0});
  const auto quantised =
      f.accessor(f.view(bytes_of(std::vector<std::int16_t>{0, 0, 0, 0, 9, 0, 0, 0, 0, 9, 0, 0}), 8),
                 5122, 3, "VEC3");
  const auto sparse_indices = f.view(bytes_of(std::vector<std::uint8_t>{1}));
  const auto sparse_values = f.view(bytes_of(std::vector<float>{3, 3, 3}));
  f.document["accessors"][strip]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", sparse_indices}, {"componentType", 5121}}},
      {"values", {{"bufferView", sparse_values}}}};
  const auto drc = encode_drc(tetrahedron(), 0);
  json compressed = GltfFixture::primitive(
      f.add("accessors", {{"componentType", 5126}, {"count", 4}, {"type", "VEC3"}}));
  compressed["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", f.view(drc.value())},
                                                            {"attributes", {{"POSITION", 0}}}};
  f.mesh({GltfFixture::primitive(strip, 5), GltfFixture::primitive(quantised), compressed});
  f.node({{"mesh", 1}, {"children", {0}}, {"scale", {1, 2, 3}}});
  f.document["scenes"] = json::array({{{"nodes", {1}}}});
  f.document["scene"] = 0;
  return f;
}

void check_cut_everywhere(const Bytes& bytes) {
  REQUIRE(decode(bytes).has_value());
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    // A copy of that size, so that a sanitizer sees the first byte too many.
    const Bytes cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length));
    const auto mesh = decode(cut);
    CAPTURE(length);
    CHECK_FALSE(mesh.has_value());
  }
}

// Decodes; an error must say something, a mesh must be one.
bool survives(const Bytes& bytes) {
  DecodeLimits limits;
  limits.max_vertices = 100'000;
  limits.max_faces = 100'000;
  const auto mesh = decode_mesh(bytes, limits);
  if (!mesh) return mesh.error().code != ErrorCode::internal && !mesh.error().detail.empty();
  const auto count = mesh->soup.positions.size();
  return !mesh->soup.faces.empty() && std::ranges::all_of(mesh->soup.positions, [](const Vec3& p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
  }) && std::ranges::all_of(mesh->soup.faces, [count](const auto& face) {
    return face[0] < count && face[1] < count && face[2] < count;
  });
}

}  // namespace

TEST_CASE("a GLB cut at any length is an error") { check_cut_everywhere(rich().glb()); }

TEST_CASE("a glTF cut at any length is an error") { check_cut_everywhere(rich().gltf()); }

TEST_CASE("a Draco bitstream cut at any length is an error") {
  for (const int bits : {0, 11}) {
    CAPTURE(bits);
    check_cut_everywhere(encode_drc(tetrahedron(), bits).value());
  }
}

TEST_CASE("every byte of a Draco bitstream may have every value") {
  const Bytes bytes = encode_drc(tetrahedron(), 0).value();
  int failures = 0;
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    for (unsigned value = 0; value < 256; ++value) {
      Bytes changed = bytes;
      changed[at] = static_cast<std::byte>(value);
      if (!survives(changed)) ++failures;
    }
  }
  CHECK(failures == 0);
}

TEST_CASE("mutated files end in an error or a valid mesh") {
  std::mt19937 random(20240229);
  const std::vector<Bytes> fixtures = {one_triangle().glb(), rich().glb(), rich().gltf(),
                                       encode_drc(tetrahedron(), 0).value(),
                                       encode_drc(tetrahedron(), 11).value()};
  int failures = 0;
  for (int i = 0; i < 1000; ++i) {
    for (const Bytes& fixture : fixtures) {
      if (!survives(mutated(fixture, random))) ++failures;
    }
  }
  CHECK(failures == 0);
}

TEST_CASE("documents with one misplaced value end in an error or a valid mesh") {
  std::mt19937 random(42);
  const GltfFixture fixture = rich();
  int failures = 0;
  for (int i = 0; i < 3000; ++i) {
    GltfFixture spoiled = fixture;
    spoiled.document["buffers"] = json::array({{{"byteLength", fixture.binary.size()}}});
    spoiled.document = misplaced(spoiled.document, random);
    if (i % 2 == 0) spoiled.document = misplaced(spoiled.document, random);
    if (!survives(spoiled.glb())) ++failures;
  }
  CHECK(failures == 0);
}
