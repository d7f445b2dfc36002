#include "core/arrive_lanes.h"

#include <cstring>

#include "core/lane_arithmetic.h"

namespace geodesic {
namespace {

using lanes::Flags;
using lanes::Floats;
using lanes::kWide;
using lanes::Reals;
using lanes::root;

struct Base {
  const FaceRecord& face;
  std::uint32_t p, q, w;  // corners
};

GEODESIC_LANES_INLINE Base base_of(const FaceRecord* faces, Halfedge h) {
  const std::uint32_t c = corner_of(h);
  return {faces[face_of(h)], c, lanes::kNextCorner[c], lanes::kPreviousCorner[c]};
}

// The steps of arrive(), with a choice between lanes where that has a branch.
GEODESIC_LANES_INLINE void arrive_four(const FaceRecord* faces, const double* distance,
                                       const Halfedge* bases, double* to_distance,
                                       float* to_crossing) {
  const Base b0 = base_of(faces, bases[0]);
  const Base b1 = base_of(faces, bases[1]);
  const Base b2 = base_of(faces, bases[2]);
  const Base b3 = base_of(faces, bases[3]);
  const Reals p = {b0.face.dot[b0.p], b1.face.dot[b1.p], b2.face.dot[b2.p], b3.face.dot[b3.p]};
  const Reals q = {b0.face.dot[b0.q], b1.face.dot[b1.q], b2.face.dot[b2.q], b3.face.dot[b3.q]};
  const Reals w = {b0.face.dot[b0.w], b1.face.dot[b1.w], b2.face.dot[b2.w], b3.face.dot[b3.w]};
  const Reals height = {b0.face.area2, b1.face.area2, b2.face.area2, b3.face.area2};
  const Reals dp = {distance[b0.face.vertex[b0.p]], distance[b1.face.vertex[b1.p]],
                    distance[b2.face.vertex[b2.p]], distance[b3.face.vertex[b3.p]]};
  const Reals dq = {distance[b0.face.vertex[b0.q]], distance[b1.face.vertex[b1.q]],
                    distance[b2.face.vertex[b2.q]], distance[b3.face.vertex[b3.q]]};
  const Reals zero = {};
  const Reals one = zero + 1;
  const Reals base2 = p + q;
  const Reals sum = dp + dq;
  const Reals difference = dp - dq;
  const Reals sx = 0.5 * (base2 + difference * sum);
  Reals sy2 = 0.25 * (sum * sum - base2) * (base2 - difference * difference);
  sy2 = sy2 > 0 ? sy2 : zero;
  Reals sy;
  root(sy, sy2);
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
  square = at_q ? (to_q2 > 0 ? to_q2 : zero) : square;
  square = at_p ? (to_p2 > 0 ? to_p2 : zero) : square;
  Reals d;
  root(d, square);
  d = (at_p ? dp : at_q ? dq : zero) + d;
  Reals flat = sx / base2;
  flat = flat < 0 ? zero : flat;
  flat = flat > 1 ? one : flat;
  Reals crossing = rise > 0 ? meets / whole : flat;
  crossing = at_p ? zero + ArrivalLanes::kBendsAtTail : crossing;
  crossing = at_q ? zero + ArrivalLanes::kBendsAtHead : crossing;
  const Floats rounded = __builtin_convertvector(crossing, Floats);
  std::memcpy(to_distance, &d, sizeof d);
  std::memcpy(to_crossing, &rounded, sizeof rounded);
}

GEODESIC_LANES_INLINE void arrive_all(const FaceRecord* faces, const double* distance,
                                      const Halfedge* bases, ArrivalLanes& to) {
  for (std::size_t i = 0; i < ArrivalLanes::kLanes; i += kWide) {
    arrive_four(faces, distance, bases + i, to.distance.data() + i, to.crossing.data() + i);
  }
}

void arrive_plain(const FaceRecord* faces, const double* distance, const Halfedge* bases,
                  ArrivalLanes& to) {
  arrive_all(faces, distance, bases, to);
}

#ifdef __x86_64__
__attribute__((target("avx2"))) void arrive_avx2(const FaceRecord* faces, const double* distance,
                                                 const Halfedge* bases, ArrivalLanes& to) {
  arrive_all(faces, distance, bases, to);
}

__attribute__((target("avx512f,avx512vl,avx512dq"))) void arrive_avx512(const FaceRecord* faces,
                                                                        const double* distance,
                                                                        const Halfedge* bases,
                                                                        ArrivalLanes& to) {
  arrive_all(faces, distance, bases, to);
}
#endif

}  // namespace

void arrive_lanes(std::span<const FaceRecord> faces, std::span<const double> distance,
                  std::span<const Halfedge, ArrivalLanes::kLanes> bases, Vectors vectors,
                  ArrivalLanes& to) {
#ifdef __x86_64__
  if (vectors == Vectors::avx512) {
    return arrive_avx512(faces.data(), distance.data(), bases.data(), to);
  }
  if (vectors == Vectors::avx2) {
    return arrive_avx2(faces.data(), distance.data(), bases.data(), to);
  }
#endif
  (void)vectors;
  arrive_plain(faces.data(), distance.data(), bases.data(), to);
}

}  // namespace geodesic
