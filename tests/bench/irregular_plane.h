// A bumpy plane over points thrown at random: triangles of every shape, as of measured
// terrain.
#pragma once

#include <cstdint>

#include "core/mesh/triangle_soup.h"

namespace geodesic::bench {

// The Delaunay triangulation of `count` points, spread evenly at random over a square of
// that area and numbered along its rows, without the few thin triangles of its border; raised
// to hills of two sizes, the larger `height` high and a fifth of the square wide.
[[nodiscard]] TriangleSoup irregular_plane(std::uint32_t count, double height, std::uint32_t seed);

}  // namespace geodesic::bench
