// Whatever computes asks often enough whether it should stop, stops when it should, and
// says how far it has come. Counted in steps, not in time.
#include "core/base/cancel.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/field/window_table.h"
#include "core/locate/closest_point.h"
#include "core/mesh/shapes.h"
#include "core/mesh/weld.h"
#include "core/paths/arrive_at_point.h"
#include "core/paths/down_edges.h"
#include "core/paths/edge_path.h"
#include "core/paths/isolines.h"
#include "core/paths/leave_cluster.h"
#include "core/paths/trace_path.h"
#include "core/solve/farthest_points.h"
#include "core/solve/solve_field.h"
#include "core/steiner/path.h"
#include "core/straighten/shorten_path.h"
#include "core/straighten/straightest_geodesic.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;

namespace {

// What a computation asked and told.
struct Listener {
  std::size_t asked = 0;
  std::size_t stop_at = 0;  // the question that is answered with yes; 0: none
  std::vector<double> told;
  std::vector<std::size_t> asked_before;  // each of them

  Cancel cancel() {
    return Cancel([this] { return ++asked == stop_at; },
                  [this](double done) {
                    told.push_back(done);
                    asked_before.push_back(asked);
                  });
  }
};

struct Terrain {
  explicit Terrain(const TriangleSoup& soup)
      : mesh(std::make_shared<const Mesh>(std::move(*Mesh::build(soup)))),
        adjacency(Adjacency::build(mesh)) {}
  std::shared_ptr<const Mesh> mesh;
  Adjacency adjacency;
};

const Terrain& terrain() {
  static const Terrain surface(shapes::terrain(200, 6, 3));
  return surface;
}
std::uint64_t vertex_count() { return terrain().mesh->vertex_count(); }
std::uint64_t face_count() { return terrain().mesh->face_count(); }

Source at_vertex(std::uint32_t v) { return {point_at_vertex(terrain().adjacency, v), 0}; }

using Computation = std::function<Result<void>(const Cancel&)>;

template <class Value>
Result<void> without_value(const Result<Value>& result) {
  if (!result) return fail(result.error());
  return {};
}

Computation solving(Method method, std::vector<Source> sources, double max = kUnreached) {
  return [=](const Cancel& cancel) {
    SolveScratch scratch;
    FieldLimits limits;
    limits.max = max;
    return without_value(
        solve_field(method, {}, terrain().adjacency, sources, limits, scratch, cancel));
  };
}

const Field& dijkstra_field() {
  static const Field field = [] {
    SolveScratch scratch;
    const Source source = at_vertex(0);
    return std::move(*solve_field(Method::dijkstra, {}, terrain().adjacency, {&source, 1}, {},
                                  scratch, Cancel()));
  }();
  return field;
}

struct Named {
  std::string name;
  Computation run;
};

std::vector<Named> all_computations() {
  const Source one = at_vertex(7);
  const std::vector<Source> two{one, at_vertex(30'000)};
  std::vector<Named> all;
  for (const auto& [name, method] :
       {std::pair{"dijkstra", Method::dijkstra}, std::pair{"wavefront", Method::wavefront},
        std::pair{"novotni", Method::novotni}, std::pair{"fast_marching", Method::fast_marching},
        std::pair{"steiner", Method::steiner}}) {
    all.push_back({name, solving(method, {one})});
    all.push_back({name + std::string(" from two"), solving(method, two)});
  }
  all.push_back({"auto", solving(Method::back_traced, {one})});
  all.push_back({"auto from two", solving(Method::back_traced, two)});
  // As much as the exact ones do of so many vertices in a second.
  all.push_back({"exact", solving(Method::exact, {one}, 60)});
  all.push_back({"exact from two", solving(Method::exact, two, 30)});
  all.push_back({"chen_han", solving(Method::chen_han, {one}, 40)});
  all.push_back({"chen_han from two", solving(Method::chen_han, two, 20)});
  all.push_back({"adjacency", [](const Cancel& cancel) {
                   return without_value(Adjacency::build(terrain().mesh, cancel));
                 }});
  all.push_back({"mesh", [](const Cancel& cancel) {
                   static const TriangleSoup soup = shapes::terrain(200, 6, 3);
                   return without_value(Mesh::build(soup, Weld::by_position, cancel));
                 }});
  all.push_back({"welding", [](const Cancel& cancel) {
                   TriangleSoup soup = shapes::terrain(200, 6, 3);
                   return without_value(weld_within(soup, 0.1, cancel));
                 }});
  all.push_back({"closest points", [](const Cancel& cancel) {
                   static const auto adjacency =
                       std::make_shared<const Adjacency>(Adjacency::build(terrain().mesh));
                   return without_value(ClosestPointIndex::build(adjacency, cancel));
                 }});
  all.push_back({"isolines", [](const Cancel& cancel) {
                   const std::vector<double> levels{20, 40, 60};
                   return without_value(
                       isolines(terrain().adjacency, dijkstra_field(), levels, 1'000'000, cancel));
                 }});
  all.push_back({"samples", [](const Cancel& cancel) {
                   SolveScratch scratch;
                   return without_value(farthest_points(Method::wavefront, {}, terrain().adjacency,
                                                        {}, 4, scratch, cancel));
                 }});
  all.push_back({"steiner path", [=](const Cancel& cancel) {
                   WavefrontScratch scratch;
                   return without_value(steiner_path(terrain().adjacency, one,
                                                     point_at_vertex(terrain().adjacency, 39'000),
                                                     {}, scratch, cancel));
                 }});
  all.push_back({"shortening", [](const Cancel& cancel) {
                   const auto path = *trace_path(
                       terrain().adjacency, dijkstra_field(),
                       point_at_vertex(terrain().adjacency, dijkstra_field().farthest), Cancel());
                   return without_value(shorten_path(terrain().adjacency, *path, cancel));
                 }});
  return all;
}

// A flat cone of so many faces round its tip, vertex 0.
TriangleSoup hub(std::uint32_t faces) {
  TriangleSoup soup;
  soup.positions.push_back({0, 0, 0.3});
  for (std::uint32_t i = 0; i < faces; ++i) {
    const double angle = 6.283185307179586 * i / faces;
    soup.positions.push_back({std::cos(angle), std::sin(angle), 0});
    soup.faces.push_back({0, i + 1, (i + 1) % faces + 1});
  }
  return soup;
}

constexpr std::uint32_t kHubFaces = 20'000;
const Terrain& disc() {
  static const Terrain surface(hub(kHubFaces));
  return surface;
}

// So long that a path along it is.
const Terrain& strip() {
  static const Terrain surface(shapes::plane(4000, 2));
  return surface;
}

std::uint32_t disc_vertex(std::uint32_t source) { return disc().mesh->vertex_of_source()[source]; }
SurfacePoint on_disc(std::uint32_t source) {
  return point_at_vertex(disc().adjacency, disc_vertex(source));
}

Field field_on_disc(Method method, std::uint32_t from) {
  SolveScratch scratch;
  const Source source{on_disc(from), 0};
  return std::move(*solve_field(method, {}, disc().adjacency, {&source, 1}, {}, scratch, Cancel()));
}

// Over the middle of the disc, from one side to the other.
Path over_the_hub() {
  const Field field = field_on_disc(Method::dijkstra, 1);
  return std::move(**trace_path(disc().adjacency, field, on_disc(1 + kHubFaces / 3), Cancel()));
}

// What follows a path, or looks for one: nobody knows how much there is to do. Over long
// ways, and over vertices with many faces.
std::vector<Named> all_path_tools() {
  std::vector<Named> all;
  all.push_back({"trace", [](const Cancel& cancel) {
                   static const Field field = [] {
                     SolveScratch scratch;
                     const Source source{point_at_vertex(strip().adjacency, 0), 0};
                     return std::move(*solve_field(Method::dijkstra, {}, strip().adjacency,
                                                   {&source, 1}, {}, scratch, Cancel()));
                   }();
                   return without_value(
                       trace_path(strip().adjacency, field,
                                  point_at_vertex(strip().adjacency, field.farthest), cancel));
                 }});
  all.push_back({"exact trace", [](const Cancel& cancel) {
                   static const Field field = field_on_disc(Method::exact, 1);
                   return without_value(trace_path(disc().adjacency, field, on_disc(0), cancel));
                 }});
  all.push_back({"edge path", [](const Cancel& cancel) {
                   WavefrontScratch scratch;
                   const std::uint32_t last = strip().mesh->vertex_of_source()[3999];
                   return without_value(edge_path(
                       strip().adjacency,
                       point_at_vertex(strip().adjacency, strip().mesh->vertex_of_source()[0]),
                       point_at_vertex(strip().adjacency, last), scratch, cancel));
                 }});
  all.push_back({"edge path over a hub", [](const Cancel& cancel) {
                   WavefrontScratch scratch;
                   return without_value(
                       edge_path(disc().adjacency, on_disc(0), on_disc(9), scratch, cancel));
                 }});
  all.push_back({"down edges", [](const Cancel& cancel) {
                   Poll poll(cancel);
                   // Nothing is below it.
                   (void)down_edges(terrain().adjacency, dijkstra_field(), 7, 0, poll);
                   if (poll.stopped()) return Result<void>(fail(ErrorCode::cancelled, ""));
                   return Result<void>();
                 }});
  all.push_back({"leaving a cluster", [](const Cancel& cancel) {
                   static const Field field = field_on_disc(Method::exact, 1);
                   Poll poll(cancel);
                   const PointArrivals arrivals(disc().adjacency, field, &poll);
                   const auto never = [](std::uint32_t) { return false; };
                   (void)leave_cluster(disc().adjacency, field, arrivals, disc_vertex(0), never,
                                       never, poll);
                   if (poll.stopped()) return Result<void>(fail(ErrorCode::cancelled, ""));
                   return Result<void>();
                 }});
  all.push_back({"distances of points", [](const Cancel& cancel) {
                   const Field field = field_on_disc(Method::dijkstra, 0);
                   Poll poll(cancel);
                   // The source alone lies in every face.
                   const PointArrivals arrivals(disc().adjacency, field, &poll);
                   if (poll.stopped()) return Result<void>(fail(ErrorCode::cancelled, ""));
                   return Result<void>();
                 }});
  all.push_back({"shortening over a hub", [](const Cancel& cancel) {
                   static const Path path = over_the_hub();
                   return without_value(shorten_path(disc().adjacency, path, cancel));
                 }});
  all.push_back({"straightest over a hub", [](const Cancel& cancel) {
                   return without_value(
                       straightest_geodesic(disc().adjacency, on_disc(1), {-1, 0, 0.3}, 9, cancel));
                 }});
  all.push_back({"straightest from a hub", [](const Cancel& cancel) {
                   return without_value(
                       straightest_geodesic_at_angle(disc().adjacency, on_disc(0), 5, 9, cancel));
                 }});
  all.push_back({"straightest along a knot", [](const Cancel& cancel) {
                   static const Terrain knot(shapes::torus_knot(60, 10, 0.3));
                   return without_value(straightest_geodesic_at_angle(
                       knot.adjacency, point_at_vertex(knot.adjacency, 5), 0.3, 3000, cancel));
                 }});
  all.push_back({"steiner path over a hub", [](const Cancel& cancel) {
                   WavefrontScratch scratch;
                   return without_value(steiner_path(disc().adjacency, {on_disc(1), 0},
                                                     on_disc(1 + kHubFaces / 2), {}, scratch,
                                                     cancel));
                 }});
  all.push_back({"one long isoline", [](const Cancel& cancel) {
                   static const Field field = field_on_disc(Method::dijkstra, 0);
                   const std::vector<double> levels{0.5};
                   return without_value(
                       isolines(disc().adjacency, field, levels, 1'000'000, cancel));
                 }});
  return all;
}

}  // namespace

TEST_CASE("EveryComputationStopsAtWhicheverQuestionIsAnsweredWithYes") {
  std::mt19937_64 random(fixtures::test_seed());
  std::vector<Named> all = all_computations();
  for (Named& named : all_path_tools()) all.push_back(std::move(named));
  std::shuffle(all.begin(), all.end(), random);
  all.resize(fixtures::all_or(all.size(), all.size() / 4));
  for (const auto& [name, run] : all) {
    CAPTURE(name);
    Listener whole;
    REQUIRE(run(whole.cancel()));
    REQUIRE(whole.asked > 0);
    std::vector<std::size_t> questions{1, whole.asked};
    for (int i = 0; i < fixtures::all_or(6, 1); ++i) {
      questions.push_back(1 + random() % whole.asked);
    }
    for (const std::size_t at : questions) {
      CAPTURE(at);
      Listener stopped;
      stopped.stop_at = at;
      const auto result = run(stopped.cancel());
      REQUIRE_FALSE(result);
      CHECK(result.error().code == ErrorCode::cancelled);
      CHECK(stopped.asked == at);  // told once, it asks no more
    }
  }
}

TEST_CASE("ProgressRisesFromZeroAndNeverPassesOne") {
  std::vector<Named> all = all_computations();
  std::shuffle(all.begin(), all.end(), std::mt19937_64(fixtures::test_seed()));
  all.resize(fixtures::all_or(all.size(), all.size() / 4));
  for (const auto& [name, run] : all) {
    if (name == "shortening") continue;  // nobody knows how much there is to do
    CAPTURE(name);
    Listener whole;
    REQUIRE(run(whole.cancel()));
    REQUIRE_FALSE(whole.told.empty());
    CHECK(std::is_sorted(whole.told.begin(), whole.told.end()));
    CHECK(whole.told.front() >= 0);
    CHECK(whole.told.back() <= 1);
    CHECK(whole.told.back() > 0.02);
  }
}

// Progress counts vertices, so from one question to the next it shows how many.
TEST_CASE("BetweenTwoQuestionsNoMoreThanSoManyVertices") {
  constexpr double kMost = 4096.5;  // and rounding
  for (const auto method :
       {Method::dijkstra, Method::wavefront, Method::novotni, Method::fast_marching}) {
    Listener whole;
    REQUIRE(solving(method, {at_vertex(7)})(whole.cancel()));
    double before = 0;
    std::size_t asked_before = whole.asked_before.front();
    for (std::size_t i = 0; i < whole.told.size(); ++i) {
      CHECK((whole.told[i] - before) * double(vertex_count()) <= kMost);
      CHECK(whole.asked_before[i] >= asked_before);
      before = whole.told[i];
      asked_before = whole.asked_before[i];
    }
    CHECK((1 - before) * double(vertex_count()) <= kMost);
  }
  for (const auto& [method, max] :
       {std::pair{Method::exact, 60.0}, std::pair{Method::chen_han, 40.0}}) {
    Listener whole;
    REQUIRE(solving(method, {at_vertex(7)}, max)(whole.cancel()));
    double before = 0;
    for (const double done : whole.told) {
      CHECK((done - before) * double(vertex_count()) <= kMost);
      before = done;
    }
  }
}

// What goes over all faces before the first vertex is accepted must be asked for too.
TEST_CASE("PreparationsAskAsOften") {
  constexpr std::size_t kMost = 4096;
  const auto asked_before_the_first = [](Method method) {
    Listener whole;
    REQUIRE(solving(method, {at_vertex(7)}, 5)(whole.cancel()));
    return whole.told.empty() ? whole.asked : whole.asked_before.front();
  };
  // Fast marching splits faces, Steiner's graph and the exact one number edges.
  CHECK(asked_before_the_first(Method::fast_marching) >= face_count() / kMost - 1);
  CHECK(asked_before_the_first(Method::steiner) >= face_count() / kMost - 1);
  CHECK(asked_before_the_first(Method::exact) >= 2 * face_count() / kMost - 1);
  Listener adjacency;
  REQUIRE(Adjacency::build(terrain().mesh, adjacency.cancel()));
  CHECK(adjacency.asked >= 5 * face_count() / kMost - 6);
  Listener mesh;
  REQUIRE(Mesh::build(shapes::terrain(200, 6, 3), Weld::by_position, mesh.cancel()));
  // Faces are gone through four times; vertices four times, and sorted.
  CHECK(mesh.asked >= (4 * face_count() + 7 * vertex_count()) / kMost - 12);
  Listener welding;
  TriangleSoup soup = shapes::terrain(200, 6, 3);
  REQUIRE(weld_within(soup, 0.1, welding.cancel()));
  // Gone through once, sorted in runs that are then merged.
  CHECK(welding.asked >= 2 * vertex_count() / kMost - 2);
  Listener index;
  REQUIRE(ClosestPointIndex::build(
      std::make_shared<const Adjacency>(Adjacency::build(terrain().mesh)), index.cancel()));
  CHECK(index.asked >= face_count() / kMost);
}

// What is left on the edges is read into a table after the last vertex is final; `chen_han` sorts
// it, too.
TEST_CASE("WhatComesAfterTheLastVertexAsksAsOften") {
  constexpr std::size_t kMost = 4096;
  for (const auto& [method, max, times] :
       {std::tuple{Method::exact, 60.0, 2U}, {Method::chen_han, 40.0, 3U}}) {
    Listener whole;
    SolveScratch scratch;
    FieldLimits limits;
    limits.max = max;
    const Source source = at_vertex(7);
    const auto field =
        solve_field(method, {}, terrain().adjacency, {&source, 1}, limits, scratch, whole.cancel());
    REQUIRE(field);
    REQUIRE(field->windows);
    const std::size_t after = whole.asked - whole.asked_before.back();
    CHECK(after >= (times * field->windows->size() + 4 * face_count()) / kMost - 1);
  }
}

TEST_CASE("APartReportsWithinItsBounds") {
  std::vector<double> told;
  bool stop = false;
  const Cancel whole([&] { return stop; }, [&](double done) { told.push_back(done); });
  const Cancel second = whole.part(0.5, 0.75);
  second.report(0);
  second.report(0.5);
  const Cancel half_of_it = second.part(0.5, 1);
  half_of_it.report(1);
  CHECK(told == std::vector<double>{0.5, 0.625, 0.75});
  CHECK_FALSE(half_of_it.requested());
  stop = true;
  CHECK(half_of_it.requested());
}

TEST_CASE("APollAsksOnceInSoManyStepsAndRemembersYes") {
  Listener listener;
  listener.stop_at = 2;
  const Cancel cancel = listener.cancel();
  Poll poll(cancel, 10);
  for (int step = 1; step < 20; ++step) CHECK_FALSE(poll.cancelled(std::uint64_t(step), 40));
  CHECK(listener.asked == 1);
  CHECK_FALSE(poll.stopped());
  CHECK(poll.cancelled(20, 40));
  CHECK(listener.told == std::vector<double>{0.25, 0.5});
  for (int step = 0; step < 5; ++step) CHECK(poll.cancelled());
  CHECK(poll.stopped());
  CHECK(listener.asked == 2);
}
