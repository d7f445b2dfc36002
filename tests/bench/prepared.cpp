#include "tests/bench/prepared.h"

#include <cstdio>
#include <cstdlib>
#include <utility>

#include "core/paths/trace_path.h"
#include "proto/wire/methods.h"

namespace geodesic::bench {

void give_up(const std::string& sentence) {
  std::fprintf(stderr, "%s\n", sentence.c_str());
  std::exit(1);
}

Prepared::Prepared(const TriangleSoup& soup) {
  auto mesh = Mesh::build(soup);
  if (!mesh) give_up(mesh.error().detail);
  mesh_ = std::make_shared<const Mesh>(std::move(*mesh));
  adjacency_ = std::make_shared<const Adjacency>(Adjacency::build(mesh_));
}

Field Prepared::solve(Method method, std::uint32_t source_vertex, SolveScratch& scratch,
                      const MethodOptions& options, const FieldLimits& limits) const {
  const Source source = source_at(source_vertex);
  auto field = solve_field(method, options, *adjacency_, {&source, 1}, limits, scratch, Cancel());
  if (!field) give_up(std::string(proto::name_of(method)) + ": " + field.error().detail);
  return std::move(*field);
}

Path Prepared::path(const Field& field, std::uint32_t source_vertex) const {
  auto path =
      trace_path(*adjacency_, field, point_at_vertex(*adjacency_, vertex(source_vertex)), Cancel());
  if (!path || !*path)
    give_up(std::string(proto::name_of(field.method)) + ": no path where there is a distance");
  return std::move(**path);
}

std::vector<double> Prepared::in_source_order(std::span<const double> by_vertex) const {
  std::vector<double> values;
  values.reserve(mesh_->source_vertex_count());
  for (const std::uint32_t v : mesh_->vertex_of_source()) values.push_back(by_vertex[v]);
  return values;
}

}  // namespace geodesic::bench
