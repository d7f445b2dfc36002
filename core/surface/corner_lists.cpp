#include "core/surface/corner_lists.h"

#include "core/base/polled_fill.h"

namespace geodesic {

// A counting sort.
void list_corners(std::span<const FaceRecord> faces, std::size_t vertex_count,
                  std::vector<std::uint32_t>& begin, std::vector<std::uint32_t>& corners,
                  Poll& poll) {
  polled_assign(begin, vertex_count + 1, std::uint32_t{0}, poll);
  if (poll.stopped()) return;
  for (const FaceRecord& record : faces) {
    if (poll.cancelled()) return;
    for (const std::uint32_t v : record.vertex) ++begin[v + 1];
  }
  for (std::size_t v = 1; v <= vertex_count; ++v) begin[v] += begin[v - 1];
  polled_assign(corners, 3 * faces.size(), std::uint32_t{0}, poll);
  std::vector<std::uint32_t> next;
  polled_copy(next, std::span<const std::uint32_t>(begin).first(vertex_count), poll);
  if (poll.stopped()) return;
  for (std::uint32_t f = 0; f < faces.size() && !poll.cancelled(); ++f) {
    for (std::uint32_t c = 0; c < 3; ++c) corners[next[faces[f].vertex[c]]++] = halfedge(f, c);
  }
}

}  // namespace geodesic
