// One field on several threads: the same bits, however many there are.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "core/base/team.h"
#include "core/field/window_table.h"
#include "core/mesh/shapes.h"
#include "core/solve/solve_field.h"
#include "tests/fixtures/crumpled_surfaces.h"
#include "tests/fixtures/faces_thrown_together.h"
#include "tests/fixtures/helping_threads.h"
#include "tests/fixtures/mixed_scales.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/same_adjacency.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::HelpingThreads;
using fixtures::Surface;

namespace {

// Faces at random among few places, many of which coincide: pinched vertices, and ways as long.
TriangleSoup among_lattice_points(std::mt19937& random) {
  TriangleSoup soup;
  const std::uint32_t places = 2 + random() % 3;
  const auto place = [&] { return static_cast<double>(random() % places); };
  for (std::uint32_t i = 6 + random() % 30; i > 0; --i) {
    soup.positions.push_back({place(), place(), place()});
  }
  // A face that has an area, whatever the others have.
  soup.positions.push_back({-1, 0, 0});
  soup.positions.push_back({-1, 1, 0});
  soup.positions.push_back({-2, 0, 1});
  const auto count = static_cast<std::uint32_t>(soup.positions.size());
  soup.faces.push_back({count - 3, count - 2, count - 1});
  for (std::uint32_t i = count / 2 + random() % (2 * count); i > 0; --i) {
    soup.faces.push_back({static_cast<std::uint32_t>(random() % count),
                          static_cast<std::uint32_t>(random() % count),
                          static_cast<std::uint32_t>(random() % count)});
  }
  return soup;
}

struct Question {
  Method method = Method::back_traced;
  std::vector<Source> sources;
  MethodOptions options;
  FieldLimits limits;
  std::vector<std::uint32_t> targets;
};

Question drawn(std::mt19937& random, const Surface& surface, double reach) {
  Question question;
  if (random() % 2 == 0) {
    question.method = Method::exact;
  } else if (random() % 2 == 0) {
    question.options.error_at_most = random() % 2 == 0 ? 1e-2 : 1e-4;
  } else if (random() % 2 == 0) {
    question.options.bound = Bound::upper;
  }
  question.limits.keep_details = random() % 3 != 0;
  const std::size_t count = random() % 4 == 0 ? 2 + random() % 3 : 1;
  const std::uint32_t vertices = surface.mesh().vertex_count();
  for (std::size_t i = 0; i < count; ++i) {
    if (random() % 3 == 0) {
      const auto face = static_cast<std::uint32_t>(random() % surface.mesh().face_count());
      question.sources.push_back({{face, {0.5, 0.3, 0.2}, kNone}, 0});
    } else {
      const auto v = static_cast<std::uint32_t>(random() % vertices);
      question.sources.push_back({point_at_vertex(surface.adjacency(), v), 0.01 * (random() % 2)});
    }
  }
  if (random() % 4 == 0) question.limits.max = reach * fixtures::fraction(random);
  if (random() % 4 == 0) {
    for (int i = 0; i < 3; ++i) question.targets.push_back(random() % vertices);
  }
  return question;
}

Field solved(const Surface& surface, const Question& question, Team* team, SolveScratch& scratch) {
  FieldLimits limits = question.limits;
  limits.targets = question.targets;
  const Cancel cancel([] { return false; }, {}, nullptr, team);
  auto field = solve_field(question.method, question.options, surface.adjacency(), question.sources,
                           limits, scratch, cancel);
  REQUIRE(field);
  return std::move(*field);
}

void check_same(const Field& field, const Field& alone, std::uint32_t face_count) {
  const auto distances = field.distance.values();
  const auto expected = alone.distance.values();
  REQUIRE(distances.size() == expected.size());
  std::size_t different = 0;
  for (std::size_t v = 0; v < expected.size(); ++v) {
    if (!(distances[v] == expected[v])) ++different;  // neither is ever no number
  }
  CHECK(different == 0);
  CHECK(field.nearest_source == alone.nearest_source);
  CHECK(field.reached == alone.reached);
  REQUIRE((field.windows == nullptr) == (alone.windows == nullptr));
  if (!field.windows) return;
  REQUIRE(field.windows->size() == alone.windows->size());
  std::size_t different_lists = 0;
  for (std::uint32_t h = 0; h < 4 * face_count; ++h) {
    if (!fixtures::has_same_bytes(field.windows->into(h), alone.windows->into(h)))
      ++different_lists;
  }
  CHECK(different_lists == 0);
}

void check_threads(std::mt19937& random, const TriangleSoup& soup, int questions) {
  const Surface surface(soup);
  const auto& box = surface.mesh().box();
  SolveScratch scratch;
  for (int i = 0; i < questions; ++i) {
    const Question question = drawn(random, surface, norm(box.max - box.min));
    const Field alone = solved(surface, question, nullptr, scratch);
    for (const std::size_t threads : {std::size_t{2}, std::size_t{3}, 4 + random() % 13}) {
      CAPTURE(threads);
      Team team(threads, 0);
      // Fewer, or none, may come than were expected.
      const HelpingThreads helping(team, random() % 3);
      check_same(solved(surface, question, &team, scratch), alone, surface.mesh().face_count());
    }
  }
}

}  // namespace

TEST_CASE("AFieldHasTheSameBitsOnAnyNumberOfThreads") {
  std::mt19937 random(fixtures::test_seed());
  SUBCASE("of surfaces like scans") {
    check_threads(random, shapes::terrain(60, 12, random()), 4);
    check_threads(random, shapes::terrain(150, 12, random()), 2);
    check_threads(random, shapes::icosphere(4), 4);
    check_threads(random, fixtures::dented_ball(random, 4), 4);
    check_threads(random, shapes::shuffled(shapes::torus_knot(120, 12, 0.3), random()), 4);
  }
  SUBCASE("of planes, where many ways are as short") {
    check_threads(random, shapes::plane(50, 40), 4);
    check_threads(random, shapes::icosphere(3), 4);
  }
  SUBCASE("with edges hundreds of times as long as others") {
    for (int i = 0; i < 10; ++i) {
      CAPTURE(i);
      TriangleSoup soup = shapes::terrain(60, 8, random());
      fixtures::pull_together(soup, random, 1e-3, 0.5);
      check_threads(random, soup, 2);
      check_threads(
          random, fixtures::star(random, 60, std::exp(12 * fixtures::fraction(random)), false), 2);
    }
  }
  SUBCASE("of awkward ones") {
    for (int i = 0; i < 60; ++i) {
      CAPTURE(i);
      check_threads(random, fixtures::RandomMesh(random()).soup(), 1);
      check_threads(random, fixtures::grown(random, 20 + static_cast<int>(random() % 80)), 1);
      check_threads(random, fixtures::faces_thrown_together(random, 40), 1);
      check_threads(random, fixtures::crumpled(random, 12, 3, 0.3), 1);
      check_threads(random, among_lattice_points(random), 1);
    }
  }
}

// A pinched vertex gives two estimates over one base, from both of its ends and as far. Which of
// them is taken decides how a vertex behind it is traced.
TEST_CASE("OfTwoEstimatesOverOneBaseTheSameIsTakenOnAnyNumberOfThreads") {
  const Surface surface(TriangleSoup{
      {{0, 2, 1}, {2, 1, 0}, {1, 2, 0}, {0, 1, 1}, {0, 2, 1},  {0, 0, 1},  {2, 1, 0}, {1, 2, 1},
       {0, 0, 0}, {2, 0, 0}, {2, 1, 1}, {0, 0, 0}, {2, 2, 0},  {2, 1, 0},  {1, 1, 1}, {1, 2, 0},
       {1, 1, 1}, {0, 2, 1}, {2, 0, 1}, {2, 2, 1}, {-1, 0, 0}, {-1, 1, 0}, {-2, 0, 1}},
      {{20, 21, 22}, {12, 3, 14},  {10, 2, 22}, {0, 9, 3},    {16, 14, 10}, {17, 18, 9},
       {8, 2, 9},    {2, 6, 0},    {11, 7, 19}, {10, 6, 3},   {20, 10, 8},  {11, 17, 15},
       {15, 8, 10},  {13, 12, 16}, {13, 7, 2},  {0, 0, 3},    {21, 8, 19},  {8, 17, 9},
       {22, 5, 21},  {13, 19, 20}, {5, 17, 19}, {21, 6, 1},   {1, 3, 11},   {14, 2, 16},
       {1, 19, 22},  {14, 5, 12},  {9, 16, 9},  {8, 7, 3},    {6, 7, 15},   {14, 11, 8},
       {8, 4, 2},    {14, 1, 7},   {21, 13, 7}, {13, 14, 20}, {19, 11, 8},  {3, 3, 10},
       {16, 10, 15}, {2, 19, 17},  {15, 11, 2}, {0, 14, 5},   {16, 18, 13}}});
  SolveScratch scratch;
  for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
    CAPTURE(v);
    const Question question{
        Method::back_traced, {{point_at_vertex(surface.adjacency(), v), 0}}, {}, {}, {}};
    const Field alone = solved(surface, question, nullptr, scratch);
    for (const std::size_t threads : {2, 3, 5, 16}) {
      CAPTURE(threads);
      Team team(threads, 0);
      check_same(solved(surface, question, &team, scratch), alone, surface.mesh().face_count());
    }
  }
}

TEST_CASE("AFieldOfManyThreadsThatIsCancelledLeavesNothingBehind") {
  std::mt19937 random(fixtures::test_seed());
  const Surface surface(shapes::terrain(80, 10, random()));
  SolveScratch scratch;
  Question question{
      Method::back_traced, {{point_at_vertex(surface.adjacency(), 7), 0}}, {}, {}, {}};
  SUBCASE("by auto") {}
  SUBCASE("by windows") { question.method = Method::exact; }
  const Field alone = solved(surface, question, nullptr, scratch);
  for (int i = 0; i < 20; ++i) {
    Team team(3, 0);
    const HelpingThreads helping(team, 2);
    int left = static_cast<int>(random() % 5);
    const Cancel cancel([&] { return left-- <= 0; }, {}, nullptr, &team);
    const auto field = solve_field(question.method, {}, surface.adjacency(), question.sources, {},
                                   scratch, cancel);
    if (!field) CHECK(field.error().code == ErrorCode::cancelled);
    Team next(2, 0);
    check_same(solved(surface, question, i % 2 == 0 ? nullptr : &next, scratch), alone,
               surface.mesh().face_count());
  }
}
