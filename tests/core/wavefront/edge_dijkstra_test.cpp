// Distances along edges, beside a Dijkstra of few lines, on meshes of any kind.
#include "core/wavefront/edge_dijkstra.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <queue>
#include <random>
#include <utility>
#include <vector>

#include "core/mesh/shapes.h"
#include "tests/fixtures/awkward_meshes.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/surface.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using fixtures::RandomMesh;
using fixtures::Surface;
using fixtures::test_seed;

namespace {

using Start = std::pair<double, std::uint32_t>;

std::vector<double> along_edges(const Mesh& mesh, const std::vector<Start>& starts) {
  std::vector<std::vector<std::uint32_t>> neighbours(mesh.vertex_count());
  for (const Triangle& face : mesh.faces()) {
    for (const std::uint32_t a : face) {
      for (const std::uint32_t b : face) {
        if (a != b) neighbours[a].push_back(b);
      }
    }
  }
  std::vector<double> distance(mesh.vertex_count(), kUnreached);
  std::priority_queue<Start, std::vector<Start>, std::greater<>> queue;
  const auto push = [&](double d, std::uint32_t v) {
    if (!(d < distance[v])) return;
    distance[v] = d;
    queue.emplace(d, v);
  };
  for (const auto& [d, v] : starts) push(d, v);
  while (!queue.empty()) {
    const auto [d, v] = queue.top();
    queue.pop();
    if (d > distance[v]) continue;
    for (const std::uint32_t w : neighbours[v]) {
      push(d + geodesic::distance(mesh.positions()[v], mesh.positions()[w]), w);
    }
  }
  return distance;
}

std::vector<Start> starts_of(const Surface& surface, const std::vector<Source>& sources) {
  std::vector<Start> starts;
  for (const Source& source : sources) {
    if (source.point.at_vertex()) starts.emplace_back(source.offset, source.point.vertex);
    for (const SurfacePoint& place : in_all_faces(surface.adjacency(), source.point)) {
      for (std::uint32_t c = 0; c < 3; ++c) {
        starts.emplace_back(source.offset + distance_to_corner(surface.mesh(), place, c),
                            surface.adjacency().face(place.face).vertex[c]);
      }
    }
  }
  return starts;
}

// The same numbers to the last bit: each is a sum along a way, and the least of them is unique.
void check_field(const Surface& surface, const Field& field, const std::vector<double>& truth,
                 double limit) {
  for (std::uint32_t v = 0; v < truth.size(); ++v) {
    CAPTURE(v);
    if (!(truth[v] <= limit)) {
      CHECK(field.distance[v] == kUnreached);
      CHECK((field.parents[v].first == kNone && field.parents[v].second == kNone));
      continue;
    }
    CHECK(field.distance[v] == truth[v]);
    // The way back leads to a source, and to the one that is named.
    std::uint32_t u = v;
    std::size_t steps = 0;
    while (!field.parents[u].from_source() && ++steps <= truth.size()) {
      REQUIRE(field.parents[u].along_edge());
      const std::uint32_t parent = field.parents[u].first;
      const auto positions = surface.mesh().positions();
      CHECK(field.distance[u] ==
            field.distance[parent] + distance(positions[u], positions[parent]));
      u = parent;
    }
    CHECK(steps <= truth.size());
    const std::uint32_t source = field.parents[u].second;
    REQUIRE(source < field.sources.size());
    if (field.sources.size() > 1) CHECK(field.nearest_source[v] == source);
  }
}

// Corners from 1 to 10^6 apart: short edges are far shorter than a bucket is wide.
TriangleSoup of_all_lengths(std::uint32_t seed) {
  std::mt19937 random(seed);
  TriangleSoup soup = shapes::plane(40, 40);
  for (Vec3& p : soup.positions) {
    p = {std::exp2(p.x / 2), std::exp2(p.y / 2), static_cast<double>(random() % 1000) / 1000};
  }
  return soup;
}

}  // namespace

TEST_CASE("DistancesAlongEdgesAreThoseOfTheTextbook") {
  std::vector<TriangleSoup> soups;
  for (const auto& awkward : fixtures::awkward_meshes()) soups.push_back(awkward.soup);
  for (std::uint32_t i = 0; i < 200; ++i) soups.push_back(RandomMesh(test_seed() + i).soup());
  for (std::uint32_t i = 0; i < 3; ++i) soups.push_back(of_all_lengths(test_seed() + i));
  std::mt19937 random(test_seed());
  WavefrontScratch scratch;  // of the mesh before
  for (std::size_t i = 0; i < soups.size(); ++i) {
    CAPTURE(i);
    const Surface surface(soups[i]);
    const std::uint32_t face_count = surface.mesh().face_count();
    std::vector<Source> sources;
    for (std::size_t s = 0; s <= i % 4; ++s) {
      const std::uint32_t f = random() % face_count;
      const double u = static_cast<double>(random() % 100) / 200;
      const SurfacePoint point =
          random() % 2 == 0 ? point_at_vertex(surface.adjacency(),
                                              surface.adjacency().face(f).vertex[random() % 3])
                            : point_on_face(surface.adjacency(), f, {u, 0.5 - u / 2, 0.5 - u / 2});
      sources.push_back({point, s == 0 ? 0 : static_cast<double>(random() % 3)});
    }
    const std::vector<double> truth = along_edges(surface.mesh(), starts_of(surface, sources));
    const auto field_of = [&](const FieldLimits& limits) {
      auto field = edge_dijkstra_field(surface.adjacency(), sources, limits, scratch, Cancel());
      REQUIRE(field);
      return std::move(*field);
    };
    check_field(surface, field_of({}), truth, std::numeric_limits<double>::max());
    const std::uint32_t target = random() % surface.mesh().vertex_count();
    FieldLimits within;
    within.max = truth[target] == kUnreached ? 1 : truth[target];
    check_field(surface, field_of(within), truth, within.max);
    if (truth[target] == kUnreached) continue;
    FieldLimits at_target;
    at_target.targets = {&target, 1};
    check_field(surface, field_of(at_target), truth, truth[target]);
  }
}

TEST_CASE("EdgesOfAllLengthsCostNoMoreThanOthers") {
  // Counted in questions to Cancel, of which each stands for as many vertices.
  const auto questions_on = [](const TriangleSoup& soup) {
    const Surface surface(soup);
    std::uint64_t questions = 0;
    const Cancel counting([&] {
      ++questions;
      return false;
    });
    WavefrontScratch scratch;
    const std::vector<Source> sources{{surface.at(0), 0}};
    REQUIRE(edge_dijkstra_field(surface.adjacency(), sources, {}, scratch, counting));
    return questions;
  };
  const auto plain = questions_on(shapes::plane(300, 300));
  TriangleSoup soup = shapes::plane(300, 300);
  for (Vec3& p : soup.positions) {
    p = {std::exp2(p.x / 15), std::exp2(p.y / 15), 0};
  }
  CHECK(questions_on(soup) <= 3 * plain + 1);
}
