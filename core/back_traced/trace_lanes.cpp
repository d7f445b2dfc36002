#include "core/back_traced/trace_lanes.h"

#include <cstring>

#include "core/back_traced/trace_lane_start.h"
#include "core/base/lane_arithmetic.h"
#include "core/base/tolerances.h"
#include "core/field/field.h"

namespace geodesic {
namespace {

// Of several faces on an edge the one whose apex is nearest to the source.
Halfedge nearest_beyond(const FaceRecord* faces, const FrontDistances& distances,
                        std::uint32_t source, const CrowdedEdges* crowds, Halfedge edge) {
  if (const Halfedge known = crowds != nullptr ? crowds->nearest_beyond(edge) : kNone;
      known != kNone) {
    return known;
  }
  const auto ring = [faces](Halfedge h) { return faces[face_of(h)].ring[corner_of(h)]; };
  const auto at_apex = [&](Halfedge h) {
    return distances.at(faces[face_of(h)].vertex[previous_corner(corner_of(h))], source);
  };
  Halfedge nearest = ring(edge);
  for (Halfedge h = ring(nearest); h != edge; h = ring(h)) {
    if (at_apex(h) < at_apex(nearest)) nearest = h;
  }
  return nearest;
}

// What is read of the faces that the traces go over next.
template <std::size_t kWide>
struct Ahead {
  using Reals = typename lanes::Lanes<kWide>::Reals;
  using Ids = typename lanes::Lanes<kWide>::Ids;

  Reals dot, next_dot, area, at_apex;
  Ids vertex, apex;              // at the halfedge's tail, and opposite it
  Ids next, previous;            // the other two halfedges …
  Ids over_next, over_previous;  // … and who is across those
};

// The next faces of the traces. Where there are more than two on an edge, the nearest.
template <std::size_t kWide, bool kOriented, bool kSeveralSources>
GEODESIC_LANES_INLINE void look_ahead(const FaceRecord* faces, const FrontDistances& distances,
                                      const CrowdedEdges* crowds, bool has_lines,
                                      TraceLaneState<kWide>& s, Ahead<kWide>& to) {
  using Lanes = lanes::Lanes<kWide>;
  const auto source = [&s](std::size_t i) { return kSeveralSources ? s.source[i] : 0; };
  if constexpr (!kOriented) {
    for (std::size_t i = 0; i < kWide; ++i) {
      const auto at = static_cast<Halfedge>(s.across[i]);
      if (faces[face_of(at)].ring[corner_of(at)] != s.edge[i]) [[unlikely]] {
        s.across[i] =
            nearest_beyond(faces, distances, source(i), crowds, static_cast<Halfedge>(s.edge[i]));
      }
    }
  }
  const FaceRecord* face[kWide];
  std::size_t corner[kWide];
  std::size_t next[kWide];
  std::size_t previous[kWide];
  for (std::size_t i = 0; i < kWide; ++i) {
    const auto at = static_cast<Halfedge>(s.across[i]);
    face[i] = &faces[face_of(at)];
    corner[i] = corner_of(at);
    next[i] = lanes::kNextCorner[corner[i]];
    previous[i] = lanes::kPreviousCorner[corner[i]];
  }
  Lanes::gather(to.at_apex, [&](std::size_t i) {
    return distances.at<kSeveralSources>(face[i]->vertex[previous[i]], source(i));
  });
  Lanes::gather(to.dot, [&](std::size_t i) { return face[i]->dot[corner[i]]; });
  Lanes::gather(to.next_dot, [&](std::size_t i) { return face[i]->dot[next[i]]; });
  Lanes::gather(to.area, [&](std::size_t i) { return face[i]->area2; });
  if (has_lines) [[unlikely]] {
    for (std::size_t i = 0; i < kWide; ++i) {
      const Vec2 right{s.right_x[i], s.right_y[i]};
      const Vec2 left{s.left_x[i], s.left_y[i]};
      // Nobody sees over it.
      if (is_seen_along_line(*face[i], right, left)) s.at_border[i] = -1;
    }
  }
  const auto gather_ids = [](auto& ids, auto id) {
    Lanes::gather(ids, [&](std::size_t i) { return std::uint64_t{id(i)}; });
  };
  gather_ids(to.over_next, [&](std::size_t i) { return face[i]->ring[next[i]]; });
  gather_ids(to.over_previous, [&](std::size_t i) { return face[i]->ring[previous[i]]; });
  if constexpr (!kOriented) {
    gather_ids(to.apex, [&](std::size_t i) { return face[i]->vertex[previous[i]]; });
    gather_ids(to.vertex, [&](std::size_t i) { return face[i]->vertex[corner[i]]; });
    const auto others = [&](const std::size_t* which) {
      return [&s, which](std::size_t i) { return (s.across[i] & ~std::uint64_t{3}) + which[i]; };
    };
    gather_ids(to.next, others(next));
    gather_ids(to.previous, others(previous));
  }
}

// Unfolds the faces ahead over their bases, and goes on to the edges beyond. Adds to
// `going` which of the traces do.
template <std::size_t kWide, bool kOriented, bool kEven>
GEODESIC_LANES_INLINE void unfold(const Ahead<kWide>& ahead, TraceLaneState<kWide>& s,
                                  typename lanes::Lanes<kWide>::Flags& going) {
  using Lanes = lanes::Lanes<kWide>;
  using Reals = typename Lanes::Reals;
  using Flags = typename Lanes::Flags;
  using Ids = typename Lanes::Ids;
  const Reals farther = s.at_right < s.at_left ? s.at_left : s.at_right;
  const Flags may_be_farther = ~s.crossed & (ahead.at_apex < kUnreached);
  s.beyond_is_surface &= ~(s.alive & s.at_border);
  s.alive &= s.beyond_is_surface & ((ahead.at_apex < farther) | may_be_farther);
  s.crossed |= s.alive;
  // The halfedge's tail is to the right.
  const Flags forward = kOriented ? Flags{} : Flags(ahead.vertex == s.right_vertex);
  const Reals per_base2 = 1.0 / (ahead.dot + ahead.next_dot);
  Reals along = ahead.next_dot;
  if constexpr (!kOriented) Lanes::choose(along, forward, ahead.dot, along);
  along *= per_base2;
  const Reals height = ahead.area * per_base2;
  const Reals base_x = s.left_x - s.right_x;
  const Reals base_y = s.left_y - s.right_y;
  const Reals x = s.right_x + along * base_x + height * base_y;
  const Reals y = s.right_y + along * base_y - height * base_x;
  const Flags within_left = x * s.left_bound_y - y * s.left_bound_x >= 0;
  const Flags within_right = s.right_bound_x * y - s.right_bound_y * x >= 0;
  Reals length;
  const Reals length2 = x * x + y * y;
  Lanes::root(length, length2);
  if constexpr (!kEven) {
    // Of those that have ended, too: nobody minds some care in vain.
    s.farthest2 = length2 > s.farthest2 ? length2 : s.farthest2;
    s.finest = per_base2 > s.finest ? per_base2 : s.finest;
  }
  const Reals by = ahead.at_apex + length;
  const Flags nearer = s.alive & within_left & within_right & (by < s.best);
  Lanes::choose(s.best, nearer, by, s.best);
  const Flags on_left = s.alive & (y > 0);
  const Flags on_right = s.alive & ~(y > 0);
  const Flags bounds_left = on_left & within_left;
  const Flags bounds_right = on_right & within_right;
  Lanes::choose(s.left_x, on_left, x, s.left_x);
  Lanes::choose(s.left_y, on_left, y, s.left_y);
  Lanes::choose(s.at_left, on_left, ahead.at_apex, s.at_left);
  Lanes::choose(s.left_bound_x, bounds_left, x, s.left_bound_x);
  Lanes::choose(s.left_bound_y, bounds_left, y, s.left_bound_y);
  Lanes::choose(s.right_x, on_right, x, s.right_x);
  Lanes::choose(s.right_y, on_right, y, s.right_y);
  Lanes::choose(s.at_right, on_right, ahead.at_apex, s.at_right);
  Lanes::choose(s.right_bound_x, bounds_right, x, s.right_bound_x);
  Lanes::choose(s.right_bound_y, bounds_right, y, s.right_bound_y);

  if constexpr (kOriented) {
    const Ids from = s.across;
    Lanes::choose(s.across, on_right, ahead.over_previous, from);
    Lanes::choose(s.across, on_left, ahead.over_next, s.across);
    s.at_border = Flags(s.across ^ from) < 4;  // across is the same face
  } else {
    const Flags to_previous = (on_left & forward) | (on_right & ~forward);
    const Flags to_next = (on_left & ~forward) | (on_right & forward);
    Lanes::choose(s.edge, to_previous, ahead.previous, s.edge);
    Lanes::choose(s.edge, to_next, ahead.next, s.edge);
    Lanes::choose(s.across, to_previous, ahead.over_previous, s.across);
    Lanes::choose(s.across, to_next, ahead.over_next, s.across);
    Lanes::choose(s.right_vertex, on_right, ahead.apex, s.right_vertex);
    s.at_border = s.edge == s.across;
  }
  going |= s.alive;
}

// The virtual sources of the edges that the traces have come to. Tells those apart that
// are to look farther, if they may.
template <std::size_t kWide, bool kOriented, bool kSeveralSources>
GEODESIC_LANES_INLINE void meet_circles(const FaceRecord* faces, const FrontDistances& distances,
                                        BackTrace::Candidates candidates, BackTrace::Reach reach,
                                        TraceLaneState<kWide>& s,
                                        typename lanes::Lanes<kWide>::Flags& unsure) {
  using Lanes = lanes::Lanes<kWide>;
  using Reals = typename Lanes::Reals;
  using Flags = typename Lanes::Flags;
  const Reals base_x = s.left_x - s.right_x;
  const Reals base_y = s.left_y - s.right_y;
  const Reals square = base_x * base_x + base_y * base_y;
  const Reals sum = s.at_right + s.at_left;
  const Reals difference = s.at_right - s.at_left;
  const Reals sx = 0.5 * (square + difference * sum);
  Reals sy2 = 0.25 * (sum * sum - square) * (square - difference * difference);
  Flags meet = s.beyond_is_surface & (sy2 > 0);
  Reals sy;
  Lanes::choose(sy2, meet, sy2, Reals{});
  Lanes::root(sy, sy2);
  const Reals per_base2 = 1.0 / square;
  const Reals along = sx * per_base2;
  const Reals down = sy * per_base2;
  const Reals x = s.right_x + along * base_x + down * base_y;
  const Reals y = s.right_y + along * base_y - down * base_x;
  Reals straight;
  Lanes::root(straight, x * x + y * y);
  if (candidates == BackTrace::Candidates::virtual_sources) {
    meet &= s.crossed & (x * s.left_bound_y - y * s.left_bound_x >= 0) &
            (s.right_bound_x * y - s.right_bound_y * x >= 0) &
            (straight >= BackTrace::kLeastOfBest * s.best);
  }
  unsure = Flags{};
  if (reach == BackTrace::Reach::near) {
    Reals away;
    Lanes::root(away, s.right_x * s.right_x + s.right_y * s.right_y);
    const BackTrace::Shares shares = BackTrace::unsure(candidates);
    unsure = s.alive & meet & (straight + shares.least * away < s.best) &
             (s.best < straight + shares.most * away);
  }
  if (candidates == BackTrace::Candidates::virtual_sources) {
    Flags taken = meet & ~unsure & (straight < s.best);
    // Some ended where distances grow.
    if (Lanes::any(taken & ~s.alive)) [[unlikely]] {
      for (std::size_t i = 0; i < kWide; ++i) {
        if (taken[i] == 0 || s.alive[i] != 0) continue;
        const auto at = static_cast<Halfedge>(s.across[i]);
        const FaceRecord& face = faces[face_of(at)];
        const std::uint32_t c = corner_of(at);
        const double at_apex = distances.at<kSeveralSources>(face.vertex[previous_corner(c)],
                                                             kSeveralSources ? s.source[i] : 0);
        const bool forward = !kOriented && face.vertex[c] == s.right_vertex[i];
        const Vec2 right{s.right_x[i], s.right_y[i]};
        const Vec2 left{s.left_x[i], s.left_y[i]};
        if (!BackTrace::has_reached_apex(face, c, forward, at_apex, right, left, {x[i], y[i]})) {
          taken[i] = 0;
        }
      }
    }
    Lanes::choose(s.best, taken, straight, s.best);
  }
}

struct Task {
  const FaceRecord* faces;
  FrontDistances distances;
  bool is_oriented;
  bool is_even;
  bool has_lines;
  BackTrace::Rule rule;
  const CrowdedEdges* crowds;
};

// The same steps as in BackTrace, each for all lanes. Returns a bit for each trace that is to be
// begun anew, with care, and leaves its `best` as it was.
template <std::size_t kWide, bool kOriented, bool kEven, bool kSeveralSources>
GEODESIC_LANES_INLINE std::uint32_t trace(const Task& task, TraceLanes& traces) {
  using Lanes = lanes::Lanes<kWide>;
  constexpr std::size_t kParts = TraceLanes::kLanes / kWide;
  const auto& [faces, distances, is_oriented, is_even, has_lines, rule, crowds] = task;
  const std::size_t parts = (traces.count + kWide - 1) / kWide;
  TraceLaneState<kWide> states[kParts];
  std::size_t part_of[kParts];
  for (std::size_t part = 0; part < parts; ++part) {
    begin_traces<kWide, kSeveralSources>(faces, distances, traces, part * kWide, has_lines,
                                         states[part]);
    if ((traces.elsewhere >> (part * kWide)) != 0) {
      begin_traces_elsewhere<kWide, kSeveralSources>(faces, distances, traces, part * kWide,
                                                     states[part]);
    }
    part_of[part] = part;
  }
  // Near all of them, then far those with an unsure one among them.
  std::size_t count = parts;
  int step = 0;
  for (const auto reach : {BackTrace::Reach::near, BackTrace::Reach::far}) {
    Ahead<kWide> ahead{};
    for (const int most = BackTrace::most_faces(rule, reach); step < most; ++step) {
      typename Lanes::Flags going = {};
      for (std::size_t i = 0; i < count; ++i) {
        TraceLaneState<kWide>& s = states[part_of[i]];
        look_ahead<kWide, kOriented, kSeveralSources>(faces, distances, crowds, has_lines, s,
                                                      ahead);
        unfold<kWide, kOriented, kEven>(ahead, s, going);
        // While the other parts have their turn.
        for (std::size_t j = 0; j < kWide; ++j) __builtin_prefetch(&faces[s.across[j] >> 2U]);
      }
      if (!Lanes::any(going)) break;
    }
    std::size_t unsure_parts = 0;
    for (std::size_t i = 0; i < count; ++i) {
      TraceLaneState<kWide>& s = states[part_of[i]];
      typename Lanes::Flags unsure;
      meet_circles<kWide, kOriented, kSeveralSources>(faces, distances, rule.candidates, reach, s,
                                                      unsure);
      s.alive &= unsure;
      if (Lanes::any(s.alive)) part_of[unsure_parts++] = part_of[i];
    }
    count = unsure_parts;
    if (count == 0) break;
  }
  std::uint32_t wide = 0;
  for (std::size_t part = 0; part < parts; ++part) {
    TraceLaneState<kWide>& s = states[part];
    if constexpr (kEven) {
      std::memcpy(traces.best.data() + part * kWide, &s.best, sizeof s.best);
      continue;
    }
    const typename Lanes::Flags is_wide = (s.farthest2 * s.finest > tolerance::kMostSpread2) |
                                          ~(s.farthest2 <= tolerance::kMostSpread2 * s.start2);
    if (Lanes::any(is_wide)) {
      for (std::size_t i = 0; i < kWide; ++i) {
        if (is_wide[i] == 0) continue;
        wide |= 1U << (part * kWide + i);
        s.best[i] = traces.best[part * kWide + i];
      }
    }
    std::memcpy(traces.best.data() + part * kWide, &s.best, sizeof s.best);
  }
  return wide;
}

template <std::size_t kWide, bool kSeveralSources>
GEODESIC_LANES_INLINE std::uint32_t trace_on(const Task& task, TraceLanes& traces) {
  if (task.is_oriented) {
    return task.is_even ? trace<kWide, true, true, kSeveralSources>(task, traces)
                        : trace<kWide, true, false, kSeveralSources>(task, traces);
  }
  return task.is_even ? trace<kWide, false, true, kSeveralSources>(task, traces)
                      : trace<kWide, false, false, kSeveralSources>(task, traces);
}

template <std::size_t kWide>
GEODESIC_LANES_INLINE std::uint32_t trace_any(const Task& task, TraceLanes& traces) {
  return task.distances.has_several_sources() ? trace_on<kWide, true>(task, traces)
                                              : trace_on<kWide, false>(task, traces);
}

std::uint32_t trace_plain(const Task& task, TraceLanes& traces) {
  return trace_any<lanes::kPlain>(task, traces);
}

#ifdef __x86_64__
__attribute__((target("avx2"))) std::uint32_t trace_avx2(const Task& task, TraceLanes& traces) {
  return trace_any<lanes::kWithAvx2>(task, traces);
}

__attribute__((target("avx512f,avx512vl,avx512dq"))) std::uint32_t trace_avx512(
    const Task& task, TraceLanes& traces) {
  return trace_any<lanes::kWithAvx2>(task, traces);
}
#endif

}  // namespace

void trace_lanes(const Triangulation& surface, const FrontDistances& distances,
                 BackTrace::Rule rule, Vectors vectors, TraceLanes& traces,
                 const CrowdedEdges* crowds) {
  const Task task{surface.faces.data(),
                  distances,
                  surface.is_oriented,
                  surface.is_even,
                  surface.has_lines,
                  rule,
                  crowds};
  std::uint32_t wide = 0;
#ifdef __x86_64__
  if (vectors == Vectors::avx512) {
    wide = trace_avx512(task, traces);
  } else if (vectors == Vectors::avx2) {
    wide = trace_avx2(task, traces);
  } else {
    wide = trace_plain(task, traces);
  }
#else
  (void)vectors;
  wide = trace_plain(task, traces);
#endif
  if (wide == 0) [[likely]]
    return;
  for (std::size_t i = 0; i < traces.count; ++i) {
    if (((wide >> i) & 1U) == 0) continue;
    const BackTrace one(surface, distances, rule, crowds, traces.source[i]);
    double& best = traces.best[i];
    best = traces.begins_elsewhere(i) ? one.least(traces.start[i], best)
                                      : one.over(traces.base[i], traces.crossing[i], best);
  }
}

}  // namespace geodesic
