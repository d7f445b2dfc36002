// Edges of thousands of faces, and the same face thousands of times over: a field by windows or by
// points on edges takes no more than n log n, and asks whether to stop.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "core/solve/solve_field.h"
#include "tests/fixtures/crumpled_surfaces.h"
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

// Some milliseconds, with room for sanitizers; what it stands against took seconds.
constexpr double kLongestWithoutAQuestion = 0.5;
constexpr double kMostWork = 5;

// How long a computation works at most between two questions. Ends it after so much in all.
class WorkBetweenQuestions {
 public:
  explicit WorkBetweenQuestions(double most) : most_(most) {}

  [[nodiscard]] bool ask() {
    const double now = seconds_of_work();
    longest_ = std::max(longest_, now - last_);
    last_ = now;
    return now - start_ > most_;
  }
  [[nodiscard]] double longest() const { return longest_; }

 private:
  double most_;
  double start_ = seconds_of_work();
  double last_ = start_;
  double longest_ = 0;
};

void check_that_it_ends(const Surface& surface, const Source& source) {
  for (const Method method : {Method::exact, Method::chen_han, Method::steiner}) {
    for (const bool keep_details : {false, true}) {
      CAPTURE(static_cast<int>(method));
      CAPTURE(keep_details);
      FieldLimits limits;
      limits.keep_details = keep_details;
      WorkBetweenQuestions work(kMostWork);
      SolveScratch scratch;
      const Cancel cancel([&] { return work.ask(); });
      const auto field =
          solve_field(method, {}, surface.adjacency(), {&source, 1}, limits, scratch, cancel);
      (void)work.ask();
      CHECK(field.has_value());
      CHECK(work.longest() < kLongestWithoutAQuestion);
    }
  }
}

}  // namespace

TEST_CASE("AFaceThousandsOfTimesOverIsCrossedOnce") {
  TriangleSoup soup{{{0, 0, 0}, {3, 0, 0}, {0, 4, 0}}, {}};
  constexpr std::uint32_t kFaces = fixtures::all_or(100'000, 20'000);
  soup.faces.assign(kFaces, {0, 1, 2});
  const Surface surface(soup);
  check_that_it_ends(surface, {surface.at(0), 0});
  check_that_it_ends(surface, {surface.on(kFaces / 2, {0.25, 0.25, 0.5}), 0});
  check_that_it_ends(surface, {surface.on(kFaces / 2, {0.5, 0.5, 0}), 0});
}

// Light goes to and fro between two of them, and may cross each once.
TEST_CASE("AThinFaceThousandsOfTimesOverIsCrossedOnce") {
  for (const double height : {1e-3, 1e-6, 1e-9, 1e-12}) {
    CAPTURE(height);
    TriangleSoup soup{{{0, 0, 0}, {1, 0, 0}, {0.4, height, 0}}, {}};
    constexpr std::uint32_t kFaces = fixtures::all_or(20'000, 5'000);
    soup.faces.assign(kFaces, {0, 1, 2});
    const Surface surface(soup);
    check_that_it_ends(surface, {surface.at(2), 0});
    check_that_it_ends(surface, {surface.on(kFaces / 2, {0.25, 0.25, 0.5}), 0});
    check_that_it_ends(surface, {surface.on(kFaces / 2, {0.5, 0.5, 0}), 0});
  }
}

TEST_CASE("ABookOfThousandsOfPagesIsReadOnce") {
  constexpr std::uint32_t kPages = fixtures::all_or(60'000, 6'000);
  TriangleSoup soup{{{0, 0, 0}, {0, 0, 1}}, {}};
  for (std::uint32_t i = 0; i < kPages; ++i) {
    const double angle = i * 1e-4;
    soup.positions.push_back({2 * std::cos(angle), 2 * std::sin(angle), 0.1 * (i % 11)});
    soup.faces.push_back({0, 1, i + 2});
  }
  const Surface surface(soup);
  check_that_it_ends(surface, {surface.at(0), 0});
  check_that_it_ends(surface, {surface.at(kPages / 2), 0});
  check_that_it_ends(surface, {surface.on(kPages / 2, {0.25, 0.25, 0.5}), 0});
}

TEST_CASE("AVertexOfAHundredThousandFacesIsPassedWithQuestions") {
  TriangleSoup soup{{{0, 0, 0}}, {}};
  constexpr std::uint32_t kFaces = fixtures::all_or(100'000, 10'000);
  for (std::uint32_t i = 0; i < kFaces; ++i) {
    const double angle = 2 * std::numbers::pi * i / kFaces;
    const double r = 1 + 0.1 * (i % 2);
    soup.positions.push_back({r * std::cos(angle), r * std::sin(angle), 0});
    soup.faces.push_back({0, i + 1, (i + 1) % kFaces + 1});
  }
  const Surface surface(soup);
  check_that_it_ends(surface, {surface.at(0), 0});
  check_that_it_ends(surface, {surface.on(kFaces / 2, {0.25, 0.25, 0.5}), 0});
}

// Two sheets meet on each of many lines, so that windows come to the last one in 2^14 ways, all of
// which unfold to the same. From far away rounding sets them apart by more than a part of an edge.
TEST_CASE("TheSameLightFromAMillionEdgesAwayIsOneWindow") {
  constexpr std::uint32_t kLines = 14;
  constexpr std::uint32_t kRows = 3;
  for (const double far : {1e2, 1e6, 1e7, 1e9}) {
    CAPTURE(far);
    TriangleSoup soup;
    for (std::uint32_t i = 0; i <= kLines; ++i) {
      for (std::uint32_t j = 0; j <= kRows; ++j) {
        soup.positions.push_back(
            {1.01 * i, 0.97 * j + 0.1 * ((7 * i + 3 * j) % 5), 0.3 * std::sin(1.3 * i)});
      }
    }
    for (std::uint32_t i = 0; i < kLines; ++i) {
      for (std::uint32_t j = 0; j < kRows; ++j) {
        const std::uint32_t a = i * (kRows + 1) + j;
        const std::uint32_t b = a + kRows + 1;
        soup.faces.insert(soup.faces.end(),
                          {{a, b, a + 1}, {a + 1, b, b + 1}, {a, b, b + 1}, {a, b + 1, a + 1}});
      }
    }
    const auto source = static_cast<std::uint32_t>(soup.positions.size());
    soup.positions.push_back({-far, 0.01 * far, 0});
    for (std::uint32_t j = 0; j < kRows; ++j) soup.faces.push_back({source, j, j + 1});
    const Surface surface(soup);
    std::size_t asked = 0;
    const Cancel cancel([&] { return ++asked > 2'000; });
    FieldLimits limits;
    limits.keep_details = false;
    SolveScratch scratch;
    const Source from{surface.at(source), 0};
    const auto field =
        solve_field(Method::chen_han, {}, surface.adjacency(), {&from, 1}, limits, scratch, cancel);
    REQUIRE(field.has_value());
    const Field exact = surface.field_by(Method::exact, {from}, limits);
    for (std::uint32_t v = 0; v < surface.mesh().vertex_count(); ++v) {
      CHECK(std::abs(field->distance[v] - exact.distance[v]) <= 1e-12 * exact.distance[v]);
    }
  }
}

// Of three groups of points each three are a face, and all lie nearly on a line: hundreds of
// thousands of windows come to an edge, and all of them are to cross each of its faces.
TEST_CASE("WindowsByTheMillionOnThinHeapsAskWhetherToStop") {
  std::mt19937 random(fixtures::test_seed());
  for (int round = 0; round < fixtures::all_or(4, 1); ++round) {
    const std::uint32_t n = 12 + random() % 9;
    CAPTURE(n);
    TriangleSoup soup;
    const auto about = [&] {
      return fixtures::fraction(random) + fixtures::fraction(random) + fixtures::fraction(random) -
             1.5;
    };
    for (std::uint32_t i = 0; i < 3 * n; ++i) {
      soup.positions.push_back({2 * about(), 2e-3 * about(), 2e-3 * about()});
    }
    for (std::uint32_t i = 0; i < n * n * n; ++i) {
      soup.faces.push_back({i % n, n + i / n % n, 2 * n + i / n / n});
    }
    const Surface surface(soup);
    const Source source{round % 2 == 0 ? surface.on(random() % (n * n * n), {0.3, 0.3, 0.4})
                                       : surface.at(random() % (3 * n)),
                        0};
    MethodOptions within;
    within.error_at_most = 1e-3;
    MethodOptions upper;
    upper.bound = Bound::upper;
    for (const auto& [method, options] :
         {std::pair{Method::exact, MethodOptions()}, std::pair{Method::chen_han, MethodOptions()},
          std::pair{Method::back_traced, within}, std::pair{Method::back_traced, upper}}) {
      for (const bool keep_details : {false, true}) {
        CAPTURE(static_cast<int>(method));
        CAPTURE(keep_details);
        WorkBetweenQuestions work(0.7);
        FieldLimits limits;
        limits.keep_details = keep_details;
        SolveScratch scratch;
        const Cancel cancel([&] { return work.ask(); });
        // Whether it has come to an end by then does not matter.
        (void)solve_field(method, options, surface.adjacency(), {&source, 1}, limits, scratch,
                          cancel);
        (void)work.ask();
        CHECK(work.longest() < kLongestWithoutAQuestion);
      }
    }
  }
}
