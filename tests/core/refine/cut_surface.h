// Surfaces with lines put in that are cut along them.
#pragma once

#include <doctest/doctest.h>

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "core/mesh/shapes.h"
#include "core/refine/cut_along.h"
#include "core/refine/refine_along.h"
#include "core/solve/pair_search.h"
#include "core/solve/solve_field.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/surface.h"

namespace geodesic::fixtures {

inline constexpr std::uint64_t kPlenty = 1'000'000;

// A surface with lines put in, and cut along all of them.
struct Cut {
  RefinedMesh refined;
  CutMesh cut;
  std::unique_ptr<Adjacency> adjacency;

  Cut(const Surface& surface, const std::vector<SurfacePolyline>& lines)
      : refined(*refine_along(surface.adjacency(), walls_of(surface, lines), kPlenty, Cancel())),
        cut(along_all(refined)),
        adjacency(
            std::make_unique<Adjacency>(Adjacency::build(std::make_shared<const Mesh>(cut.mesh)))) {
  }

  static std::vector<SurfacePolyline> walls_of(const Surface& surface,
                                               const std::vector<SurfacePolyline>& lines) {
    const Cancel never;
    Poll poll(never);
    std::vector<SurfacePolyline> walls;
    for (const SurfacePolyline& line : lines) {
      walls.push_back(as_wall(surface.adjacency(), line, poll));
    }
    return walls;
  }

  static CutMesh along_all(const RefinedMesh& refined) {
    std::vector<std::uint32_t> walls(refined.chains.size());
    for (std::uint32_t i = 0; i < walls.size(); ++i) walls[i] = i;
    const std::vector<std::uint8_t> all(refined.mesh.face_count(), 1);
    auto cut = cut_along(refined, walls, all, Cancel());
    REQUIRE(cut);
    return std::move(*cut);
  }

  [[nodiscard]] Field field(const SurfacePoint& from) const {
    SolveScratch scratch;
    const Source source{from, 0};
    auto found = solve_field(Method::exact, {}, *adjacency, {&source, 1}, {}, scratch, Cancel());
    REQUIRE(found);
    return std::move(*found);
  }
  // A point of a source face of the whole.
  [[nodiscard]] SurfacePoint on(std::uint32_t source_face, const Weights& bary) const {
    const Cancel never;
    Poll poll(never);
    if (const auto there = cut.refinement.in_piece(source_face, bary, poll)) {
      return point_on_face(*adjacency, there->face, there->bary);
    }
    return point_on_face(*adjacency, cut.mesh.face_of_source(source_face), bary);
  }
};

// The straight line between two points of a plane, which is the shortest there.
inline SurfacePolyline straight(const Surface& plane, const SurfacePoint& a,
                                const SurfacePoint& b) {
  SolveScratch scratch;
  const auto pair = pair_search(Method::exact, {}, plane.adjacency(), {a, 0}, b, PairPath::refined,
                                scratch, Cancel());
  REQUIRE(pair);
  REQUIRE(pair->path);
  SurfacePolyline line;
  for (const PathPoint& point : pair->path->points) line.push_back(point.point);
  return line;
}

}  // namespace geodesic::fixtures
