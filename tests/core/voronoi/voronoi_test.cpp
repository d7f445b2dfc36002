#include "core/voronoi/voronoi.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "core/mesh/shapes.h"
#include "core/paths/arrive_at_point.h"
#include "core/voronoi/face_cells.h"
#include "tests/core/voronoi/cell_checks.h"
#include "tests/fixtures/awkward_meshes.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::Surface;
using fixtures::test_seed;

namespace {

constexpr std::uint64_t kMostSteps = 1'000'000'000;

FieldLimits without_details() {
  FieldLimits limits;
  limits.keep_details = false;
  return limits;
}

Voronoi cells_by(const Surface& surface, const std::vector<Source>& sites,
                 Method method = Method::exact) {
  SolveScratch scratch;
  const Field field = surface.field_by(method, sites, without_details());
  auto found = voronoi(method, {}, surface.adjacency(), field, kMostSteps, scratch, Cancel());
  REQUIRE(found);
  return std::move(*found);
}

// Vertices, places inside faces, sometimes twice the same, sometimes with an offset.
std::vector<Source> any_sources(const Surface& surface, std::mt19937& random) {
  const auto unit = [&] { return random() / 4294967296.0; };
  std::vector<Source> sites;
  const std::size_t count = 1 + random() % 9;
  for (std::size_t i = 0; i < count; ++i) {
    const auto f = static_cast<std::uint32_t>(random() % surface.mesh().face_count());
    Source site{point_on_face(surface.adjacency(), f, {unit() + 1e-3, unit(), unit()}), 0};
    if (random() % 2 == 0) {
      site.point = point_at_vertex(surface.adjacency(), surface.mesh().faces()[f][0]);
    }
    if (random() % 6 == 0 && !sites.empty()) site = sites.front();
    if (random() % 6 == 0) site.offset = unit();
    sites.push_back(site);
  }
  return sites;
}

void check_cells(const Surface& surface, const std::vector<Source>& sites, Method method) {
  const Field field = surface.field_by(method, sites, without_details());
  const Voronoi found = cells_by(surface, sites, method);
  REQUIRE(found.cells.size() == sites.size());
  fixtures::check_measures(surface, field, found);

  // Fields of each site alone say which is nearest; the field of all is no farther.
  std::vector<Field> alone;
  for (const Source& site : sites) {
    alone.push_back(surface.field_by(method, {site}, without_details()));
  }
  const bool is_metric = traits_of(method).are_metric;
  for (const std::uint32_t v : surface.mesh().vertex_of_source()) {
    if (field.distance[v] == kUnreached || !is_metric) continue;
    double least = kUnreached;
    for (const Field& own : alone) least = std::min(least, own.distance[v]);
    const std::uint32_t nearest = found.near->nearest(v);
    REQUIRE(nearest < sites.size());
    const double slack = 1e-9 * (1 + least);
    CHECK(alone[nearest].distance[v] <= least + slack);
    if (field.nearest_source.empty()) continue;
    // The labels of the field, but for ties.
    const std::uint32_t label = field.nearest_source[v];
    if (label != nearest) CHECK(alone[label].distance[v] <= alone[nearest].distance[v] + slack);
  }
}

}  // namespace

TEST_CASE("CellsAddUpToTheSurface") {
  std::mt19937 random(test_seed());
  for (int i = 0; i < 40; ++i) {
    const auto number = static_cast<std::uint32_t>(random());
    CAPTURE(number);
    const Surface surface(fixtures::RandomMesh(number).soup());
    const Method methods[] = {Method::exact,         Method::chen_han, Method::back_traced,
                              Method::wavefront,     Method::novotni,  Method::dijkstra,
                              Method::fast_marching, Method::steiner};
    const Method method = methods[random() % 8];
    CAPTURE(static_cast<int>(method));
    check_cells(surface, any_sources(surface, random), method);
  }
}

TEST_CASE("CellsOfAwkwardSurfacesAddUp") {
  std::mt19937 random(test_seed());
  for (const fixtures::AwkwardMesh& mesh : fixtures::awkward_meshes()) {
    CAPTURE(mesh.name);
    const Surface surface(mesh.soup);
    check_cells(surface, any_sources(surface, random), Method::exact);
    check_cells(surface, any_sources(surface, random), Method::back_traced);
  }
}

// The same where the greatest coordinates and the least ones make products that no double has.
TEST_CASE("CellsAreTheSameInAnyUnit") {
  const TriangleSoup soup = shapes::terrain(9, 3, test_seed());
  std::vector<double> shares;
  for (const double unit : {1.0, 1e50, 1e-40}) {
    TriangleSoup scaled = soup;
    for (Vec3& p : scaled.positions) p = unit * p;
    const Surface surface(scaled);
    const Voronoi found =
        cells_by(surface, {{surface.at(3), 0}, {surface.at(40), 0}, {surface.at(77), 0}});
    for (std::size_t i = 0; i < 3; ++i) {
      const double share = found.cells[i].area / surface.mesh().area();
      if (unit == 1) {
        shares.push_back(share);
      } else {
        CHECK(share == doctest::Approx(shares[i]).epsilon(1e-9));
      }
    }
  }
}

// n cells that are discs meet in 2 (n - 2) points, by Euler's formula, and their dual is the
// sphere again.
TEST_CASE("CellsOfASphereMeetAsEulerSays") {
  std::mt19937 random(test_seed());
  const Surface surface(shapes::icosphere(3));
  for (int round = 0; round < 10; ++round) {
    const std::size_t count = 12 + random() % 80;
    const bool in_faces = round % 2 == 0;
    std::vector<Source> sites;
    std::vector<bool> is_taken(surface.mesh().face_count());
    while (sites.size() < count) {
      const auto f = static_cast<std::uint32_t>(random() % surface.mesh().face_count());
      if (is_taken[f]) continue;
      if (in_faces) {
        const auto unit = [&] { return 0.05 + random() / 4294967296.0; };
        is_taken[f] = true;
        sites.push_back({point_on_face(surface.adjacency(), f, {unit(), unit(), unit()}), 0});
      } else {
        const std::uint32_t v = surface.mesh().faces()[f][0];
        for (const std::uint32_t corner : surface.adjacency().corners(v)) {
          is_taken[face_of(corner)] = true;
        }
        sites.push_back({point_at_vertex(surface.adjacency(), v), 0});
      }
    }
    // Symmetric ones, too: the icosahedron's corners are the first twelve.
    if (round == 1) {
      sites.clear();
      for (std::uint32_t v = 0; v < 12; ++v) sites.push_back({surface.at(v), 0});
    }
    CAPTURE(sites.size());
    const Voronoi found = cells_by(surface, sites);
    CHECK(found.bisectors.vertices.size() == 2 * (sites.size() - 2));
    // Where four cells meet in a point, the line between two of these is but a point.
    const std::size_t lines = found.bisectors.lines.size();
    CHECK(lines <= 3 * (sites.size() - 2));
    if (in_faces) CHECK(lines == 3 * (sites.size() - 2));
    double volume = 0;
    for (const VoronoiVertex& vertex : found.bisectors.vertices) {
      std::array<Vec3, 3> p;
      for (std::size_t c = 0; c < 3; ++c) {
        p[c] = position_of(surface.mesh(), sites[vertex.sites[c]].point);
        // A chord's arc, but for how far the faces are from the sphere.
        const double arc = 2 * std::asin(distance(p[c], vertex.position) / 2);
        CHECK(std::abs(arc - vertex.distance) < 0.02);
      }
      CHECK(dot(cross(p[1] - p[0], p[2] - p[0]), vertex.position) > -1e-9);
      volume += dot(p[0], cross(p[1], p[2])) / 6;
    }
    // Few may leave a half of the sphere empty.
    if (sites.size() >= 40) CHECK(volume > 1);
    CHECK(volume < 4.19);
  }
}

// Of two sites on a sphere the bisector is a great circle.
TEST_CASE("TwoSitesOnASphereHaveHalfEach") {
  std::mt19937 random(test_seed());
  double worst[2] = {0, 0};
  for (const std::uint32_t levels : {3U, 4U}) {
    const Surface surface(shapes::icosphere(levels));
    for (int round = 0; round < 4; ++round) {
      const auto a = static_cast<std::uint32_t>(random() % 12);
      auto b = static_cast<std::uint32_t>(random() % 12);
      if (a == b) b = (b + 1) % 12;
      const Voronoi found = cells_by(surface, {{surface.at(a), 0}, {surface.at(b), 0}});
      REQUIRE(found.bisectors.lines.size() == 1);
      const Bisector& line = found.bisectors.lines[0];
      CHECK(line.closed);
      CHECK(found.bisectors.vertices.empty());
      CHECK(line.length == doctest::Approx(2 * std::numbers::pi).epsilon(0.01));
      CHECK(found.cells[0].area == doctest::Approx(found.cells[1].area).epsilon(0.01));
      const Vec3 axis = surface.mesh().positions()[surface.vertex(b)] -
                        surface.mesh().positions()[surface.vertex(a)];
      for (const Vec3 point : line.points) {
        worst[levels - 3] = std::max(worst[levels - 3], std::abs(dot(point, axis)) / norm(axis));
      }
    }
  }
  CHECK(worst[0] < 0.02);
  CHECK(worst[1] < 0.01);
}

// Where cells meet, windows say how far each of the three sites is. Off by the square of the edges'
// length, which is about 1, over the distance; where a bisector has a bend in the face, by no more
// than the face is long.
TEST_CASE("CellsMeetAsFarFromTheirSitesAsWindowsSay") {
  std::mt19937 random(test_seed());
  double sum = 0;
  double worst = 0;
  double count = 0;
  for (int round = 0; round < 3; ++round) {
    const Surface surface(shapes::terrain(32, 4, static_cast<std::uint32_t>(random())));
    std::vector<Source> sites;
    for (int i = 0; i < 14; ++i) {
      sites.push_back({surface.at(static_cast<std::uint32_t>(random() % 1024)), 0});
    }
    const Voronoi found = cells_by(surface, sites);
    std::vector<Field> fields;
    for (const Source& site : sites) fields.push_back(surface.field_by(Method::exact, {site}));
    for (const VoronoiVertex& vertex : found.bisectors.vertices) {
      for (const std::uint32_t site : vertex.sites) {
        const PointArrivals arrivals(surface.adjacency(), fields[site]);
        const double off = std::abs(arrivals.distance_at(vertex.point) - vertex.distance);
        sum += off;
        const double side = std::sqrt(surface.adjacency().face(vertex.point.face).longest2());
        worst = std::max(worst, off / side);
        ++count;
      }
    }
  }
  CHECK(count > 60);
  CHECK(sum / count < 0.03);
  CHECK(worst < 1);
}

TEST_CASE("ASiteAloneHasAllThatIsReached") {
  const Surface surface(fixtures::two_components());
  const Voronoi found = cells_by(surface, {{surface.at(3), 0}});
  REQUIRE(found.cells.size() == 1);
  CHECK(found.cells[0].area == doctest::Approx(16));
  CHECK(found.cells[0].boundary == doctest::Approx(16));
  CHECK(found.cells[0].perimeter == 0);
  CHECK(found.cells[0].vertices == 25);
  CHECK(distance(found.cells[0].mean, {2, 2, 0}) < 1e-12);
  CHECK(found.bisectors.lines.empty());
  CHECK(found.neighbours.empty());
}

TEST_CASE("OfSitesInOnePlaceTheFirstHasTheCell") {
  const Surface surface(shapes::plane(5, 5));
  const Source here{surface.at(6), 0};
  const Voronoi found = cells_by(surface, {here, here, {surface.at(18), 0}, here});
  CHECK(found.cells[0].area == doctest::Approx(8));
  CHECK(found.cells[1].is_empty());
  CHECK(found.cells[2].area == doctest::Approx(8));
  CHECK(found.cells[3].is_empty());
  CHECK(found.neighbours.size() == 1);
  SolveScratch scratch;
  const auto moved = relax_sites(Method::exact, {}, surface.adjacency(),
                                 {here, here, {surface.at(18), 0}}, 1, scratch, Cancel());
  REQUIRE(moved);
  CHECK((*moved)[0].point.vertex != surface.vertex(6));
  CHECK((*moved)[1].point.vertex == surface.vertex(6));
}

// A site farther than its neighbour is from there has no cell, and one that starts later has less.
TEST_CASE("OffsetsMoveBisectors") {
  const Surface surface(shapes::plane(11, 3));
  const Voronoi even = cells_by(surface, {{surface.at(11), 0}, {surface.at(21), 0}});
  CHECK(even.cells[0].area == doctest::Approx(even.cells[1].area));
  const Voronoi late = cells_by(surface, {{surface.at(11), 0}, {surface.at(21), 2}});
  CHECK(late.cells[0].area > even.cells[0].area + 1.5);
  const Voronoi never = cells_by(surface, {{surface.at(11), 0}, {surface.at(21), 100}});
  CHECK(never.cells[1].is_empty());
  CHECK(never.cells[0].area == doctest::Approx(20));
}

// Lloyd's rounds never make the mean squared distance in space from the sites greater by much.
TEST_CASE("RelaxedSitesAreSpreadEvenly") {
  std::mt19937 random(test_seed());
  const Surface surface(shapes::icosphere(3));
  std::vector<Source> sites;
  for (int i = 0; i < 12; ++i) {
    sites.push_back({surface.at(static_cast<std::uint32_t>(random() % 642)), 0});
  }
  std::sort(sites.begin(), sites.end(),
            [](const Source& a, const Source& b) { return a.point.vertex < b.point.vertex; });
  sites.erase(std::unique(sites.begin(), sites.end(),
                          [](const Source& a, const Source& b) {
                            return a.point.vertex == b.point.vertex;
                          }),
              sites.end());
  const auto unevenness = [&](const std::vector<Source>& at) {
    const Voronoi found = cells_by(surface, at);
    double least = found.cells[0].area;
    double most = least;
    for (const VoronoiCell& cell : found.cells) {
      least = std::min(least, cell.area);
      most = std::max(most, cell.area);
    }
    return most / least;
  };
  SolveScratch scratch;
  const auto moved =
      relax_sites(Method::exact, {}, surface.adjacency(), sites, 20, scratch, Cancel());
  REQUIRE(moved);
  CHECK(unevenness(*moved) < 2);
  CHECK(unevenness(*moved) <= unevenness(sites));
  const auto again =
      relax_sites(Method::exact, {}, surface.adjacency(), sites, 20, scratch, Cancel());
  REQUIRE(again);
  for (std::size_t i = 0; i < sites.size(); ++i) {
    CHECK((*again)[i].point.face == (*moved)[i].point.face);
    CHECK((*again)[i].point.bary == (*moved)[i].point.bary);
  }
}

// The middle of a parallelogram of two faces is on their common side, and rounding puts it beside.
TEST_CASE("ASiteMovedOntoAnEdgeIsOnTheEdge") {
  std::mt19937 random(test_seed() + 8);
  const auto part = [&] { return 0.6 * (random() / 4294967296.0 - 0.5); };
  for (int round = 0; round < 200; ++round) {
    CAPTURE(round);
    const Vec3 corner{10 * part(), 10 * part(), 10 * part()};
    const Vec3 one{1 + part(), part(), part()};
    const Vec3 other{part(), 1 + part(), part()};
    const Surface surface(
        {{corner, corner + one, corner + one + other, corner + other}, {{0, 1, 2}, {0, 2, 3}}});
    SolveScratch scratch;
    const auto moved = relax_sites(Method::exact, {}, surface.adjacency(), {{surface.at(0), 0}}, 1,
                                   scratch, Cancel());
    REQUIRE(moved);
    const SurfacePoint& at = moved->front().point;
    CHECK(edge_under(at) != kNone);
    const Vec3 middle = corner + 0.5 * (one + other);
    CHECK(distance(position_of(surface.mesh(), at), middle) < 1e-12);
  }
}

// From within a circle of sites each part has a side for all of these that have cut it so far.
TEST_CASE("CutsCountForAsManyStepsAsTheyHaveSidesToLookAt") {
  std::mt19937 random(test_seed() + 9);
  constexpr std::uint32_t kSites = 60;  // on the circle, and within it
  const Surface surface(fixtures::single_triangle());
  std::vector<Source> sites;
  const auto add = [&](double x, double y) {
    sites.push_back({surface.on(0, {1 - x / 3 - y / 4, x / 3, y / 4}), 0});
  };
  for (std::uint32_t i = 0; i < kSites; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSites;
    add(1 + 0.5 * std::cos(angle), 1 + 0.5 * std::sin(angle));
  }
  for (std::uint32_t i = 0; i < kSites; ++i) {
    const auto near_middle = [&] { return 0.9 + 0.2 * (random() / 4294967296.0); };
    const double x = near_middle();
    add(x, near_middle());
  }
  const Field field = surface.field_by(Method::exact, sites, without_details());
  SolveScratch scratch;
  const auto near = near_sites(Method::exact, {}, surface.adjacency(), field, points_of(field),
                               scratch, Cancel());
  REQUIRE(near);
  constexpr std::uint32_t kBetween = 256;
  std::uint64_t asked = 0;
  const Cancel cancel([&] { return ++asked == 0; });
  Poll poll(cancel, kBetween);
  FaceCells face_cells(surface.adjacency(), *near);
  CHECK(face_cells.parts_of(0, poll).size() == sites.size());
  // Of each site within, i cuts leave i sides at the least. What is asked about at once may begin
  // just before the steps are up.
  constexpr std::uint64_t kSteps = kSites * (kSites * (kSites - 1) / 2);
  CHECK(asked >= kSteps / (kBetween + 2 * kSites));
}

TEST_CASE("CellsAreStoppedInTheMiddle") {
  const Surface surface(shapes::icosphere(5));
  std::vector<Source> sites;
  for (std::uint32_t v = 0; v < 12; ++v) sites.push_back({surface.at(v), 0});
  const Field field = surface.field_by(Method::back_traced, sites, without_details());
  SolveScratch scratch;
  std::size_t all = 0;
  double done = 0;
  const Cancel counting([&] { return ++all == 0; },
                        [&](double now) {
                          CHECK(now >= done - 1e-12);
                          CHECK(now <= 1 + 1e-12);
                          done = now;
                        });
  REQUIRE(
      voronoi(Method::back_traced, {}, surface.adjacency(), field, kMostSteps, scratch, counting));
  CHECK(done > 0.9);
  for (const std::size_t most :
       {std::size_t{0}, std::size_t{3}, all / 4, all / 2, all * 3 / 4, all - 1}) {
    std::size_t asked = 0;
    const Cancel stopping([&] { return ++asked > most; });
    const auto found =
        voronoi(Method::back_traced, {}, surface.adjacency(), field, kMostSteps, scratch, stopping);
    REQUIRE_FALSE(found.has_value());
    CHECK(found.error().code == ErrorCode::cancelled);
    // Soon.
    CHECK(asked < most + 10);
    asked = 0;
    const auto moved =
        relax_sites(Method::back_traced, {}, surface.adjacency(), sites, 2, scratch, stopping);
    REQUIRE_FALSE(moved.has_value());
    CHECK(moved.error().code == ErrorCode::cancelled);
  }
}

TEST_CASE("CellsAskForTheirMemory") {
  const Surface surface(shapes::icosphere(4));
  std::vector<Source> sites;
  for (std::uint32_t v = 0; v < 12; ++v) sites.push_back({surface.at(v), 0});
  const Field field = surface.field_by(Method::dijkstra, sites, without_details());
  SolveScratch scratch;
  std::uint64_t all = 0;
  MemoryBudget counting([&](std::uint64_t bytes) -> std::optional<Error> {
    all += bytes;
    return {};
  });
  const auto cells = [&](MemoryBudget& budget) {
    return voronoi(Method::dijkstra, {}, surface.adjacency(), field, kMostSteps, scratch,
                   Cancel({}, {}, &budget));
  };
  REQUIRE(cells(counting));
  // A near site for each vertex at the least, and some for bisectors.
  CHECK(all > surface.mesh().vertex_count() * sizeof(NearSite));
  for (const std::uint64_t most : {std::uint64_t{0}, all / 3, all / 2, all - 1}) {
    std::uint64_t taken = 0;
    MemoryBudget refusing([&](std::uint64_t bytes) -> std::optional<Error> {
      if (taken + bytes > most) return Error{ErrorCode::too_large, "no more", {}, {}, {}};
      taken += bytes;
      return {};
    });
    const auto found = cells(refusing);
    REQUIRE_FALSE(found.has_value());
    CHECK(found.error().detail == "no more");
  }
}

TEST_CASE("TooManySegmentsAreRefused") {
  const Surface surface(shapes::plane(20, 20));
  const std::vector<Source> sites{{surface.at(0), 0}, {surface.at(399), 0}};
  const Field field = surface.field_by(Method::exact, sites, without_details());
  SolveScratch scratch;
  const auto all =
      voronoi(Method::exact, {}, surface.adjacency(), field, kMostSteps, scratch, Cancel());
  REQUIRE(all);
  const std::uint64_t segments = all->bisectors.segments;
  CHECK(segments > 19);
  CHECK(voronoi(Method::exact, {}, surface.adjacency(), field, segments, scratch, Cancel()));
  const auto refused =
      voronoi(Method::exact, {}, surface.adjacency(), field, segments - 1, scratch, Cancel());
  REQUIRE_FALSE(refused.has_value());
  CHECK(refused.error().code == ErrorCode::too_large);
  CHECK(refused.error().limit == segments - 1);
  CHECK(refused.error().actual == segments);
}
