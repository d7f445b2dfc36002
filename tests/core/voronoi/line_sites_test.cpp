// Cells of curves, boundaries and faces, among points: against fields of each site alone, closed
// forms in planes, and the faces that sites have as a whole.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "core/mesh/shapes.h"
#include "core/voronoi/face_cells.h"
#include "core/voronoi/voronoi.h"
#include "tests/core/curves/curve_fixtures.h"
#include "tests/core/voronoi/cell_checks.h"
#include "tests/fixtures/awkward_meshes.h"
#include "tests/fixtures/random_meshes.h"

using namespace geodesic;
using fixtures::LineQuestion;
using fixtures::some_point;
using fixtures::Surface;
using fixtures::test_seed;

namespace {

constexpr std::uint64_t kAny = 1'000'000'000;

struct Site {
  enum class Kind { point, curve, boundary, faces } kind = Kind::point;
  std::vector<SurfacePoint> points;
  bool is_closed = false;
  std::vector<std::uint32_t> of;

  void add_to(LineQuestion& question) const {
    switch (kind) {
      case Kind::point:
        return question.point(points.front());
      case Kind::curve:
        (void)question.curve(points, is_closed);
        return;
      case Kind::boundary:
        return question.boundary();
      case Kind::faces:
        return question.faces(of);
    }
  }
};

Site at_point(const SurfacePoint& point) { return {Site::Kind::point, {point}, false, {}}; }
Site along(std::vector<SurfacePoint> points) {
  return {Site::Kind::curve, std::move(points), false, {}};
}
Site of_faces(std::vector<std::uint32_t> faces) {
  return {Site::Kind::faces, {}, false, std::move(faces)};
}

// Each of them apart. Both must outlive this.
VoronoiSites apart_of(const Surface& surface, const std::vector<Site>& sites) {
  return {static_cast<std::uint32_t>(sites.size()),
          [&](std::uint32_t i, SolveScratch&, const Cancel&) -> Result<VoronoiSite> {
            LineQuestion own(surface);
            sites[i].add_to(own);
            if (sites[i].kind == Site::Kind::point) return VoronoiSite{own.sources(), nullptr};
            return VoronoiSite{own.sources(), std::make_shared<const SourceLines>(own.lines())};
          }};
}

// The cells, and the fields that they are held against.
struct Cells {
  Cells(const Surface& surface, const std::vector<Site>& sites, Method method)
      : all(surface, sites, method) {
    const VoronoiSites apart = apart_of(surface, sites);
    SolveScratch scratch;
    auto cells =
        voronoi(method, {}, surface.adjacency(), all.field, apart, kAny, scratch, Cancel());
    REQUIRE(cells);
    found = std::move(*cells);
  }

  struct All {
    All(const Surface& surface, const std::vector<Site>& sites, Method method) : question(surface) {
      for (const Site& site : sites) site.add_to(question);
      question.merge();
      FieldLimits limits;
      limits.keep_details = false;
      field = question.field(method, limits);
    }
    LineQuestion question;
    Field field;
  };
  All all;
  Voronoi found;
};

std::vector<Site> any_sites(const Surface& surface, std::mt19937& random) {
  const std::uint32_t faces = surface.mesh().face_count();
  std::vector<Site> sites;
  const std::size_t count = 2 + random() % 6;
  for (std::size_t i = 0; i < count; ++i) {
    switch (random() % 5) {
      case 0:
        sites.push_back(at_point(some_point(surface, random)));
        break;
      case 1:
        if (surface.adjacency().report().edges_boundary > 0) {
          sites.push_back({Site::Kind::boundary, {}, false, {}});
          break;
        }
        [[fallthrough]];
      case 2: {
        std::vector<std::uint32_t> set;
        const std::uint32_t first = random() % faces;
        const std::uint32_t last = std::min(faces, first + 1 + faces / 8);
        for (std::uint32_t f = first; f < last; ++f) set.push_back(f);
        sites.push_back(of_faces(set));
        break;
      }
      default: {
        const SurfacePoint from = some_point(surface, random);
        const Field field = surface.field_by(Method::exact, {Source{from, 0}});
        for (int tries = 0; tries < 30; ++tries) {
          const SurfacePoint to = some_point(surface, random);
          if (!surface.path(field, to)) continue;
          sites.push_back(along({from, to}));
          // Lines like to begin where others end.
          if (random() % 2 == 0) sites.push_back(along({to, from}));
          break;
        }
        if (sites.empty()) sites.push_back(at_point(from));
      }
    }
  }
  return sites;
}

void check_cells(const Surface& surface, const std::vector<Site>& sites, Method method) {
  const Cells cells(surface, sites, method);
  const Field& field = cells.all.field;
  const Voronoi& found = cells.found;
  REQUIRE(found.cells.size() == sites.size());
  fixtures::check_measures(surface, field, found);

  // Fields of each site alone say which is nearest, and so do the labels of the field of all.
  const bool is_exact = method == Method::exact || method == Method::chen_han;
  const Box& box = surface.mesh().box();
  const double slack = 1e-8 * norm(box.max - box.min);
  std::vector<Field> alone;
  for (const Site& site : sites) {
    LineQuestion own(surface);
    site.add_to(own);
    FieldLimits limits;
    limits.keep_details = false;
    alone.push_back(own.field(method, limits));
  }
  for (const std::uint32_t v : surface.mesh().vertex_of_source()) {
    if (v == kNone || field.distance[v] == kUnreached || !is_exact) continue;
    double least = kUnreached;
    for (const Field& own : alone) least = std::min(least, own.distance[v]);
    CHECK(std::abs(field.distance[v] - least) <= slack);
    const std::uint32_t nearest = found.near->nearest(v);
    REQUIRE(nearest < sites.size());
    CHECK(alone[nearest].distance[v] <= least + slack);
    const std::uint32_t label = field.item_of_source(field.nearest_source[v]);
    CHECK(alone[label].distance[v] <= least + slack);
    if (label == nearest) continue;
    // As near, and it comes first.
    CHECK(nearest < label);
  }

  // What sites have as a whole is in their cells: a face that several have in that of the first.
  std::vector<double> owned(sites.size());
  std::vector<bool> is_taken(surface.mesh().face_count());
  for (std::size_t i = 0; i < sites.size(); ++i) {
    for (const std::uint32_t f : sites[i].of) {
      if (!is_taken[f]) owned[i] += fixtures::area_of(surface, f);
      is_taken[f] = true;
    }
    CHECK(found.cells[i].area >= owned[i] - 1e-9 * fixtures::reached_area(surface, field));
  }
}

}  // namespace

TEST_CASE("CellsOfLinesAddUpToTheSurfaceAndAreWhatFieldsSay") {
  std::mt19937 random(test_seed());
  for (int i = 0; i < 24; ++i) {
    const auto number = static_cast<std::uint32_t>(random());
    CAPTURE(number);
    const Surface surface(fixtures::RandomMesh(number).soup());
    const Method methods[] = {Method::exact,       Method::exact,    Method::chen_han,
                              Method::back_traced, Method::dijkstra, Method::fast_marching,
                              Method::steiner};
    const Method method = methods[random() % 7];
    CAPTURE(static_cast<int>(method));
    check_cells(surface, any_sites(surface, random), method);
  }
}

TEST_CASE("CellsOfLinesOnAwkwardSurfacesAddUp") {
  std::mt19937 random(test_seed());
  for (const fixtures::AwkwardMesh& mesh : fixtures::awkward_meshes()) {
    CAPTURE(mesh.name);
    const Surface surface(mesh.soup);
    check_cells(surface, any_sites(surface, random), Method::exact);
    check_cells(surface, any_sites(surface, random), Method::back_traced);
  }
}

// Squares of lines that begin in one vertex are the same at corners for which that is the nearest
// place: differences whose exact products add up to nothing.
TEST_CASE("CellsOfLinesFromOneVertexAddUp") {
  std::mt19937 random(test_seed());
  for (int round = 0; round < 60; ++round) {
    CAPTURE(round);
    const Surface surface(fixtures::turned_plane(5, 5, random));
    const SurfacePoint start = surface.at(12);
    std::vector<Site> sites{at_point(some_point(surface, random))};
    for (int i = 0; i < 4; ++i) sites.push_back(along({start, some_point(surface, random)}));
    sites.push_back(at_point(some_point(surface, random)));
    check_cells(surface, sites, Method::exact);
  }
}

// Each face belongs to some site, so that nothing is left to be divided: cells are these faces, and
// meet along the edges between them.
TEST_CASE("CellsOfAllFacesAreTheseFaces") {
  std::mt19937 random(test_seed());
  for (int round = 0; round < 16; ++round) {
    const auto number = static_cast<std::uint32_t>(random());
    CAPTURE(number);
    const Surface surface(fixtures::RandomMesh(number).soup());
    const std::uint32_t faces = surface.mesh().face_count();
    const std::uint32_t count = 2 + random() % std::min(5U, faces);
    std::vector<Site> sites(count, of_faces({}));
    std::vector<std::uint32_t> owner(faces);
    for (std::uint32_t f = 0; f < faces; ++f) {
      // In runs, and each site has one.
      owner[f] = f < count ? f : random() % 3 == 0 ? random() % count : owner[f - 1];
      sites[owner[f]].of.push_back(f);
    }
    const Cells cells(surface, sites, round % 2 == 0 ? Method::exact : Method::back_traced);
    std::vector<double> area(count);
    std::map<std::array<std::uint32_t, 2>, double> border;
    for (std::uint32_t f = 0; f < faces; ++f) {
      area[owner[f]] += fixtures::area_of(surface, f);
      for (std::uint32_t c = 0; c < 3; ++c) {
        const Adjacency& adjacency = surface.adjacency();
        const Halfedge h = halfedge(f, c);
        const Halfedge beyond = adjacency.ring(h);
        if (beyond == h || adjacency.ring(beyond) != h || face_of(beyond) < f) continue;
        const auto [low, high] = std::minmax(owner[f], owner[face_of(beyond)]);
        if (low == high) continue;
        border[{low, high}] += distance(surface.mesh().positions()[adjacency.tail(h)],
                                        surface.mesh().positions()[adjacency.head(h)]);
      }
    }
    double whole = 0;
    for (const double one : area) whole += one;
    for (std::uint32_t i = 0; i < count; ++i) {
      CHECK(std::abs(cells.found.cells[i].area - area[i]) <= 1e-12 * whole);
    }
    CHECK(cells.found.neighbours.size() == border.size());
    for (const NeighbourCells& pair : cells.found.neighbours) {
      CHECK(pair.length == doctest::Approx(border[pair.sites]));
    }
  }
}

namespace {

// The place of a plane of so many columns and rows, one apart.
SurfacePoint in_plane(const Surface& surface, double x, double y) {
  const auto positions = surface.mesh().positions();
  for (std::uint32_t f = 0; f < surface.mesh().face_count(); ++f) {
    const Triangle& t = surface.mesh().faces()[f];
    const Vec3 a = positions[t[0]];
    const Vec3 b = positions[t[1]] - a;
    const Vec3 c = positions[t[2]] - a;
    const double twice = b.x * c.y - b.y * c.x;
    const double v = ((x - a.x) * c.y - (y - a.y) * c.x) / twice;
    const double w = (b.x * (y - a.y) - b.y * (x - a.x)) / twice;
    if (v >= -1e-12 && w >= -1e-12 && v + w <= 1 + 1e-12) {
      return point_on_face(surface.adjacency(), f,
                           {std::max(1 - v - w, 0.0), std::max(v, 0.0), std::max(w, 0.0)});
    }
  }
  FAIL("outside of the plane");
  return {};
}

}  // namespace

// All of the plane is seen straight from both lines, and squared distances differ by a linear
// function.
TEST_CASE("BetweenParallelLinesTheCellsAreRightToRounding") {
  std::mt19937 random(test_seed());
  const auto unit = [&] { return random() / 4294967296.0; };
  const Surface surface(shapes::plane(13, 9));
  for (const Method method : {Method::exact, Method::chen_han}) {
    for (int round = 0; round < 4; ++round) {
      const double low = 3 * unit();
      const double high = 5 + 3 * unit();
      CAPTURE(low);
      CAPTURE(high);
      const Cells cells(surface,
                        {along({in_plane(surface, 0, low), in_plane(surface, 12, low)}),
                         along({in_plane(surface, 12, high), in_plane(surface, 0, high)})},
                        method);
      const double middle = (low + high) / 2;
      CHECK(std::abs(cells.found.cells[0].area - 12 * middle) < 1e-9);
      CHECK(std::abs(cells.found.cells[1].area - 12 * (8 - middle)) < 1e-9);
      REQUIRE(cells.found.bisectors.lines.size() == 1);
      CHECK(std::abs(cells.found.bisectors.lines[0].length - 12) < 1e-9);
      for (const Vec3 p : cells.found.bisectors.lines[0].points)
        CHECK(std::abs(p.y - middle) < 1e-9);
      CHECK(cells.found.bisectors.vertices.empty());
    }
  }
}

// Between a point and a line, a parabola: off by the square of the edges over the distance.
TEST_CASE("BetweenAPointAndALineIsAParabola") {
  std::mt19937 random(test_seed());
  const auto unit = [&] { return random() / 4294967296.0; };
  constexpr double kWidth = 24;
  constexpr double kHeight = 18;
  const Surface surface(shapes::plane(25, 19));
  for (int round = 0; round < 4; ++round) {
    const double x = 4 + 16 * unit();
    const double y = 6 + 9 * unit();
    CAPTURE(x);
    CAPTURE(y);
    const Cells cells(surface,
                      {along({in_plane(surface, 0, 0), in_plane(surface, kWidth, 0)}),
                       at_point(in_plane(surface, x, y))},
                      Method::exact);
    const auto height = [&](double at) { return ((at - x) * (at - x) + y * y) / (2 * y); };
    constexpr int kSteps = 20'000;
    double below = 0;
    for (int i = 0; i < kSteps; ++i) {
      below += std::min(kHeight, height(kWidth * (i + 0.5) / kSteps)) * kWidth / kSteps;
    }
    // Edges are up to 1.5 long, and the distance is 3 at least.
    CHECK(std::abs(cells.found.cells[0].area - below) < 0.15 * kWidth);
    double off = 0;
    double count = 0;
    for (const Bisector& line : cells.found.bisectors.lines) {
      for (const Vec3 p : line.points) {
        const double from_point = std::hypot(p.x - x, p.y - y);
        CHECK(std::abs(from_point - p.y) < 1.5 * 1.5 / 3);
        off += std::abs(from_point - p.y);
        ++count;
      }
    }
    CHECK(count > 10);
    CHECK(off / count < 0.1);
  }
}

// Whatever lines there are, no place is in a cell whose site is farther than the nearest one by
// more than two edges, for then it would be farther at all corners of the face.
TEST_CASE("PlacesAreInTheCellOfASiteThatIsNear") {
  std::mt19937 random(test_seed());
  const auto unit = [&] { return random() / 4294967296.0; };
  double sum = 0;
  double count = 0;
  for (int round = 0; round < 6; ++round) {
    const Surface surface(shapes::plane(25, 19));
    std::vector<Site> sites;
    std::vector<std::vector<Vec3>> lines;
    for (int i = 0; i < 6; ++i) {
      const Vec3 from{24 * unit(), 18 * unit(), 0};
      const Vec3 to{std::clamp(from.x + 8 * unit() - 4, 0.0, 24.0),
                    std::clamp(from.y + 8 * unit() - 4, 0.0, 18.0), 0};
      if (i % 3 == 0) {
        sites.push_back(at_point(in_plane(surface, from.x, from.y)));
        lines.push_back({from});
      } else {
        sites.push_back(along({in_plane(surface, from.x, from.y), in_plane(surface, to.x, to.y)}));
        lines.push_back({from, to});
      }
    }
    const Cells cells(surface, sites, Method::exact);
    REQUIRE(each_cell_triangle(
        surface.adjacency(), *cells.found.near,
        [&](const CellTriangle& triangle) {
          const auto& t = triangle.corners;
          const Vec3 middle = (1.0 / 3) * (t[0] + t[1] + t[2]);
          const double area = norm(cross(t[1] - t[0], t[2] - t[0])) / 2;
          double least = kUnreached;
          for (const auto& line : lines) {
            least = std::min(least, fixtures::to_polyline(middle, line, false));
          }
          const double more = fixtures::to_polyline(middle, lines[triangle.site], false) - least;
          CHECK(more <= 2 * std::sqrt(2.0) + 1e-9);
          sum += more * area;
          count += area;
        },
        Cancel()));
  }
  // On the whole next to nothing is in the wrong cell.
  CHECK(sum / count < 0.01);
}

// Beyond the common end of two lines, and at a whole line that two sites have, the first is
// nearest.
TEST_CASE("WhatIsAsNearToSeveralLinesBelongsToTheFirst") {
  const Surface surface(shapes::plane(21, 21));
  const auto at = [&](double x, double y) { return in_plane(surface, x, y); };
  // Down from the middle, and to the right of it: what is up and left of it is as far from both.
  const std::vector<Site> sites{along({at(10, 10), at(10, 0)}), along({at(10, 10), at(20, 10)})};
  const Cells cells(surface, sites, Method::exact);
  const Cells turned(surface, {sites[1], sites[0]}, Method::exact);
  // The diagonal between the lines, and the first line's side of the rest.
  CHECK(cells.found.cells[0].area == doctest::Approx(50 + 100 + 100).epsilon(0.05));
  CHECK(cells.found.cells[1].area == doctest::Approx(50 + 100).epsilon(0.08));
  CHECK(turned.found.cells[0].area == doctest::Approx(50 + 100 + 100).epsilon(0.05));
  for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
    const Vec3 p = surface.mesh().positions()[v];
    if (p.x <= 10 && p.y >= 10) {
      CHECK(cells.found.near->nearest(v) == 0);
      CHECK(turned.found.near->nearest(v) == 0);
    }
  }
  const Cells same(surface, {sites[0], sites[0], sites[1]}, Method::exact);
  CHECK(same.found.cells[1].is_empty());
  CHECK(same.found.cells[0].area == doctest::Approx(cells.found.cells[0].area));
}

namespace {

// Three lines and a set of faces on a sphere.
std::vector<Site> some_sites(const Surface& surface) {
  std::vector<Site> sites;
  for (std::uint32_t v = 0; v < 6; v += 2) {
    sites.push_back(along({surface.at(v), surface.at(v + 20)}));
  }
  sites.push_back(of_faces({7, 8, 9, 300}));
  return sites;
}

}  // namespace

TEST_CASE("CellsOfLinesAreStoppedInTheMiddle") {
  const Surface surface(shapes::icosphere(4));
  const std::vector<Site> sites = some_sites(surface);
  const Cells cells(surface, sites, Method::exact);
  const VoronoiSites apart = apart_of(surface, sites);
  SolveScratch scratch;
  const auto ask = [&](const Cancel& cancel) {
    return voronoi(Method::exact, {}, surface.adjacency(), cells.all.field, apart, kAny, scratch,
                   cancel);
  };
  REQUIRE(ask(Cancel()));  // with scratch memory that is there, it asks as often each time
  std::size_t all = 0;
  double done = 0;
  const Cancel counting([&] { return ++all == 0; },
                        [&](double now) {
                          CHECK(now >= done - 1e-12);
                          CHECK(now <= 1 + 1e-12);
                          done = now;
                        });
  REQUIRE(ask(counting));
  CHECK(done > 0.9);
  for (const std::size_t most : {std::size_t{0}, all / 4, all / 2, all * 3 / 4, all - 1}) {
    std::size_t asked = 0;
    const Cancel stopping([&] { return ++asked > most; });
    const auto found = ask(stopping);
    REQUIRE_FALSE(found.has_value());
    CHECK(found.error().code == ErrorCode::cancelled);
    CHECK(asked < most + 10);
  }
  // What a site says is wrong with it ends all.
  VoronoiSites failing = apart;
  failing.at = [](std::uint32_t, SolveScratch&, const Cancel&) -> Result<VoronoiSite> {
    return fail(ErrorCode::too_large, "no such site");
  };
  const auto failed = voronoi(Method::exact, {}, surface.adjacency(), cells.all.field, failing,
                              kAny, scratch, Cancel());
  REQUIRE_FALSE(failed.has_value());
  CHECK(failed.error().detail == "no such site");
}

TEST_CASE("CellsOfLinesAskForTheirMemory") {
  const Surface surface(shapes::icosphere(4));
  const std::vector<Site> sites = some_sites(surface);
  const Cells cells(surface, sites, Method::dijkstra);
  const VoronoiSites apart = apart_of(surface, sites);
  SolveScratch scratch;
  const auto ask = [&](MemoryBudget& budget) {
    return voronoi(Method::dijkstra, {}, surface.adjacency(), cells.all.field, apart, kAny, scratch,
                   Cancel({}, {}, &budget));
  };
  std::uint64_t all = 0;
  MemoryBudget counting([&](std::uint64_t bytes) -> std::optional<Error> {
    all += bytes;
    return {};
  });
  REQUIRE(ask(counting));
  CHECK(all > surface.mesh().vertex_count() * sizeof(NearSite));
  for (const std::uint64_t most : {std::uint64_t{0}, all / 3, all / 2, all - 1}) {
    std::uint64_t taken = 0;
    MemoryBudget refusing([&](std::uint64_t bytes) -> std::optional<Error> {
      if (taken + bytes > most) return Error{ErrorCode::too_large, "no more", {}, {}, {}};
      taken += bytes;
      return {};
    });
    const auto found = ask(refusing);
    REQUIRE_FALSE(found.has_value());
    CHECK(found.error().detail == "no more");
  }
}
