// What the methods reach on meshes that nobody has looked at: `geodesic_bench --family SEED`.
#pragma once

#include <cstdint>
#include <optional>

namespace geodesic::bench {

struct FamilyOptions {
  std::uint32_t seed = 0;
  bool quick = false;                 // two meshes of each kind
  std::optional<std::uint32_t> only;  // the mesh of this number
};

// Prints Markdown tables: a row for each kind, the worst meshes by their numbers, and for each aim
// whether it is reached. Says whether all that is promised holds: no distance is below the straight
// line in space, no upper bound below the truth, and every vertex is reached by all methods or
// none.
[[nodiscard]] bool print_family(const FamilyOptions& options);

}  // namespace geodesic::bench
