// Weights and labels of faces out of an attribute: what its numbers mean, and claims that are not
// true.
#include "proto/gltf/weights.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "proto/region/region.h"
#include "tests/proto/gltf_file/fixture.h"

using namespace geodesic;
using namespace geodesic::proto;

namespace {

// A triangle whose vertices have `_MUD`, an accessor that the test makes.
GltfFixture muddy(std::size_t (*accessor)(GltfFixture&)) {
  GltfFixture f = one_triangle();
  const std::size_t added = accessor(f);
  f.document["meshes"][0]["primitives"][0]["attributes"]["_MUD"] = added;
  return f;
}

// One that is zeros.
std::size_t without_bytes(GltfFixture& f) {
  return f.add("accessors", {{"componentType", 5126}, {"count", 3}, {"type", "SCALAR"}});
}

Result<FaceNumbers> mud(const GltfFixture& f) {
  REQUIRE(decode_mesh(f.glb(), DecodeLimits{}));
  return read_face_numbers(f.glb(), DecodeLimits{}, ImportOptions{}, "_MUD", FaceNumber::weight);
}

void check_refused(const GltfFixture& f, const std::string& named) {
  const auto weights = mud(f);
  REQUIRE_FALSE(weights.has_value());
  CAPTURE(weights.error().detail);
  CHECK(weights.error().detail.find(named) != std::string::npos);
  CHECK(weights.error().parameter == "weight_attribute");
}

}  // namespace

TEST_CASE("a face weighs the mean of its corners") {
  const auto floats = mud(muddy([](GltfFixture& f) {
    return f.accessor(f.view(bytes_of(std::vector<float>{1, 2, 6})), 5126, 3, "SCALAR");
  }));
  REQUIRE(floats);
  CHECK(floats->by_face == std::vector<double>{3});
  const auto integers = mud(muddy([](GltfFixture& f) {
    return f.accessor(f.view(bytes_of(std::vector<std::uint16_t>{1, 2, 6})), 5123, 3, "SCALAR");
  }));
  REQUIRE(integers);
  CHECK(integers->by_face == std::vector<double>{3});
}

TEST_CASE("normalised integers are parts of their greatest") {
  const auto weights = mud(muddy([](GltfFixture& f) {
    const auto view = f.view(bytes_of(std::vector<std::uint16_t>{65535, 65535, 65535}));
    const std::size_t added = f.accessor(view, 5123, 3, "SCALAR");
    f.document["accessors"][added]["normalized"] = true;
    return added;
  }));
  REQUIRE(weights);
  CHECK(weights->by_face == std::vector<double>{1});
}

TEST_CASE("an attribute that is not one number a vertex is refused before it is read") {
  // As many zeros as the file has bytes may be claimed without any; these are more, and others.
  for (const std::uint64_t count : {std::uint64_t{2}, std::uint64_t{4}, std::uint64_t{1} << 40U}) {
    GltfFixture f = one_triangle();
    const std::size_t added =
        f.add("accessors", {{"componentType", 5126}, {"count", count}, {"type", "SCALAR"}});
    f.document["meshes"][0]["primitives"][0]["attributes"]["_MUD"] = added;
    check_refused(f, "not one number for each");
  }
  check_refused(muddy([](GltfFixture& f) {
                  return f.accessor(f.view(bytes_of(std::vector<float>(9, 1.0F))), 5126, 3, "VEC3");
                }),
                "not one number for each");
}

TEST_CASE("what is no weight, and an attribute that is not there, are refused") {
  for (const float bad : {0.0F, -1.0F, 1e30F}) {
    GltfFixture f = one_triangle();
    const auto view = f.view(bytes_of(std::vector<float>{1, bad, 1}));
    f.document["meshes"][0]["primitives"][0]["attributes"]["_MUD"] =
        f.accessor(view, 5126, 3, "SCALAR");
    check_refused(f, "at vertex 1");
  }
  check_refused(one_triangle(), "it has: POSITION");
  check_refused(muddy(without_bytes), "at vertex 0");
}

TEST_CASE("an accessor that there is not is refused") {
  GltfFixture f = one_triangle();
  f.document["meshes"][0]["primitives"][0]["attributes"]["_MUD"] = 99;
  check_refused(f, "names an accessor that there is not");
}

TEST_CASE("a label is what all corners have, to the last digit") {
  const auto labels = [](const GltfFixture& f) {
    REQUIRE(decode_mesh(f.glb(), DecodeLimits{}));
    const auto read =
        read_face_numbers(f.glb(), DecodeLimits{}, ImportOptions{}, "_MUD", FaceNumber::label);
    REQUIRE(read);
    REQUIRE(read->by_face.size() == 1);
    return read->by_face.front();
  };
  // No two of these are one float.
  for (const std::uint32_t whole : {0U, 7U, 16777216U, 16777217U, 4294967294U, 4294967295U}) {
    for (const std::uint32_t last : {whole, whole + 1}) {
      GltfFixture f = one_triangle();
      const auto view = f.view(bytes_of(std::vector<std::uint32_t>{whole, whole, last}));
      f.document["meshes"][0]["primitives"][0]["attributes"]["_MUD"] =
          f.accessor(view, 5125, 3, "SCALAR");
      const double label = labels(f);
      CHECK((label == whole) == (last == whole));
      CHECK(std::isnan(label) == (last != whole));
      CHECK(LabelShape{"_MUD", double(whole)}.is_of(label) == (last == whole));
      CHECK_FALSE(LabelShape{"_MUD", double(whole) + 1}.is_of(label));
    }
  }
  const double tenth = labels(muddy([](GltfFixture& f) {
    return f.accessor(f.view(bytes_of(std::vector<float>{0.1F, 0.1F, 0.1F})), 5126, 3, "SCALAR");
  }));
  CHECK(LabelShape{"_MUD", 0.1}.is_of(tenth));
  CHECK_FALSE(LabelShape{"_MUD", 0.1001}.is_of(tenth));
  const double nothing = labels(muddy([](GltfFixture& f) {
    const auto nan = std::numeric_limits<float>::quiet_NaN();
    return f.accessor(f.view(bytes_of(std::vector<float>{nan, nan, nan})), 5126, 3, "SCALAR");
  }));
  CHECK(std::isnan(nothing));
  CHECK(labels(muddy(without_bytes)) == 0);
}
