// Paths on scanned meshes, straightened: against exact distances from vertex 0.
#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

#include "core/straighten/shorten_path.h"
#include "tests/fixtures/locally_shortest.h"
#include "tests/fixtures/path_checks.h"
#include "tests/fixtures/surface.h"
#include "tests/paper/real_meshes.h"

using namespace geodesic;
using fixtures::has_reference;
using fixtures::load_real_mesh;
using fixtures::Surface;

namespace {

std::uint64_t median(std::vector<std::uint64_t> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

// Shortens the paths to random vertices; `most_excess` is the mean that is allowed over
// the exact distance.
void check_shortening(const std::string& name, Method method, double most_excess) {
  const auto loaded = load_real_mesh(name);
  if (!loaded) {
    MESSAGE("skipped: no ", name, " with its reference; set GEODESIC_SHARED");
    return;
  }
  REQUIRE(loaded->has_value());
  const auto& real = **loaded;
  const Surface surface(real.soup);
  const double size = distance(surface.mesh().box().min, surface.mesh().box().max);
  const Field field = surface.field_by(method, {Source{surface.at(0), 0}});
  std::mt19937 random(20050600);  // its output is fixed by the standard
  constexpr int kPaths = 1000;
  double excess_before = 0;
  double excess = 0;
  double least = 1;
  int shortest = 0;
  std::vector<std::uint64_t> crossings;
  std::vector<std::uint64_t> faces;
  for (int found = 0; found < kPaths;) {
    const auto target = static_cast<std::uint32_t>(random() % real.soup.positions.size());
    const double exact = real.exact[target];
    if (!has_reference(exact) || !(exact > 0)) continue;
    ++found;
    const auto path = surface.path(field, surface.at(target));
    REQUIRE(path);
    ShortenCounts counts;
    const auto shorter = shorten_path(surface.adjacency(), *path, Cancel(), &counts);
    REQUIRE(shorter.has_value());
    fixtures::check_is_a_path(surface.adjacency(), *shorter, size);
    CHECK(shorter->length <= path->length);
    least = std::min(least, shorter->length / exact - 1);
    CHECK(counts.locally_shortest);
    const auto bend = fixtures::worst_bend(surface.adjacency(), *shorter, 1e-3);
    // A path that is straight but for this much is handed back as it is.
    CHECK(bend.at_edges <= 1e-6);
    CHECK(bend.at_vertices <= 1e-6);
    excess_before += path->length / exact - 1;
    excess += shorter->length / exact - 1;
    if (shorter->length <= exact * (1 + 1e-6)) ++shortest;
    crossings.push_back(counts.crossings);
    faces.push_back(counts.faces_unfolded);
  }
  MESSAGE(name, ": mean excess ", 100 * excess_before / kPaths, " % before, ",
          100 * excess / kPaths, " % after; ", shortest / 10.0,
          " % are shortest of all; medians: ", median(crossings), " crossings, ", median(faces),
          " faces unfolded; the least excess is ", least);
  CHECK(excess / kPaths < most_excess);
  CHECK(least > -1e-5);
}

}  // namespace

TEST_CASE("WavefrontPathsShortenToNearlyTheExactDistance") {
  check_shortening("bunny35k", Method::wavefront, 0.0005);
  check_shortening("fandisk_m1", Method::wavefront, 0.0005);
}

TEST_CASE("PathsAlongEdgesShortenToLocallyShortestOnes") {
  check_shortening("bunny35k", Method::dijkstra, 0.002);
}
