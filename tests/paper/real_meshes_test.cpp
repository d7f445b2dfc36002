// The paper's Fig. 8, with figures: scanned meshes against exact distances.
#include "tests/paper/real_meshes.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "tests/fixtures/path_checks.h"
#include "tests/fixtures/surface.h"

using namespace geodesic;
using fixtures::check_is_a_path;
using fixtures::has_reference;
using fixtures::load_real_mesh;
using fixtures::RealMesh;
using fixtures::Surface;

namespace {

// Runs `check(name, mesh)` on every mesh that is there, and says which are not.
template <class Check>
void for_each_real_mesh(Check check) {
  for (const std::string name : fixtures::kRealMeshes) {
    CAPTURE(name);
    const auto loaded = load_real_mesh(name);
    if (!loaded) {
      MESSAGE("skipped: no ", name, " with its reference; set GEODESIC_SHARED");
      continue;
    }
    REQUIRE(loaded->has_value());
    check(name, **loaded);
  }
}

double size_of(const Mesh& mesh) { return distance(mesh.box().min, mesh.box().max); }

}  // namespace

TEST_CASE("RealMeshesFieldIsCloseToTheExactDistances") {
  for_each_real_mesh([](const std::string& name, const RealMesh& real) {
    const Surface surface(real.soup);
    const auto distances = surface.in_source_order(surface.field_from(0));
    double sum = 0;
    double worst = 0;
    std::size_t compared = 0;
    for (std::size_t i = 0; i < distances.size(); ++i) {
      const double exact = real.exact[i];
      if (!has_reference(exact)) {
        CHECK_FALSE(std::isfinite(distances[i]));
        continue;
      }
      REQUIRE(std::isfinite(distances[i]));
      if (!(exact > 0)) continue;
      const double error = std::abs(distances[i] - exact) / exact;
      sum += error;
      worst = std::max(worst, error);
      ++compared;
    }
    REQUIRE(compared > 20'000);
    const double mean = sum / static_cast<double>(compared);
    MESSAGE(name, ": mean relative error ", 100 * mean, " %, worst ", 100 * worst, " %");
    CHECK(mean < 0.006);
  });
}

TEST_CASE("RealMeshesPathsArePathsOfTheStatedLength") {
  for_each_real_mesh([](const std::string& name, const RealMesh& real) {
    const Surface surface(real.soup);
    const double size = size_of(surface.mesh());
    const Field field = surface.field_from(0);
    std::mt19937 random(20070614);  // its output is fixed by the standard
    double farthest_from_field = 0;
    double least_over_exact = kUnreached;
    double sum_over_exact = 0;
    int much_shorter = 0;
    for (int found = 0; found < 50;) {
      const std::uint32_t target = random() % surface.mesh().source_vertex_count();
      const double exact = real.exact[target];
      if (!has_reference(exact) || !(exact > 0)) continue;
      ++found;
      CAPTURE(target);
      CAPTURE(exact);
      CAPTURE(field.distance[surface.vertex(target)]);
      const auto path = surface.path(field, surface.at(target));
      REQUIRE(path);
      check_is_a_path(surface.adjacency(), *path, size);
      CHECK(path->points.front().position == real.soup.positions[0]);
      CHECK(path->points.back().position == real.soup.positions[target]);
      const double stated = field.distance[surface.vertex(target)];
      CHECK(path->length <= 1.01 * stated);
      // Shorter is better: the trace back mends some of what the field is over by.
      if (path->length < 0.99 * stated) ++much_shorter;
      CHECK(path->length >= exact * (1 - 1e-6));
      farthest_from_field = std::max(farthest_from_field, std::abs(path->length / stated - 1));
      least_over_exact = std::min(least_over_exact, path->length / exact - 1);
      sum_over_exact += path->length / exact - 1;
    }
    CHECK(much_shorter <= 1);
    MESSAGE(name, ": paths differ from the field by at most ", 100 * farthest_from_field,
            " %; over the exact distance by at least ", 100 * least_over_exact, " %, by ",
            2 * sum_over_exact, " % on average");
  });
}
