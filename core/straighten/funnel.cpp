#include "core/straighten/funnel.h"

#include <algorithm>
#include <cmath>

#include "core/base/tolerances.h"

namespace geodesic {
namespace {

// Positive when `p` is to the left of the line from `a` on to `b`.
double leftness(Vec2 a, Vec2 b, Vec2 p) { return cross(b - a, p - a); }

// On one line with a -> b, but not beyond b: the strip has turned back on itself
// round b, which only faces without area make possible.
bool is_back(Vec2 a, Vec2 b, Vec2 p) { return dot(b - a, p - b) < 0; }

// Whether two vectors lie on one line, as far as rounding can tell.
bool is_on_line(Vec2 u, Vec2 v) {
  const double longer2 = std::max(dot(u, u), dot(v, v));
  return std::abs(cross(u, v)) <= tolerance::kThroughVertex * longer2;
}

// On one line with b -> a, beyond a: the path sets out on the portal between the two, or comes to
// it through faces without width, and sees all that is behind it.
bool is_between(Vec2 b, Vec2 a, Vec2 p) {
  return dot(b - a, p - a) < 0 && is_on_line(b - a, p - a);
}

// On one line with a -> b, which goes on to the portal from b to `other`, and back from b as far as
// `other` at the most: in faces without width the path crosses the portal where p is, and need not
// go to b.
bool is_on_portal(Vec2 a, Vec2 b, Vec2 other, Vec2 p) {
  return dot(a - b, p - b) > 0 && dot(other - b, p - b) > 0 && dot(b - other, p - other) >= 0 &&
         is_on_line(a - b, p - b) && is_on_line(other - b, p - b);
}

}  // namespace

void Funnel::list_sides(const UnfoldedStrip& strip) {
  nodes_.clear();
  left_node_.clear();
  right_node_.clear();
  nodes_.push_back({strip.start, kNone, 0, 0});
  for (std::size_t i = 0; i < strip.unfolded_portals.size(); ++i) {
    const UnfoldedPortal& unfolded_portal = strip.unfolded_portals[i];
    const bool new_left =
        i == 0 || unfolded_portal.left_vertex != strip.unfolded_portals[i - 1].left_vertex;
    const bool new_right =
        i == 0 || unfolded_portal.right_vertex != strip.unfolded_portals[i - 1].right_vertex;
    const auto side = [&](std::vector<std::uint32_t>& side_node, bool is_new, Vec2 at,
                          std::uint32_t vertex) {
      if (is_new) {
        side_node.push_back(static_cast<std::uint32_t>(nodes_.size()));
        nodes_.push_back({at, vertex, i, i});
      } else {
        side_node.push_back(side_node.back());
        nodes_[side_node.back()].last_portal = i;
      }
    };
    side(left_node_, new_left, unfolded_portal.left, unfolded_portal.left_vertex);
    side(right_node_, new_right, unfolded_portal.right, unfolded_portal.right_vertex);
  }
  nodes_.push_back(
      {strip.end, kNone, strip.unfolded_portals.size(), strip.unfolded_portals.size()});
}

// The portal's left end moves on to `node`. The left side of the funnel turns left at
// every vertex; what the new end can see past drops out, and when it sees past the
// apex and over the right side, the apex moves on along that side.
void Funnel::widen_left(std::uint32_t node) {
  const Vec2 p = nodes_[node].at;
  const Vec2 left_end = nodes_[deque_[first_]].at;
  const Vec2 right_end = nodes_[deque_[last_]].at;
  while (first_ < apex_) {
    const Vec2 a = nodes_[deque_[first_ + 1]].at;
    const Vec2 b = nodes_[deque_[first_]].at;
    if (leftness(a, b, p) > 0 && !is_on_portal(a, b, right_end, p)) break;
    ++first_;
  }
  while (first_ == apex_ && apex_ < last_) {
    const Vec2 a = nodes_[deque_[apex_]].at;
    const Vec2 b = nodes_[deque_[apex_ + 1]].at;
    const double left = leftness(a, b, p);
    if (left > 0 || (left == 0 && !is_back(a, b, p)) || is_between(b, a, p) ||
        is_on_portal(a, b, left_end, p)) {
      break;
    }
    first_ = ++apex_;
  }
  parent_[node] = deque_[first_];
  deque_[--first_] = node;
}

// The mirror image.
void Funnel::widen_right(std::uint32_t node) {
  const Vec2 p = nodes_[node].at;
  const Vec2 left_end = nodes_[deque_[first_]].at;
  const Vec2 right_end = nodes_[deque_[last_]].at;
  while (last_ > apex_) {
    const Vec2 a = nodes_[deque_[last_ - 1]].at;
    const Vec2 b = nodes_[deque_[last_]].at;
    if (leftness(a, b, p) < 0 && !is_on_portal(a, b, left_end, p)) break;
    --last_;
  }
  while (last_ == apex_ && apex_ > first_) {
    const Vec2 a = nodes_[deque_[apex_]].at;
    const Vec2 b = nodes_[deque_[apex_ - 1]].at;
    const double left = leftness(a, b, p);
    if (left < 0 || (left == 0 && !is_back(a, b, p)) || is_between(b, a, p) ||
        is_on_portal(a, b, right_end, p)) {
      break;
    }
    last_ = --apex_;
  }
  parent_[node] = deque_[last_];
  deque_[++last_] = node;
}

const std::vector<StripVertex>& Funnel::touched(const UnfoldedStrip& strip) {
  list_sides(strip);
  const std::size_t portals = strip.unfolded_portals.size();
  parent_.assign(nodes_.size(), kNone);
  // Each portal brings at most one vertex to a side, the first portal one to both.
  deque_.resize(2 * portals + 5);
  first_ = apex_ = last_ = portals + 2;
  deque_[apex_] = 0;
  for (std::size_t i = 0; i < portals; ++i) {
    if (nodes_[left_node_[i]].first_portal == i) widen_left(left_node_[i]);
    if (nodes_[right_node_[i]].first_portal == i) widen_right(right_node_[i]);
  }
  const auto end = static_cast<std::uint32_t>(nodes_.size() - 1);
  widen_left(end);

  touched_.clear();
  for (std::uint32_t node = parent_[end]; node != 0; node = parent_[node]) {
    touched_.push_back(nodes_[node]);
  }
  std::reverse(touched_.begin(), touched_.end());
  return touched_;
}

}  // namespace geodesic
