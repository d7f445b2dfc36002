// What grows asks the budget before; what is refused ends with the refusal, and what it leaves
// behind serves the next query as if nothing had been.
#include <doctest/doctest.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "core/field/window_table.h"
#include "core/paths/isolines.h"
#include "core/solve/solve_field.h"
#include "server/base/service_codes.h"
#include "tests/fixtures/bumpy_plane.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::bumpy_plane;

namespace {

// Says no once so many bytes were asked for.
struct Purse {
  explicit Purse(std::uint64_t bytes) : left(bytes) {}

  std::uint64_t left;
  std::uint64_t asked = 0;
  MemoryBudget budget{[this](std::uint64_t bytes) -> std::optional<Error> {
    asked += bytes;
    if (bytes > left) {
      return Error{ServiceCode::too_much_memory, "no more", {}, left, bytes};
    }
    left -= bytes;
    return std::nullopt;
  }};
  Cancel cancel{{}, {}, &budget};
};
constexpr std::uint64_t kPlenty = std::uint64_t{1} << 40;

Adjacency prepared(const TriangleSoup& soup) {
  return Adjacency::build(std::make_shared<const Mesh>(std::move(*Mesh::build(soup))));
}

constexpr Method kMethods[] = {Method::exact,     Method::chen_han,      Method::steiner,
                               Method::wavefront, Method::fast_marching, Method::back_traced};

}  // namespace

TEST_CASE("WhatIsRefusedEndsWithTooMuchMemoryAndLeavesNothingBehind") {
  std::mt19937 random(fixtures::test_seed());
  const Adjacency adjacency = prepared(bumpy_plane(60));
  MethodOptions options;
  options.points_per_edge = 3;
  SolveScratch kept;
  int refused = 0;
  for (int round = 0; round < fixtures::all_or(60, 6); ++round) {
    const Method method = kMethods[random() % std::size(kMethods)];
    const auto v = static_cast<std::uint32_t>(random() % adjacency.mesh().vertex_count());
    const bool inside = random() % 2 == 0;
    const auto f = static_cast<std::uint32_t>(random() % adjacency.mesh().face_count());
    const Source source{
        inside ? point_on_face(adjacency, f, {0.3, 0.3, 0.4}) : point_at_vertex(adjacency, v), 0};
    FieldLimits limits;
    limits.keep_details = random() % 2 == 0;
    CAPTURE(static_cast<int>(method));
    CAPTURE(round);

    Purse plenty(kPlenty);
    SolveScratch fresh;
    const auto wanted =
        solve_field(method, options, adjacency, {&source, 1}, limits, fresh, plenty.cancel);
    REQUIRE(wanted);
    Purse little(plenty.asked == 0 ? 0 : random() % plenty.asked);
    const auto field =
        solve_field(method, options, adjacency, {&source, 1}, limits, kept, little.cancel);
    if (!field) {
      ++refused;
      CHECK(field.error().code == ServiceCode::too_much_memory);
      CHECK(field.error().detail == "no more");
      CHECK(little.budget.refusal());
    }
    Purse again(kPlenty);
    const auto after =
        solve_field(method, options, adjacency, {&source, 1}, limits, kept, again.cancel);
    REQUIRE(after);
    CHECK(after->distance.values() == wanted->distance.values());
  }
  CHECK(refused > fixtures::all_or(5, 0));
}

// Windows take more than edges do, and are asked for as they come.
TEST_CASE("TheWindowsOfAnExactMethodAreAskedForBeforeTheyAreMade") {
  const Adjacency adjacency = prepared(bumpy_plane(120));
  const Source source{point_on_face(adjacency, 5, {0.3, 0.3, 0.4}), 0};
  for (const Method method : {Method::exact, Method::chen_han}) {
    CAPTURE(static_cast<int>(method));
    Purse plenty(kPlenty);
    SolveScratch scratch;
    const auto field = solve_field(method, {}, adjacency, {&source, 1}, {}, scratch, plenty.cancel);
    REQUIRE(field);
    REQUIRE(field->windows);
    CHECK(plenty.asked > field->windows->bytes());
    // Told before the first window where not even one an edge would fit.
    Purse none(1000);
    std::size_t polled = 0;
    const Cancel cancel([&] { return ++polled == 0; }, {}, &none.budget);
    SolveScratch other;
    const auto refused = solve_field(method, {}, adjacency, {&source, 1}, {}, other, cancel);
    REQUIRE_FALSE(refused);
    CHECK(refused.error().code == ServiceCode::too_much_memory);
    CHECK(polled < 3);
  }
}

TEST_CASE("MeshesAndAdjacencyAndLinesAskToo") {
  const TriangleSoup soup = bumpy_plane(100);
  Purse none(1000);
  const auto mesh = Mesh::build(soup, Weld::by_position, none.cancel);
  REQUIRE_FALSE(mesh);
  CHECK(mesh.error().code == ServiceCode::too_much_memory);
  const auto built = std::make_shared<const Mesh>(std::move(*Mesh::build(soup)));
  Purse little(1000);
  const auto adjacency = Adjacency::build(built, little.cancel);
  REQUIRE_FALSE(adjacency);
  CHECK(adjacency.error().code == ServiceCode::too_much_memory);

  const Adjacency whole = Adjacency::build(built);
  const Source source{point_at_vertex(whole, 0), 0};
  SolveScratch scratch;
  const auto field = solve_field(Method::wavefront, {}, whole, {&source, 1}, {}, scratch, Cancel());
  REQUIRE(field);
  std::vector<double> levels;
  for (int i = 1; i < 50; ++i) levels.push_back(i * 0.2);
  Purse few(1000);
  const auto lines = isolines(whole, *field, levels, 1'000'000, few.cancel);
  REQUIRE_FALSE(lines);
  CHECK(lines.error().code == ServiceCode::too_much_memory);
}
