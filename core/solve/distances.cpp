#include "core/solve/distances.h"

#include <memory>
#include <string>

#include "core/base/cancel.h"
#include "core/solve/solve_field.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"

namespace geodesic {

Result<std::vector<double>> distances(const Mesh& mesh, std::uint32_t vertex, Method method) {
  if (vertex >= mesh.source_vertex_count()) {
    return fail_limit(ErrorCode::index_out_of_range,
                      "there is no vertex " + std::to_string(vertex) + " in a mesh of " +
                          std::to_string(mesh.source_vertex_count()),
                      mesh.source_vertex_count(), vertex, "vertex");
  }
  // Not owned: the adjacency ends before this call does.
  const Adjacency adjacency =
      Adjacency::build(std::shared_ptr<const Mesh>(std::shared_ptr<void>(), &mesh));
  const Source source{point_at_vertex(adjacency, mesh.vertex_of_source()[vertex]), 0};
  FieldLimits limits;
  limits.keep_details = false;
  SolveScratch scratch;
  const auto field = solve_field(method, {}, adjacency, {&source, 1}, limits, scratch, Cancel());
  if (!field) return fail(field.error());
  std::vector<double> result(mesh.source_vertex_count());
  for (std::uint32_t v = 0; v < result.size(); ++v) {
    result[v] = field->distance[mesh.vertex_of_source()[v]];
  }
  return result;
}

}  // namespace geodesic
