#include "core/surface/corner_lists.h"

#include <algorithm>
#include <utility>

#include "core/base/polled_fill.h"
#include "core/base/team.h"

namespace geodesic {

// A counting sort. Of several threads each does so with a part of the faces: in a vertex's list the
// corners of a part come after those of the parts before.
void list_corners(std::span<const FaceRecord> faces, std::size_t vertex_count,
                  std::vector<std::uint32_t>& begin, std::vector<std::uint32_t>& corners,
                  Poll& poll) {
  constexpr std::size_t kMostParts = 4;  // each takes as much memory as `begin`
  const Team* const team = poll.team();
  const std::size_t parts =
      team == nullptr ? 1 : std::min(team->parts_for(vertex_count), kMostParts);
  polled_assign(begin, vertex_count + 1, std::uint32_t{0}, poll);
  polled_assign(corners, 3 * faces.size(), std::uint32_t{0}, poll);
  // Of each part and vertex: how many corners, and then the place of the next one.
  std::vector<std::uint32_t> next;
  polled_assign(next, parts * vertex_count, std::uint32_t{0}, poll);
  if (poll.stopped()) return;
  const auto begin_of = [&](std::size_t part) { return part * faces.size() / parts; };
  run_parts(parts, poll, [&](std::size_t part, Poll& asked) {
    std::uint32_t* const count = next.data() + part * vertex_count;
    for (std::size_t f = begin_of(part); f < begin_of(part + 1) && !asked.cancelled(); ++f) {
      for (const std::uint32_t v : faces[f].vertex) ++count[v];
    }
  });
  std::uint32_t place = 0;
  for (std::size_t v = 0; v < vertex_count && !poll.cancelled(); ++v) {
    begin[v] = place;
    for (std::size_t part = 0; part < parts; ++part) {
      place += std::exchange(next[part * vertex_count + v], place);
    }
  }
  begin[vertex_count] = place;
  if (poll.stopped()) return;
  run_parts(parts, poll, [&](std::size_t part, Poll& asked) {
    std::uint32_t* const place_of = next.data() + part * vertex_count;
    const auto last = static_cast<std::uint32_t>(begin_of(part + 1));
    for (auto f = static_cast<std::uint32_t>(begin_of(part)); f < last && !asked.cancelled(); ++f) {
      for (std::uint32_t c = 0; c < 3; ++c)
        corners[place_of[faces[f].vertex[c]]++] = halfedge(f, c);
    }
  });
}

}  // namespace geodesic
