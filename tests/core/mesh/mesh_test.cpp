#include "core/mesh/mesh.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "core/mesh/shapes.h"

using namespace geodesic;

namespace {

TriangleSoup two_triangles_apart() {
  // A square whose two triangles share no vertex, as flat-shaded files have it.
  return {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 0, 0}, {1, 1, 0}, {0, 1, 0}},
          {{0, 1, 2}, {3, 4, 5}}};
}

}  // namespace

TEST_CASE("WeldsVerticesAtTheSamePosition") {
  const auto mesh = Mesh::build(two_triangles_apart());
  REQUIRE(mesh);
  CHECK(mesh->vertex_count() == 4);
  CHECK(mesh->source_vertex_count() == 6);
  CHECK(mesh->vertex_of_source()[0] == mesh->vertex_of_source()[3]);
  CHECK(mesh->vertex_of_source()[2] == mesh->vertex_of_source()[4]);
  CHECK(mesh->vertex_of_source()[1] != mesh->vertex_of_source()[5]);
  CHECK(mesh->source_of_vertex(mesh->vertex_of_source()[3]) == 0);
  CHECK(mesh->area() == doctest::Approx(1));
}

TEST_CASE("WeldsPositiveAndNegativeZero") {
  TriangleSoup soup = two_triangles_apart();
  soup.positions[3] = {-0.0, 0.0, -0.0};
  const auto mesh = Mesh::build(soup);
  REQUIRE(mesh);
  CHECK(mesh->vertex_count() == 4);
}

// Below Mesh::kMinCoordinate positions are zero, and so is the box that their order is
// counted in: its scale was infinite. Seen by UBSan (float-cast-overflow), and in the box.
TEST_CASE("PositionsNextToNothingAreZero") {
  for (const double tiny : {1e-310, 5e-324, 1e-61, -1e-310}) {
    CAPTURE(tiny);
    TriangleSoup soup;
    soup.positions = {{0, 0, 0}, {tiny, 0, 0}, {0, tiny, 0}, {tiny, tiny, tiny}};
    soup.faces = {{0, 1, 2}, {1, 2, 3}};
    CHECK_FALSE(Mesh::build(soup));  // all at one place
    const auto unwelded = Mesh::build(soup, Weld::off);
    CHECK_FALSE(unwelded);

    soup.positions.push_back({1, 0, 0});
    soup.positions.push_back({0, 1, 0});
    soup.faces.push_back({3, 4, 5});
    const auto mesh = Mesh::build(soup);
    REQUIRE(mesh);
    CHECK(mesh->vertex_count() == 3);
    CHECK(mesh->box().min == Vec3{0, 0, 0});
    CHECK(mesh->box().max == Vec3{1, 1, 0});
  }
}

TEST_CASE("EverySourceVertexKeepsItsPosition") {
  const TriangleSoup soup = shapes::shuffled(shapes::torus_knot(60, 8, 0.3), 7);
  const auto mesh = Mesh::build(soup);
  REQUIRE(mesh);
  for (std::size_t i = 0; i < soup.positions.size(); ++i) {
    CHECK(mesh->positions()[mesh->vertex_of_source()[i]] == soup.positions[i]);
  }
  for (std::uint32_t f = 0; f < soup.faces.size(); ++f) {
    const Triangle& t = mesh->faces()[mesh->face_of_source(f)];
    for (std::size_t c = 0; c < 3; ++c) {
      CHECK(t[c] == mesh->vertex_of_source()[soup.faces[f][c]]);
    }
    CHECK(mesh->source_of_face(mesh->face_of_source(f)) == f);
  }
}

TEST_CASE("OrderDoesNotDependOnTheFile") {
  const TriangleSoup soup = shapes::terrain(20, 3, 1);
  const auto plain = Mesh::build(soup);
  const auto mixed = Mesh::build(shapes::shuffled(soup, 5));
  REQUIRE(plain);
  REQUIRE(mixed);
  REQUIRE(plain->vertex_count() == mixed->vertex_count());
  for (std::uint32_t v = 0; v < plain->vertex_count(); ++v) {
    CHECK(plain->positions()[v] == mixed->positions()[v]);
  }
}

TEST_CASE("DropsFacesThatWeldingCollapsedAndRemembersThem") {
  TriangleSoup soup = two_triangles_apart();
  soup.faces.push_back({0, 3, 1});  // 0 and 3 are one vertex
  const auto mesh = Mesh::build(soup);
  REQUIRE(mesh);
  CHECK(mesh->face_count() == 2);
  CHECK(mesh->dropped_face_count() == 1);
  CHECK(mesh->face_of_source(2) == kNone);
  const Triangle dropped = mesh->dropped_face(2);
  CHECK(dropped[0] == dropped[1]);
  CHECK(dropped[2] == mesh->vertex_of_source()[1]);
}

TEST_CASE("CountsFacesWithoutArea") {
  TriangleSoup soup = two_triangles_apart();
  soup.positions.push_back({0.5, 0, 0});
  soup.faces.push_back({0, 1, 6});
  const auto mesh = Mesh::build(soup);
  REQUIRE(mesh);
  CHECK(mesh->zero_area_face_count() == 1);
  CHECK(mesh->face_count() == 3);
}

TEST_CASE("RefusesWhatIsNoMesh") {
  const auto code_of = [](const TriangleSoup& soup) {
    const auto mesh = Mesh::build(soup);
    REQUIRE_FALSE(mesh);
    return mesh.error().code;
  };
  CHECK(code_of({}) == ErrorCode::no_triangles);
  CHECK(code_of({{{0, 0, 0}}, {}}) == ErrorCode::no_triangles);
  CHECK(code_of({{{0, 0, 0}, {1, 0, 0}}, {{0, 1, 2}}}) == ErrorCode::index_out_of_range);
  CHECK(code_of({{{0, 0, 0}, {0, 0, 0}, {1, 0, 0}}, {{0, 1, 2}}}) == ErrorCode::mesh_invalid);
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), -1e61}) {
    TriangleSoup soup = two_triangles_apart();
    soup.positions[4].y = bad;
    const auto mesh = Mesh::build(soup);
    REQUIRE_FALSE(mesh);
    CHECK(mesh.error().code == ErrorCode::mesh_invalid);
    CHECK(mesh.error().detail.find("vertex 4") != std::string::npos);
  }
}
