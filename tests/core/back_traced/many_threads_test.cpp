// One field on several threads: the same bits, however many there are.
#include <doctest/doctest.h>

#include <cstdint>
#include <random>
#include <vector>

#include "core/base/team.h"
#include "core/mesh/shapes.h"
#include "core/solve/solve_field.h"
#include "tests/fixtures/crumpled_surfaces.h"
#include "tests/fixtures/faces_thrown_together.h"
#include "tests/fixtures/helping_threads.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::HelpingThreads;
using fixtures::Surface;

namespace {

struct Question {
  std::vector<Source> sources;
  MethodOptions options;
  FieldLimits limits;
  std::vector<std::uint32_t> targets;
};

Question drawn(std::mt19937& random, const Surface& surface, double reach) {
  Question question;
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
  if (random() % 3 == 0) question.options.bound = Bound::upper;
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
  auto field = solve_field(Method::back_traced, question.options, surface.adjacency(),
                           question.sources, limits, scratch, cancel);
  REQUIRE(field);
  return std::move(*field);
}

void check_same(const Field& field, const Field& alone) {
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
      check_same(solved(surface, question, &team, scratch), alone);
    }
  }
}

}  // namespace

TEST_CASE("AFieldHasTheSameBitsOnAnyNumberOfThreads") {
  std::mt19937 random(fixtures::test_seed());
  SUBCASE("of surfaces like scans") {
    check_threads(random, shapes::terrain(60, 12, random()), 4);
    check_threads(random, shapes::icosphere(4), 4);
    check_threads(random, fixtures::dented_ball(random, 4), 4);
    check_threads(random, shapes::shuffled(shapes::torus_knot(120, 12, 0.3), random()), 4);
  }
  SUBCASE("of planes, where many ways are as short") {
    check_threads(random, shapes::plane(50, 40), 4);
    check_threads(random, shapes::icosphere(3), 4);
  }
  SUBCASE("of awkward ones") {
    for (int i = 0; i < 60; ++i) {
      CAPTURE(i);
      check_threads(random, fixtures::RandomMesh(random()).soup(), 1);
      check_threads(random, fixtures::grown(random, 20 + static_cast<int>(random() % 80)), 1);
      check_threads(random, fixtures::faces_thrown_together(random, 40), 1);
      check_threads(random, fixtures::crumpled(random, 12, 3, 0.3), 1);
    }
  }
}

TEST_CASE("AFieldOfManyThreadsThatIsCancelledLeavesNothingBehind") {
  std::mt19937 random(fixtures::test_seed());
  const Surface surface(shapes::terrain(80, 10, random()));
  SolveScratch scratch;
  const Question question{{{point_at_vertex(surface.adjacency(), 7), 0}}, {}, {}, {}};
  const Field alone = solved(surface, question, nullptr, scratch);
  for (int i = 0; i < 20; ++i) {
    Team team(3, 0);
    const HelpingThreads helping(team, 2);
    int left = static_cast<int>(random() % 5);
    const Cancel cancel([&] { return left-- <= 0; }, {}, nullptr, &team);
    const auto field = solve_field(Method::back_traced, {}, surface.adjacency(), question.sources,
                                   {}, scratch, cancel);
    if (!field) CHECK(field.error().code == ErrorCode::cancelled);
    Team next(2, 0);
    check_same(solved(surface, question, i % 2 == 0 ? nullptr : &next, scratch), alone);
  }
}
