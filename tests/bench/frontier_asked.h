// What the rows of queries share: a mesh, its source, and what a row says.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/solve/solve_field.h"
#include "tests/bench/frontier_meshes.h"
#include "tests/bench/prepared.h"

namespace geodesic::bench {

template <class Value>
Value take(Result<Value> result) {
  if (!result) give_up(result.error().detail);
  return std::move(*result);
}

struct Figures {
  double ms = 0;
  double off = 0;        // relative
  bool is_there = true;  // false where the mesh has no such thing, as a loop that stays one
};

// The mesh of a row, and what all queries need of it.
class Asked {
 public:
  Asked(const Prepared& prepared, const FrontierMesh& mesh)
      : prepared_(prepared), source_(prepared.source_at(mesh.first_source)) {
    for (const double d : field(Method::exact, kUnreached, false).distance.values()) {
      if (d < kUnreached) farthest_ = std::max(farthest_, d);
    }
  }

  [[nodiscard]] const Adjacency& adjacency() const { return prepared_.adjacency(); }
  [[nodiscard]] const Source& source() const { return source_; }
  [[nodiscard]] double farthest() const { return farthest_; }
  [[nodiscard]] SolveScratch& scratch() { return scratch_; }

  [[nodiscard]] Field field(Method method, double max, bool keep_details) {
    FieldLimits limits;
    limits.max = max;
    limits.keep_details = keep_details;
    return take(solve_field(method, {}, adjacency(), {&source_, 1}, limits, scratch_, Cancel()));
  }

  // With a way between them: from the nearest to the source on, evenly by their numbers.
  [[nodiscard]] std::vector<std::uint32_t> connected_vertices(std::size_t count) {
    const Field all = field(Method::back_traced, kUnreached, false);
    std::vector<std::uint32_t> reached;
    for (std::uint32_t v = 0; v < all.distance.size(); ++v) {
      if (all.distance[v] < kUnreached) reached.push_back(v);
    }
    std::vector<std::uint32_t> chosen;
    for (std::size_t i = 0; i < count; ++i) chosen.push_back(reached[i * reached.size() / count]);
    return chosen;
  }
  [[nodiscard]] std::vector<SurfacePoint> connected_points(std::size_t count) {
    std::vector<SurfacePoint> points;
    for (const std::uint32_t v : connected_vertices(count)) {
      points.push_back(point_at_vertex(adjacency(), v));
    }
    return points;
  }

 private:
  const Prepared& prepared_;
  Source source_;
  double farthest_ = 0;
  SolveScratch scratch_;
};

}  // namespace geodesic::bench
