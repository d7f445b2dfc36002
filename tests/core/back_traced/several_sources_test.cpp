// Distances from several sources: what one of them says of a vertex must not hide what another one
// does, and where two meet, distances are as true as elsewhere.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "core/mesh/shapes.h"
#include "tests/fixtures/faces_thrown_together.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::Surface;

namespace {

void check_not_above_ways_along_edges(std::mt19937& random, const Surface& surface) {
  std::vector<Source> sources;
  const std::size_t count = 2 + random() % 3;
  const auto vertices = surface.mesh().vertex_count();
  const double size = norm(surface.mesh().box().max - surface.mesh().box().min);
  for (std::size_t i = 0; i < count; ++i) {
    const double offset =
        random() % 2 == 0 ? 0 : std::uniform_real_distribution<double>(0, size)(random);
    if (random() % 3 == 0) {
      const auto face = static_cast<std::uint32_t>(random() % surface.mesh().face_count());
      sources.push_back({{face, {0.5, 0.3, 0.2}, kNone}, offset});
    } else {
      const auto v = static_cast<std::uint32_t>(random() % vertices);
      sources.push_back({point_at_vertex(surface.adjacency(), v), offset});
    }
  }
  const Field field = surface.field_by(Method::back_traced, sources);
  const Field along_edges = surface.field_by(Method::dijkstra, sources);
  for (std::uint32_t v = 0; v < vertices; ++v) {
    CAPTURE(v);
    CHECK(field.distance[v] <= along_edges.distance[v] * (1 + 1e-6));
  }
}

// Sources at vertices and inside faces, about half of them late.
std::vector<Source> some_sources(std::mt19937& random, const Surface& surface, std::size_t count,
                                 double latest) {
  std::vector<Source> sources;
  for (std::size_t i = 0; i < count; ++i) {
    const auto face = static_cast<std::uint32_t>(random() % surface.mesh().face_count());
    const double offset =
        random() % 2 == 0 ? 0 : std::uniform_real_distribution<double>(0, latest)(random);
    if (random() % 2 == 0) {
      sources.push_back({point_on_face(surface.adjacency(), face, {0.5, 0.3, 0.2}), offset});
    } else {
      const std::uint32_t vertex = surface.adjacency().face(face).vertex[random() % 3];
      sources.push_back({point_at_vertex(surface.adjacency(), vertex), offset});
    }
  }
  return sources;
}

TriangleSoup some_soup(std::mt19937& random) {
  switch (random() % 4) {
    case 0:
      return shapes::terrain(60, 6, random());
    case 1:
      return shapes::icosphere(4);
    case 2:
      return shapes::torus_knot(150, 14, 0.4);
    default: {
      // Edges a hundred times as long at one end as at the other.
      TriangleSoup soup = shapes::plane(50, 50);
      double most = 0;
      for (const Vec3& p : soup.positions) most = std::max(most, p.x);
      for (Vec3& p : soup.positions) p.x = most * std::pow(100.0, p.x / most);
      return soup;
    }
  }
}

double extent_of(const Surface& surface) {
  return norm(surface.mesh().box().max - surface.mesh().box().min);
}

}  // namespace

TEST_CASE("NoDistanceFromSeveralSourcesIsAboveTheWayAlongEdges") {
  std::mt19937 random(fixtures::test_seed());
  for (int round = 0; round < 600; ++round) {
    CAPTURE(round);
    const int faces = 20 + static_cast<int>(random() % 80);
    check_not_above_ways_along_edges(random,
                                     Surface(fixtures::faces_thrown_together(random, faces)));
  }
}

// The front drops a source where another is clearly nearer. That must not change distances much.
TEST_CASE("DistancesFromManySourcesAreTheLeastFromEachAlone") {
  std::mt19937 random(fixtures::test_seed());
  TriangleSoup stretched = shapes::terrain(60, 6, random());
  for (Vec3& p : stretched.positions) p.x *= 4;
  std::vector<TriangleSoup> soups{shapes::terrain(70, 10, random()), std::move(stretched),
                                  shapes::torus_knot(200, 16, 0.4), shapes::icosphere(4)};
  std::shuffle(soups.begin(), soups.end(), random);
  soups.resize(fixtures::all_or<std::size_t>(soups.size(), 1));
  for (const TriangleSoup& soup : soups) {
    const Surface surface(soup);
    const auto vertices = static_cast<std::uint32_t>(surface.mesh().vertex_count());
    for (const std::size_t count : {3, 12, 60}) {
      CAPTURE(count);
      std::vector<Source> sources;
      for (std::size_t i = 0; i < count; ++i) {
        const auto v = static_cast<std::uint32_t>(random() % vertices);
        sources.push_back({point_at_vertex(surface.adjacency(), v), 0});
      }
      std::vector<double> least(vertices, kUnreached);
      for (const Source& source : sources) {
        const Field alone = surface.field_by(Method::back_traced, {source});
        for (std::uint32_t v = 0; v < vertices; ++v) {
          least[v] = std::min(least[v], alone.distance[v]);
        }
      }
      const Field together = surface.field_by(Method::back_traced, sources);
      double greatest = 0;
      double sum = 0;
      std::uint32_t others = 0;
      for (std::uint32_t v = 0; v < vertices; ++v) {
        if (least[v] == 0) continue;
        const double off = std::abs(together.distance[v] / least[v] - 1);
        greatest = std::max(greatest, off);
        sum += off;
        if (off > 1e-6) ++others;
      }
      MESSAGE(count, " sources: ", others, " of ", vertices, " differ, by at most ", greatest);
      CHECK(sum < 1e-4 * vertices);
      CHECK(greatest < 0.03);
    }
  }
}

TEST_CASE("WhereTwoSourcesMeetDistancesAreAsTrueAsElsewhere") {
  std::mt19937 random(fixtures::test_seed());
  for (int round = 0; round < fixtures::all_or(24, 6); ++round) {
    CAPTURE(round);
    const Surface surface(some_soup(random));
    const std::size_t count = 2 + random() % 40;
    CAPTURE(count);
    const double edge = surface.adjacency().report().mean_edge;
    const std::vector<Source> sources =
        some_sources(random, surface, count, random() % 2 == 0 ? 0 : 10 * edge);
    const Field truth = surface.field_by(Method::exact, sources);
    for (const Bound bound : {Bound::none, Bound::upper}) {
      MethodOptions options;
      options.bound = bound;
      const Field field = surface.field_by(Method::back_traced, sources, {}, options);
      double sum = 0;
      for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
        CAPTURE(v);
        // An edge is the least that says anything near a source.
        const double off = (field.distance[v] - truth.distance[v]) / (truth.distance[v] + edge);
        if (bound == Bound::upper) CHECK(off >= -1e-6);
        CHECK(std::abs(off) < 0.03);
        sum += std::abs(off);
        const std::uint32_t source = field.nearest_source[v];
        REQUIRE(source < sources.size());
        CHECK(field.distance[v] >= sources[source].offset * (1 - 1e-6));
      }
      CHECK(sum < 1e-3 * surface.mesh().vertex_count());
    }
  }
}

TEST_CASE("ANearestSourceIsNoFartherThanTheUpperBoundSays") {
  std::mt19937 random(fixtures::test_seed());
  for (int round = 0; round < fixtures::all_or(12, 4); ++round) {
    CAPTURE(round);
    const Surface surface(some_soup(random));
    const std::vector<Source> sources = some_sources(random, surface, 2 + random() % 6, 0);
    MethodOptions upper;
    upper.bound = Bound::upper;
    const Field field = surface.field_by(Method::back_traced, sources, {}, upper);
    for (std::uint32_t s = 0; s < sources.size(); ++s) {
      const Field alone = surface.field_by(Method::exact, {sources[s]});
      for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
        if (field.nearest_source[v] != s) continue;
        CHECK(alone.distance[v] <= field.distance[v] * (1 + 1e-6) + 1e-6 * extent_of(surface));
      }
    }
  }
}

// Whatever ends the wave early, what it tells is what the whole field does.
TEST_CASE("WavesFromSeveralSourcesThatEndEarlyTellWhatWholeOnesDo") {
  std::mt19937 random(fixtures::test_seed());
  for (int round = 0; round < fixtures::all_or(40, 10); ++round) {
    CAPTURE(round);
    const Surface surface(some_soup(random));
    const std::vector<Source> sources = some_sources(random, surface, 2 + random() % 20,
                                                     5 * surface.adjacency().report().mean_edge);
    MethodOptions options;
    if (random() % 2 == 0) options.bound = Bound::upper;
    SolveScratch scratch;
    const auto solve = [&](const FieldLimits& limits) {
      auto field = solve_field(Method::back_traced, options, surface.adjacency(), sources, limits,
                               scratch, Cancel());
      REQUIRE(field.has_value());
      return std::move(*field);
    };
    const Field whole = solve({});
    // The farthest is within its own distance, however that was rounded.
    for (const double part : {1.0, std::pow(10.0, -static_cast<double>(random() % 200) / 100)}) {
      FieldLimits nearby;
      nearby.max = whole.max * part;
      const Field within = solve(nearby);
      for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
        CHECK(within.distance[v] ==
              (whole.distance[v] <= nearby.max ? whole.distance[v] : kUnreached));
      }
    }
    std::vector<std::uint32_t> targets;
    for (std::size_t i = 0; i <= random() % 3; ++i) {
      targets.push_back(static_cast<std::uint32_t>(random() % surface.mesh().vertex_count()));
    }
    FieldLimits some;
    some.targets = targets;
    const Field of_targets = solve(some);
    for (const std::uint32_t v : targets) CHECK(of_targets.distance[v] == whole.distance[v]);
    CHECK(solve({}).distance == whole.distance);
  }
}

namespace {

// Cones without bottoms that share nothing but their tip, and a vertex in no face at the end.
TriangleSoup cones_at_one_tip(std::uint32_t cones, std::uint32_t rim) {
  TriangleSoup soup;
  soup.positions.push_back({0, 0, 0});
  for (std::uint32_t cone = 0; cone < cones; ++cone) {
    const auto first = static_cast<std::uint32_t>(soup.positions.size());
    for (std::uint32_t i = 0; i < rim; ++i) {
      const double angle = 2 * std::numbers::pi * i / rim;
      const double height = 0.5 + cone;
      soup.positions.push_back(
          {std::cos(angle), std::sin(angle), cone % 2 == 0 ? height : -height});
    }
    for (std::uint32_t i = 0; i < rim; ++i) {
      soup.faces.push_back({0, first + i, first + (i + 1) % rim});
    }
  }
  soup.positions.push_back({9, 9, 9});
  return soup;
}

void check_by_exact(const Surface& surface, const std::vector<Source>& sources, double off) {
  const Field truth = surface.field_by(Method::exact, sources);
  for (const Bound bound : {Bound::none, Bound::upper}) {
    MethodOptions options;
    options.bound = bound;
    const Field field = surface.field_by(Method::back_traced, sources, {}, options);
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      CAPTURE(v);
      if (truth.distance[v] == kUnreached) {
        CHECK(field.distance[v] == kUnreached);
        continue;
      }
      CHECK(std::abs(field.distance[v] - truth.distance[v]) <= off * (1e-3 + truth.distance[v]));
    }
  }
}

}  // namespace

TEST_CASE("SeveralSourcesGoOnThroughAVertexWhereFacesMeetInNothingElse") {
  std::mt19937 random(fixtures::test_seed());
  for (const std::uint32_t rim : {6U, 60U, 600U, 3000U}) {
    CAPTURE(rim);
    const Surface surface(cones_at_one_tip(3, rim));
    const auto last = surface.mesh().source_vertex_count() - 1;
    std::vector<Source> sources{{surface.at(last), 0}, {surface.at(last), 5}};
    for (int i = 0; i < 6; ++i) {
      sources.push_back({surface.at(1 + static_cast<std::uint32_t>(random() % rim)), 0});
      sources.push_back({surface.at(1 + rim), 0.01 * i});
    }
    check_by_exact(surface, sources, 0.02);
  }
}

// All are as far as each other nearly everywhere.
TEST_CASE("ManySourcesCloseTogetherAreAsTrueAsFew") {
  std::mt19937 random(fixtures::test_seed());
  const Surface surface(shapes::icosphere(4));
  std::vector<Source> sources;
  const auto face = static_cast<std::uint32_t>(random() % surface.mesh().face_count());
  for (int i = 0; i < 300; ++i) {
    const double a = std::uniform_real_distribution<double>(0, 1)(random);
    const double b = std::uniform_real_distribution<double>(0, 1 - a)(random);
    sources.push_back({point_on_face(surface.adjacency(), face, {a, b, 1 - a - b}), 0});
  }
  sources.push_back(sources[0]);
  check_by_exact(surface, sources, 0.02);
}

// More sources than a vertex keeps distances from, all as far from the middle, and beyond what each
// looks over.
TEST_CASE("SourcesAsFarFromAVertexAsEachOtherAreAsTrueAsOthers") {
  const std::uint32_t columns = 121;
  const Surface surface(shapes::plane(columns, columns));
  const std::uint32_t middle = columns * (columns / 2) + columns / 2;
  std::vector<Source> sources;
  for (const int x : {-40, -30, 30, 40}) {
    for (const int y : {-40, -30, 30, 40}) {
      if (std::abs(x) == std::abs(y)) continue;
      const auto vertex =
          static_cast<std::uint32_t>(static_cast<int>(middle) + x + y * static_cast<int>(columns));
      sources.push_back({surface.at(vertex), 0});
    }
  }
  check_by_exact(surface, sources, 0.002);
  // Four that are late, and two that come round with less in one round.
  std::vector<Source> late;
  for (int i = 0; i < 4; ++i) late.push_back({surface.at(middle), 100.0 + 0.1 * i});
  late.push_back(sources[0]);
  late.push_back(sources[5]);
  check_by_exact(surface, late, 0.002);
}

// A fine part meets faces a hundred times as long.
TEST_CASE("WhereTwoSourcesMeetAcrossASeamDistancesAreAsTrueAsElsewhere") {
  std::mt19937 random(fixtures::test_seed());
  TriangleSoup soup = shapes::plane(161, 161);
  double most = 0;
  for (const Vec3& p : soup.positions) most = std::max(most, p.x);
  for (Vec3& p : soup.positions) {
    if (p.x > 0.8 * most) p.x = 0.8 * most + 100 * (p.x - 0.8 * most);
  }
  const Surface surface(soup);
  for (int round = 0; round < fixtures::all_or(4, 1); ++round) {
    CAPTURE(round);
    std::vector<Source> sources;
    for (int i = 0; i < 3; ++i) {
      sources.push_back({surface.at(static_cast<std::uint32_t>(random() % (161 * 161))), 0});
    }
    // Such long faces make a source alone err, too.
    std::vector<double> least(surface.mesh().vertex_count(), kUnreached);
    for (const Source& source : sources) {
      const Field alone = surface.field_by(Method::back_traced, {source});
      for (std::uint32_t v = 0; v < least.size(); ++v) {
        least[v] = std::min(least[v], alone.distance[v]);
      }
    }
    const Field together = surface.field_by(Method::back_traced, sources);
    for (std::uint32_t v = 0; v < least.size(); ++v) {
      CAPTURE(v);
      CHECK(std::abs(together.distance[v] - least[v]) <= 0.01 * (1e-3 + least[v]));
    }
  }
}

TEST_CASE("AWaveFromSeveralSourcesThatIsCancelledLeavesNothingBehind") {
  std::mt19937 random(fixtures::test_seed());
  const Surface surface(shapes::terrain(80, 6, 4));
  const std::vector<Source> sources = some_sources(random, surface, 9, 0);
  SolveScratch scratch;
  for (int asks = 0; asks < 40; asks += 1 + static_cast<int>(random() % 4)) {
    int left = asks;
    const auto cancelled = solve_field(Method::back_traced, {}, surface.adjacency(), sources, {},
                                       scratch, Cancel([&left] { return left-- <= 0; }));
    if (cancelled) break;
    CHECK(cancelled.error().code == ErrorCode::cancelled);
  }
  const auto field =
      solve_field(Method::back_traced, {}, surface.adjacency(), sources, {}, scratch, Cancel());
  REQUIRE(field.has_value());
  CHECK(field->distance == surface.field_by(Method::back_traced, sources).distance);
  const std::vector<Source> one{sources[0]};
  const auto single =
      solve_field(Method::back_traced, {}, surface.adjacency(), one, {}, scratch, Cancel());
  REQUIRE(single.has_value());
  CHECK(single->distance == surface.field_by(Method::back_traced, one).distance);
}
