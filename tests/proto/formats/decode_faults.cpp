// OBJ, PLY and STL files with a fault: what each is refused with, and where the fault is said to
// be.
#include <doctest/doctest.h>

#include <cstdint>
#include <cstring>
#include <string>

#include "core/mesh/shapes.h"
#include "tests/proto/formats/polygon_files.h"

using namespace geodesic;
using namespace geodesic::proto;

TEST_CASE("faults of OBJ files are named with their line") {
  const std::string three = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  constexpr auto wrong = ErrorCode::mesh_invalid;
  check_bad("v 0 0\nf 1 1 1\n", wrong, "line 1: a vertex");
  check_bad("v 0 0 x\n", wrong, "line 1: a vertex");
  check_bad("v 0 0 nan\n", wrong, "line 1: a vertex");
  check_bad("v 0 0 1e999\n", wrong, "line 1: a vertex");
  const std::string zeros(400, '0');
  for (const std::string& large :
       {std::string("0.5e400"), std::string("-0.5E+400"), std::string("0.5e99999999999999999999"),
        "1" + zeros, "1" + zeros + "e-5", "0." + zeros + "1e900"}) {
    check_bad("v 0 0 " + large + "\n", wrong, "line 1: a vertex");
  }
  for (const std::string& small :
       {std::string("0.5e-400"), std::string("-5E-400"), std::string("1e-99999999999999999999"),
        "0." + zeros + "1", "-." + zeros + "1e5", "1" + zeros + "e-900"}) {
    CAPTURE(small);
    const auto mesh = good("v 1 0 " + small + "\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", MeshFormat::obj);
    CHECK(mesh.soup.positions[0] == Vec3{1, 0, 0});
  }
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
