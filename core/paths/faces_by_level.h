// For every level of a field, or for every strip between two levels, the faces that it meets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/base/polled_fill.h"
#include "core/surface/adjacency.h"

namespace geodesic {

// Which of them a face meets: the numbers from `first` up to `last`.
struct LevelRange {
  std::size_t first = 0;
  std::size_t last = 0;
};

// Those of the first, ascending, then those of the second, and so on.
struct FacesByLevel {
  std::vector<std::size_t> begin;  // one more than there are levels
  std::vector<std::uint32_t> face;

  [[nodiscard]] std::span<const std::uint32_t> of(std::size_t level) const {
    return {face.data() + begin[level], begin[level + 1] - begin[level]};
  }
};

// `range_of(face)` tells a face's. `may_list(entries)` may refuse so many. `stops(entries)` is
// asked for each face in each of two passes, with how many entries come of it then: true once the
// poll says to stop, and what is returned is of no use. Errors: those of `may_list`.
template <class RangeOf, class MayList, class Stops>
[[nodiscard]] Result<FacesByLevel> list_by_level(const Adjacency& adjacency, std::size_t levels,
                                                 RangeOf range_of, MayList may_list, Stops stops,
                                                 Poll& poll) {
  FacesByLevel found;
  // First the change of the count from level to level, then its running sum.
  std::vector<std::int64_t> change(levels + 1, 0);
  std::uint64_t entries = 0;
  for (const FaceRecord& face : adjacency.faces()) {
    const LevelRange range = range_of(face);
    if (stops(std::size_t{0})) return found;
    ++change[range.first];
    --change[range.last];
    entries += range.last - range.first;
  }
  if (auto may = may_list(entries); !may) return fail(std::move(may.error()));
  found.begin.assign(levels + 1, 0);
  std::int64_t count = 0;
  for (std::size_t level = 0; level < levels; ++level) {
    count += change[level];
    found.begin[level + 1] = found.begin[level] + static_cast<std::size_t>(count);
  }
  polled_assign(found.face, entries, 0U, poll);
  if (poll.stopped()) return found;
  std::vector<std::size_t> fill(found.begin.begin(), found.begin.end() - 1);
  for (std::uint32_t f = 0; f < adjacency.faces().size(); ++f) {
    const LevelRange range = range_of(adjacency.face(f));
    if (stops(range.last - range.first)) return found;
    for (std::size_t level = range.first; level < range.last; ++level) {
      found.face[fill[level]++] = f;
    }
  }
  return found;
}

}  // namespace geodesic
