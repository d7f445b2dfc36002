#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "proto/formats/decode_mesh.h"
#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

// Two squares that share a side whose vertices each has for itself, a face that has
// two corners at one place, and a vertex in no face.
TriangleSoup two_squares() {
  return {{{0, 0, 0},
           {1, 0, 0},
           {1, 1, 0},
           {0, 1, 0},  // one
           {1, 0, 0},
           {2, 0, 0},
           {2, 1, 0},
           {1, 1, 0},  // the other
           {5, 5, 5}},
          {{0, 1, 2}, {0, 2, 3}, {1, 4, 6}, {4, 5, 6}, {4, 6, 7}}};
}

struct GeometryFrame {
  json about;
  std::vector<double> positions;
  std::vector<std::uint32_t> triangles;
};

template <class Number>
std::vector<Number> array_of(const std::string& bytes, const json& array, const char* dtype) {
  CHECK(array["dtype"] == dtype);
  std::vector<Number> numbers(array["nbytes"].get<std::size_t>() / sizeof(Number));
  REQUIRE(array["offset"].get<std::size_t>() + array["nbytes"].get<std::size_t>() <= bytes.size());
  std::memcpy(numbers.data(), bytes.data() + array["offset"].get<std::size_t>(),
              numbers.size() * sizeof(Number));
  return numbers;
}

GeometryFrame frame_of(const HttpResponse& response) {
  REQUIRE(response.status == 200);
  CHECK(response.content_type == "application/vnd.geodesic.frame");
  const std::string& bytes = *response.body;
  REQUIRE(bytes.starts_with("GEOD"));
  std::uint32_t length = 0;
  std::memcpy(&length, bytes.data() + 8, sizeof length);
  GeometryFrame frame;
  frame.about = json::parse(bytes.substr(24, length));
  REQUIRE(frame.about["arrays"].size() == 2);
  CHECK(frame.about["arrays"][0]["name"] == "positions");
  CHECK(frame.about["arrays"][1]["name"] == "triangles");
  frame.positions = array_of<double>(bytes, frame.about["arrays"][0], "<f8");
  frame.triangles = array_of<std::uint32_t>(bytes, frame.about["arrays"][1], "<u4");
  return frame;
}

TriangleSoup soup_of_glb(const HttpResponse& response) {
  REQUIRE(response.status == 200);
  CHECK(response.content_type == "model/gltf-binary");
  const auto decoded = proto::decode_mesh(
      {reinterpret_cast<const std::byte*>(response.body->data()), response.body->size()}, {});
  REQUIRE(decoded);
  return decoded->soup;
}

}  // namespace

TEST_CASE("GeometryHasAPositionASourceVertexAndATriangleASourceFace") {
  PlaneService plane;
  const TriangleSoup soup = two_squares();
  const std::string base = plane.add(soup);
  const GeometryFrame frame = frame_of(plane.service.get(base + "/geometry?format=frame"));
  CHECK("/v1/meshes/" + frame.about["mesh"].get<std::string>() == base);
  CHECK(frame.about["vertices"] == 9);
  CHECK(frame.about["faces"] == 5);
  CHECK(frame.about["arrays"][0]["shape"] == json::parse("[9,3]"));
  CHECK(frame.about["arrays"][1]["shape"] == json::parse("[5,3]"));
  REQUIRE(frame.positions.size() == 27);
  REQUIRE(frame.triangles.size() == 15);
  const auto position = [&](std::uint32_t v) {
    return Vec3{frame.positions[3 * v], frame.positions[3 * v + 1], frame.positions[3 * v + 2]};
  };
  for (std::uint32_t v = 0; v < 9; ++v) CHECK(position(v) == soup.positions[v]);
  for (std::size_t f = 0; f < 5; ++f) {
    for (std::size_t c = 0; c < 3; ++c) {
      CHECK(position(frame.triangles[3 * f + c]) == soup.positions[soup.faces[f][c]]);
    }
  }
  // Welded vertices are one in the triangles: the first of them, so that both squares
  // hang together.
  CHECK(frame.triangles[9] == 1);
  CHECK(std::count(frame.triangles.begin(), frame.triangles.end(), 4U) == 0);

  const TriangleSoup drawn = soup_of_glb(plane.service.get(base + "/geometry"));
  CHECK(drawn.positions == soup.positions);
  REQUIRE(drawn.faces.size() == 5);
  for (std::size_t f = 0; f < 5; ++f) {
    for (std::size_t c = 0; c < 3; ++c) CHECK(drawn.faces[f][c] == frame.triangles[3 * f + c]);
  }
}

TEST_CASE("AFieldAndFacesFitTheGeometryByNumber") {
  PlaneService plane;
  const std::string base = plane.add(two_squares());
  const GeometryFrame frame = frame_of(plane.service.get(base + "/geometry?format=frame"));
  const json field = body_of(plane.service.get(base + "/distance?from=v:0"));
  REQUIRE(field["distances"].size() == 9);
  for (std::size_t v = 0; v < 8; ++v) {
    const double straight = std::hypot(frame.positions[3 * v], frame.positions[3 * v + 1]);
    CHECK(field["distances"][v].get<double>() == doctest::Approx(straight));
  }
  CHECK(field["distances"][8].is_null());
  const json point = body_of(plane.service.get(base + "/nearest?point=f:4,0.25,0.25"))["points"][0];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto at = [&](std::size_t corner) {
      return frame.positions[3 * frame.triangles[12 + corner] + axis];
    };
    CHECK(point["xyz"][axis].get<double>() ==
          doctest::Approx(0.25 * at(0) + 0.25 * at(1) + 0.5 * at(2)));
  }
}

TEST_CASE("TheGlbUploadedAgainHasTheSameDistances") {
  PlaneService plane;
  for (const TriangleSoup& soup : {two_squares(), shapes::torus_knot(30, 6, 0.5),
                                   shapes::shuffled(shapes::terrain(12, 3, 4), 2)}) {
    const std::string base = plane.add(soup);
    const HttpResponse geometry = plane.service.get(base + "/geometry?format=glb");
    REQUIRE(geometry.status == 200);
    const std::string again = "/v1/meshes/" + plane.service.upload(*geometry.body);
    CHECK(again != base);
    for (const char* query :
         {"/distance?from=v:0", "/distance?from=v:3&method=exact", "/distance?from=f:1,0.2,0.3"}) {
      const json before = body_of(plane.service.get(base + query));
      const json after = body_of(plane.service.get(again + query));
      CHECK(before["distances"] == after["distances"]);
    }
  }
}

TEST_CASE("GeometryIsNegotiatedAndKeptForever") {
  PlaneService plane;
  const auto accept = [&](const char* type) {
    return plane.service.ask("GET", plane.base + "/geometry", {}, {{"Accept", type}});
  };
  CHECK(accept("model/gltf-binary").content_type == "model/gltf-binary");
  CHECK(accept("application/vnd.geodesic.frame").content_type == "application/vnd.geodesic.frame");
  const HttpResponse any = accept("*/*");
  CHECK(any.content_type == "model/gltf-binary");
  CHECK(header_of(any, "Cache-Control") == "public, max-age=31536000, immutable");
  CHECK(header_of(any, "Vary").find("Accept") != std::string::npos);
  check_problem(accept("application/json"), 406, "not_acceptable", "Accept");
  plane.check_refused("/geometry?format=json", 406, "not_acceptable", "format");
  plane.check_refused("/geometry?precision=3", 400, "unknown_parameter", "precision");
  plane.check_refused("/geometry?colormap=viridis", 400, "unknown_parameter", "colormap");
  plane.check_refused("/geometry?from=v:0", 400, "unknown_parameter", "from");
  check_problem(plane.service.get("/v1/meshes/" + std::string(64, 'a') + "/geometry"), 404,
                "mesh_unknown");
  const HttpResponse post = plane.service.ask("POST", plane.base + "/geometry", "{}");
  check_problem(post, 405, "method_not_allowed");
  CHECK(header_of(post, "Allow") == "GET, HEAD, OPTIONS");
}

TEST_CASE("PositionsThatFloat32DoesNotHoldAreToBeHadAsAFrame") {
  PlaneService plane;
  // Moved out of float32's range by its node.
  const std::string gltf = R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
    "nodes":[{"mesh":0,"scale":[1e20,1e20,1e20]}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3",
                  "min":[0,0,0],"max":[1e20,1e20,0]}],
    "bufferViews":[{"buffer":0,"byteLength":36}],
    "buffers":[{"byteLength":36,
      "uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAA7HitYAAAAAAAAAAAAAAAAOx4rWAAAAAA"}]})";
  const std::string base = "/v1/meshes/" + plane.service.upload(gltf);
  check_problem(plane.service.get(base + "/geometry"), 422, "unsupported", "format");
  const GeometryFrame frame = frame_of(plane.service.get(base + "/geometry?format=frame"));
  CHECK(frame.positions[3] == doctest::Approx(1e40));
}
