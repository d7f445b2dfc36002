// What is measured must be right itself.
#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/paths/arrive_at_point.h"
#include "core/solve/distance_at_point.h"
#include "core/straighten/refine_path.h"
#include "tests/bench/edge_dijkstra.h"
#include "tests/bench/errors.h"
#include "tests/bench/family_meshes.h"
#include "tests/bench/irregular_plane.h"
#include "tests/bench/outline.h"
#include "tests/bench/peak_memory.h"
#include "tests/bench/peer.h"
#include "tests/bench/prepared.h"
#include "tests/bench/subjects.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using bench::Errors;
using bench::errors_of;
using bench::peak_bytes_of;

namespace {
constexpr double kInfinite = std::numeric_limits<double>::infinity();
}

TEST_CASE("ErrorsAreRelativeToTheTruth") {
  const std::vector<double> truth{0, 1, 2, 4};
  const std::vector<double> distance{0, 1.1, 1.8, 4};
  const Errors e = errors_of(distance, truth);
  CHECK(e.compared == 4);
  CHECK(e.unreached == 0);
  CHECK(e.invented == 0);
  CHECK(e.mean == doctest::Approx(0.2 / 3));
  CHECK(e.rms == doctest::Approx(std::sqrt(0.02 / 3)));
  CHECK(e.max == doctest::Approx(0.1));
  CHECK(e.share_below == doctest::Approx(1.0 / 3));
  CHECK(e.max_absolute == doctest::Approx(0.2));
  CHECK(e.mean_square == doctest::Approx((0.01 + 0.04) / 4));
}

TEST_CASE("OneVertexInAThousandMayBeWorseThanThePercentile") {
  std::vector<double> truth(2000, 1);
  std::vector<double> distance(2000, 1.001);
  distance[7] = 3;
  distance[8] = 2;
  CHECK(errors_of(distance, truth).p999 == doctest::Approx(0.001));
  distance[9] = 1.5;
  CHECK(errors_of(distance, truth).p999 == doctest::Approx(0.5));
  CHECK(errors_of(distance, truth).max == doctest::Approx(2));
}

TEST_CASE("RoundingIsNotBelowTheTruth") {
  const std::vector<double> truth{1, 1};
  CHECK(errors_of(std::vector<double>{1 - 1e-12, 1}, truth).share_below == 0);
  CHECK(errors_of(std::vector<double>{1 - 1e-6, 1}, truth).share_below == 0.5);
}

TEST_CASE("VerticesThatOneSideLacksAreCounted") {
  const std::vector<double> truth{1, kInfinite, 2};
  const std::vector<double> distance{kInfinite, 5, 2};
  const Errors e = errors_of(distance, truth);
  CHECK(e.compared == 2);
  CHECK(e.unreached == 1);
  CHECK(e.invented == 1);
  CHECK(e.max == 0);
}

TEST_CASE("PeakBytesAreWhatIsHeldAtOnce") {
  constexpr std::size_t kLarge = 1 << 20;
  // Outside of the work, so that no compiler can do without them.
  std::vector<char> a;
  std::vector<char> b;
  const std::size_t one_by_one = peak_bytes_of([&] {
    for (int i = 0; i < 5; ++i) {
      a = std::vector<char>(kLarge);
      a = std::vector<char>();
    }
  });
  CHECK(one_by_one >= kLarge);
  CHECK(one_by_one < kLarge + kLarge / 8);
  const std::size_t together = peak_bytes_of([&] {
    a = std::vector<char>(kLarge);
    b = std::vector<char>(kLarge);
  });
  CHECK(together >= 2 * kLarge);
  CHECK(together < 2 * kLarge + kLarge / 8);
  struct alignas(256) Wide {
    char bytes[4096];
  };
  std::unique_ptr<Wide> wide;
  CHECK(peak_bytes_of([&] { wide = std::make_unique<Wide>(); }) >= 4096);
  CHECK(peak_bytes_of([] {}) == 0);
}

TEST_CASE("WhatIsGivenBackMakesRoom") {
  auto before = std::make_unique<std::vector<char>>(1 << 20);
  std::vector<char> after;
  const std::size_t peak = peak_bytes_of([&] {
    before.reset();
    after = std::vector<char>(1 << 10);
  });
  CHECK(peak == 0);  // never more than at the start
}

TEST_CASE("ClosedFormsOfTheSubjectsAgreeWithExact") {
  std::size_t checked = 0;
  for (const bench::Subject& subject : bench::formula_subjects(bench::Scale::small)) {
    if (subject.known.empty()) continue;
    CAPTURE(subject.title);
    const bench::Prepared prepared(subject.soup);
    const auto distance = prepared.in_source_order(prepared.solve(Method::exact).distance.values());
    const Errors e = errors_of(distance, subject.known);
    CHECK(e.max < 1e-9);
    CHECK(e.unreached == 0);
    CHECK(e.invented == 0);
    ++checked;
  }
  CHECK(checked == 2);
}

TEST_CASE("APeerThatIsNotInstalledSaysSo") {
  const auto peer = bench::Peer::start(bench::kPeerSolvers[0], "nowhere", "nowhere", 0);
  REQUIRE_FALSE(peer.has_value());
  CHECK(peer.error() == "not installed");
}

TEST_CASE("TheBumpyPlaneIsADelaunayTriangulation") {
  const TriangleSoup soup = bench::irregular_plane(400, 0, 3);
  const TriangleSoup raised = bench::irregular_plane(400, 20, 3);
  REQUIRE(soup.positions.size() == 400);
  std::vector<bool> used(400, false);
  double area = 0;
  for (const auto& f : soup.faces) {
    const Vec3& a = soup.positions[f[0]];
    const Vec3 ab = soup.positions[f[1]] - a;
    const Vec3 ac = soup.positions[f[2]] - a;
    const double twice = ab.x * ac.y - ab.y * ac.x;
    CHECK(twice > 0);
    area += 0.5 * twice;
    // From a, the middle of the circle round the face; nobody is in it.
    const Vec3 middle{(ac.y * dot(ab, ab) - ab.y * dot(ac, ac)) / (2 * twice),
                      (ab.x * dot(ac, ac) - ac.x * dot(ab, ab)) / (2 * twice), 0};
    const double radius = norm(middle);
    for (const Vec3& p : soup.positions) CHECK(norm(p - a - middle) > radius * (1 - 1e-6));
    for (const std::uint32_t v : f) used[v] = true;
  }
  CHECK(std::count(used.begin(), used.end(), true) == 400);
  // What lies between the points' hull and the square is not covered.
  CHECK(area > 0.9 * 400);
  CHECK(area < 400);
  double highest = 0;
  for (const Vec3& p : raised.positions) highest = std::max(highest, p.z);
  CHECK(highest > 8);
  CHECK(highest < 13);
}

TEST_CASE("TheYardstickIsRightInBothOrders") {
  for (std::uint32_t i = 0; i < 30; ++i) {
    CAPTURE(i);
    const bench::Prepared prepared(fixtures::RandomMesh(fixtures::test_seed() + i).soup());
    const std::uint32_t source = prepared.vertex(0);
    if (prepared.adjacency().corners(source).empty()) continue;
    bench::Yardstick yardstick(prepared.adjacency());
    CHECK(yardstick.ms(source) >= 0);
    const Field field = prepared.solve(Method::dijkstra);
    for (std::uint32_t v = 0; v < prepared.mesh().vertex_count(); ++v) {
      CAPTURE(v);
      const double ours = yardstick.in_our_order().distance(v);
      if (ours == kUnreached) {
        CHECK(yardstick.in_file_order().distance(v) == kUnreached);
        CHECK(field.distance[v] == kUnreached);
        continue;
      }
      CHECK(yardstick.in_file_order().distance(v) == doctest::Approx(ours).epsilon(1e-12));
      CHECK(field.distance[v] == doctest::Approx(ours).epsilon(1e-6));
    }
  }
}

TEST_CASE("PartsOfTheFamilyAreClosed") {
  for (std::uint32_t i = 0; i < 2 * bench::kPartKinds; ++i) {
    const bench::FamilyMesh part = bench::part_of_family(fixtures::test_seed(), i);
    CAPTURE(i);
    CAPTURE(part.kind);
    const bench::Prepared prepared(part.soup);
    CHECK(prepared.adjacency().report().edges_boundary == 0);
  }
}

TEST_CASE("PointsAndPathsByAutoOnPartsAreExact") {
  std::mt19937 random(fixtures::test_seed());
  std::vector<double> of_points;
  std::vector<double> of_paths;
  for (std::uint32_t i = 0; i < bench::kPartKinds; ++i) {
    CAPTURE(i);
    const bench::Prepared prepared(bench::part_of_family(fixtures::test_seed(), i).soup);
    const Adjacency& adjacency = prepared.adjacency();
    const auto draw = [&] {
      const auto weight = [&] { return 0.001 + static_cast<double>(random()) / 4294967296.0; };
      const auto face = static_cast<std::uint32_t>(random() % prepared.mesh().face_count());
      return random() % 2 == 0 ? point_on_face(adjacency, face, {weight(), weight(), weight()})
                               : point_at_vertex(adjacency, adjacency.face(face).vertex[0]);
    };
    const Source source{draw(), 0};
    SolveScratch scratch;
    const auto field = [&](Method method) {
      return solve_field(method, {}, adjacency, {&source, 1}, {}, scratch, Cancel());
    };
    const auto exact = field(Method::exact);
    const auto automatic = field(Method::back_traced);
    REQUIRE((exact && automatic));
    const PointArrivals exactly(adjacency, *exact);
    const PointArrivals automatically(adjacency, *automatic);
    for (int k = 0; k < 40; ++k) {
      const SurfacePoint target = draw();
      const double d = exactly.distance_at(target);
      if (!(d > 0 && d < kInfinite)) continue;
      const auto told = distance_at_point(adjacency, *automatic, automatically, target, Cancel());
      const auto path = path_through(adjacency, *automatic, target, PathWork::refined, Cancel());
      REQUIRE((told && path && *path));
      of_points.push_back(std::abs(*told / d - 1));
      of_paths.push_back((*path)->length / d - 1);
    }
  }
  for (const auto& [what, errors] :
       {std::pair{std::string("points"), &of_points}, std::pair{std::string("paths"), &of_paths}}) {
    const double worst = *std::max_element(errors->begin(), errors->end());
    const auto bad =
        std::count_if(errors->begin(), errors->end(), [](double e) { return e > 1e-6; });
    MESSAGE(what << ": " << bad << " of " << errors->size()
                 << " off by more than 1e-6, the worst by " << worst);
    CHECK(20 * static_cast<std::size_t>(bad) <= errors->size());
  }
}

// Windows over the refined surface against those over the mesh, which are the oracle and the
// yardstick.
TEST_CASE("PointsAndPathsByExactOnPartsAreThoseOverTheMesh") {
  std::mt19937 random(fixtures::test_seed());
  int parts = 0;
  int asked = 0;
  double worst = 0;
  std::vector<double> times;
  std::vector<double> bytes;
  for (std::uint32_t i = 0; i < bench::kPartKinds; ++i) {
    CAPTURE(i);
    const bench::Prepared prepared(bench::part_of_family(fixtures::test_seed(), i).soup);
    const Adjacency& adjacency = prepared.adjacency();
    const auto draw = [&] {
      const auto weight = [&] { return 0.001 + static_cast<double>(random()) / 4294967296.0; };
      const auto face = static_cast<std::uint32_t>(random() % prepared.mesh().face_count());
      return point_on_face(adjacency, face, {weight(), weight(), weight()});
    };
    const Source source{draw(), 0};
    SolveScratch scratch;
    const auto field = [&](bool may_keep_refined, double& seconds) {
      FieldLimits limits;
      limits.may_keep_refined = may_keep_refined;
      const auto begin = std::chrono::steady_clock::now();
      auto solved =
          solve_field(Method::exact, {}, adjacency, {&source, 1}, limits, scratch, Cancel());
      seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      REQUIRE(solved);
      return std::move(*solved);
    };
    double of_mesh = 0;
    double of_refined = 0;
    const Field over_mesh = field(false, of_mesh);
    const Field refined = field(true, of_refined);
    if (!refined.kept_windows) continue;
    ++parts;
    times.push_back(of_refined / of_mesh);
    bytes.push_back(static_cast<double>(refined.bytes()) / static_cast<double>(over_mesh.bytes()));
    const PointArrivals by_mesh(adjacency, over_mesh);
    const PointArrivals by_refined(adjacency, refined);
    for (int k = 0; k < 40; ++k) {
      const SurfacePoint target = draw();
      const double d = by_mesh.distance_at(target);
      if (!(d > 0 && d < kInfinite)) continue;
      ++asked;
      const auto told = distance_at_point(adjacency, refined, by_refined, target, Cancel());
      const auto path = path_through(adjacency, refined, target, PathWork::traced, Cancel());
      REQUIRE((told && path && *path));
      worst = std::max({worst, std::abs(*told / d - 1), std::abs((*path)->length / d - 1)});
    }
  }
  REQUIRE(parts > 0);
  const auto [quickest, slowest] = std::minmax_element(times.begin(), times.end());
  const auto [least, most] = std::minmax_element(bytes.begin(), bytes.end());
  MESSAGE(asked << " points and paths on " << parts << " parts, off by at most " << worst
                << "; fields took " << *quickest << " to " << *slowest << " times as long, "
                << *least << " to " << *most << " times the memory");
  CHECK(worst <= 1e-8);
}

TEST_CASE("TubesOfThousandsOfSidesAreRefined") {
  std::mt19937 random(fixtures::test_seed());
  const auto sides = static_cast<std::uint32_t>(3000 + random() % 2001);
  const bench::Prepared prepared(bench::extrusion(bench::circle({0, 0}, 1, sides),
                                                  {bench::circle({0, 0}, 0.6, sides, true)}, 1, 1));
  const Adjacency& adjacency = prepared.adjacency();
  REQUIRE(adjacency.refined() != nullptr);
  const Source source{point_at_vertex(adjacency, static_cast<std::uint32_t>(
                                                     random() % prepared.mesh().vertex_count())),
                      0};
  FieldLimits limits;
  limits.keep_details = false;
  SolveScratch scratch;
  const auto exact =
      solve_field(Method::exact, {}, adjacency, {&source, 1}, limits, scratch, Cancel());
  const auto automatic =
      solve_field(Method::back_traced, {}, adjacency, {&source, 1}, limits, scratch, Cancel());
  REQUIRE((exact && automatic));
  double worst = 0;
  for (std::uint32_t v = 0; v < prepared.mesh().vertex_count(); ++v) {
    const double d = exact->distance[v];
    if (d > 0) worst = std::max(worst, std::abs(automatic->distance[v] / d - 1));
  }
  MESSAGE(sides << " sides: " << adjacency.parts().delaunay->flips() / prepared.mesh().face_count()
                << " flips a face, auto off by at most " << worst);
  CHECK(worst <= 1e-6);
}

TEST_CASE("ExactEndsSoonOnPartsWhoseEdgesAreRounding") {
  const auto questions_on = [](const bench::Prepared& prepared, std::uint32_t draw) {
    const Adjacency& adjacency = prepared.adjacency();
    const std::uint32_t face = draw % prepared.mesh().face_count();
    const Source source{point_at_vertex(adjacency, adjacency.face(face).vertex[0]), 0};
    std::uint64_t questions = 0;
    const std::uint64_t most = 10'000 + 4 * prepared.mesh().face_count();
    const Cancel bounded([&] { return ++questions > most; });
    FieldLimits limits;
    limits.keep_details = false;
    SolveScratch scratch;
    return solve_field(Method::exact, {}, adjacency, {&source, 1}, limits, scratch, bounded)
        .has_value();
  };
  // Of 1e-16 each, where three cuts meet: this one took 70 s.
  const bench::Prepared known(bench::part_of_family(1, 22).soup);
  CHECK(questions_on(known, std::mt19937(22)()));
  std::mt19937 random(fixtures::test_seed());
  for (std::uint32_t i = 0; i < bench::kPartKinds; ++i) {
    CAPTURE(i);
    const bench::Prepared prepared(bench::part_of_family(fixtures::test_seed(), i).soup);
    CHECK(questions_on(prepared, static_cast<std::uint32_t>(random())));
  }
}
