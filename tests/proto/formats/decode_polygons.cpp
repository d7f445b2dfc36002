// OBJ, PLY and STL: what good files decode to, by hand and against one another, and
// what bad ones are refused with.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "core/mesh/shapes.h"
#include "proto/mesh/polygon_soup.h"
#include "proto/wire/input_codes.h"
#include "tests/proto/gltf_file/fixture.h"

using namespace geodesic;
using namespace geodesic::proto;

namespace {

using Corners = std::vector<std::array<std::uint32_t, 3>>;
using Places = std::vector<Vec3>;

DecodedMesh good(const std::string& text, MeshFormat format) {
  CHECK(sniff_format(bytes_of(text)) == format);
  auto mesh = decode(bytes_of(text));
  if (!mesh) FAIL(mesh.error().detail);
  CHECK(mesh->format == format);
  REQUIRE(mesh->parts.size() == 1);
  CHECK(mesh->parts[0].vertex_count == mesh->soup.positions.size());
  CHECK(mesh->parts[0].face_count == mesh->soup.faces.size());
  return *mesh;
}

void check_bad(const std::string& text, ErrorCode code, const std::string& named,
               const DecodeLimits& limits = {}) {
  const auto mesh = decode_mesh(bytes_of(text), limits);
  CAPTURE(text);
  REQUIRE_FALSE(mesh.has_value());
  CAPTURE(mesh.error().detail);
  CHECK(mesh.error().code.name() == code.name());
  CHECK(mesh.error().detail.find(named) != std::string::npos);
}

template <class T>
void append(std::string& out, T value, bool swapped = false) {
  std::array<char, sizeof(T)> bytes{};
  std::memcpy(bytes.data(), &value, sizeof(T));
  if (swapped) std::ranges::reverse(bytes);
  out.append(bytes.data(), bytes.size());
}

std::string text_of(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

std::string obj_of(const TriangleSoup& soup) {
  std::string out = "# made by a test\nmtllib ../../etc/passwd\no thing\n";
  for (const Vec3& p : soup.positions) {
    out += "v " + text_of(p.x) + " " + text_of(p.y) + "\t" + text_of(p.z) + "\r\n";
  }
  for (const auto& [a, b, c] : soup.faces) {
    out += "f " + std::to_string(a + 1) + "/7/8 " + std::to_string(b + 1) + "//9 " +
           std::to_string(c + 1) + " # there\n";
  }
  return out;
}

std::string ply_header(const std::string& format, std::size_t vertices, std::size_t faces) {
  return "ply\nformat " + format + " 1.0\ncomment by a test\nelement vertex " +
         std::to_string(vertices) +
         "\nproperty uchar red\nproperty double x\nproperty double y\nproperty double z\n"
         "property list uchar float weights\nelement face " +
         std::to_string(faces) +
         "\nproperty list uchar int vertex_indices\nproperty float quality\nend_header\n";
}

std::string ply_text_of(const TriangleSoup& soup) {
  std::string out = ply_header("ascii", soup.positions.size(), soup.faces.size());
  for (const Vec3& p : soup.positions) {
    out += "255 " + text_of(p.x) + " " + text_of(p.y) + " " + text_of(p.z) + " 2 0.5 nan\n";
  }
  for (const auto& [a, b, c] : soup.faces) {
    out += "3 " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(c) + " 1\n";
  }
  return out;
}

std::string ply_binary_of(const TriangleSoup& soup, bool swapped) {
  std::string out = ply_header(swapped ? "binary_big_endian" : "binary_little_endian",
                               soup.positions.size(), soup.faces.size());
  for (const Vec3& p : soup.positions) {
    append(out, std::uint8_t{255});
    for (const double coordinate : {p.x, p.y, p.z}) append(out, coordinate, swapped);
    append(out, std::uint8_t{1});
    append(out, NAN, swapped);
  }
  for (const auto& face : soup.faces) {
    append(out, std::uint8_t{3});
    for (const std::uint32_t corner : face) append(out, corner, swapped);
    append(out, 1.0F, swapped);
  }
  return out;
}

std::string stl_text_of(const TriangleSoup& soup) {
  std::string out = "solid a facet of\n";
  for (const auto& face : soup.faces) {
    out += " facet normal 0 nan 0\n  OUTER loop\n";
    for (const std::uint32_t v : face) {
      const Vec3& p = soup.positions[v];
      out += "   vertex " + text_of(p.x) + " " + text_of(p.y) + " " + text_of(p.z) + "\n";
    }
    out += "  endloop\n endfacet\n";
  }
  return out + "endsolid a facet of\n";
}

std::string stl_binary_of(const TriangleSoup& soup) {
  std::string out = "solid, though not in text";
  out.resize(80);
  append(out, static_cast<std::uint32_t>(soup.faces.size()));
  for (const auto& face : soup.faces) {
    for (int i = 0; i < 3; ++i) append(out, NAN);
    for (const std::uint32_t v : face) {
      const Vec3& p = soup.positions[v];
      for (const double x : {p.x, p.y, p.z}) append(out, static_cast<float>(x));
    }
    append(out, std::uint16_t{7});
  }
  return out;
}

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

TEST_CASE("faults of OBJ files are named with their line") {
  const std::string three = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  constexpr auto wrong = ErrorCode::mesh_invalid;
  check_bad("v 0 0\nf 1 1 1\n", wrong, "line 1: a vertex");
  check_bad("v 0 0 x\n", wrong, "line 1: a vertex");
  check_bad("v 0 0 nan\n", wrong, "line 1: a vertex");
  check_bad("v 0 0 1e999\n", wrong, "line 1: a vertex");
  check_bad(three + "f 1 2\n", wrong, "line 4: the face has 2 corners");
  check_bad(three + "f 1 2 0\n", wrong, "line 4: a corner");
  check_bad(three + "f 1 2 -4\n", wrong, "line 4: a corner");
  check_bad(three + "f 1 2 4294967297\n", wrong, "4294967297");
  check_bad(three + "f 1 2 99999999999999999999\n", wrong, "line 4: a corner");
  check_bad(three + "f a b c\n", wrong, "names no vertex: a");
  check_bad(three + "f 1 2 4\n", ErrorCode::index_out_of_range, "Face 0 refers to vertex 3");
  check_bad(three, ErrorCode::no_triangles, "no faces");
  check_bad("o nothing\n", ErrorCode::no_triangles, "no vertices");
}

TEST_CASE("faults of PLY files are named with their line or element") {
  const std::string begin = "ply\nformat ascii 1.0\n";
  const std::string vertex =
      "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string face = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  const std::string three = "0 0 0\n1 0 0\n0 1 0\n";
  constexpr auto wrong = ErrorCode::mesh_invalid;
  CHECK(good(begin + vertex + face + three + "3 0 1 2", MeshFormat::ply).soup.faces.size() == 1);
  const std::string x = "element vertex 3\nproperty float x\n";
  const std::string end = "end_header\n";
  check_bad("ply\nformat ascii 1.0\n", wrong, "no `end_header`");
  check_bad("ply\nend_header\n", wrong, "no `format`");
  check_bad("ply\n" + vertex + face + three + "3 0 1 2\n", wrong, "line 2: a PLY header begins");
  check_bad("ply\nformat text 1.0\n" + vertex + face, wrong, "Invalid file format");
  check_bad(begin + begin.substr(4) + vertex + face, wrong, "line 3: a PLY header begins");
  check_bad(begin + "elephant\n", wrong, "line 3: this is no line");
  check_bad(begin + "property float x\n" + vertex + face, wrong, "Unexpected token 'property'");
  check_bad(begin + "element vertex -3\n", wrong, "line 3: an element");
  check_bad(begin + "element vertex 3.5\n", wrong, "line 3: an element");
  check_bad(begin + vertex + vertex + face, wrong, "line 7: an element is there twice");
  check_bad(begin + x + "property string y\n" + end, wrong, "Unexpected token 'string'");
  check_bad(begin + x + "property float\n" + end, wrong, "line 5: a word is lacking");
  check_bad(begin + x + "property comment y\n" + end, wrong, "line 5: a comment");
  check_bad(begin + x + "property list float int y\n" + end, wrong, "length is no integer: y");
  check_bad(begin + x + "property float x\n" + end, wrong, "vertex has x twice");
  check_bad(begin + x + "property list uchar float x\n" + end, wrong, "vertex has x twice");
  check_bad(begin + vertex + "element face 1\nproperty int vertex_indices\n" +
                face.substr(face.find("property")) + three + "3 3 0 1 2\n",
            wrong, "face has vertex_indices twice");
  check_bad(begin + x + "property list int list y\n" + end, wrong, "a list of lists");
  check_bad(begin + x + "property list list int y\n" + end, wrong, "a list of lists");
  check_bad(begin + "element vertex 3\nend_header\n", wrong, "lacks x, y or z");
  check_bad(begin + "element a 3\n" + vertex + face + three, wrong, "a has no properties");
  check_bad(begin + "element vertex 3\nproperty float x\nproperty float y\n" + face + three, wrong,
            "lacks x, y or z");
  check_bad(begin + vertex + "element face 1\nproperty int a\nend_header\n" + three + "3\n", wrong,
            "face has no list");
  check_bad(begin + vertex + face + "0 0 0\n1 0 0\n0 1 here\n3 0 1 2\n", wrong,
            "Error reading 'z' of 'vertex' number 2");
  check_bad(begin + vertex + face + "0 0 0\n1 0 0\n0 1 inf\n3 0 1 2\n", wrong,
            "Error reading 'z' of 'vertex' number 2");
  check_bad(begin + vertex + face + "0 0 0\n1 0 0\n0 1 nan\n3 0 1 2\n", wrong, "vertex 2:");
  const std::string corner = "'vertex_indices' of 'face' number 0";
  check_bad(begin + vertex + face + three + "3 0 1\n", wrong,
            "Unexpected end of file: Error reading value number 3 of " + corner);
  check_bad(begin + vertex + face + three + "-3 0 1 2\n", wrong, "Error reading " + corner);
  check_bad(begin + vertex + face + three + "2 0 1\n", wrong, "face 0: it has 2 corners");
  check_bad(begin + vertex + face + three + "3 0 1 -1\n", wrong, "face 0: a corner");
  check_bad(begin + vertex + face + three + "3 0 1 3\n", ErrorCode::index_out_of_range, "Face 0");
  check_bad(begin + vertex + "end_header\n" + three, ErrorCode::no_triangles, "no faces");
}

TEST_CASE("faults of STL files are named with their line or facet") {
  const std::string head = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n";
  constexpr auto wrong = ErrorCode::mesh_invalid;
  check_bad(head + "vertex 1 0 0\nendloop\nendfacet\n", wrong, "line 6: `vertex`");
  check_bad(head + "vertex 1 0 0\nvertex 1 0 x\nendloop\nendfacet\n", wrong, "line 6: a vertex");
  check_bad(head + "vertex 1 0 0\nvertex 1 1 0\nvertex 2 2 2\n", wrong, "`endloop`");
  check_bad("solid a\nfacet normal 0 0 1\nloop\n", wrong, "line 3: `outer loop`");
  check_bad("solid a\nfacet\nouter loop\n", wrong, "`normal`");
  check_bad("solid a\nendsolid a\n", ErrorCode::no_triangles, "no facets");
  auto binary = stl_binary_of(shapes::plane(3, 3));
  std::memset(binary.data() + 84 + 50 + 12 + 12, 0xFF, 4);
  check_bad(binary, wrong, "Facet 1: vertex 1");
  std::string none(80, ' ');
  none.append(4, '\0');
  check_bad(none, ErrorCode::no_triangles, "no facets");
}

TEST_CASE("claims of PLY files are checked against the bytes before memory is taken") {
  const std::string tail = "\nproperty float x\nproperty float y\nproperty float z\n";
  for (const char* format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    const std::string begin = std::string("ply\nformat ") + format + " 1.0\nelement vertex ";
    check_bad(begin + "20000000" + tail + "end_header\n0 0 0\n", ErrorCode::mesh_invalid,
              "vertex claims 20000000");
    check_bad(begin + "9223372036854775807" + tail + "end_header\n0 0 0\n", ErrorCode::mesh_invalid,
              "vertex claims 9223372036854775807");
  }
  std::string list = ply_header("binary_little_endian", 0, 1);
  list.replace(list.find("uchar int"), 9, "uint  int");
  append(list, std::uint32_t{0xFFFFFFFF});
  append(list, std::uint64_t{0});
  check_bad(list, ErrorCode::mesh_invalid, "face 0: it has 4294967295 corners");
  list[list.size() - 9] = '\x7f';
  check_bad(list, ErrorCode::mesh_invalid, "Error reading value number 3 of 'vertex_indices'");
}

TEST_CASE("PLY headers that rply would misread are read aright, or refused") {
  const std::string rest =
      "element vertex 3\ncomment\nproperty float x\nproperty float y\nobj_info\n"
      "property float z\ncomment " +
      std::string(20000, 'c') +
      "\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
  const std::string begin = "ply\nformat ascii 1.0\n";
  const std::string data = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2";
  // Without a text, a comment took the next line with it; a long one was refused.
  CHECK(good(begin + rest + data, MeshFormat::ply).soup.faces == Corners{{0, 1, 2}});
  // The end of a file without the end of a line was overlooked, and what had been read
  // before was read again.
  for (const std::size_t cut : {1, 2, 3}) {
    check_bad(begin + rest + data.substr(0, data.size() - 2 * cut), ErrorCode::mesh_invalid,
              "Unexpected end of file");
  }
  // Printed into a buffer of 1024 bytes.
  for (const std::size_t length : {256, 1100, 8000, 70000}) {
    const std::string word(length, 'w');
    for (const std::string& line :
         {word + "\n", "element vertex " + word + "\n", "property float " + word + "\n"}) {
      check_bad(begin + "element vertex 3\n" + line + rest + data, ErrorCode::mesh_invalid,
                "line 4: ");
    }
    check_bad(begin + rest + "0 0 " + word + data, ErrorCode::mesh_invalid, "'z' of 'vertex'");
  }
  std::string many;
  for (int i = 0; i < 3000; ++i) many += "property float a\n";
  check_bad(begin + "element vertex 3\n" + many + rest + data, ErrorCode::mesh_invalid,
            "the header is too long");
}

TEST_CASE("the limits of vertices and faces hold for these formats too") {
  const TriangleSoup soup = shapes::plane(4, 4);  // 16 vertices, 18 faces
  for (const std::string& text : {obj_of(soup), ply_text_of(soup), ply_binary_of(soup, false),
                                  stl_text_of(soup), stl_binary_of(soup)}) {
    const bool is_stl = text.starts_with("solid");
    DecodeLimits limits;
    limits.max_vertices = is_stl ? 54 : 16;
    limits.max_faces = 18;
    CHECK(decode_mesh(bytes_of(text), limits).has_value());
    --limits.max_faces;
    check_bad(text, ErrorCode::too_many_faces, "too many faces", limits);
    ++limits.max_faces;
    --limits.max_vertices;
    check_bad(text, ErrorCode::too_many_vertices, "too many vertices", limits);
  }
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
