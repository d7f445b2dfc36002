// What the tests of prepared meshes share.
#pragma once

#include <doctest/doctest.h>
#include <sys/stat.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/surface/intrinsic_delaunay.h"
#include "server/prepared/prepared_files.h"
#include "tests/fixtures/surface.h"
#include "tests/server/routes/service_fixture.h"

namespace geodesic::server::test {

inline const std::string kId(64, 'a');
inline const auto kNeverStop = [] { return false; };

inline std::shared_ptr<const Adjacency> prepared(const TriangleSoup& soup) {
  return fixtures::Surface(soup).shared();
}

inline std::unique_ptr<PreparedFiles> opened(const TemporaryFolder& folder,
                                             const PreparedFiles::Limits& limits = {},
                                             const std::string& engine = std::string(32, '1'),
                                             std::unique_ptr<PreparedBucket> bucket = nullptr) {
  auto files = PreparedFiles::open(folder.path(), limits, engine, std::move(bucket));
  REQUIRE(files);
  return std::move(*files);
}

template <class Array>
bool is_same(const Array& a, const Array& b) {
  const auto one = std::as_bytes(std::span(a));
  const auto other = std::as_bytes(std::span(b));
  return one.size() == other.size() &&
         (one.empty() || std::memcmp(one.data(), other.data(), one.size()) == 0);
}

inline void check_same(const Adjacency& a, const Adjacency& b) {
  const Mesh::Parts& mesh = a.mesh().parts();
  const Mesh::Parts& other_mesh = b.mesh().parts();
  CHECK(is_same(mesh.positions, other_mesh.positions));
  CHECK(is_same(mesh.faces, other_mesh.faces));
  CHECK(is_same(mesh.vertex_of_source, other_mesh.vertex_of_source));
  CHECK(is_same(mesh.source_of_vertex, other_mesh.source_of_vertex));
  CHECK(is_same(mesh.face_of_source, other_mesh.face_of_source));
  CHECK(is_same(mesh.source_of_face, other_mesh.source_of_face));
  CHECK(is_same(mesh.dropped, other_mesh.dropped));
  CHECK(mesh.zero_area_faces == other_mesh.zero_area_faces);
  CHECK(mesh.area == other_mesh.area);
  CHECK(mesh.box.min == other_mesh.box.min);
  CHECK(mesh.box.max == other_mesh.box.max);
  const auto check_view = [](const Triangulation& one, const Triangulation& other) {
    CHECK(is_same(one.faces, other.faces));
    CHECK(is_same(one.corner_begin, other.corner_begin));
    CHECK(is_same(one.all_corners, other.all_corners));
    CHECK(one.is_oriented == other.is_oriented);
    CHECK(one.is_even == other.is_even);
    CHECK(one.has_flat_faces == other.has_flat_faces);
    CHECK(one.is_crowded == other.is_crowded);
    CHECK(one.has_lines == other.has_lines);
  };
  check_view(a.triangulation(), b.triangulation());
  check_view(a.delaunay(), b.delaunay());
  CHECK((a.parts().delaunay == nullptr) == (b.parts().delaunay == nullptr));
  if (a.parts().delaunay) CHECK(a.parts().delaunay->flips() == b.parts().delaunay->flips());
  CHECK(is_same(a.parts().pinched, b.parts().pinched));
  CHECK(std::memcmp(&a.report(), &b.report(), sizeof(TopologyReport)) == 0);
}

inline std::filesystem::path only_file(const TemporaryFolder& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry :
       std::filesystem::directory_iterator(folder.path() / "geodesicd-prepared")) {
    files.push_back(entry.path());
  }
  REQUIRE(files.size() == 1);
  return files.front();
}

inline std::size_t count_files(const TemporaryFolder& folder) { return folder.files().size(); }

inline std::string bytes_of_file(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {(std::istreambuf_iterator<char>(in)), {}};
}

inline void set_contents(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  REQUIRE(::chmod(path.c_str(), 0600) == 0);
}

}  // namespace geodesic::server::test
