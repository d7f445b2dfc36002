// OBJ, PLY and STL: what good files decode to, by hand and against one another, and what damaged
// ones do.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "core/mesh/shapes.h"
#include "proto/wire/input_codes.h"
#include "tests/proto/formats/polygon_files.h"

using namespace geodesic;
using namespace geodesic::proto;

namespace {

// What an STL file keeps of a soup.
TriangleSoup in_facets(const TriangleSoup& soup, bool is_float) {
  TriangleSoup out;
  for (const auto& face : soup.faces) {
    const auto first = static_cast<std::uint32_t>(out.positions.size());
    for (const std::uint32_t v : face) {
      Vec3 p = soup.positions[v];
      if (is_float) p = {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
      out.positions.push_back(p);
    }
    out.faces.push_back({first, first + 1, first + 2});
  }
  return out;
}

void check_same(const TriangleSoup& got, const TriangleSoup& expected) {
  CHECK(got.positions == expected.positions);
  CHECK(got.faces == expected.faces);
}

}  // namespace

TEST_CASE("OBJ, PLY and STL give back to the last bit what was written into them") {
  const TriangleSoup soup = shapes::torus_knot(30, 6, 0.3);
  check_same(good(obj_of(soup), MeshFormat::obj).soup, soup);
  check_same(good(ply_text_of(soup), MeshFormat::ply).soup, soup);
  check_same(good(ply_binary_of(soup, false), MeshFormat::ply).soup, soup);
  check_same(good(ply_binary_of(soup, true), MeshFormat::ply).soup, soup);
  check_same(good(stl_text_of(soup), MeshFormat::stl).soup, in_facets(soup, false));
  check_same(good(stl_binary_of(soup), MeshFormat::stl).soup, in_facets(soup, true));
  CHECK(good(obj_of(soup), MeshFormat::obj).parts[0].name == "thing");
}

TEST_CASE("OBJ corners may count back, and refer to vertices yet to come") {
  const auto back =
      good("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 5 5 5\nf -1 1 -3", MeshFormat::obj);
  CHECK(back.soup.faces == Corners{{0, 1, 2}, {3, 0, 1}});
  const auto ahead =
      good("f 3 2 1\nv 0 0 0 1\nv +1 0 0 0.1 0.2 0.3\nv 0 1e-999 -2.5e1\n", MeshFormat::obj);
  CHECK(ahead.soup.faces == Corners{{2, 1, 0}});
  CHECK(ahead.soup.positions == Places{{0, 0, 0}, {1, 0, 0}, {0, 0, -25}});
}

TEST_CASE("OBJ lines may go on, and what is no face is told") {
  const auto mesh = good(
      "# first a comment\n\n\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvt x y\nf 1 \\\n 2 \\\r\n 3\n"
      "l 1 2\np 1\ncurv 1 2 3\ns off\ng\nusemtl red\n",
      MeshFormat::obj);
  CHECK(mesh.soup.faces == Corners{{0, 1, 2}});
  CHECK(warns_of(mesh, "line 12 draws points or lines, which are left out (and 1 more)"));
  CHECK(warns_of(mesh, "line 14 is a free-form curve"));
}

TEST_CASE("PLY elements that nobody asked for are stepped over") {
  const std::string text =
      "ply\r\nformat ascii 1.0\r\nobj_info x\r\nelement camera 2\r\nproperty list int int a\r\n"
      "property float b\r\nelement vertex 3\r\nproperty short x\r\nproperty int z\r\n"
      "property uint8 y\r\nelement face 1\r\nproperty list int16 uint vertex_index\r\n"
      "element edge 1\r\nproperty int v\r\nend_header\r\n2 9 9 0.5 0 1.5\r\n"
      "0 0 0 1 0 0\r\n0 -3 1\r\n3 2 1 0\r\nanything";
  const auto mesh = good(text, MeshFormat::ply);
  CHECK(mesh.soup.positions == Places{{0, 0, 0}, {1, 0, 0}, {0, 1, -3}});
  CHECK(mesh.soup.faces == Corners{{2, 1, 0}});
}

TEST_CASE("a text PLY may have colours that are no bytes") {
  const auto mesh = good(
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty uint8 red\nproperty int x\n"
      "property float y\nproperty float z\nproperty float quality\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n"
      "128.0 0 0 0 nan\n300 1.5 0 0 1e-50\n-1 0 1 0 0\n3 0 1 2\n",
      MeshFormat::ply);
  CHECK(mesh.soup.positions == Places{{0, 0, 0}, {1.5, 0, 0}, {0, 1, 0}});
}

TEST_CASE("a text file may begin with a byte order mark") {
  const TriangleSoup soup = shapes::icosphere(1);
  const std::string mark = "\xEF\xBB\xBF";
  check_same(good(mark + obj_of(soup), MeshFormat::obj).soup, soup);
  check_same(good(mark + ply_text_of(soup), MeshFormat::ply).soup, soup);
  check_same(good(mark + stl_text_of(soup), MeshFormat::stl).soup, in_facets(soup, false));
  // What says nothing in a binary file may begin so too.
  check_same(good(stl_binary_of(soup).replace(0, 3, mark), MeshFormat::stl).soup,
             in_facets(soup, true));
}

TEST_CASE("damaged OBJ, PLY and STL files end in an error or a mesh that holds together") {
  const TriangleSoup soup = shapes::icosphere(1);
  std::mt19937 random(5);
  int refused = 0;
  int accepted = 0;
  for (const std::string& text :
       {obj_of(soup), ply_text_of(soup), ply_binary_of(soup, false), ply_binary_of(soup, true),
        stl_text_of(soup), stl_binary_of(soup)}) {
    for (int i = 0; i < 2000; ++i) {
      std::string damaged = text;
      if (i % 4 == 0) damaged.resize(random() % text.size());
      for (std::size_t k = random() % 4; k > 0 && !damaged.empty(); --k) {
        const std::size_t at =
            random() % (i % 2 == 0 ? std::min<std::size_t>(400, damaged.size()) : damaged.size());
        damaged[at] =
            static_cast<char>(i % 3 == 0 ? "0123456789-eE. \n/"[random() % 17] : random());
      }
      const auto mesh = decode(bytes_of(damaged));
      if (!mesh) {
        CHECK(mesh.error().code != ErrorCode::internal);
        ++refused;
        continue;
      }
      ++accepted;
      const auto count = mesh->soup.positions.size();
      CHECK_FALSE(mesh->soup.faces.empty());
      CHECK(std::ranges::all_of(mesh->soup.faces, [count](const auto& face) {
        return std::ranges::all_of(face, [count](std::uint32_t v) { return v < count; });
      }));
      CHECK(std::ranges::all_of(mesh->soup.positions, [](const Vec3& p) {
        return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
      }));
    }
  }
  CHECK(refused > 1000);
  CHECK(accepted > 1000);
}

TEST_CASE("a file is known however much it says before it begins") {
  const std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const std::string facet =
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
      "endfacet\nendsolid\n";
  const std::string ply_rest =
      "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  const auto many = [](const std::string& line) {
    std::string lines;
    while (lines.size() < 3'000'000) lines += line;
    return lines;
  };
  const std::string long_line(3'000'000, 'x');
  for (const std::string& file :
       {many("# a comment\n") + obj, many("\n") + obj, many(" \t\r\n") + obj,
        many("#\r\n \n") + obj, "# " + long_line + "\n" + obj, many(" ") + obj,
        "# v\\\n" + many("#\n") + obj, many("\n") + "solid a\n" + facet,
        "solid " + long_line + "\n" + facet, "solid a\n" + many("\r\n") + facet,
        many(" \n") + "solid\n" + many(" \n") + facet,
        "ply\nformat ascii 1.0\n" + many("comment that is one\n") + ply_rest,
        "ply\n" + many("obj_info x\n") + "format ascii 1.0\n" + ply_rest,
        "ply\nformat ascii 1.0\ncomment " + long_line + "\n" + many("\n") + ply_rest}) {
    CAPTURE(file.substr(0, 40));
    const auto mesh = decode(bytes_of(file));
    REQUIRE(mesh);
    CHECK(mesh->soup.faces.size() == 1);
  }
  // What never begins is nothing.
  for (const std::string& file : {many("# a comment\n"), many("\n"), many(" ")}) {
    const auto refused = decode(bytes_of(file));
    REQUIRE_FALSE(refused);
    CHECK(refused.error().code == InputCode::format_unknown);
  }
}
