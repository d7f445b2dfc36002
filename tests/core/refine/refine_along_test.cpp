#include "core/refine/refine_along.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/memory_budget.h"
#include "core/mesh/shapes.h"
#include "core/refine/face_pieces.h"
#include "tests/core/refine/cut_surface.h"
#include "tests/core/refine/lines_on_meshes.h"
#include "tests/fixtures/awkward_meshes.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::kPlenty;
using fixtures::length_of;
using fixtures::random_line;
using fixtures::RandomMesh;
using fixtures::Surface;
using fixtures::test_seed;

namespace {

double diagonal_of(const Mesh& mesh) { return distance(mesh.box().min, mesh.box().max); }

double length_along(const Mesh& mesh, const std::vector<std::uint32_t>& chain) {
  double length = 0;
  for (std::size_t i = 1; i < chain.size(); ++i) {
    length += distance(mesh.positions()[chain[i - 1]], mesh.positions()[chain[i]]);
  }
  return length;
}

// Parts cover each face once, and lie where they say.
void check_pieces(const RefinedMesh& refined, const Mesh& whole) {
  const Cancel never;
  Poll poll(never);
  std::vector<double> covered(whole.source_face_count(), 0);
  for (std::uint32_t f = 0; f < refined.mesh.face_count(); ++f) {
    const std::uint32_t parent = refined.mesh.source_of_face(f);
    const FacePiece* piece = refined.refinement.piece(f);
    const Triangle& t = refined.mesh.faces()[f];
    const Triangle& whole_corners = whole.faces()[whole.face_of_source(parent)];
    if (piece == nullptr) {
      CHECK(covered[parent] == 0);
      covered[parent] = 1;
      CHECK(refined.mesh.face_of_source(parent) == f);
      continue;
    }
    CHECK(piece->parent == parent);
    const auto& [a, b, c] = piece->corners;
    const double part = (b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1]);
    CHECK(part >= -1e-15);
    covered[parent] += part;
    for (std::size_t k = 0; k < 3; ++k) {
      Vec3 there{};
      for (std::size_t j = 0; j < 3; ++j) {
        there = there + piece->corners[k][j] * whole.positions()[whole_corners[j]];
      }
      CHECK(distance(there, refined.mesh.positions()[t[k]]) < 1e-12 * diagonal_of(whole));
    }
    // There and back again.
    const Weights middle{0.3, 0.3, 0.4};
    const auto in_parent = refined.refinement.in_parent(f, middle);
    REQUIRE(in_parent);
    const auto back = refined.refinement.in_piece(parent, *in_parent, poll);
    REQUIRE(back);
    if (part > 1e-6) {
      CHECK(back->face == f);
      for (std::size_t k = 0; k < 3; ++k) {
        CHECK(back->bary[k] == doctest::Approx(middle[k]).epsilon(1e-6));
      }
    }
  }
  for (std::uint32_t s = 0; s < whole.source_face_count(); ++s) {
    if (whole.face_of_source(s) == kNone) continue;
    CHECK(covered[s] == doctest::Approx(1).epsilon(1e-9));
    CHECK(refined.mesh.face_of_source(s) != kNone);
  }
}

void check_chains(const RefinedMesh& refined, const Adjacency& adjacency, const Mesh& whole,
                  const std::vector<SurfacePolyline>& lines) {
  const double near = 1e-7 * diagonal_of(whole);
  REQUIRE(refined.chains.size() == lines.size());
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto& chain = refined.chains[i];
    REQUIRE(!chain.empty());
    for (std::size_t k = 1; k < chain.size(); ++k) {
      CHECK(chain[k - 1] != chain[k]);
      CHECK(adjacency.find_edge(chain[k - 1], chain[k]) != kNone);
    }
    CHECK(std::abs(length_along(refined.mesh, chain) - length_of(whole, lines[i])) <
          near * static_cast<double>(lines[i].size()));
    // In this order.
    std::size_t at = 0;
    for (const SurfacePoint& point : lines[i]) {
      const Vec3 place = position_of(whole, point);
      while (at < chain.size() && distance(refined.mesh.positions()[chain[at]], place) > near) ++at;
      REQUIRE(at < chain.size());
    }
  }
}

// The same surface: as many pieces and holes, and as far from everywhere to everywhere.
void check_is_same_surface(const Adjacency& refined, const Adjacency& whole, RandomMesh& random) {
  const auto euler = [](const Adjacency& of) {
    return static_cast<std::int64_t>(of.mesh().vertex_count()) -
           static_cast<std::int64_t>(of.report().edges) + of.mesh().face_count();
  };
  CHECK(euler(refined) == euler(whole));
  CHECK(refined.report().components == whole.report().components);
  CHECK(refined.report().boundary_loops == whole.report().boundary_loops);
  CHECK(refined.mesh().area() == doctest::Approx(whole.mesh().area()).epsilon(1e-9));
  const std::uint32_t from = random.vertex();
  const auto field = [&](const Adjacency& of) {
    SolveScratch scratch;
    const Source source{point_at_vertex(of, of.mesh().vertex_of_source()[from]), 0};
    auto found = solve_field(Method::exact, {}, of, {&source, 1}, {}, scratch, Cancel());
    REQUIRE(found);
    return std::move(*found);
  };
  const Field before = field(whole);
  const Field after = field(refined);
  for (std::uint32_t s = 0; s < whole.mesh().source_vertex_count(); ++s) {
    const double a = before.distance[whole.mesh().vertex_of_source()[s]];
    const double b = after.distance[refined.mesh().vertex_of_source()[s]];
    CAPTURE(s);
    if (a == kUnreached || b == kUnreached) {
      CHECK(a == b);
    } else {
      CHECK(std::abs(a - b) <= 1e-9 * diagonal_of(whole.mesh()));
    }
  }
}

}  // namespace

TEST_CASE("AMeshRefinedAlongLinesHasThemAsEdgesAndIsTheSameSurface") {
  constexpr std::uint32_t kMeshes = 40;
  for (std::uint32_t i = 0; i < kMeshes; ++i) {
    const std::uint32_t number = test_seed() + i;
    CAPTURE(number);
    RandomMesh random(number);
    const Surface surface(random.soup());
    std::vector<SurfacePolyline> lines;
    const std::uint32_t count = 1 + random.below(4);
    for (std::uint32_t k = 0; k < count; ++k) {
      lines.push_back(random_line(random, surface.adjacency(), 1 + random.below(12)));
    }
    const auto refined = refine_along(surface.adjacency(), lines, kPlenty, Cancel());
    REQUIRE(refined);
    const Adjacency adjacency = Adjacency::build(std::make_shared<const Mesh>(refined->mesh));
    check_pieces(*refined, surface.mesh());
    check_chains(*refined, adjacency, surface.mesh(), lines);
    check_is_same_surface(adjacency, surface.adjacency(), random);
  }
}

TEST_CASE("ManyLinesInOneFaceCrossEachOther") {
  RandomMesh random(test_seed());
  TriangleSoup soup;
  soup.positions = {{0, 0, 0}, {3, 0, 0}, {1, 2, 0}};
  soup.faces = {{0, 1, 2}};
  const Surface surface(soup);
  std::vector<SurfacePolyline> lines;
  for (int i = 0; i < 12; ++i) {
    SurfacePolyline& line = lines.emplace_back();
    for (int k = 0; k < 3; ++k) {
      line.push_back(surface.on(0, {random.unit() + 1e-3, random.unit(), random.unit()}));
    }
    // Over what is there already, and back.
    line.push_back(line[1]);
    if (i > 0) {
      line.push_back(lines[static_cast<std::size_t>(i) - 1][0]);
      line.push_back(lines[static_cast<std::size_t>(i) - 1][1]);
    }
  }
  const auto refined = refine_along(surface.adjacency(), lines, kPlenty, Cancel());
  REQUIRE(refined);
  const Adjacency adjacency = Adjacency::build(std::make_shared<const Mesh>(refined->mesh));
  check_pieces(*refined, surface.mesh());
  check_chains(*refined, adjacency, surface.mesh(), lines);
  // A field of a triangle is the straight distance.
  const Source source{point_at_vertex(adjacency, adjacency.mesh().vertex_of_source()[0]), 0};
  SolveScratch scratch;
  const auto field = solve_field(Method::exact, {}, adjacency, {&source, 1}, {}, scratch, Cancel());
  REQUIRE(field);
  for (std::uint32_t v = 0; v < adjacency.mesh().vertex_count(); ++v) {
    CHECK(std::abs(field->distance[v] - norm(adjacency.mesh().positions()[v])) < 1e-8);
  }
}

namespace {

// The part of the one face in which a point is, or on whose border, found by looking at all of them
// in turn.
std::optional<std::uint32_t> part_of_all(const Refinement& refinement, const Weights& bary) {
  const auto area2 = [](const Weights& a, const Weights& b, const Weights& c) {
    return (b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1]);
  };
  std::optional<std::uint32_t> found;
  double deepest = -1e-9;
  for (const FacePiece& part : refinement.pieces()) {
    const auto& [a, b, c] = part.corners;
    const double all = area2(a, b, c);
    if (!(all > 0)) continue;
    const double depth =
        std::min({area2(bary, b, c) / all, area2(a, bary, c) / all, area2(a, b, bary) / all});
    if (depth <= deepest) continue;
    found = part.face;
    if (depth >= 0) break;
    deepest = depth;
  }
  return found;
}

}  // namespace

TEST_CASE("APointOfASplitFaceIsFoundAmongItsPartsByLookingAtFew") {
  RandomMesh random(test_seed());
  TriangleSoup soup;
  soup.positions = {{0, 0, 0}, {3, 0, 0}, {1, 2, 0}};
  soup.faces = {{0, 1, 2}};
  const Surface surface(soup);
  std::vector<SurfacePolyline> lines(30);
  for (SurfacePolyline& line : lines) {
    for (int k = 0; k < 3; ++k) {
      line.push_back(surface.on(0, {random.unit() + 1e-3, random.unit(), random.unit()}));
    }
  }
  const auto refined = refine_along(surface.adjacency(), lines, kPlenty, Cancel());
  REQUIRE(refined);
  const Refinement& refinement = refined->refinement;
  std::vector<Weights> points;
  for (int i = 0; i < 300; ++i) {
    const SurfacePoint anywhere =
        surface.on(0, {random.unit() + 1e-3, random.unit(), random.unit()});
    points.push_back(anywhere.bary);
    // And at a corner of a part, or in the middle of a side.
    const auto parts = static_cast<std::uint32_t>(refinement.pieces().size());
    const auto& corners = refinement.pieces()[random.below(parts)].corners;
    Weights on_border = corners[random.below(3)];
    const Weights& other = corners[random.below(3)];
    for (std::size_t k = 0; k < 3; ++k) on_border[k] = 0.5 * (on_border[k] + other[k]);
    points.push_back(on_border);
  }
  std::uint64_t looked_at = 0;
  const Cancel counted([&] {
    ++looked_at;
    return false;
  });
  Poll poll(counted, 1);
  for (const Weights& bary : points) {
    const auto there = refinement.in_piece(0, bary, poll);
    REQUIRE(there);
    CHECK(there->face == part_of_all(refinement, bary));
  }
  CHECK(looked_at > 0);
  CHECK(4 * looked_at < points.size() * refinement.pieces().size());
  const Cancel at_once([] { return true; });
  Poll stopped(at_once, 1);
  CHECK_FALSE(refinement.in_piece(0, points[0], stopped));
  CHECK(stopped.stopped());
}

namespace {

// Of all triangles, the one that a place is deepest in.
std::size_t deepest_of_all(const FacePieces& pieces, const Weights& place) {
  std::size_t deepest = 0;
  double depth = -2;
  for (std::size_t i = 0; i < pieces.triangles().size(); ++i) {
    double least = 2;
    for (std::size_t c = 0; c < 3; ++c) {
      const Weights& a = pieces.points()[pieces.triangles()[i][c]];
      const Weights& b = pieces.points()[pieces.triangles()[i][(c + 1) % 3]];
      const double x = b[1] - a[1];
      const double y = b[2] - a[2];
      least = std::min(least, (x * (place[2] - a[2]) - y * (place[1] - a[1])) / std::hypot(x, y));
    }
    if (least <= depth) continue;
    depth = least;
    deepest = i;
  }
  return deepest;
}

// Triangles that cover the face once.
void check_covers_the_face(const FacePieces& pieces) {
  double sum = 0;
  for (const auto& triangle : pieces.triangles()) {
    const Weights& a = pieces.points()[triangle[0]];
    const Weights& b = pieces.points()[triangle[1]];
    const Weights& c = pieces.points()[triangle[2]];
    const double part = (b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1]);
    CHECK(part >= -1e-15);
    sum += part;
  }
  CHECK(sum == doctest::Approx(1).epsilon(1e-9));
}

}  // namespace

TEST_CASE("APointInsideAFaceIsPutIntoTheTriangleThatHasIt") {
  RandomMesh random(test_seed());
  const Cancel never;
  Poll poll(never);
  FacePieces pieces;
  for (int i = 0; i < 400; ++i) {
    Weights place{random.unit() + 0.01, random.unit() + 0.01, random.unit() + 0.01};
    if (i % 4 == 0) {  // in the middle of an edge between two triangles
      const auto count = static_cast<std::uint32_t>(pieces.triangles().size());
      const auto& triangle = pieces.triangles()[random.below(count)];
      const std::uint32_t c = random.below(3);
      for (std::size_t k = 0; k < 3; ++k) {
        place[k] = pieces.points()[triangle[c]][k] + pieces.points()[triangle[(c + 1) % 3]][k];
      }
      if (std::min({place[0], place[1], place[2]}) < 1e-6) continue;
    }
    const double sum = place[0] + place[1] + place[2];
    for (double& weight : place) weight /= sum;
    const std::size_t deepest = deepest_of_all(pieces, place);
    const std::uint32_t at = pieces.add_inside(place, poll);
    REQUIRE(at + 1 == pieces.points().size());
    const auto& triangle = pieces.triangles()[deepest];
    CHECK(std::find(triangle.begin(), triangle.end(), at) != triangle.end());
  }
  check_covers_the_face(pieces);
}

// As a wall by a person's hand is: long, and with each point near the one before.
TEST_CASE("ALongLineInsideAFaceLooksAtFewOfItsPieces") {
  RandomMesh random(test_seed());
  constexpr int kPoints = 1500;
  const double turns = 6 + 6 * random.unit();
  std::uint64_t looked_at = 0;
  const Cancel counted([&] {
    ++looked_at;
    return false;
  });
  Poll poll(counted, 1);
  FacePieces pieces;
  std::uint64_t all = 0;
  std::vector<std::uint32_t> line;
  for (int i = 0; i < kPoints; ++i) {
    const double part = (i + 0.3 * random.unit()) / kPoints;
    const double angle = 2 * 3.14159265358979 * turns * part;
    const double radius = 0.01 + 0.19 * part;
    Weights place{0, 1.0 / 3 + radius * std::cos(angle), 1.0 / 3 + radius * std::sin(angle)};
    place[0] = 1 - place[1] - place[2];
    all += pieces.points().size() + pieces.triangles().size();
    line.push_back(pieces.add_inside(place, poll));
    if (i == 0) continue;
    const auto chain = pieces.join(line[line.size() - 2], line.back(), poll);
    CHECK(chain.back() == line.back());
  }
  CHECK(10 * looked_at < all);
  check_covers_the_face(pieces);
  // What is as near as one point is that.
  const std::size_t count = pieces.points().size();
  for (int i = 0; i < 200; ++i) {
    const std::uint32_t point = line[random.below(kPoints)];
    Weights beside = pieces.points()[point];
    beside[1] += 1e-9 * (2 * random.unit() - 1);
    beside[2] += 1e-9 * (2 * random.unit() - 1);
    beside[0] = 1 - beside[1] - beside[2];
    CHECK(pieces.add_inside(beside, poll) == point);
  }
  CHECK(pieces.points().size() == count);
}

TEST_CASE("LinesAlongEdgesSplitNothing") {
  for (std::uint32_t i = 0; i < 10; ++i) {
    RandomMesh random(test_seed() + i);
    const Surface surface(random.soup());
    const Mesh& mesh = surface.mesh();
    SurfacePolyline line{point_at_vertex(surface.adjacency(), mesh.faces()[0][0])};
    for (int k = 0; k < 5; ++k) {
      const auto corners = surface.adjacency().corners(line.back().vertex);
      const auto at = corners[random.below(static_cast<std::uint32_t>(corners.size()))];
      line.push_back(point_at_vertex(
          surface.adjacency(), surface.adjacency().face(face_of(at)).vertex[random.below(3)]));
    }
    const std::vector<SurfacePolyline> lines{line};
    const auto refined = refine_along(surface.adjacency(), lines, 0, Cancel());
    REQUIRE(refined);
    CHECK(refined->refinement.pieces().empty());
    REQUIRE(refined->mesh.vertex_count() == mesh.vertex_count());
    REQUIRE(refined->mesh.face_count() == mesh.face_count());
    for (std::uint32_t v = 0; v < mesh.vertex_count(); ++v) {
      REQUIRE(refined->mesh.positions()[v] == mesh.positions()[v]);
      REQUIRE(refined->mesh.source_of_vertex(v) == mesh.source_of_vertex(v));
    }
    for (std::uint32_t f = 0; f < mesh.face_count(); ++f) {
      REQUIRE(refined->mesh.faces()[f] == mesh.faces()[f]);
      REQUIRE(refined->mesh.source_of_face(f) == mesh.source_of_face(f));
    }
    std::vector<std::uint32_t> vertices;
    for (const SurfacePoint& point : line) {
      if (vertices.empty() || vertices.back() != point.vertex) vertices.push_back(point.vertex);
    }
    CHECK(refined->chains[0] == vertices);
  }
}

// A face without width whose middle corner lies on the side of a larger face; and a face between
// that corner and the larger one's apex, which lies on the larger one but is joined to it in these
// two corners only. A line from the place on the side to the apex does not join them by an edge.
TEST_CASE("FacesThatTouchAlongALineAreNotJoinedThere") {
  RandomMesh random(test_seed());
  for (int round = 0; round < 50; ++round) {
    CAPTURE(round);
    TriangleSoup soup;
    const double length = 4 * (1 + random.below(6));
    const Vec3 side{length, 0, 0};
    const Vec3 corner = 0.25 * (1 + random.below(3)) * side;
    const Vec3 apex{random.unit() * length, 1 + random.unit(), random.unit()};
    const Vec3 aside{random.unit() * length, -1 - random.unit(), 1 + random.unit()};
    soup.positions = {{0, 0, 0}, side, corner, apex, aside};
    soup.faces = {{0, 1, 3}, {0, 2, 1}, {2, 3, 4}};
    if (random.below(2) == 0) soup.faces.push_back({1, 3, 0});  // the larger one again
    const Surface surface(soup);
    const double t = corner.x / length;
    const SurfacePolyline line{surface.on(0, {1 - t, t, 0}), surface.at(3)};
    const auto refined = refine_along(surface.adjacency(), {&line, 1}, kPlenty, Cancel());
    REQUIRE(refined);
    CHECK(length_along(refined->mesh, refined->chains[0]) ==
          doctest::Approx(length_of(surface.mesh(), line)));
    const auto mesh = std::make_shared<const Mesh>(refined->mesh);
    const Adjacency adjacency = Adjacency::build(mesh);
    const auto there = [&](std::uint32_t s) { return mesh->vertex_of_source()[s]; };
    SolveScratch scratch;
    for (const std::uint32_t from : {0U, 1U, 4U}) {
      const Source source{point_at_vertex(adjacency, there(from)), 0};
      const auto field =
          solve_field(Method::exact, {}, adjacency, {&source, 1}, {}, scratch, Cancel());
      REQUIRE(field);
      const Field whole = surface.field_by(Method::exact, {{surface.at(from), 0}});
      for (std::uint32_t s = 0; s < 5; ++s) {
        CHECK(field->distance[there(s)] ==
              doctest::Approx(whole.distance[surface.vertex(s)]).epsilon(1e-9));
      }
    }
  }
}

TEST_CASE("RefiningIsBoundedAndCanBeStopped") {
  const Surface surface(shapes::plane(20, 20));
  RandomMesh random(test_seed());
  const std::vector<SurfacePolyline> lines{random_line(random, surface.adjacency(), 300),
                                           random_line(random, surface.adjacency(), 300)};
  const auto all = refine_along(surface.adjacency(), lines, kPlenty, Cancel());
  REQUIRE(all);
  const std::uint32_t made = all->mesh.vertex_count() - surface.mesh().vertex_count();
  // Some places become one when the mesh is built.
  std::uint32_t too_few = 0;
  std::uint32_t enough = 2 * made + 100;
  const auto refined_within = [&](std::uint32_t most) {
    return refine_along(surface.adjacency(), lines, most, Cancel());
  };
  REQUIRE(refined_within(enough));
  while (enough - too_few > 1) {
    const std::uint32_t middle = (too_few + enough) / 2;
    (refined_within(middle) ? enough : too_few) = middle;
  }
  CHECK(enough >= made);
  CHECK(enough < made + made / 10 + 10);
  const auto over = refined_within(too_few);
  REQUIRE(!over);
  CHECK(over.error().code == ErrorCode::too_large);
  CHECK(over.error().limit == too_few);
  const auto stopped =
      refine_along(surface.adjacency(), lines, kPlenty, Cancel([] { return true; }));
  REQUIRE(!stopped);
  CHECK(stopped.error().code == ErrorCode::cancelled);
  MemoryBudget budget([](std::uint64_t) -> std::optional<Error> {
    return Error{ErrorCode("too_much_memory"), "no", {}, {}, {}};
  });
  const auto refused = refine_along(surface.adjacency(), lines, kPlenty, Cancel({}, {}, &budget));
  REQUIRE(!refused);
  CHECK(refused.error().code == ErrorCode("too_much_memory"));
  const std::vector<SurfacePolyline> apart{{surface.at(0), surface.at(200)}};
  const auto bad = refine_along(surface.adjacency(), apart, kPlenty, Cancel());
  REQUIRE(!bad);
  CHECK(bad.error().code == ErrorCode::value_out_of_range);
  CHECK(!refine_along(surface.adjacency(), std::vector<SurfacePolyline>(1), kPlenty, Cancel()));
}
