// Meshes drawn from a seed, of kinds that a method may never have met.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/mesh/triangle_soup.h"

namespace geodesic::bench {

struct FamilyMesh {
  std::string kind;
  TriangleSoup soup;
};

// Surfaces stretched 1 to 1,000 times, slivers of five kinds, holes, noise, edges from 1 to 10^4,
// folds. The same seed and number give the same mesh, of at most 10,000 vertices or so.
[[nodiscard]] FamilyMesh surface_of_family(std::uint32_t seed, std::uint32_t number);
inline constexpr std::uint32_t kSurfaceKinds = 12;

// Machine parts, of some dozens to 20,000 vertices, closed.
[[nodiscard]] FamilyMesh part_of_family(std::uint32_t seed, std::uint32_t number);
inline constexpr std::uint32_t kPartKinds = 12;

}  // namespace geodesic::bench
