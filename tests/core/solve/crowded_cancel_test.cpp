// Whatever is asked about faces that crowd on an edge or at a vertex ends in little work, asks all
// the time whether to stop, and stops at whichever question is answered with yes.
#include <doctest/doctest.h>

#include <algorithm>
#include <ctime>
#include <functional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/locate/closest_point.h"
#include "core/paths/isolines.h"
#include "core/solve/farthest_points.h"
#include "core/solve/pair_search.h"
#include "core/solve/surface_patch.h"
#include "core/steiner/path.h"
#include "core/straighten/refine_path.h"
#include "core/straighten/shorten_path.h"
#include "core/straighten/straightest_geodesic.h"
#include "tests/core/solve/crowded_meshes.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::Surface;

namespace {

// Of the process, so that others on the machine do not count.
double seconds_of_work() {
  std::timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// Some milliseconds and half a second, with room for sanitizers; the square of the faces takes
// longer.
constexpr double kLongestWithoutAQuestion = 0.5;
constexpr double kMostWork = 10;

using Computation = std::function<Result<void>(const Cancel&)>;
struct NamedComputation {
  std::string name;
  Computation run;
};

template <class Value>
Result<void> without_value(const Result<Value>& result) {
  if (!result) return fail(result.error());
  return {};
}

struct Way {
  std::string name;
  Method method;
  MethodOptions options;
};

std::vector<Way> ways() {
  MethodOptions upper;
  upper.bound = Bound::upper;
  MethodOptions within;
  within.error_at_most = 0.01;
  MethodOptions fine;
  fine.points_per_edge = 20;
  return {{"wavefront", Method::wavefront, {}},
          {"novotni", Method::novotni, {}},
          {"fast_marching", Method::fast_marching, {}},
          {"dijkstra", Method::dijkstra, {}},
          {"exact", Method::exact, {}},
          {"chen_han", Method::chen_han, {}},
          {"steiner", Method::steiner, {}},
          {"fine steiner", Method::steiner, fine},
          {"auto", Method::back_traced, {}},
          {"upper", Method::back_traced, upper},
          {"within", Method::back_traced, within}};
}

// Fields and what follows from them.
void add_fields(const Surface& surface, const SurfacePoint& from, const SurfacePoint& to,
                std::vector<NamedComputation>& all) {
  for (const Way& way : ways()) {
    all.push_back({way.name, [&surface, from, way](const Cancel& cancel) {
                     SolveScratch scratch;
                     const Source source{from, 0};
                     return without_value(solve_field(way.method, way.options, surface.adjacency(),
                                                      {&source, 1}, {}, scratch, cancel));
                   }});
    all.push_back({way.name + ", many sources", [&surface, way](const Cancel& cancel) {
                     // On one edge, where all of a crowd's faces may be.
                     std::vector<Source> sources;
                     for (int i = 1; i < 8; ++i) {
                       sources.push_back({surface.on(7, {0.1 * i, 1 - 0.1 * i, 0}), 0});
                     }
                     SolveScratch scratch;
                     return without_value(solve_field(way.method, way.options, surface.adjacency(),
                                                      sources, {}, scratch, cancel));
                   }});
    all.push_back({way.name + ", a pair", [&surface, from, to, way](const Cancel& cancel) {
                     SolveScratch scratch;
                     return without_value(pair_search(way.method, way.options, surface.adjacency(),
                                                      {from, 0}, to, PairPath::refined, scratch,
                                                      cancel));
                   }});
    const Field field = surface.field_by(way.method, {{from, 0}}, {}, way.options);
    all.push_back({way.name + ", a path", [&surface, to, field](const Cancel& cancel) {
                     return without_value(trace_path(surface.adjacency(), field, to, cancel));
                   }});
    all.push_back({way.name + ", isolines", [&surface, field](const Cancel& cancel) {
                     const std::vector<double> levels{0.1, 0.3, 0.7, 1.5};
                     return without_value(
                         isolines(surface.adjacency(), field, levels, 1'000'000, cancel));
                   }});
    const auto path = surface.path(field, to);
    if (!path) continue;
    all.push_back({way.name + ", refined", [&surface, to, field, path](const Cancel& cancel) {
                     return without_value(
                         refine_path(surface.adjacency(), field, to, *path, cancel));
                   }});
    all.push_back({way.name + ", shortened", [&surface, path](const Cancel& cancel) {
                     return without_value(shorten_path(surface.adjacency(), *path, cancel));
                   }});
  }
}

void add_others(const Surface& surface, const SurfacePoint& from, const SurfacePoint& to,
                std::vector<NamedComputation>& all) {
  all.push_back({"adjacency", [&surface](const Cancel& cancel) {
                   const auto mesh = std::make_shared<const Mesh>(surface.mesh());
                   return without_value(Adjacency::build(mesh, cancel));
                 }});
  all.push_back({"closest points", [&surface](const Cancel& cancel) -> Result<void> {
                   const auto index = ClosestPointIndex::build(surface.shared(), cancel);
                   if (!index) return fail(index.error());
                   if (auto found = (*index)->closest({1e9, 2, 3}, cancel); !found) {
                     return fail(found.error());
                   }
                   return without_value((*index)->first_hit({0.3, 0.3, 9}, {0, 0, -1}, cancel));
                 }});
  // No path is shorter than the straight line.
  const double longest =
      1.2 * distance(position_of(surface.mesh(), from), position_of(surface.mesh(), to));
  all.push_back({"a part of the surface", [&surface, from, to, longest](const Cancel& cancel) {
                   return without_value(
                       SurfacePatch::cut(surface.adjacency(), from, to, longest, cancel));
                 }});
  all.push_back({"steiner, a path of its own", [&surface, from, to](const Cancel& cancel) {
                   WavefrontScratch scratch;
                   return without_value(
                       steiner_path(surface.adjacency(), {from, 0}, to, {}, scratch, cancel));
                 }});
  for (const Method method : {Method::wavefront, Method::steiner, Method::chen_han}) {
    all.push_back({"samples", [&surface, from, method](const Cancel& cancel) {
                     SolveScratch scratch;
                     const Source source{from, 0};
                     return without_value(farthest_points(method, {}, surface.adjacency(),
                                                          {&source, 1}, 3, scratch, cancel));
                   }});
  }
  for (const Vec3 direction : {Vec3{-1, 0.01, 0}, Vec3{0.3, 0.5, -0.1}}) {
    all.push_back({"straight ahead", [&surface, from, direction](const Cancel& cancel) {
                     return without_value(
                         straightest_geodesic(surface.adjacency(), from, direction, 100, cancel));
                   }});
  }
}

// Answers a question with yes once it has been asked so often, and notes when it was asked.
struct Listener {
  std::size_t stop_at = 0;  // 0: never
  std::size_t asked = 0;
  double begun = seconds_of_work();
  double last = begun;
  double longest = 0;

  bool ask() {
    const double now = seconds_of_work();
    longest = std::max(longest, now - std::exchange(last, now));
    return ++asked == stop_at || now - begun > kMostWork;
  }
};

void check(const Computation& run, std::mt19937& random) {
  Listener whole;
  const auto result = run(Cancel([&] { return whole.ask(); }));
  (void)whole.ask();
  // Some have no answer here, such as a trace that leaves the surface.
  CHECK((result || result.error().code == ErrorCode::value_out_of_range));
  CHECK(whole.last - whole.begun < kMostWork);
  CHECK(whole.longest < kLongestWithoutAQuestion);
  const std::size_t questions = whole.asked - 1;
  if (questions == 0) return;
  Listener stopped;
  stopped.stop_at = 1 + random() % questions;
  CAPTURE(stopped.stop_at);
  const auto ended = run(Cancel([&] { return stopped.ask(); }));
  REQUIRE_FALSE(ended);
  CHECK(ended.error().code == ErrorCode::cancelled);
  CHECK(stopped.asked == stopped.stop_at);
  CHECK(seconds_of_work() - stopped.last < kLongestWithoutAQuestion);
}

}  // namespace

// Whether one face with an area is among them, which the ray is said to meet then, or none.
TEST_CASE("ARayThroughACrowdOfFlatFacesGoesRoundTheirEdgesOnce") {
  std::mt19937 random(fixtures::test_seed() + 1);
  constexpr double kHeight = 1e-13;
  for (const bool has_area : {false, true}) {
    CAPTURE(has_area);
    TriangleSoup soup = crowded::copies(kHeight);
    for (int i = 0; i < 2; ++i) {
      soup.faces.insert(soup.faces.end(), soup.faces.begin(), soup.faces.end());
    }
    if (has_area) {
      soup.positions.push_back({0.5, -1, 0});
      soup.faces.push_back({0, 1, 3});
    }
    const Surface surface(soup);
    for (const auto hierarchy :
         {ClosestPointIndex::Hierarchy::quickest, ClosestPointIndex::Hierarchy::boxes}) {
      const auto index = ClosestPointIndex::build(surface.shared(), Cancel(), hierarchy);
      REQUIRE(index);
      const Vec3 from{0.4, kHeight / 2, 9};
      const Vec3 down{0, 0, -1};
      check(
          [&](const Cancel& cancel) {
            return without_value((*index)->first_hit(from, down, cancel));
          },
          random);
      const auto hit = (*index)->first_hit(from, down);
      REQUIRE(hit.has_value() == has_area);
      if (!hit) continue;
      CHECK(surface.adjacency().face(hit->point.face).area2 > 0.5);
      CHECK(distance(position_of(surface.mesh(), hit->point), {0.4, 0, 0}) < 1e-12);
    }
  }
}

TEST_CASE("WhateverIsAskedAboutACrowdEndsAndIsLeftAtAnyQuestion") {
  std::mt19937 random(fixtures::test_seed());
  auto crowds = crowded::crowds();
  std::shuffle(crowds.begin(), crowds.end(), random);
  crowds.resize(fixtures::all_or(crowds.size(), crowds.size() / 4));
  for (const crowded::Crowd& crowd : crowds) {
    CAPTURE(crowd.name);
    const Surface surface(crowd.soup);
    const auto face = static_cast<std::uint32_t>(random() % crowded::kFaces);
    std::vector<SurfacePoint> points{
        surface.at(0), surface.at(2), surface.on(face, {0.2, 0.3, 0.5}),
        surface.on(face, {0.4, 0.6, 0}), surface.on(crowded::kFaces - 1 - face, {0.1, 0, 0.9})};
    std::shuffle(points.begin(), points.end(), random);
    std::vector<NamedComputation> all;
    add_fields(surface, points[0], points[1], all);
    add_others(surface, points[2], points[3], all);
    for (const NamedComputation& named : all) {
      CAPTURE(named.name);
      check(named.run, random);
    }
  }
}
