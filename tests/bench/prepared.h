// A subject made ready for queries, and one method's field on it.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/paths/path.h"
#include "core/solve/solve_field.h"
#include "core/surface/adjacency.h"
#include "tests/bench/subjects.h"

namespace geodesic::bench {

// Prints the sentence and ends the process: figures of wrong results are worth
// nothing.
[[noreturn]] void give_up(const std::string& sentence);

class Prepared {
 public:
  // Gives up when the mesh cannot be built.
  explicit Prepared(const TriangleSoup& soup);

  [[nodiscard]] const Mesh& mesh() const { return *mesh_; }
  [[nodiscard]] const Adjacency& adjacency() const { return *adjacency_; }
  [[nodiscard]] std::uint32_t vertex(std::uint32_t source_vertex) const {
    return mesh_->vertex_of_source()[source_vertex];
  }
  [[nodiscard]] Source source_at(std::uint32_t source_vertex) const {
    return {point_at_vertex(*adjacency_, vertex(source_vertex)), 0};
  }

  // A method's distances from a source vertex. Gives up when the method fails.
  [[nodiscard]] Field solve(Method method, std::uint32_t source_vertex, SolveScratch& scratch,
                            const MethodOptions& options = {},
                            const FieldLimits& limits = {}) const;
  [[nodiscard]] Field solve(Method method, std::uint32_t source_vertex = 0) const {
    SolveScratch scratch;
    return solve(method, source_vertex, scratch);
  }
  // Gives up when there is no path.
  [[nodiscard]] Path path(const Field& field, std::uint32_t source_vertex) const;

  // Between the numberings: one value a vertex, one a source vertex.
  [[nodiscard]] std::vector<double> in_source_order(std::span<const double> by_vertex) const;

 private:
  std::shared_ptr<const Mesh> mesh_;
  std::shared_ptr<const Adjacency> adjacency_;
};

}  // namespace geodesic::bench
