// What trace_lanes.cpp knows of the traces in one register, and where they begin.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/back_traced/front_distances.h"
#include "core/back_traced/trace.h"
#include "core/back_traced/trace_lanes.h"
#include "core/base/lane_arithmetic.h"
#include "core/field/field.h"

namespace geodesic {

// Of as many lanes as a register holds; the names are those of BackTrace.
template <std::size_t kWide>
struct TraceLaneState {
  using Lanes = lanes::Lanes<kWide>;
  using Reals = typename Lanes::Reals;
  using Flags = typename Lanes::Flags;
  using Ids = typename Lanes::Ids;

  Reals right_x, right_y, left_x, left_y;
  Reals right_bound_x, right_bound_y, left_bound_x, left_bound_y;
  Reals at_right, at_left, best;
  Reals farthest2, start2, finest;  // BackTrace::Spread
  Flags alive, crossed, beyond_is_surface, at_border;
  Ids edge, across, right_vertex;
  std::uint32_t source[kWide];  // where there are several
};

template <std::size_t kWide, bool kSeveralSources>
GEODESIC_LANES_INLINE void begin_traces(const FaceRecord* faces, const FrontDistances& distances,
                                        const TraceLanes& traces, std::size_t first, bool has_lines,
                                        TraceLaneState<kWide>& s) {
  using Lanes = lanes::Lanes<kWide>;
  using Reals = typename Lanes::Reals;
  using Flags = typename Lanes::Flags;
  const FaceRecord* face[kWide];
  std::size_t corner[kWide];
  std::size_t next[kWide];
  std::size_t previous[kWide];
  std::size_t lane[kWide];
  for (std::size_t j = 0; j < kWide; ++j) {
    // Lanes without a trace do the same as the first one, with nobody to see it.
    lane[j] = first + j < traces.count ? first + j : 0;
    const Halfedge base = traces.base[lane[j]];
    face[j] = &faces[face_of(base)];
    corner[j] = corner_of(base);
    next[j] = lanes::kNextCorner[corner[j]];
    previous[j] = lanes::kPreviousCorner[corner[j]];
    __builtin_prefetch(&faces[face_of(face[j]->ring[corner[j]])]);
  }
  Reals p, q, w, area, crossing;
  Lanes::gather(p, [&](std::size_t j) { return face[j]->dot[corner[j]]; });
  Lanes::gather(q, [&](std::size_t j) { return face[j]->dot[next[j]]; });
  Lanes::gather(w, [&](std::size_t j) { return face[j]->dot[previous[j]]; });
  Lanes::gather(area, [&](std::size_t j) { return face[j]->area2; });
  const auto distance = [&](std::size_t j, std::size_t at) {
    return distances.at<kSeveralSources>(face[j]->vertex[at], traces.source[lane[j]]);
  };
  Lanes::gather(s.at_right, [&](std::size_t j) { return distance(j, corner[j]); });
  Lanes::gather(s.at_left, [&](std::size_t j) { return distance(j, next[j]); });
  if constexpr (kSeveralSources) {
    for (std::size_t j = 0; j < kWide; ++j) s.source[j] = traces.source[lane[j]];
  }
  Lanes::gather(crossing, [&](std::size_t j) { return traces.crossing[lane[j]]; });
  Lanes::gather(s.best, [&](std::size_t j) { return traces.best[lane[j]]; });
  const auto gather_ids = [](auto& ids, auto id) {
    Lanes::gather(ids, [&](std::size_t j) { return std::uint64_t{id(j)}; });
  };
  gather_ids(s.right_vertex, [&](std::size_t j) { return face[j]->vertex[corner[j]]; });
  gather_ids(s.edge, [&](std::size_t j) { return traces.base[lane[j]]; });
  gather_ids(s.across, [&](std::size_t j) { return face[j]->ring[corner[j]]; });
  const Reals zero = {};
  Reals length;
  const Reals right2 = p + w;
  Lanes::root(length, right2 > 0 ? right2 : zero);
  Reals by = s.at_right + length;
  s.best = by < s.best ? by : s.best;
  const Reals left2 = q + w;
  Lanes::root(length, left2 > 0 ? left2 : zero);
  by = s.at_left + length;
  s.best = by < s.best ? by : s.best;

  const Reals base2 = p + q;
  const Reals longer2 = right2 > left2 ? right2 : left2;
  const Reals shorter2 = right2 < left2 ? right2 : left2;
  s.farthest2 = base2 > longer2 ? base2 : longer2;
  s.start2 = base2 < shorter2 ? base2 : shorter2;
  s.finest = zero;
  const Reals across = crossing * base2;
  const Reals along = across - p;
  Reals base_length;
  Lanes::root(length, along * along + area * area);
  Lanes::root(base_length, base2);
  const Reals scale = 1.0 / (length * base_length);
  s.right_x = scale * (area * area - p * along);
  s.right_y = scale * (-area * across);
  s.left_x = scale * (area * area + q * along);
  s.left_y = scale * (area * (base2 - across));
  s.right_bound_x = s.right_x;
  s.right_bound_y = s.right_y;
  s.left_bound_x = s.left_x;
  s.left_bound_y = s.left_y;
  s.alive = s.right_x < kUnreached;
  if (has_lines) [[unlikely]] {
    for (std::size_t j = 0; j < kWide; ++j) {
      if (is_line(*face[j])) s.alive[j] = 0;
    }
  }
  s.beyond_is_surface = s.alive;
  s.at_border = s.edge == s.across;
  s.crossed = Flags{};
}

// The same for those that begin elsewhere than over a base.
template <std::size_t kWide, bool kSeveralSources>
GEODESIC_LANES_INLINE void begin_traces_elsewhere(const FaceRecord* faces,
                                                  const FrontDistances& distances,
                                                  const TraceLanes& traces, std::size_t first,
                                                  TraceLaneState<kWide>& s) {
  for (std::size_t j = 0; j < kWide; ++j) {
    if (!traces.begins_elsewhere(first + j)) continue;
    const TraceStart& start = traces.start[first + j];
    const Halfedge across = faces[face_of(start.edge)].ring[corner_of(start.edge)];
    s.right_x[j] = s.right_bound_x[j] = start.to_right.x;
    s.right_y[j] = s.right_bound_y[j] = start.to_right.y;
    s.left_x[j] = s.left_bound_x[j] = start.to_left.x;
    s.left_y[j] = s.left_bound_y[j] = start.to_left.y;
    const BackTrace::Spread spread = BackTrace::spread_of(start);
    s.farthest2[j] = spread.farthest2;
    s.start2[j] = spread.start2;
    s.at_right[j] = distances.at<kSeveralSources>(start.right, traces.source[first + j]);
    s.at_left[j] = distances.at<kSeveralSources>(start.left, traces.source[first + j]);
    s.best[j] = traces.best[first + j];
    s.right_vertex[j] = start.right;
    s.edge[j] = start.edge;
    s.across[j] = across;
    s.alive[j] = s.beyond_is_surface[j] = -1;
    s.at_border[j] = across == start.edge ? -1 : 0;
  }
}

}  // namespace geodesic
