// Meshes from formulas: the samples that the server ships with, and the fixtures
// of tests and benchmarks. Deterministic. Lengths are in mesh units.
#pragma once

#include <cstdint>
#include <span>

#include "core/mesh/triangle_soup.h"

namespace geodesic::shapes {

enum class Diagonal : std::uint8_t { rising, falling };

// A grid in the xy plane, `columns` x `rows` vertices with unit spacing, each
// square cut by one diagonal. Vertex (i, j) is number j * columns + i.
[[nodiscard]] TriangleSoup plane(std::uint32_t columns, std::uint32_t rows,
                                 Diagonal diagonal = Diagonal::rising);

// A square hole: the grid squares from (first_column, first_row), `size` a side.
struct Hole {
  std::uint32_t first_column;
  std::uint32_t first_row;
  std::uint32_t size;
};

// The plane with holes, as in Figs. 6 and 7 of Tang et al. 2007. The vertex
// numbers are the plane's; vertices inside a hole belong to no face.
[[nodiscard]] TriangleSoup plane_with_holes(std::uint32_t columns, std::uint32_t rows,
                                            std::span<const Hole> holes,
                                            Diagonal diagonal = Diagonal::rising);

// The unit sphere: an icosahedron whose faces are split in four `levels` times;
// 10 * 4^levels + 2 vertices.
[[nodiscard]] TriangleSoup icosphere(std::uint32_t levels);

// A tube of the given radius round a (2, 3) torus knot; closed, genus one.
[[nodiscard]] TriangleSoup torus_knot(std::uint32_t around_knot, std::uint32_t around_tube,
                                      double tube_radius);

// The graph of a smooth height over the square [0, side - 1]^2 in the xy plane:
// z = saddle. `side` x `side` vertices.
[[nodiscard]] TriangleSoup saddle(std::uint32_t side, double height);

// A terrain of hills at several scales over a grid whose points are moved about
// within their squares, so that no two triangles are alike; `side` x `side` vertices
// with a mean spacing of one.
[[nodiscard]] TriangleSoup terrain(std::uint32_t side, double height, std::uint32_t seed);

// The same surface with vertices and faces numbered at random, faces rotated and
// every second one flipped.
[[nodiscard]] TriangleSoup shuffled(const TriangleSoup& soup, std::uint32_t seed);

}  // namespace geodesic::shapes
