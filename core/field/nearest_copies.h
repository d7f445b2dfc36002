// Which vertex of a surface speaks for each vertex of the file, where walls have made several of
// one.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "core/base/cancel.h"
#include "core/mesh/mesh.h"

namespace geodesic {

// The copy that speaks for a vertex that vertex_of_source has. `nearer`: as nearer_copies gives it.
[[nodiscard]] inline std::uint32_t nearest_copy(
    const std::unordered_map<std::uint32_t, std::uint32_t>& nearer, std::uint32_t vertex) {
  const auto copy = nearer.find(vertex);
  return copy == nearer.end() ? vertex : copy->second;
}

// Of vertices that have copies with a value less than theirs, the copy with the least. They are
// those that vertex_of_source has. `value_at(v)`: of a vertex. O(v), and memory for no others. Of
// no use if the poll says to stop.
template <class ValueAt>
[[nodiscard]] std::unordered_map<std::uint32_t, std::uint32_t> nearer_copies(
    const Mesh& mesh, const ValueAt& value_at, Poll& poll) {
  const auto firsts = mesh.vertex_of_source();
  std::unordered_map<std::uint32_t, std::uint32_t> nearer;
  for (std::uint32_t v = 0; v < mesh.vertex_count() && !poll.cancelled(); ++v) {
    const std::uint32_t source = mesh.source_of_vertex(v);
    if (source >= mesh.source_vertex_count() || firsts[source] == v) continue;
    const std::uint32_t first = firsts[source];
    if (value_at(v) < value_at(nearest_copy(nearer, first))) nearer[first] = v;
  }
  return nearer;
}

// By source vertex, of its copies the one with the least value; kNone where it is on no surface.
// `values`: by vertex. Of no use if the poll says to stop.
template <class Values>
[[nodiscard]] std::vector<std::uint32_t> nearest_copies(const Mesh& mesh, const Values& values,
                                                        Poll& poll) {
  const auto firsts = mesh.vertex_of_source();
  std::vector<std::uint32_t> found(firsts.begin(), firsts.end());
  const auto nearer = nearer_copies(
      mesh, [&](std::uint32_t v) { return values[v]; }, poll);
  if (nearer.empty()) return found;
  for (std::uint32_t& v : found) {
    if (poll.cancelled()) break;
    v = nearest_copy(nearer, v);
  }
  return found;
}

}  // namespace geodesic
