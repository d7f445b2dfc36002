// Meshes whose coordinates are a few whole numbers, as of floats far from the origin: many of their
// faces have no area, for their corners lie on a line or two of them in one place.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/mesh/shapes.h"
#include "core/steiner/path.h"
#include "core/straighten/refine_path.h"
#include "server/base/service_codes.h"
#include "tests/fixtures/crumpled_surfaces.h"
#include "tests/fixtures/dense_graph.h"
#include "tests/fixtures/mixed_scales.h"
#include "tests/fixtures/path_checks.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::Surface;

namespace {

constexpr double kRoundingOfExtent = 1e-9;

double whole(std::mt19937& random, int most) { return static_cast<double>(random() % (most + 1)); }

// Triangles put onto edges at random, in a few whole places of a line, a plane or space.
TriangleSoup in_whole_places(std::mt19937& random) {
  TriangleSoup soup = fixtures::grown(random, 4 + static_cast<int>(random() % 17));
  const int dimensions = 1 + static_cast<int>(random() % 3);
  const int most = 1 + static_cast<int>(random() % 4);
  for (Vec3& p : soup.positions) {
    p = {whole(random, dimensions == 1 ? 3 * most : most), 0, 0};
    if (dimensions > 1) p.y = whole(random, most);
    if (dimensions > 2) p.z = whole(random, most);
  }
  // Now and then a line with one place beside it.
  if (dimensions == 1) soup.positions[random() % soup.positions.size()].z = -1;
  return soup;
}

// A closed prism, each side of which is a strip, of floats so far from the origin that they are
// multiples of `step`.
TriangleSoup rounded_prism(std::mt19937& random, double step) {
  const std::uint32_t sides = 3 + random() % 5;
  const std::uint32_t rings = 2 + random() % 3;
  TriangleSoup soup;
  for (std::uint32_t r = 0; r < rings; ++r) {
    for (std::uint32_t s = 0; s < sides; ++s) {
      const double angle = 6.283185307179586 * s / sides;
      const Vec3 p{10 * std::cos(angle), 10 * std::sin(angle), 20.0 * r / (rings - 1)};
      soup.positions.push_back({step * std::round(p.x / step), step * std::round(p.y / step),
                                step * std::round(p.z / step)});
    }
  }
  for (std::uint32_t r = 0; r + 1 < rings; ++r) {
    for (std::uint32_t s = 0; s < sides; ++s) {
      const std::uint32_t a = r * sides + s;
      const std::uint32_t b = r * sides + (s + 1) % sides;
      soup.faces.push_back({a, b, b + sides});
      soup.faces.push_back({a, b + sides, a + sides});
    }
  }
  for (std::uint32_t s = 1; s + 1 < sides; ++s) soup.faces.push_back({0, s + 1, s});
  return soup;
}

// Rows of a strip of faces that lie on one line, but for one place beside it.
TriangleSoup rows_on_a_line(std::mt19937& random) {
  const std::uint32_t width = 3 + random() % 8;
  TriangleSoup soup = shapes::plane(width, 2 + random() % 2);
  const int most = random() % 2 == 0 ? 100 : 8;
  for (Vec3& p : soup.positions) p = {whole(random, most), 0, 0};
  soup.positions[random() % soup.positions.size()].z = -1;
  // With holes.
  for (std::size_t n = random() % 4; n > 0 && soup.faces.size() > 2; --n) {
    soup.faces.erase(soup.faces.begin() +
                     static_cast<std::ptrdiff_t>(random() % soup.faces.size()));
  }
  return soup;
}

TriangleSoup any_quantised(std::mt19937& random) {
  if (random() % 2 == 0) return rows_on_a_line(random);
  if (random() % 4 == 0) return rounded_prism(random, random() % 2 == 0 ? 4 : 8);
  return in_whole_places(random);
}

template <class Check>
void for_each_quantised(int rounds, Check check) {
  std::mt19937 random(fixtures::test_seed());
  for (int round = 0; round < rounds; ++round) {
    CAPTURE(round);
    const TriangleSoup soup = any_quantised(random);
    if (!Mesh::build(soup)) continue;  // all faces without two distinct points
    const Surface surface(soup);
    const auto count = static_cast<std::uint32_t>(surface.mesh().vertex_count());
    check(surface, random() % count);
  }
}

// By meridians and parallels, with a row of vertices at each pole, of radius 10, in floats far from
// the origin along one axis.
TriangleSoup rounded_sphere(std::mt19937& random) {
  const std::uint32_t around = 20 + random() % 30;
  const std::uint32_t rows = 15 + random() % 25;
  const Vec3 off{random() % 2 == 0 ? 3e7 : 8e7, 0, 0};
  TriangleSoup soup;
  const auto rounded = [](double x) { return static_cast<double>(static_cast<float>(x)); };
  for (std::uint32_t i = 0; i <= rows; ++i) {
    const double down = 3.141592653589793 * i / rows;
    for (std::uint32_t j = 0; j <= around; ++j) {
      const double angle = 6.283185307179586 * j / around;
      const Vec3 p = 10.0 * Vec3{std::sin(down) * std::cos(angle), std::cos(down),
                                 std::sin(down) * std::sin(angle)} +
                     off;
      soup.positions.push_back({rounded(p.x), rounded(p.y), rounded(p.z)});
    }
  }
  for (std::uint32_t i = 0; i < rows; ++i) {
    for (std::uint32_t j = 0; j < around; ++j) {
      const std::uint32_t a = i * (around + 1) + j;
      const std::uint32_t below = a + around + 1;
      soup.faces.push_back({a, a + 1, below});
      soup.faces.push_back({a + 1, below + 1, below});
    }
  }
  return soup;
}

// The same about the origin, rounded to multiples of any step along one axis or along all.
TriangleSoup sphere_rounded_along_axes(std::mt19937& random) {
  const std::uint32_t around = 8 + random() % 30;
  const std::uint32_t rows = 6 + random() % 25;
  const double step = 10 * fixtures::any_scale(random, -7, -1);
  const std::uint32_t along = random() % 4;  // 3: all
  const auto rounded = [&](double x, std::uint32_t axis) {
    return along == axis || along == 3 ? step * std::round(x / step) : x;
  };
  TriangleSoup soup;
  for (std::uint32_t i = 0; i <= rows; ++i) {
    const double down = 3.141592653589793 * i / rows;
    for (std::uint32_t j = 0; j <= around; ++j) {
      const double angle = 6.283185307179586 * j / around;
      soup.positions.push_back({rounded(10 * std::sin(down) * std::cos(angle), 0),
                                rounded(10 * std::cos(down), 1),
                                rounded(10 * std::sin(down) * std::sin(angle), 2)});
    }
  }
  for (std::uint32_t i = 0; i < rows; ++i) {
    for (std::uint32_t j = 0; j < around; ++j) {
      const std::uint32_t a = i * (around + 1) + j;
      const std::uint32_t below = a + around + 1;
      soup.faces.push_back({a, a + 1, below});
      soup.faces.push_back({a + 1, below + 1, below});
    }
  }
  return soup;
}

// What a client gets: each point is where its face and weights say, consecutive points lie in one
// face, and no way is shorter than the shortest.
void check_path(const Surface& surface, const Path& path, double shortest) {
  const Mesh& mesh = surface.mesh();
  fixtures::check_is_a_path(surface.adjacency(), path, distance(mesh.box().min, mesh.box().max));
  for (const PathPoint& p : path.points) {
    CHECK(distance(p.position, position_of(mesh, p.point)) <= kRoundingOfExtent);
  }
  CHECK(path.length >= shortest * (1 - kRoundingOfExtent));
}

// Whether all that windows answer ends after a bounded number of questions and of bytes. It is no
// longer than ways along edges.
bool comes_to_an_end(const Surface& surface, std::mt19937& random) {
  constexpr std::uint64_t kMostQuestions = 500;  // these ask up to some 50 times
  constexpr std::uint64_t kMostBytes = 64'000'000;
  const std::uint32_t from = random() % surface.mesh().vertex_count();
  const Source source{point_at_vertex(surface.adjacency(), from), 0};
  const Field edges = surface.field_by(Method::dijkstra, {source});
  // Windows lie on edges, where places are rounded as coarsely as those are long.
  const double rounding = 1e-12 * distance(surface.mesh().box().min, surface.mesh().box().max);
  MethodOptions within;
  within.error_at_most = 0.01;
  MethodOptions above;
  above.bound = Bound::upper;
  for (const auto& [method, options] :
       {std::pair{Method::exact, MethodOptions{}}, std::pair{Method::back_traced, within},
        std::pair{Method::back_traced, above}}) {
    CAPTURE(static_cast<int>(method));
    std::uint64_t questions = 0;
    std::uint64_t bytes = 0;
    MemoryBudget memory([&](std::uint64_t wanted) -> std::optional<Error> {
      if ((bytes += wanted) < kMostBytes) return std::nullopt;
      return Error{ServiceCode::too_much_memory, "more than this mesh needs", {}, {}, {}};
    });
    const Cancel cancel([&] { return ++questions > kMostQuestions; }, {}, &memory);
    SolveScratch scratch;
    const auto field = solve_field(method, options, surface.adjacency(),
                                   std::vector<Source>{source}, {}, scratch, cancel);
    if (!field) return false;
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      if (edges.distance[v] == kUnreached) continue;
      CAPTURE(v);
      const double slack = options.error_at_most.value_or(0) + 1e-6;
      CHECK(field->distance[v] <= edges.distance[v] * (1 + slack) + rounding);
    }
  }
  return true;
}

}  // namespace

TEST_CASE("OnQuantisedMeshesExactIsNoLongerThanADenseGraph") {
  constexpr std::uint32_t kSteps = 8;
  // Of some 100,000 such meshes one has a vertex that `exact` is 1 % beyond.
  std::uint32_t beyond = 0;
  for_each_quantised(fixtures::all_or(1000, 200), [&](const Surface& surface, std::uint32_t from) {
    const std::size_t count = surface.mesh().vertex_count();
    const Source source{point_at_vertex(surface.adjacency(), from), 0};
    const Field exact = surface.field_by(Method::exact, {source});
    const Field chen_han = surface.field_by(Method::chen_han, {source});
    MethodOptions options;
    options.error_at_most = 0;
    const Field within = surface.field_by(Method::back_traced, {source}, {}, options);
    const auto most = fixtures::DenseGraph(surface.adjacency(), kSteps).distances(from, count);
    bool is_beyond = false;
    for (std::uint32_t v = 0; v < count; ++v) {
      CAPTURE(v);
      if (most[v] == kUnreached) {
        CHECK(exact.distance[v] == kUnreached);
        continue;
      }
      const auto positions = surface.mesh().positions();
      if (!(exact.distance[v] <= most[v] * (1 + kRoundingOfExtent))) {
        CHECK(exact.distance[v] <= most[v] * 1.05);
        is_beyond = true;
        continue;
      }
      CHECK(exact.distance[v] >= distance(positions[from], positions[v]) * (1 - kRoundingOfExtent));
      CHECK(std::abs(chen_han.distance[v] - exact.distance[v]) <= kRoundingOfExtent * most[v]);
      CHECK(std::abs(within.distance[v] - exact.distance[v]) <= kRoundingOfExtent * most[v]);
    }
    if (is_beyond) ++beyond;
  });
  CHECK(beyond <= 1);
}

TEST_CASE("OnQuantisedMeshesPathsStayOnTheSurface") {
  for_each_quantised(150, [](const Surface& surface, std::uint32_t from) {
    const Source source{point_at_vertex(surface.adjacency(), from), 0};
    const Field exact = surface.field_by(Method::exact, {source});
    for (const Method method : {Method::exact, Method::chen_han, Method::wavefront, Method::novotni,
                                Method::fast_marching, Method::dijkstra, Method::back_traced}) {
      CAPTURE(static_cast<int>(method));
      FieldLimits limits;
      limits.keep_details = true;
      const Field field = surface.field_by(method, {source}, limits);
      for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
        if (field.distance[v] == kUnreached) continue;
        CAPTURE(v);
        const SurfacePoint target = point_at_vertex(surface.adjacency(), v);
        const auto path = surface.path(field, target);
        REQUIRE(path.has_value());
        check_path(surface, *path, exact.distance[v]);
        const auto refined = refine_path(surface.adjacency(), field, target, *path, Cancel());
        REQUIRE(refined.has_value());
        check_path(surface, *refined, exact.distance[v]);
        CHECK(refined->length <= path->length * (1 + kRoundingOfExtent));
      }
    }
  });
}

TEST_CASE("OnQuantisedMeshesSteinerPathsStayOnTheSurface") {
  WavefrontScratch scratch;
  for_each_quantised(60, [&](const Surface& surface, std::uint32_t from) {
    const Source source{point_at_vertex(surface.adjacency(), from), 0};
    const Field exact = surface.field_by(Method::exact, {source});
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      if (exact.distance[v] == kUnreached) continue;
      CAPTURE(v);
      const auto path =
          steiner_path(surface.adjacency(), source, point_at_vertex(surface.adjacency(), v), {},
                       scratch, Cancel());
      REQUIRE(path.has_value());
      REQUIRE(path->has_value());
      check_path(surface, **path, exact.distance[v]);
    }
  });
}

// Light went round their narrow tips for minutes.
TEST_CASE("OnRoundedSpheresChenHanComesToAnEnd") {
  std::mt19937 random(fixtures::test_seed());
  for (int round = 0; round < 20; ++round) {
    CAPTURE(round);
    const Surface surface(rounded_sphere(random));
    const std::uint32_t from = random() % surface.mesh().vertex_count();
    const Source source{point_at_vertex(surface.adjacency(), from), 0};
    const Field edges = surface.field_by(Method::dijkstra, {source});
    // Some thousand windows are passed on, each of which asks now and then.
    std::uint64_t questions = 0;
    const Cancel cancel([&] { return ++questions > 4000; });
    SolveScratch scratch;
    const auto field = solve_field(Method::chen_han, {}, surface.adjacency(),
                                   std::vector<Source>{source}, {}, scratch, cancel);
    REQUIRE(field.has_value());
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      if (edges.distance[v] == kUnreached) continue;
      CHECK(field->distance[v] <= edges.distance[v] + kRoundingOfExtent);
    }
  }
}

// Windows narrower than rounding lay over each other on long edges beside short ones, more each
// time that light went round a tip, until they filled the memory.
TEST_CASE("OnSpheresRoundedAlongAxesExactComesToAnEnd") {
  std::mt19937 random(fixtures::test_seed());
  for (int round = 0; round < fixtures::all_or(200, 40); ++round) {
    CAPTURE(round);
    CHECK(comes_to_an_end(Surface(sphere_rounded_along_axes(random)), random));
  }
}

// On one such heap in thousands windows of one source, equal up to rounding, do not join, and only
// a limit ends them.
TEST_CASE("OnHeapsNearlyOnALineExactNearlyAlwaysComesToAnEnd") {
  std::mt19937 random(fixtures::test_seed());
  int endless = 0;
  for (int round = 0; round < 300; ++round) {
    CAPTURE(round);
    const double off = fixtures::any_scale(random, -16, -6);
    const TriangleSoup soup = fixtures::heap_on_a_line(random, 40 * off);
    if (Mesh::build(soup)) endless += !comes_to_an_end(Surface(soup), random);
  }
  MESSAGE(endless, " of 300 were ended by a limit");
  CHECK(endless <= 3);
}
