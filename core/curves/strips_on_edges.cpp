#include "core/curves/strips_on_edges.h"

#include <algorithm>
#include <cmath>

#include "core/base/polled_fill.h"
#include "core/base/tolerances.h"

namespace geodesic {
namespace {

// Of the edge: what goes on beyond the place from which another is as near. The two differ in
// direction by rounding, and may leave no crack between them.
constexpr double kOverlap = 1e-9;

// To either side of a strip. What is farther along the edge is seldom the nearest way, and there
// may be as many as vertices.
constexpr std::size_t kNeighbours = 32;

// For one more. False where the poll stops it.
template <class Value>
bool has_room(std::vector<Value>& values, Poll& poll) {
  if (values.size() < values.capacity()) return true;
  const std::size_t most = 2 * values.size() + 4;
  if (!poll.may_take(most * sizeof(Value))) return false;
  values.reserve(most);
  return true;
}

}  // namespace

StripsOnEdges::StripsOnEdges(const Adjacency& adjacency, Poll& poll) : adjacency_(adjacency) {
  polled_assign(list_of_, 4 * adjacency.faces().size(), kNone, poll);
}

template <class Way>
void StripsOnEdges::cover(const StripOnEdge& strip, Part part, const Way& way) {
  if (!(part.begin < part.end)) return;
  const double late_at_begin = strip.at(part.begin) - way(part.begin);
  const double late_at_end = strip.at(part.end) - way(part.end);
  if (!(late_at_begin >= 0) && !(late_at_end >= 0)) return;
  // Where the two are as far.
  const double meet =
      part.begin + (part.end - part.begin) * (late_at_begin / (late_at_begin - late_at_end));
  if (!(late_at_begin >= 0)) part.begin = meet;
  if (!(late_at_end >= 0)) part.end = meet;
  covered_.push_back(part);
}

bool StripsOnEdges::keep_nearer(Halfedge into, double length, double least, StripOnEdge& strip,
                                Poll& poll) {
  Halfedge first = into;
  for (Halfedge g = adjacency_.ring(into); g != into; g = adjacency_.ring(g)) {
    if (poll.cancelled()) return false;
    first = std::min(first, g);
  }
  if (list_of_[first] == kNone) {
    if (!has_room(lists_, poll)) return false;
    list_of_[first] = static_cast<std::uint32_t>(lists_.size());
    lists_.emplace_back();
  }
  std::vector<StripOnEdge>& list = lists_[list_of_[first]];
  const bool is_mirrored = adjacency_.tail(into) != adjacency_.tail(first);
  StripOnEdge own = is_mirrored ? strip.mirrored(length) : strip;
  const double rounding = tolerance::kSameWay * (length + std::abs(own.at_begin));
  const auto is_before = [](const StripOnEdge& a, const StripOnEdge& b) {
    return a.begin < b.begin;
  };
  const auto place = std::upper_bound(list.begin(), list.end(), own, is_before) - list.begin();
  const std::size_t after = std::min(list.size(), static_cast<std::size_t>(place) + kNeighbours);
  covered_.clear();
  for (std::size_t i = std::max<std::size_t>(place, kNeighbours) - kNeighbours; i < after; ++i) {
    if (poll.cancelled()) return false;
    const StripOnEdge& other = list[i];
    // A way that bends from the other's end along the edge is no shortest one. So of two as long
    // the strip goes on; of two strips the one that came before.
    cover(own, {std::max(own.begin, other.begin), std::min(own.end, other.end)},
          [&](double p) { return other.at(p) - rounding; });
    cover(own, {own.begin, std::min(own.end, other.begin)},
          [&](double p) { return other.at_begin + (other.begin - p) + rounding; });
    cover(own, {std::max(own.begin, other.end), own.end},
          [&](double p) { return other.at_end + (p - other.end) + rounding; });
  }
  std::sort(covered_.begin(), covered_.end(),
            [](const Part& a, const Part& b) { return a.begin < b.begin; });
  // From the first place that none of them covers to the last.
  Part open{own.end, own.begin};
  double reached = own.begin;
  const auto leave_open = [&](double until) {
    if (!(until > reached + least)) return;
    open.begin = std::min(open.begin, reached);
    open.end = until;
  };
  for (const Part& part : covered_) {
    leave_open(part.begin);
    reached = std::max(reached, part.end);
  }
  leave_open(own.end);
  if (!(open.begin < open.end)) return false;
  const double begin = std::max(own.begin, open.begin - kOverlap * length);
  const double end = std::min(own.end, open.end + kOverlap * length);
  own = {begin, end, own.at(begin), own.at(end)};
  if (!has_room(list, poll)) return false;
  list.insert(std::upper_bound(list.begin(), list.end(), own, is_before), own);
  strip = is_mirrored ? own.mirrored(length) : own;
  return true;
}

}  // namespace geodesic
