#include "core/mesh/cut_mesh.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/memory_budget.h"
#include "core/mesh/shapes.h"
#include "core/surface/adjacency.h"
#include "tests/fixtures/awkward_meshes.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::RandomMesh;
using fixtures::test_seed;

namespace {

Mesh built(const TriangleSoup& soup, Weld weld = Weld::by_position) {
  auto mesh = Mesh::build(soup, weld);
  REQUIRE(mesh);
  return std::move(*mesh);
}

// The faces that are left as a file of their own, and where its vertices and faces were.
struct OwnFile {
  TriangleSoup soup;
  std::vector<std::uint32_t> vertices;
  std::vector<std::uint32_t> faces;

  OwnFile(const TriangleSoup& whole, const std::vector<std::uint8_t>& is_left) {
    std::vector<std::uint32_t> number(whole.positions.size(), kNone);
    for (std::size_t f = 0; f < whole.faces.size(); ++f) {
      if (is_left[f] == 0) continue;
      for (const std::uint32_t v : whole.faces[f]) number[v] = 0;
    }
    for (std::uint32_t v = 0; v < number.size(); ++v) {
      if (number[v] == kNone) continue;
      number[v] = static_cast<std::uint32_t>(vertices.size());
      vertices.push_back(v);
      soup.positions.push_back(whole.positions[v]);
    }
    for (std::uint32_t f = 0; f < whole.faces.size(); ++f) {
      if (is_left[f] == 0) continue;
      const auto& t = whole.faces[f];
      faces.push_back(f);
      soup.faces.push_back({number[t[0]], number[t[1]], number[t[2]]});
    }
  }
};

bool same(Vec3 a, Vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

// Whether a mesh that was cut out is what the file of its own is built to, in other numbers.
void check_is_own(const Mesh& cut, const Mesh& whole, const OwnFile& file, Weld weld) {
  const Mesh own = built(file.soup, weld);
  REQUIRE(cut.vertex_count() == own.vertex_count());
  REQUIRE(cut.face_count() == own.face_count());
  for (std::uint32_t v = 0; v < own.vertex_count(); ++v) {
    REQUIRE(same(cut.positions()[v], own.positions()[v]));
  }
  for (std::uint32_t f = 0; f < own.face_count(); ++f) {
    REQUIRE(cut.faces()[f] == own.faces()[f]);
    REQUIRE(cut.source_of_face(f) == file.faces[own.source_of_face(f)]);
  }
  CHECK(same(cut.box().min, own.box().min));
  CHECK(same(cut.box().max, own.box().max));
  CHECK(cut.area() == own.area());
  CHECK(cut.zero_area_face_count() == own.zero_area_face_count());
  REQUIRE(cut.source_vertex_count() == whole.source_vertex_count());
  REQUIRE(cut.source_face_count() == whole.source_face_count());
  std::vector<std::uint32_t> own_vertex(whole.source_vertex_count(), kNone);
  for (std::uint32_t i = 0; i < file.vertices.size(); ++i) {
    own_vertex[file.vertices[i]] = own.vertex_of_source()[i];
  }
  for (std::uint32_t s = 0; s < whole.source_vertex_count(); ++s) {
    const std::uint32_t v = cut.vertex_of_source()[s];
    if (own_vertex[s] != kNone) REQUIRE(v == own_vertex[s]);
    if (v == kNone) continue;
    // Welded to one that is on the surface, it is there, too.
    REQUIRE(same(cut.positions()[v], whole.positions()[whole.vertex_of_source()[s]]));
    REQUIRE(whole.vertex_of_source()[cut.source_of_vertex(v)] == whole.vertex_of_source()[s]);
  }
  std::vector<std::uint32_t> own_face(whole.source_face_count(), kNone);
  for (std::uint32_t i = 0; i < file.faces.size(); ++i) {
    own_face[file.faces[i]] = own.face_of_source(i);
  }
  for (std::uint32_t s = 0; s < whole.source_face_count(); ++s) {
    REQUIRE(cut.face_of_source(s) == own_face[s]);
  }
}

}  // namespace

TEST_CASE("AMeshThatIsCutOutIsThatOfAFileOfItsOwn") {
  constexpr std::uint32_t kMeshes = 60;
  for (std::uint32_t i = 0; i < kMeshes; ++i) {
    const std::uint32_t number = test_seed() + i;
    CAPTURE(number);
    RandomMesh random(number);
    const TriangleSoup& soup = random.soup();
    std::vector<std::uint8_t> is_left(soup.faces.size());
    const double share = random.unit();
    for (std::uint8_t& left : is_left) left = random.unit() < share ? 1 : 0;
    is_left[random.below(random.face_count())] = 1;
    for (const Weld weld : {Weld::by_position, Weld::off}) {
      const Mesh whole = built(soup, weld);
      const auto cut = cut_mesh(whole, is_left, Cancel());
      REQUIRE(cut);
      check_is_own(*cut, whole, OwnFile(soup, is_left), weld);
    }
  }
}

TEST_CASE("CutOutOfAwkwardMeshesFacesKeepTheirNumbers") {
  for (const fixtures::AwkwardMesh& awkward : fixtures::awkward_meshes()) {
    CAPTURE(awkward.name);
    const Mesh whole = built(awkward.soup);
    for (std::size_t gone = 0; gone < awkward.soup.faces.size(); gone += 3) {
      std::vector<std::uint8_t> is_left(awkward.soup.faces.size(), 1);
      is_left[gone] = 0;
      const auto cut = cut_mesh(whole, is_left, Cancel());
      if (!cut) {
        CHECK(cut.error().code == ErrorCode::no_triangles);
        continue;
      }
      for (std::uint32_t s = 0; s < whole.source_face_count(); ++s) {
        const bool is_there = s != gone && whole.face_of_source(s) != kNone;
        REQUIRE((cut->face_of_source(s) != kNone) == is_there);
        REQUIRE_FALSE((cut->is_dropped(s) && (s == gone || !whole.is_dropped(s))));
        if (!is_there) continue;
        const std::uint32_t f = cut->face_of_source(s);
        for (std::size_t c = 0; c < 3; ++c) {
          REQUIRE(same(cut->positions()[cut->faces()[f][c]],
                       whole.positions()[whole.faces()[whole.face_of_source(s)][c]]));
        }
      }
      CHECK(Adjacency::build(std::make_shared<const Mesh>(*cut)).report().vertices_isolated == 0);
    }
  }
}

TEST_CASE("FacesWithoutSurfaceStayOnlyWhereTheyTouchWhatIsLeft") {
  // Vertex 36 is 14 again, and the last face a sliver between the two.
  const TriangleSoup soup = fixtures::plane_with_edge_without_length();
  const Mesh whole = built(soup);
  const auto sliver = static_cast<std::uint32_t>(soup.faces.size() - 1);
  REQUIRE(whole.is_dropped(sliver));
  std::vector<std::uint8_t> is_left(soup.faces.size(), 1);
  auto cut = cut_mesh(whole, is_left, Cancel());
  REQUIRE(cut);
  CHECK(cut->is_dropped(sliver));
  CHECK_FALSE(cut->is_dropped(0));
  is_left[sliver] = 0;
  cut = cut_mesh(whole, is_left, Cancel());
  REQUIRE(cut);
  CHECK_FALSE(cut->is_dropped(sliver));
  CHECK(cut->face_of_source(sliver) == kNone);
  std::fill(is_left.begin(), is_left.end(), 0);
  is_left[0] = is_left[sliver] = 1;  // 0 has neither 14 nor 15
  cut = cut_mesh(whole, is_left, Cancel());
  REQUIRE(cut);
  CHECK_FALSE(cut->is_dropped(sliver));
  is_left[0] = 0;
  cut = cut_mesh(whole, is_left, Cancel());
  REQUIRE_FALSE(cut);
  CHECK(cut.error().code == ErrorCode::no_triangles);
}

TEST_CASE("CuttingOutStopsWhenItIsToldTo") {
  const Mesh whole = built(shapes::plane(120, 120));
  const std::vector<std::uint8_t> all(whole.source_face_count(), 1);
  int questions = 0;
  REQUIRE(cut_mesh(whole, all, Cancel([&] { return ++questions < 0; })));
  CHECK(questions > 10);
  for (int stop_at = 1; stop_at <= questions; stop_at += 3) {
    int asked = 0;
    const auto cut = cut_mesh(whole, all, Cancel([&] { return ++asked >= stop_at; }));
    REQUIRE_FALSE(cut);
    CHECK(cut.error().code == ErrorCode::cancelled);
    CHECK(asked <= stop_at + 2);
  }
}

TEST_CASE("CuttingOutAsksForItsMemory") {
  const Mesh whole = built(shapes::plane(100, 100));
  const std::vector<std::uint8_t> all(whole.source_face_count(), 1);
  std::uint64_t asked = 0;
  MemoryBudget counting([&](std::uint64_t bytes) {
    asked += bytes;
    return std::optional<Error>();
  });
  REQUIRE(cut_mesh(whole, all, Cancel({}, {}, &counting)));
  CHECK(asked > whole.bytes());
  for (std::uint64_t part = 0; part < 10; ++part) {
    std::uint64_t taken = 0;
    MemoryBudget scant([&](std::uint64_t bytes) {
      taken += bytes;
      if (taken <= asked * part / 10) return std::optional<Error>();
      return std::optional<Error>(Error{ErrorCode::too_large, "no more", {}, {}, {}});
    });
    const auto cut = cut_mesh(whole, all, Cancel({}, {}, &scant));
    REQUIRE_FALSE(cut);
    CHECK(cut.error().code == ErrorCode::too_large);
  }
}
