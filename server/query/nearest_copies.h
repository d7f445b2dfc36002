// Which vertex of a surface speaks for each vertex of the file, where walls have made several of
// one.
#pragma once

#include <cstdint>
#include <numeric>
#include <vector>

#include "core/mesh/mesh.h"

namespace geodesic::server {

// By source vertex, of its copies the one with the least value; kNone where it is on no surface.
// `values`: by vertex. `is_split`: whether lines have split faces; there are no copies otherwise.
template <class Values>
[[nodiscard]] std::vector<std::uint32_t> nearest_copies(const Mesh& mesh, const Values& values,
                                                        bool is_split) {
  const auto firsts = mesh.vertex_of_source();
  std::vector<std::uint32_t> found(firsts.begin(), firsts.end());
  if (!is_split) return found;
  std::vector<std::uint32_t> nearest(mesh.vertex_count());
  std::iota(nearest.begin(), nearest.end(), 0U);
  for (std::uint32_t v = 0; v < nearest.size(); ++v) {
    const std::uint32_t source = mesh.source_of_vertex(v);
    if (source >= mesh.source_vertex_count()) continue;
    std::uint32_t& of_first = nearest[firsts[source]];
    if (values[v] < values[of_first]) of_first = v;
  }
  for (std::uint32_t& v : found) {
    if (v != kNone) v = nearest[v];
  }
  return found;
}

}  // namespace geodesic::server
