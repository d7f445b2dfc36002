// Faces with more than three corners: which triangles they become.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "tests/proto/formats/polygon_files.h"

using namespace geodesic;
using namespace geodesic::proto;

namespace {

double twice_area(const TriangleSoup& soup) {
  Vec3 sum{};
  double sizes = 0;
  for (const auto& [a, b, c] : soup.faces) {
    const Vec3 n =
        cross(soup.positions[b] - soup.positions[a], soup.positions[c] - soup.positions[a]);
    sum = sum + n;
    sizes += norm(n);
  }
  // In a plane, triangles that neither overlap nor reach outside have no more area
  // than the polygon.
  CHECK(norm(sum) == doctest::Approx(sizes));
  return sizes;
}

std::string obj_polygon(const Places& corners) {
  std::string out;
  for (const Vec3& p : corners) {
    out += "v " + text_of(p.x) + " " + text_of(p.y) + " " + text_of(p.z) + "\n";
  }
  out += "f";
  for (std::size_t i = 0; i < corners.size(); ++i) out += " " + std::to_string(i + 1);
  return out + "\n";
}

}  // namespace

TEST_CASE("convex polygons become fans, others are cut within their outline") {
  const auto quad = good("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", MeshFormat::obj);
  CHECK(quad.soup.faces == Corners{{0, 1, 2}, {0, 2, 3}});
  CHECK(quad.findings.at(0).code == "polygons_triangulated");
  CHECK(quad.findings.at(0).count == 1);
  // An arrowhead, whose fan from the first corner would leave it.
  const Places arrow = {{0, 0, 0}, {2, 2, 0}, {0, 0.5, 0}, {-2, 2, 0}};
  Places turned = arrow;
  std::ranges::rotate(turned, turned.begin() + 1);
  for (const Places& corners : {arrow, turned}) {
    const auto cut = good(obj_polygon(corners), MeshFormat::obj);
    CHECK(cut.soup.faces.size() == 2);
    CHECK(twice_area(cut.soup) == doctest::Approx(2));
  }
}

TEST_CASE("a comb is cut into its own area, in any plane and either way round") {
  // Teeth of width 1 and height 5 on a back of height 1.
  Places comb;
  for (int tooth = 0; tooth < 20; ++tooth) {
    const double x = 2 * tooth;
    comb.insert(comb.end(), {{x, 1, 0}, {x, 6, 0}, {x + 1, 6, 0}, {x + 1, 1, 0}});
  }
  comb.insert(comb.end(), {{39, 0, 0}, {0, 0, 0}});
  const double twice = 2 * (20 * 5 + 39);
  for (const Vec3 to : {Vec3{0, 0, 1}, Vec3{0, 1, 0}, Vec3{1, 0, 0}, Vec3{0.6, 0, 0.8}}) {
    Places placed;
    for (const Vec3& p : comb) {
      // Two directions at right angles to `to` and each other.
      const Vec3 across = to.z > 0.9 ? Vec3{1, 0, 0} : Vec3{-to.y, to.x, 0};
      const Vec3 along = (1 / norm(across)) * across;
      placed.push_back(p.x * along + p.y * cross(to, along));
    }
    for (int way = 0; way < 2; ++way) {
      const auto cut = good(obj_polygon(placed), MeshFormat::obj);
      CHECK(cut.soup.faces.size() == placed.size() - 2);
      CHECK(twice_area(cut.soup) == doctest::Approx(twice));
      std::ranges::reverse(placed);
    }
  }
}

TEST_CASE("a polygon that crosses itself, or of very many corners, is a fan, and that is said") {
  const auto bow =
      good(obj_polygon({{0, 0, 0}, {2, 2, 0}, {2, 0, 0}, {0, 3, 0}, {-1, 1, 0}}), MeshFormat::obj);
  CHECK(bow.soup.faces.size() == 3);
  Places star;
  for (int i = 0; i < 600; ++i) {
    const double angle = i * 2 * std::numbers::pi / 600;
    star.push_back({(2 + i % 2) * std::cos(angle), (2 + i % 2) * std::sin(angle), 0});
  }
  const auto many = good(obj_polygon(star), MeshFormat::obj);
  CHECK(many.soup.faces.size() == 598);
  CHECK(warns_of(many, "face 0 crosses itself or has very many corners"));
}
