// What building a mesh made of a file, and what its topology means for answers, by
// kind: how often, where first, and a sentence.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/surface/adjacency.h"

namespace geodesic::proto {

// By source numbers, as a client knows them.
struct MeshExample {
  enum class Of : std::uint8_t { vertex, vertices, face };
  Of of = Of::vertex;
  std::vector<std::uint32_t> numbers;  // one, or for `vertices` several that belong together
};

struct MeshFinding {
  std::string code;  // for programs, such as "faces_dropped"
  std::uint64_t count = 0;
  std::vector<MeshExample> examples;  // the first few in source order
  std::string text;                   // one sentence for people
};

// Only what there is: a closed manifold that is all of a piece has none.
[[nodiscard]] std::vector<MeshFinding> examine(const Adjacency& adjacency);

}  // namespace geodesic::proto
