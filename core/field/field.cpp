#include "core/field/field.h"

#include "core/field/edge_points.h"
#include "core/field/line_waves.h"
#include "core/field/window_table.h"

namespace geodesic {
namespace {

void forget(Field& field, std::size_t v) {
  field.distance.forget(v);
  if (!field.parents.empty()) field.parents[v] = {};
  if (!field.nearest_source.empty()) field.nearest_source[v] = kNone;
}

}  // namespace

std::uint32_t Field::item_of_source(std::uint32_t source) const {
  return lines && source != kNone ? lines->item_of_source(source) : source;
}

void Field::forget_beyond(double farthest) {
  for (std::size_t v = 0; v < distance.size(); ++v) {
    if (!(distance[v] <= farthest)) forget(*this, v);
  }
}

void Field::keep_within(double most, std::span<const std::uint32_t> among) {
  reached = 0;
  max = 0;
  farthest = kNone;
  for (const std::uint32_t v : among) {
    const double d = distance[v];
    if (!(d <= most)) forget(*this, v);
    if (!(d <= most) || d == kUnreached) continue;
    ++reached;
    // Of several as far the lowest, as count_reached takes.
    if (farthest == kNone || d > max || (d == max && v < farthest)) {
      max = d;
      farthest = v;
    }
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
         (kept_windows ? kept_windows->bytes() : 0) +
         (edge_points ? edge_points->bytes() : 0) + (lines ? lines->bytes() : 0);
}

}  // namespace geodesic
