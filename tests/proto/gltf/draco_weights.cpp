// Weights of faces out of Draco data: those of the same mesh without it, and ids and data that are
// not what they should be.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "core/mesh/shapes.h"
#include "proto/draco/codec.h"
#include "proto/gltf/weights.h"
#include "tests/fixtures/mutations.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/test_seed.h"
#include "tests/proto/gltf_file/draco_fixture.h"

using namespace geodesic;
using namespace geodesic::proto;

namespace {

using Corners = std::array<std::array<double, 3>, 3>;

// A face by where its corners are, whatever their order.
Corners place_of(const TriangleSoup& soup, const Triangle& face) {
  Corners corners{};
  for (std::size_t c = 0; c < 3; ++c) {
    const Vec3& p = soup.positions[face[c]];
    corners[c] = {p.x, p.y, p.z};
  }
  std::ranges::sort(corners);
  return corners;
}

Result<FaceNumbers> weights_in(const Bytes& file) {
  return read_face_numbers(file, DecodeLimits{}, ImportOptions{}, "_MUD", FaceNumber::weight);
}

// Of each face that the file has, with each weight that a face of that place has.
std::map<Corners, std::vector<double>> weights_by_place(const GltfFixture& f) {
  const auto mesh = decode(f.glb());
  REQUIRE(mesh);
  const auto weights = weights_in(f.glb());
  if (!weights) FAIL(weights.error().detail);
  REQUIRE(weights->by_face.size() == mesh->soup.faces.size());
  std::map<Corners, std::vector<double>> by_place;
  for (std::size_t i = 0; i < mesh->soup.faces.size(); ++i) {
    by_place[place_of(mesh->soup, mesh->soup.faces[i])].push_back(weights->by_face[i]);
  }
  for (auto& [place, all] : by_place) std::ranges::sort(all);
  return by_place;
}

// Corners that share nothing, each with its number.
GltfFixture without_draco(const TriangleSoup& soup, const DracoNumbers& numbers) {
  GltfFixture f;
  std::vector<float> xyz;
  Bytes values;
  const std::size_t size = numbers.component_type == 5121   ? 1
                           : numbers.component_type == 5123 ? 2
                                                            : 4;
  for (const Triangle& face : soup.faces) {
    for (const std::uint32_t v : face) {
      const Vec3& p = soup.positions[v];
      for (const double x : {p.x, p.y, p.z}) xyz.push_back(static_cast<float>(x));
      const auto one =
          number_of_type(numbers.at_corner[values.size() / size], numbers.component_type);
      values.insert(values.end(), one.begin(), one.begin() + static_cast<std::ptrdiff_t>(size));
    }
  }
  json primitive = GltfFixture::primitive(f.positions(xyz));
  primitive["attributes"]["_MUD"] =
      f.accessor(f.view(values), numbers.component_type, xyz.size() / 3, "SCALAR");
  f.mesh({primitive});
  f.node({{"mesh", 0}});
  return f;
}

GltfFixture with_draco(const TriangleSoup& soup, const DracoNumbers& numbers) {
  GltfFixture f;
  f.mesh({draco_primitive(f, draco_of(soup, numbers), numbers, "_MUD")});
  f.node({{"mesh", 0}});
  return f;
}

// Of the vertices, or of each corner by itself: then one position has several points.
std::vector<double> drawn_numbers(fixtures::RandomMesh& mesh, bool by_corner, double greatest,
                                  bool is_whole) {
  const auto draw = [&] {
    const double number = 1 + mesh.unit() * (greatest - 1);
    return is_whole ? std::floor(number) : number;
  };
  std::vector<double> of_vertex(mesh.soup().positions.size());
  for (double& number : of_vertex) number = draw();
  std::vector<double> at_corner;
  for (const Triangle& face : mesh.soup().faces) {
    for (const std::uint32_t v : face) at_corner.push_back(by_corner ? draw() : of_vertex[v]);
  }
  return at_corner;
}

DracoNumbers plane_numbers() { return {5126, std::vector<double>(3 * 12, 2.0), 0, true, 4, 9}; }

// What two by three squares of weight 2 are in Draco.
GltfFixture muddy_plane() { return with_draco(shapes::plane(4, 3), plane_numbers()); }

json& draco_attributes(GltfFixture& f) {
  return f.document["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]
                   ["attributes"];
}

void check_no_weights(const GltfFixture& f, const std::string& named) {
  REQUIRE(decode(f.glb()));
  const auto weights = weights_in(f.glb());
  REQUIRE_FALSE(weights.has_value());
  CAPTURE(weights.error().detail);
  CHECK(weights.error().detail.find(named) != std::string::npos);
  CHECK(weights.error().code == ErrorCode::value_out_of_range);
  CHECK(weights.error().parameter == "weight_attribute");
}

}  // namespace

TEST_CASE("weights out of Draco have the bits that they have without it") {
  const std::uint32_t seed = fixtures::test_seed();
  std::size_t several_points = 0;
  for (std::uint32_t round = 0; round < 60; ++round) {
    CAPTURE(seed);
    CAPTURE(round);
    fixtures::RandomMesh random(seed + round);
    DracoNumbers numbers;
    const std::array<int, 4> types{5126, 5121, 5123, 5125};
    numbers.component_type = types[round % 4];
    const bool by_corner = random.below(2) == 0;
    numbers.at_corner =
        drawn_numbers(random, by_corner, numbers.component_type == 5121 ? 255.0 : 60'000.0,
                      numbers.component_type != 5126);
    numbers.by_edgebreaker = random.below(2) == 0;
    numbers.position_id = random.below(1000);
    numbers.number_id = 1000 + random.below(1000);
    numbers.says_normalized = random.below(2) == 0;
    GltfFixture plain = without_draco(random.soup(), numbers);
    GltfFixture draco = with_draco(random.soup(), numbers);
    const bool is_small = numbers.component_type == 5121 || numbers.component_type == 5123;
    if (is_small && random.below(2) == 0) {
      // Parts of the greatest, which is 1.
      for (GltfFixture* f : {&plain, &draco}) {
        const json& primitive = f->document["meshes"][0]["primitives"][0];
        f->document["accessors"][primitive["attributes"]["_MUD"].get<std::size_t>()]["normalized"] =
            true;
      }
    }
    const auto expected = weights_by_place(plain);
    const auto found = weights_by_place(draco);
    std::size_t compared = 0;
    for (const auto& [place, weights] : found) {
      const auto there = expected.find(place);
      REQUIRE(there != expected.end());
      // Draco leaves out faces that are there twice, or have no width.
      if (weights.size() != there->second.size()) continue;
      ++compared;
      CHECK(weights == there->second);
    }
    CHECK(compared > found.size() / 2);
    const auto mesh = decode(draco.glb());
    if (mesh->soup.positions.size() > random.soup().positions.size()) ++several_points;
  }
  CHECK(several_points > 0);
}

TEST_CASE("quantised weights are off by half a step at most") {
  const std::uint32_t seed = fixtures::test_seed();
  for (std::uint32_t round = 0; round < 20; ++round) {
    CAPTURE(seed);
    CAPTURE(round);
    fixtures::RandomMesh random(seed + round);
    DracoNumbers numbers;
    numbers.at_corner = drawn_numbers(random, random.below(2) == 0, 100, false);
    numbers.bits = static_cast<int>(6 + random.below(12));
    numbers.by_edgebreaker = random.below(2) == 0;
    const auto [least, most] = std::ranges::minmax(numbers.at_corner);
    const double step = (most - least) / ((1U << static_cast<unsigned>(numbers.bits)) - 1);
    const auto expected = weights_by_place(without_draco(random.soup(), numbers));
    for (const auto& [place, weights] : weights_by_place(with_draco(random.soup(), numbers))) {
      const auto there = expected.find(place);
      REQUIRE(there != expected.end());
      if (weights.size() != there->second.size()) continue;
      for (std::size_t i = 0; i < weights.size(); ++i) {
        CHECK(std::abs(weights[i] - there->second[i]) <= 0.5 * step + 1e-4);
      }
    }
  }
}

TEST_CASE("primitives with Draco and without, drawn several times, have each their own weights") {
  GltfFixture f;
  const auto of = [&](double number) {
    DracoNumbers numbers = plane_numbers();
    numbers.at_corner.assign(numbers.at_corner.size(), number);
    return draco_primitive(f, draco_of(shapes::plane(4, 3), numbers), numbers, "_MUD");
  };
  json plain = GltfFixture::primitive(f.positions({0, 0, 5, 1, 0, 5, 0, 1, 5}));
  plain["attributes"]["_MUD"] =
      f.accessor(f.view(bytes_of(std::vector<float>{7, 7, 7})), 5126, 3, "SCALAR");
  // Beside Draco data a plain accessor is in the order of its vertices.
  json beside = of(1);
  beside["extensions"]["KHR_draco_mesh_compression"]["attributes"].erase("_MUD");
  beside["attributes"]["_MUD"] =
      f.accessor(f.view(bytes_of(std::vector<float>(12, 5.0F))), 5126, 12, "SCALAR");
  f.mesh({of(2), plain, of(3), beside});
  f.mesh({of(4)});
  for (const int mesh : {0, 1, 0}) f.node({{"mesh", mesh}, {"translation", {mesh, 9, 0}}});
  const auto weights = weights_in(f.glb());
  if (!weights) FAIL(weights.error().detail);
  std::vector<double> expected;
  const auto append = [&](std::size_t count, double weight) {
    expected.insert(expected.end(), count, weight);
  };
  for (const int mesh : {0, 1, 0}) {
    if (mesh == 1) {
      append(12, 4);
      continue;
    }
    append(12, 2);
    append(1, 7);
    append(12, 3);
    append(12, 5);
  }
  CHECK(weights->by_face == expected);
}

TEST_CASE("an id that the Draco data has not, or that is none, is refused") {
  REQUIRE(weights_in(muddy_plane().glb())->by_face == std::vector<double>(12, 2.0));
  for (const json& id : {json(5), json(0xFFFFFFFF)}) {
    GltfFixture f = muddy_plane();
    draco_attributes(f)["_MUD"] = id;
    check_no_weights(f, "no attribute of the id");
  }
  for (const json& id : {json(-1), json("9"), json(9.5), json(nullptr), json::array({9}),
                         json(std::uint64_t{1} << 40U), json(1e300)}) {
    CAPTURE(id.dump());
    GltfFixture f = muddy_plane();
    draco_attributes(f)["_MUD"] = id;
    check_no_weights(f, "no id in the Draco data");
  }
}

TEST_CASE("an attribute of several components is refused, by the data and by its accessor") {
  GltfFixture f = muddy_plane();
  draco_attributes(f)["_MUD"] = plane_numbers().position_id;
  check_no_weights(f, "do not have one component");
  GltfFixture wide = muddy_plane();
  const json& attributes = wide.document["meshes"][0]["primitives"][0]["attributes"];
  wide.document["accessors"][attributes["_MUD"].get<std::size_t>()]["type"] = "VEC3";
  check_no_weights(wide, "not one number for each");
}

TEST_CASE("an attribute that only the extension names is not there") {
  GltfFixture f = muddy_plane();
  f.document["meshes"][0]["primitives"][0]["attributes"].erase("_MUD");
  check_no_weights(f, "it has: POSITION");
}

// Their number is the bitstream's, as that of positions is.
TEST_CASE("accessors that count other vertices than the Draco data are not believed") {
  GltfFixture f = muddy_plane();
  for (json& accessor : f.document["accessors"]) accessor["count"] = 7;
  CHECK(weights_in(f.glb())->by_face == std::vector<double>(12, 2.0));
}

TEST_CASE("what is no weight is refused out of Draco, too") {
  for (const double bad : {0.0, -1.0, 1e30, std::numeric_limits<double>::quiet_NaN(),
                           std::numeric_limits<double>::infinity()}) {
    CAPTURE(bad);
    DracoNumbers numbers = plane_numbers();
    numbers.at_corner[7] = bad;
    check_no_weights(with_draco(shapes::plane(4, 3), numbers), "a weight is from 1e-9");
  }
}

TEST_CASE("damaged Draco data has weights for all of its vertices or none") {
  const std::uint32_t seed = fixtures::test_seed();
  std::mt19937 random(seed);
  DecodeLimits limits;
  limits.max_vertices = 10'000;
  limits.max_faces = 10'000;
  std::size_t read = 0;
  for (const int bits : {0, 9}) {
    for (const bool by_edgebreaker : {true, false}) {
      DracoNumbers numbers = plane_numbers();
      for (std::size_t i = 0; i < numbers.at_corner.size(); ++i) {
        numbers.at_corner[i] = 1 + static_cast<double>(i % 5);
      }
      numbers.bits = bits;
      numbers.by_edgebreaker = by_edgebreaker;
      const Bytes sound = draco_of(shapes::plane(4, 3), numbers).bytes;
      const auto check = [&](const Bytes& bytes) {
        const DracoLimits draco_limits{limits.max_vertices, limits.max_faces};
        const auto values = decode_draco_numbers(bytes, draco_limits, {numbers.number_id, false});
        const auto soup = decode_draco(bytes, draco_limits);
        if (!values) {
          CHECK(values.error().code != ErrorCode::internal);
          CHECK(!values.error().detail.empty());
        } else if (soup) {
          ++read;
          CHECK(values->size() == soup->positions.size());
        }
      };
      for (std::size_t length = 0; length < sound.size(); ++length) {
        check(Bytes(sound.begin(), sound.begin() + static_cast<std::ptrdiff_t>(length)));
      }
      for (std::size_t at = 0; at < sound.size(); ++at) {
        for (unsigned value = 0; value < 256; value += 5) {
          Bytes changed = sound;
          changed[at] = static_cast<std::byte>(value);
          check(changed);
        }
      }
      for (int i = 0; i < 2000; ++i) check(fixtures::mutated(sound, random));
    }
  }
  CHECK(read > 100);
}
