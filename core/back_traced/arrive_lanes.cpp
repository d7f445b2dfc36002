#include "core/back_traced/arrive_lanes.h"

#include <cstring>

#include "core/base/lane_arithmetic.h"
#include "core/wavefront/virtual_source.h"

namespace geodesic {
namespace {

// The steps of arrive(), with a choice between lanes where that has a branch.
template <std::size_t kWide, bool kSeveralSources>
GEODESIC_LANES_INLINE void arrive_some(const FaceRecord* faces, const FrontDistances& distances,
                                       const Halfedge* bases, const std::uint32_t* sources,
                                       double* to_distance, float* to_crossing) {
  using Lanes = lanes::Lanes<kWide>;
  using Reals = typename Lanes::Reals;
  using Flags = typename Lanes::Flags;
  const FaceRecord* face[kWide];
  std::uint32_t at_tail[kWide];
  std::uint32_t at_head[kWide];
  std::uint32_t at_apex[kWide];
  for (std::size_t i = 0; i < kWide; ++i) {
    face[i] = &faces[face_of(bases[i])];
    at_tail[i] = corner_of(bases[i]);
    at_head[i] = lanes::kNextCorner[at_tail[i]];
    at_apex[i] = lanes::kPreviousCorner[at_tail[i]];
  }
  Reals p, q, w, height, dp, dq;
  Lanes::gather(p, [&](std::size_t i) { return face[i]->dot[at_tail[i]]; });
  Lanes::gather(q, [&](std::size_t i) { return face[i]->dot[at_head[i]]; });
  Lanes::gather(w, [&](std::size_t i) { return face[i]->dot[at_apex[i]]; });
  Lanes::gather(height, [&](std::size_t i) { return face[i]->area2; });
  const auto distance = [&](std::size_t i, std::uint32_t at) {
    return distances.at<kSeveralSources>(face[i]->vertex[at], kSeveralSources ? sources[i] : 0);
  };
  Lanes::gather(dp, [&](std::size_t i) { return distance(i, at_tail[i]); });
  Lanes::gather(dq, [&](std::size_t i) { return distance(i, at_head[i]); });
  const Reals zero = {};
  const Reals one = zero + 1;
  const Reals base2 = p + q;
  const Reals sum = dp + dq;
  const Reals difference = dp - dq;
  const Reals sx = 0.5 * (base2 + difference * sum);
  Reals sy2 = 0.25 * (sum * sum - base2) * (base2 - difference * difference);
  sy2 = sy2 > 0 ? sy2 : zero;
  Reals sy;
  Lanes::root(sy, sy2);
  const Reals rise = sy + height;
  const Reals meets = sx * height + p * sy;
  const Reals whole = base2 * rise;
  const Flags no_base = ~(base2 > 0);
  const Flags at_p = (meets < 0) | (no_base & (dp <= dq));
  const Flags at_q = ~at_p & ((meets > whole) | no_base);

  const Reals run = p - sx;
  const Reals to_p2 = p + w;
  const Reals to_q2 = q + w;
  Reals square = (run * run + rise * rise) / base2;
  Lanes::choose(square, at_q, to_q2 > 0 ? to_q2 : zero, square);
  Lanes::choose(square, at_p, to_p2 > 0 ? to_p2 : zero, square);
  Reals d;
  Lanes::root(d, square);
  Reals before;
  Lanes::choose(before, at_q, dq, zero);
  Lanes::choose(before, at_p, dp, before);
  d = before + d;
  Reals flat = sx / base2;
  flat = flat < 0 ? zero : flat;
  flat = flat > 1 ? one : flat;
  Reals crossing = rise > 0 ? meets / whole : flat;
  Lanes::choose(crossing, at_p, zero + ArrivalLanes::kBendsAtTail, crossing);
  Lanes::choose(crossing, at_q, zero + ArrivalLanes::kBendsAtHead, crossing);
  std::memcpy(to_distance, &d, sizeof d);
  for (std::size_t i = 0; i < kWide; ++i) to_crossing[i] = static_cast<float>(crossing[i]);
  // Where all of it is on one line.
  const Flags on_line = ~(rise > 0);
  if (!Lanes::any(on_line)) [[likely]]
    return;
  for (std::size_t i = 0; i < kWide; ++i) {
    if (on_line[i] == 0) continue;
    const Arrival arrival = arrive(dp[i], dq[i], face[i]->apex_over(corner_of(bases[i])));
    to_distance[i] = arrival.distance;
    to_crossing[i] = arrival.which == Fig4::b   ? ArrivalLanes::kBendsAtTail
                     : arrival.which == Fig4::c ? ArrivalLanes::kBendsAtHead
                                                : static_cast<float>(arrival.crossing);
  }
}

// What is asked for in one call.
struct Task {
  const FaceRecord* faces;
  FrontDistances distances;
  const Halfedge* bases;
  const std::uint32_t* sources;
};

template <std::size_t kWide>
GEODESIC_LANES_INLINE void arrive_all(const Task& task, ArrivalLanes& to) {
  const auto& [faces, distances, bases, sources] = task;
  for (std::size_t i = 0; i < ArrivalLanes::kLanes; i += kWide) {
    double* const distance = to.distance.data() + i;
    float* const crossing = to.crossing.data() + i;
    if (distances.has_several_sources()) {
      arrive_some<kWide, true>(faces, distances, bases + i, sources + i, distance, crossing);
    } else {
      arrive_some<kWide, false>(faces, distances, bases + i, nullptr, distance, crossing);
    }
  }
}

void arrive_plain(const Task& task, ArrivalLanes& to) { arrive_all<lanes::kPlain>(task, to); }

#ifdef __x86_64__
__attribute__((target("avx2"))) void arrive_avx2(const Task& task, ArrivalLanes& to) {
  arrive_all<lanes::kWithAvx2>(task, to);
}

__attribute__((target("avx512f,avx512vl,avx512dq"))) void arrive_avx512(const Task& task,
                                                                        ArrivalLanes& to) {
  arrive_all<lanes::kWithAvx2>(task, to);
}
#endif

}  // namespace

void arrive_lanes(std::span<const FaceRecord> faces, const FrontDistances& distances,
                  std::span<const Halfedge, ArrivalLanes::kLanes> bases,
                  const std::uint32_t* sources, Vectors vectors, ArrivalLanes& to) {
  const Task task{faces.data(), distances, bases.data(), sources};
#ifdef __x86_64__
  if (vectors == Vectors::avx512) return arrive_avx512(task, to);
  if (vectors == Vectors::avx2) return arrive_avx2(task, to);
#endif
  (void)vectors;
  arrive_plain(task, to);
}

}  // namespace geodesic
