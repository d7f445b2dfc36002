#include "core/refine/face_pieces.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/base/edge_key.h"
#include "core/mesh/mesh.h"

namespace geodesic {
namespace {

// Parts of two sides.
struct Place2 {
  double x;
  double y;
};

Place2 place_of(const Weights& weights) { return {weights[1], weights[2]}; }
Place2 operator-(Place2 a, Place2 b) { return {a.x - b.x, a.y - b.y}; }
double cross_of(Place2 a, Place2 b) { return a.x * b.y - a.y * b.x; }
double dot_of(Place2 a, Place2 b) { return a.x * b.x + a.y * b.y; }
double length_of(Place2 a) { return std::hypot(a.x, a.y); }

Weights between(const Weights& a, const Weights& b, double t) {
  return {(1 - t) * a[0] + t * b[0], (1 - t) * a[1] + t * b[1], (1 - t) * a[2] + t * b[2]};
}

std::uint64_t directed(std::uint32_t from, std::uint32_t to) {
  return std::uint64_t{from} << 32U | to;
}

// Two points that are no farther apart are one. Twice kSnap, for one of the same place may have
// been moved onto an edge.
constexpr double kSamePoint = 2 * kSnap;

// A cell of a grid, or one beside it. Cells are wider than kSamePoint.
std::uint64_t cell_of(const Weights& weights, int across, int up) {
  constexpr double kCells = 1U << 28U;
  static_assert(kSamePoint * kCells < 1);
  const Place2 place = place_of(weights);
  const auto x = static_cast<std::int64_t>(std::floor(place.x * kCells)) + across;
  const auto y = static_cast<std::int64_t>(std::floor(place.y * kCells)) + up;
  return static_cast<std::uint64_t>(x) << 32U ^ static_cast<std::uint32_t>(y);
}

// A place that is deeper than that in one triangle is in no other: they overlap by no more than
// rounding, which is far less.
constexpr double kSurelyIn = 1e-12;

}  // namespace

FacePieces::FacePieces() {
  for (std::uint32_t c = 0; c < 3; ++c) {
    Weights corner{0, 0, 0};
    corner[c] = 1;
    add_point(corner);
    sides_[c] = {{0.0, c}, {1.0, (c + 1) % 3}};
  }
  triangles_.emplace_back();
  put(0, {0, 1, 2});
}

std::uint32_t FacePieces::add_point(const Weights& weights) {
  points_.push_back(weights);
  triangle_at_.push_back(kNone);
  return static_cast<std::uint32_t>(points_.size() - 1);
}

void FacePieces::put(std::uint32_t triangle, const Corners& corners) {
  triangles_[triangle] = corners;
  for (std::uint32_t c = 0; c < 3; ++c) {
    edges_[directed(corners[c], corners[(c + 1) % 3])] = triangle;
    triangle_at_[corners[c]] = triangle;
  }
}

std::uint32_t FacePieces::over(std::uint32_t from, std::uint32_t to) const {
  const auto found = edges_.find(directed(from, to));
  return found == edges_.end() ? kNone : found->second;
}

void FacePieces::split_edge(std::uint32_t u, std::uint32_t w, std::uint32_t at) {
  splits_[edge_key(u, w)] = at;
  for (const auto& [from, to] : {std::pair(u, w), std::pair(w, u)}) {
    const std::uint32_t triangle = over(from, to);
    if (triangle == kNone) continue;
    edges_.erase(directed(from, to));
    const Corners& corners = triangles_[triangle];
    std::uint32_t apex = corners[0];
    for (const std::uint32_t corner : corners) {
      if (corner != from && corner != to) apex = corner;
    }
    triangles_.emplace_back();
    put(triangle, {from, at, apex});
    put(static_cast<std::uint32_t>(triangles_.size() - 1), {at, to, apex});
  }
}

std::uint32_t FacePieces::add_on_side(std::uint32_t side, double t) {
  auto& there = sides_[side];
  const auto after = there.lower_bound(t);
  const std::uint32_t next = after->second;
  const std::uint32_t before = std::prev(after)->second;
  Weights weights{0, 0, 0};
  weights[side] = 1 - t;
  weights[(side + 1) % 3] = t;
  const std::uint32_t at = add_point(weights);
  there.emplace(t, at);
  split_edge(before, next, at);
  return at;
}

std::uint32_t FacePieces::find_point(const Weights& weights) {
  for (auto i = static_cast<std::uint32_t>(before_in_cell_.size()); i < points_.size(); ++i) {
    const auto [at, is_first] = cells_.try_emplace(cell_of(points_[i], 0, 0), i);
    before_in_cell_.push_back(is_first ? kNone : std::exchange(at->second, i));
  }
  std::uint32_t found = kNone;
  for (const int across : {-1, 0, 1}) {
    for (const int up : {-1, 0, 1}) {
      const auto cell = cells_.find(cell_of(weights, across, up));
      std::uint32_t i = cell == cells_.end() ? kNone : cell->second;
      for (; i != kNone; i = before_in_cell_[i]) {
        if (length_of(place_of(points_[i]) - place_of(weights)) <= kSamePoint) {
          found = std::min(found, i);
        }
      }
    }
  }
  return found;
}

FacePieces::Depth FacePieces::depth_in(std::uint32_t triangle, const Weights& weights) const {
  Depth least{2, 0};
  for (std::uint32_t c = 0; c < 3; ++c) {
    const Place2 a = place_of(points_[triangles_[triangle][c]]);
    const Place2 along = place_of(points_[triangles_[triangle][(c + 1) % 3]]) - a;
    const double off = cross_of(along, place_of(weights) - a) / length_of(along);
    if (off < least.off) least = {off, c};
  }
  return least;
}

std::uint32_t FacePieces::deepest_at(const Weights& weights, Poll& poll) const {
  std::uint32_t deepest = 0;
  double depth = -2;
  for (std::uint32_t i = 0; i < triangles_.size() && !poll.cancelled(); ++i) {
    const double off = depth_in(i, weights).off;
    if (off <= depth) continue;
    depth = off;
    deepest = i;
  }
  return deepest;
}

std::uint32_t FacePieces::walk_to(const Weights& weights, Poll& poll) const {
  std::uint32_t triangle = triangle_at_[last_inside_];
  // Over triangles of any shape it may go round in circles.
  for (std::size_t left = triangles_.size(); left > 0 && !poll.cancelled(); --left) {
    const Depth depth = depth_in(triangle, weights);
    if (depth.off > kSurelyIn) return triangle;
    const Corners& corners = triangles_[triangle];
    const std::uint32_t next = over(corners[(depth.side + 1) % 3], corners[depth.side]);
    if (depth.off >= -kSurelyIn || next == kNone) break;
    triangle = next;
  }
  return kNone;
}

std::uint32_t FacePieces::add_inside(const Weights& weights, Poll& poll) {
  const std::uint32_t known = find_point(weights);
  if (known != kNone) return last_inside_ = known;
  const std::uint32_t near = walk_to(weights, poll);
  const std::uint32_t deepest = near != kNone ? near : deepest_at(weights, poll);
  return last_inside_ = split_at(weights, deepest);
}

std::uint32_t FacePieces::split_at(const Weights& weights, std::uint32_t triangle) {
  const Place2 p = place_of(weights);
  const auto [depth, nearest] = depth_in(triangle, weights);
  const Corners corners = triangles_[triangle];
  const std::uint32_t u = corners[nearest];
  const std::uint32_t w = corners[(nearest + 1) % 3];
  if (depth <= kSnap && over(w, u) != kNone) {
    const Place2 a = place_of(points_[u]);
    const Place2 along = place_of(points_[w]) - a;
    const double t = std::clamp(dot_of(p - a, along) / dot_of(along, along), 0.0, 1.0);
    if (t * length_of(along) <= kSnap) return u;
    if ((1 - t) * length_of(along) <= kSnap) return w;
    const std::uint32_t at = add_point(between(points_[u], points_[w], t));
    split_edge(u, w, at);
    return at;
  }
  const std::uint32_t at = add_point(weights);
  triangles_.resize(triangles_.size() + 2);
  const auto last = static_cast<std::uint32_t>(triangles_.size() - 1);
  put(triangle, {corners[0], corners[1], at});
  put(last - 1, {corners[1], corners[2], at});
  put(last, {corners[2], corners[0], at});
  return at;
}

template <class Visit>
void FacePieces::around(std::uint32_t a, Visit&& visit) const {
  const std::uint32_t first = triangle_at_[a];
  const auto others = [&](std::uint32_t triangle) {
    const Corners& corners = triangles_[triangle];
    const std::uint32_t c = corners[0] == a ? 0 : corners[1] == a ? 1 : 2;
    return std::pair(corners[(c + 1) % 3], corners[(c + 2) % 3]);
  };
  std::uint32_t triangle = first;
  do {
    const auto [u, w] = others(triangle);
    visit(u, w);
    triangle = over(a, w);
  } while (triangle != kNone && triangle != first);
  if (triangle == first) return;
  // The other way round, from a face's side.
  for (triangle = over(others(first).first, a); triangle != kNone;) {
    const auto [u, w] = others(triangle);
    visit(u, w);
    triangle = over(u, a);
  }
}

std::uint32_t FacePieces::step_along_side(std::uint32_t a, std::uint32_t b) const {
  for (std::uint32_t side = 0; side < 3; ++side) {
    // The weight across from it is exactly zero.
    const std::uint32_t across = (side + 2) % 3;
    if (points_[a][across] != 0 || points_[b][across] != 0) continue;
    const auto at = [&](std::uint32_t point) {
      if (point == side) return 0.0;
      return point == (side + 1) % 3 ? 1.0 : points_[point][(side + 1) % 3];
    };
    const auto here = sides_[side].find(at(a));
    if (here == sides_[side].end()) return kNone;
    return at(a) < at(b) ? std::next(here)->second : std::prev(here)->second;
  }
  return kNone;
}

std::uint32_t FacePieces::step(std::uint32_t a, std::uint32_t b) {
  if (over(a, b) != kNone || over(b, a) != kNone) return b;
  if (const std::uint32_t next = step_along_side(a, b); next != kNone) return next;
  const Place2 from = place_of(points_[a]);
  const Place2 ahead = place_of(points_[b]) - from;
  const double length = length_of(ahead);
  std::uint32_t on_way = kNone;
  double least_off = kSnap;
  std::pair<std::uint32_t, std::uint32_t> crossed{kNone, kNone};
  double clearest = 0;
  double part = 0;
  around(a, [&](std::uint32_t u, std::uint32_t w) {
    const Place2 to_u = place_of(points_[u]) - from;
    const Place2 to_w = place_of(points_[w]) - from;
    for (const auto& [point, to] : {std::pair(u, to_u), std::pair(w, to_w)}) {
      const double along = dot_of(to, ahead) / length;
      const double off = std::abs(cross_of(to, ahead)) / length;
      if (off > least_off || along <= 0 || along >= length) continue;
      least_off = off;
      on_way = point;
    }
    const double right = cross_of(to_u, ahead);
    const double left = cross_of(ahead, to_w);
    const double clear = std::min(right / length_of(to_u), left / length_of(to_w));
    if (clear <= clearest) return;
    clearest = clear;
    crossed = {u, w};
    part = right / (right + left);
  });
  if (on_way != kNone) return on_way;
  const auto [u, w] = crossed;
  if (u == kNone || over(w, u) == kNone) return kNone;
  const double span = length_of(place_of(points_[w]) - place_of(points_[u]));
  if (part * span <= kSnap) return u;
  if ((1 - part) * span <= kSnap) return w;
  const std::uint32_t at = add_point(between(points_[u], points_[w], part));
  split_edge(u, w, at);
  return at;
}

std::vector<std::uint32_t> FacePieces::along_edges(std::uint32_t a, std::uint32_t b,
                                                   Poll& poll) const {
  std::vector<std::uint32_t> from(points_.size(), kNone);
  std::vector<std::uint32_t> queue{b};
  from[b] = b;
  for (std::size_t i = 0; i < queue.size() && from[a] == kNone && !poll.cancelled(); ++i) {
    around(queue[i], [&](std::uint32_t u, std::uint32_t w) {
      for (const std::uint32_t next : {u, w}) {
        if (from[next] != kNone) continue;
        from[next] = queue[i];
        queue.push_back(next);
      }
    });
  }
  std::vector<std::uint32_t> way;
  while (a != b && from[a] != kNone) way.push_back(a = from[a]);
  return way;
}

std::vector<std::uint32_t> FacePieces::join(std::uint32_t a, std::uint32_t b, Poll& poll) {
  std::vector<std::uint32_t> chain{a};
  // A segment crosses an edge once. More steps than that are rounding's.
  std::size_t left = points_.size() + 3 * triangles_.size();
  while (a != b && !poll.cancelled()) {
    const std::uint32_t next = left > 0 ? step(a, b) : kNone;
    if (next == kNone) {
      const std::vector<std::uint32_t> rest = along_edges(a, b, poll);
      chain.insert(chain.end(), rest.begin(), rest.end());
      break;
    }
    --left;
    chain.push_back(a = next);
  }
  return chain;
}

std::vector<std::uint32_t> FacePieces::with_splits(const std::vector<std::uint32_t>& chain) const {
  if (chain.empty()) return {};
  std::vector<std::uint32_t> whole{chain.front()};
  std::vector<std::uint32_t> ahead;  // the nearest last
  for (std::size_t i = 1; i < chain.size(); ++i) {
    ahead.assign(1, chain[i]);
    while (!ahead.empty()) {
      const auto split = splits_.find(edge_key(whole.back(), ahead.back()));
      if (split != splits_.end()) {
        ahead.push_back(split->second);
        continue;
      }
      whole.push_back(ahead.back());
      ahead.pop_back();
    }
  }
  return whole;
}

}  // namespace geodesic
