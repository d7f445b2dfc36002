// OBJ, PLY and STL files made in code, and what is asked of every good and every bad one.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "core/mesh/triangle_soup.h"
#include "tests/proto/gltf_file/fixture.h"

namespace geodesic::proto {

using Corners = std::vector<std::array<std::uint32_t, 3>>;
using Places = std::vector<Vec3>;

inline DecodedMesh good(const std::string& text, MeshFormat format) {
  CHECK(sniff_format(bytes_of(text)) == format);
  auto mesh = decode(bytes_of(text));
  if (!mesh) FAIL(mesh.error().detail);
  CHECK(mesh->format == format);
  REQUIRE(mesh->parts.size() == 1);
  CHECK(mesh->parts[0].vertex_count == mesh->soup.positions.size());
  CHECK(mesh->parts[0].face_count == mesh->soup.faces.size());
  return *mesh;
}

inline void check_bad(const std::string& text, ErrorCode code, const std::string& named,
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

inline std::string text_of(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

inline std::string obj_of(const TriangleSoup& soup) {
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

inline std::string ply_header(const std::string& format, std::size_t vertices, std::size_t faces) {
  return "ply\nformat " + format + " 1.0\ncomment by a test\nelement vertex " +
         std::to_string(vertices) +
         "\nproperty uchar red\nproperty double x\nproperty double y\nproperty double z\n"
         "property list uchar float weights\nelement face " +
         std::to_string(faces) +
         "\nproperty list uchar int vertex_indices\nproperty float quality\nend_header\n";
}

inline std::string ply_text_of(const TriangleSoup& soup) {
  std::string out = ply_header("ascii", soup.positions.size(), soup.faces.size());
  for (const Vec3& p : soup.positions) {
    out += "255 " + text_of(p.x) + " " + text_of(p.y) + " " + text_of(p.z) + " 2 0.5 nan\n";
  }
  for (const auto& [a, b, c] : soup.faces) {
    out += "3 " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(c) + " 1\n";
  }
  return out;
}

inline std::string ply_binary_of(const TriangleSoup& soup, bool swapped) {
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

inline std::string stl_text_of(const TriangleSoup& soup) {
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

inline std::string stl_binary_of(const TriangleSoup& soup) {
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

}  // namespace geodesic::proto
