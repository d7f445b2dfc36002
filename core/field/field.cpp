#include "core/field/field.h"

#include "core/field/edge_points.h"
#include "core/field/line_waves.h"
#include "core/field/window_table.h"

namespace geodesic {

std::uint32_t Field::item_of_source(std::uint32_t source) const {
  return lines && source != kNone ? lines->item_of_source(source) : source;
}

void Field::forget_beyond(double farthest) {
  for (std::size_t v = 0; v < distance.size(); ++v) {
    if (distance[v] <= farthest) continue;
    distance.forget(v);
    if (!parents.empty()) parents[v] = {};
    if (!nearest_source.empty()) nearest_source[v] = kNone;
  }
}

void Field::count_reached() {
  reached = 0;
  max = 0;
  farthest = kNone;
  for (std::uint32_t v = 0; v < distance.size(); ++v) {
    if (distance[v] == kUnreached) continue;
    ++reached;
    if (farthest == kNone || distance[v] > max) {
      max = distance[v];
      farthest = v;
    }
  }
}

std::size_t Field::bytes() const {
  return sizeof(Field) + nearest_source.capacity() * sizeof(std::uint32_t) +
         sources.capacity() * sizeof(Source) + distance.bytes() +
         parents.capacity() * sizeof(Parents) + (windows ? windows->bytes() : 0) +
         (edge_points ? edge_points->bytes() : 0) + (lines ? lines->bytes() : 0);
}

}  // namespace geodesic
