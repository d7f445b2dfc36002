#include "core/landmarks/landmark_distances.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "core/landmarks/spread_points.h"
#include "core/mesh/shapes.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::Surface;
using fixtures::test_seed;

namespace {

constexpr double kRounding = 1e-5;  // floats, of differences

using Distance = std::function<double(std::size_t, std::size_t)>;  // between two points

std::vector<double> row_of(std::size_t from, std::size_t count, const Distance& distance) {
  std::vector<double> row;
  for (std::size_t p = 0; p < count; ++p) row.push_back(distance(from, p));
  return row;
}

// Every so many points are landmarks.
LandmarkDistances known_by(std::size_t count, std::size_t every, const Distance& distance) {
  std::vector<std::uint32_t> landmarks;
  std::vector<std::vector<double>> rows;
  for (std::size_t l = 0; l < count; l += every) {
    landmarks.push_back(static_cast<std::uint32_t>(l));
    rows.push_back(row_of(l, count, distance));
  }
  auto made = LandmarkDistances::make(landmarks, rows, Cancel());
  REQUIRE(made.has_value());
  return std::move(*made);
}

KnownRow known_row(const LandmarkDistances& known, std::size_t from, std::size_t count,
                   const Distance& distance) {
  KnownRow row{{}, row_of(from, count, distance)};
  for (const std::uint32_t l : known.landmarks()) row.to_landmarks.push_back(distance(from, l));
  return row;
}

// What is estimated of a row of which nothing farther than `near` is known.
std::vector<double> estimated(const LandmarkDistances& known, const KnownRow& row) {
  std::vector<double> entries = row.to_points;
  const double near = known.near(row.to_landmarks);
  for (double& d : entries) {
    if (!(d <= near)) d = kUnreached;
  }
  const Cancel never;
  Poll poll(never);
  known.estimate(row.to_landmarks, entries, poll);
  return entries;
}

std::vector<Vec3> some_directions(std::size_t count, std::mt19937& random) {
  std::normal_distribution<double> normal;
  std::vector<Vec3> directions;
  while (directions.size() < count) {
    const Vec3 v{normal(random), normal(random), normal(random)};
    if (norm(v) > 0.1) directions.push_back((1 / norm(v)) * v);
  }
  return directions;
}

}  // namespace

// Squared distances in a plane have four eigenvalues that are not zero.
TEST_CASE("EstimatesInAPlaneAreTheDistances") {
  std::mt19937 random(test_seed());
  std::uniform_real_distribution<double> uniform(0, 1);
  const std::size_t count = 400;
  std::vector<Vec3> points;
  for (std::size_t p = 0; p < count; ++p) points.push_back({uniform(random), uniform(random), 0});
  // In any unit, also such that squares of it are no floats.
  constexpr std::array kUnits{1.0, 1e-40, 1e40};
  const double unit = kUnits[random() % kUnits.size()];
  CAPTURE(unit);
  const Distance distance = [&](std::size_t a, std::size_t b) {
    return unit * geodesic::distance(points[a], points[b]);
  };
  LandmarkDistances known = known_by(count, 10, distance);
  std::vector<KnownRow> rows;
  for (std::size_t p = 1; p < count; p += 50) rows.push_back(known_row(known, p, count, distance));
  const auto errors = known.choose(rows, Cancel());
  REQUIRE(errors.has_value());
  CHECK(errors->max < 1e-3);
  for (std::size_t p = 2; p < count; p += 7) {
    const KnownRow row = known_row(known, p, count, distance);
    const std::vector<double> found = estimated(known, row);
    for (std::size_t q = 0; q < count; ++q) {
      CHECK(std::abs(found[q] - row.to_points[q]) <= 1e-3 * row.to_points[q]);
    }
  }
}

TEST_CASE("EstimatesOnASphereAreNearTheClosedFormAndWithinTheirBounds") {
  std::mt19937 random(test_seed() + 1);
  const std::size_t count = 1000;
  const std::vector<Vec3> points = some_directions(count, random);
  const Distance distance = [&](std::size_t a, std::size_t b) {
    return std::atan2(norm(cross(points[a], points[b])), dot(points[a], points[b]));
  };
  LandmarkDistances known = known_by(count, 8, distance);
  std::vector<KnownRow> rows;
  for (std::size_t p = 1; p < count; p += 40) rows.push_back(known_row(known, p, count, distance));
  const auto errors = known.choose(rows, Cancel());
  REQUIRE(errors.has_value());
  CHECK(errors->mean < 0.01);
  double sum = 0;
  std::size_t compared = 0;
  std::size_t out_of_bounds = 0;
  for (std::size_t p = 3; p < count; p += fixtures::all_or(10, 50)) {
    const KnownRow row = known_row(known, p, count, distance);
    const std::vector<double> found = estimated(known, row);
    for (std::size_t q = 0; q < count; ++q) {
      if (q == p) continue;
      sum += std::abs(found[q] / row.to_points[q] - 1);
      ++compared;
      for (const std::uint32_t l : known.landmarks()) {
        const double to = distance(p, l);
        const double from = distance(l, q);
        const bool is_within =
            found[q] <= to + from + kRounding && found[q] >= std::abs(to - from) - kRounding;
        if (!is_within) ++out_of_bounds;
      }
      const double near = known.near(row.to_landmarks);
      if (row.to_points[q] > near && !(found[q] >= near)) ++out_of_bounds;
    }
  }
  CHECK(out_of_bounds == 0);
  // What is said of some rows holds for others, but for chance.
  CHECK(sum / static_cast<double>(compared) < 2 * errors->mean + 1e-4);
}

// Squares of distances that are 1e19 times as great as those between the others are no floats.
TEST_CASE("RowsFarFromAllLandmarksHaveEstimatesWithinTheirBounds") {
  std::mt19937 random(test_seed() + 4);
  std::uniform_real_distribution<double> uniform(0, 1);
  const std::size_t count = 200;
  std::vector<Vec3> points;
  for (std::size_t p = 0; p < count; ++p) points.push_back({uniform(random), uniform(random), 0});
  for (const double far : {1e3, 1e9, 1e17, 1e19, 1e22, 1e38, 1e60, 1e200}) {
    CAPTURE(far);
    // One point more, from which all ways lead by the first one.
    const Distance distance = [&](std::size_t a, std::size_t b) {
      const double way = geodesic::distance(points[a % count], points[b % count]);
      return (a == count) == (b == count) ? way : far + way;
    };
    LandmarkDistances known = known_by(count, 5, distance);
    const std::vector<KnownRow> rows{known_row(known, count, count, distance)};
    const auto errors = known.choose(rows, Cancel());
    REQUIRE(errors.has_value());
    // All others are at most the square's diagonal apart.
    const double off = 2 * std::sqrt(2.0) / far + kRounding;
    CHECK(errors->max <= off);
    const std::vector<double> found = estimated(known, rows.front());
    for (std::size_t q = 0; q < count; ++q) {
      CHECK(std::abs(found[q] - rows.front().to_points[q]) <= off * rows.front().to_points[q]);
    }
  }
}

TEST_CASE("ComponentsAreEstimatedApart") {
  std::mt19937 random(test_seed() + 2);
  std::uniform_real_distribution<double> uniform(0, 1);
  // Every tenth point is in the second plane, every hundredth in a third one.
  const std::size_t count = 1000;
  std::vector<Vec3> points;
  const auto plane_of = [](std::size_t p) { return p % 100 == 5 ? 2 : p % 10 == 1 ? 1 : 0; };
  for (std::size_t p = 0; p < count; ++p) points.push_back({uniform(random), uniform(random), 0});
  const Distance distance = [&](std::size_t a, std::size_t b) {
    return plane_of(a) == plane_of(b) ? geodesic::distance(points[a], points[b]) : kUnreached;
  };
  const LandmarkDistances known = known_by(count, 3, distance);
  for (std::size_t p = 0; p < count; p += fixtures::all_or(1, 7)) {
    const KnownRow row = known_row(known, p, count, distance);
    // Of the third plane's ten points fewer than eight are landmarks.
    const bool is_estimated = plane_of(p) != 2;
    CHECK((known.near(row.to_landmarks) == kUnreached) == !is_estimated);
    const std::vector<double> found = estimated(known, row);
    for (std::size_t q = 0; q < count; ++q) {
      CHECK((found[q] == kUnreached) == (plane_of(p) != plane_of(q)));
    }
  }
}

TEST_CASE("EstimatesEndWhenTheyAreCancelled") {
  const Distance distance = [](std::size_t a, std::size_t b) {
    return std::abs(static_cast<double>(a) - static_cast<double>(b));
  };
  std::vector<std::vector<double>> rows;
  std::vector<std::uint32_t> landmarks;
  for (std::uint32_t l = 0; l < 100; ++l) {
    landmarks.push_back(l * 10);
    rows.push_back(row_of(l * 10, 1000, distance));
  }
  const Cancel stop([] { return true; });
  const auto made = LandmarkDistances::make(landmarks, rows, stop);
  REQUIRE(!made.has_value());
  CHECK(made.error().code == ErrorCode::cancelled);

  auto known = LandmarkDistances::make(landmarks, rows, Cancel());
  REQUIRE(known.has_value());
  std::vector<KnownRow> checks{known_row(*known, 5, 1000, distance)};
  const auto chosen = known->choose(checks, stop);
  REQUIRE(!chosen.has_value());
  CHECK(chosen.error().code == ErrorCode::cancelled);

  const Surface surface(shapes::plane(60, 60));
  std::vector<SurfacePoint> points;
  for (std::uint32_t v = 0; v < 2000; ++v) points.push_back(surface.at(v));
  const auto spread = spread_points(surface.adjacency(), points, 20, stop);
  REQUIRE(!spread.has_value());
  CHECK(spread.error().code == ErrorCode::cancelled);
}

TEST_CASE("EachOfSpreadPointsIsTheFarthestFromThoseBefore") {
  std::mt19937 random(test_seed() + 3);
  for (int round = 0; round < 10; ++round) {
    CAPTURE(round);
    const Surface surface(shapes::shuffled(shapes::terrain(12, 2, random()), random()));
    std::vector<SurfacePoint> points;
    for (int i = 0; i < 60; ++i) {
      points.push_back(
          surface.at(static_cast<std::uint32_t>(random() % surface.mesh().vertex_count())));
    }
    const std::size_t wanted = 1 + random() % 40;
    const auto chosen = spread_points(surface.adjacency(), points, wanted, Cancel());
    REQUIRE(chosen.has_value());
    std::vector<double> nearest(points.size(), kUnreached);
    for (const std::uint32_t c : *chosen) {
      const double farthest = *std::max_element(nearest.begin(), nearest.end());
      CHECK((nearest[c] == farthest || nearest[c] == doctest::Approx(farthest).epsilon(1e-12)));
      CHECK(nearest[c] > 0);
      const Field field = surface.field_by(Method::dijkstra, {Source{points[c], 0}});
      for (std::size_t i = 0; i < points.size(); ++i) {
        nearest[i] = std::min(nearest[i], field.distance[points[i].vertex]);
      }
    }
    // Fewer only where all others are at the same vertices.
    if (chosen->size() < wanted) {
      CHECK(std::all_of(nearest.begin(), nearest.end(), [](double d) { return d == 0; }));
    }
  }
}
