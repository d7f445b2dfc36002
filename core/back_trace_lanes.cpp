#include "core/back_trace_lanes.h"

#include <cstring>

#include "core/field.h"
#include "core/lane_arithmetic.h"

namespace geodesic {
namespace {

using lanes::any;
using lanes::Flags;
using lanes::Ids;
using lanes::kWide;
using lanes::narrow;
using lanes::Reals;
using lanes::root;

constexpr std::size_t kMostParts = TraceLanes::kLanes / kWide;

// Of several faces on an edge the one whose apex is nearest to the source.
Halfedge nearest_beyond(const FaceRecord* faces, const double* distance, Halfedge edge) {
  const auto ring = [faces](Halfedge h) { return faces[face_of(h)].ring[corner_of(h)]; };
  const auto at_apex = [&](Halfedge h) {
    return distance[faces[face_of(h)].vertex[previous_corner(corner_of(h))]];
  };
  Halfedge nearest = ring(edge);
  for (Halfedge h = ring(nearest); h != edge; h = ring(h)) {
    if (at_apex(h) < at_apex(nearest)) nearest = h;
  }
  return nearest;
}

// Of four lanes; the names are those of BackTrace.
struct State {
  Reals right_x, right_y, left_x, left_y;
  Reals right_bound_x, right_bound_y, left_bound_x, left_bound_y;
  Reals at_right, at_left, best;
  Flags alive, crossed, beyond_is_surface;
  Ids edge, across, right_vertex;
};

GEODESIC_LANES_INLINE void begin(const FaceRecord* faces, const double* distance,
                                 const TraceLanes& lanes, std::size_t first, State& s) {
  Reals p, q, w, area, crossing;
  for (std::size_t j = 0; j < kWide; ++j) {
    // Lanes without a trace do the same as the first one, with nobody to see it.
    const std::size_t i = first + j < lanes.count ? first + j : 0;
    const Halfedge base = lanes.base[i];
    const FaceRecord& face = faces[face_of(base)];
    const std::uint32_t c = corner_of(base);
    const std::uint32_t n = next_corner(c);
    p[j] = face.dot[c];
    q[j] = face.dot[n];
    w[j] = face.dot[previous_corner(c)];
    area[j] = face.area2;
    s.at_right[j] = distance[face.vertex[c]];
    s.at_left[j] = distance[face.vertex[n]];
    s.right_vertex[j] = face.vertex[c];
    s.edge[j] = base;
    s.across[j] = face.ring[c];
    s.beyond_is_surface[j] = face.ring[c] == base ? 0 : -1;
    crossing[j] = lanes.crossing[i];
    s.best[j] = lanes.best[i];
    __builtin_prefetch(&faces[face_of(face.ring[c])]);
  }
  const Reals zero = {};
  Reals length;
  const Reals right2 = p + w;
  root(length, right2 > 0 ? right2 : zero);
  Reals by = s.at_right + length;
  s.best = by < s.best ? by : s.best;
  const Reals left2 = q + w;
  root(length, left2 > 0 ? left2 : zero);
  by = s.at_left + length;
  s.best = by < s.best ? by : s.best;

  const Reals base2 = p + q;
  const Reals across = crossing * base2;
  const Reals along = across - p;
  Reals base_length;
  root(length, along * along + area * area);
  root(base_length, base2);
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
  s.beyond_is_surface &= s.alive;
  s.crossed = Flags{};
}

// What is read of the faces that four traces go over next.
struct Ahead {
  Reals dot, next_dot, area, at_apex;
  Ids back, vertex, apex;        // who is across; at the halfedge's tail, and opposite it
  Ids next, previous;            // the other two halfedges …
  Ids over_next, over_previous;  // … and who is across those
};

GEODESIC_LANES_INLINE void read(const FaceRecord* faces, const double* distance, const Ids& across,
                                Ahead& to) {
  const Halfedge h0 = across[0], h1 = across[1], h2 = across[2], h3 = across[3];
  const FaceRecord& f0 = faces[face_of(h0)];
  const FaceRecord& f1 = faces[face_of(h1)];
  const FaceRecord& f2 = faces[face_of(h2)];
  const FaceRecord& f3 = faces[face_of(h3)];
  const std::uint32_t c0 = corner_of(h0), c1 = corner_of(h1), c2 = corner_of(h2),
                      c3 = corner_of(h3);
  const std::uint32_t n0 = lanes::kNextCorner[c0], n1 = lanes::kNextCorner[c1],
                      n2 = lanes::kNextCorner[c2], n3 = lanes::kNextCorner[c3];
  const std::uint32_t p0 = lanes::kPreviousCorner[c0], p1 = lanes::kPreviousCorner[c1],
                      p2 = lanes::kPreviousCorner[c2], p3 = lanes::kPreviousCorner[c3];
  const std::uint32_t a0 = f0.vertex[p0], a1 = f1.vertex[p1], a2 = f2.vertex[p2],
                      a3 = f3.vertex[p3];
  to.dot = Reals{f0.dot[c0], f1.dot[c1], f2.dot[c2], f3.dot[c3]};
  to.next_dot = Reals{f0.dot[n0], f1.dot[n1], f2.dot[n2], f3.dot[n3]};
  to.area = Reals{f0.area2, f1.area2, f2.area2, f3.area2};
  to.at_apex = Reals{distance[a0], distance[a1], distance[a2], distance[a3]};
  to.apex = Ids{a0, a1, a2, a3};
  to.vertex = Ids{f0.vertex[c0], f1.vertex[c1], f2.vertex[c2], f3.vertex[c3]};
  to.back = Ids{f0.ring[c0], f1.ring[c1], f2.ring[c2], f3.ring[c3]};
  to.over_next = Ids{f0.ring[n0], f1.ring[n1], f2.ring[n2], f3.ring[n3]};
  to.over_previous = Ids{f0.ring[p0], f1.ring[p1], f2.ring[p2], f3.ring[p3]};
  const Ids first = across & ~3U;
  to.next = first + Ids{n0, n1, n2, n3};
  to.previous = first + Ids{p0, p1, p2, p3};
}

// The next faces of four traces. Where there are more than two on an edge, the nearest.
GEODESIC_LANES_INLINE void look_ahead(const FaceRecord* faces, const double* distance, State& s,
                                      Ahead& ahead) {
  read(faces, distance, s.across, ahead);
  const Ids others = (Ids)(ahead.back != s.edge);
  if ((others[0] | others[1] | others[2] | others[3]) != 0) [[unlikely]] {
    for (std::size_t j = 0; j < kWide; ++j) {
      if (others[j] != 0) s.across[j] = nearest_beyond(faces, distance, s.edge[j]);
    }
    read(faces, distance, s.across, ahead);
  }
}

// Unfolds the faces ahead over their bases, and goes on to the edges beyond. Adds to
// `going` which of the traces do.
GEODESIC_LANES_INLINE void unfold(const Ahead& ahead, State& s, Flags& going) {
  const Reals farther = s.at_right < s.at_left ? s.at_left : s.at_right;
  s.alive &= s.beyond_is_surface & (ahead.at_apex < farther);
  s.crossed |= s.alive;
  const Ids forward = (Ids)(ahead.vertex == s.right_vertex);
  const Flags is_forward = __builtin_convertvector(ahead.vertex == s.right_vertex, Flags);
  const Reals per_base2 = 1.0 / (ahead.dot + ahead.next_dot);
  const Reals along = (is_forward ? ahead.dot : ahead.next_dot) * per_base2;
  const Reals height = ahead.area * per_base2;
  const Reals base_x = s.left_x - s.right_x;
  const Reals base_y = s.left_y - s.right_y;
  const Reals x = s.right_x + along * base_x + height * base_y;
  const Reals y = s.right_y + along * base_y - height * base_x;
  const Flags within_left = x * s.left_bound_y - y * s.left_bound_x >= 0;
  const Flags within_right = s.right_bound_x * y - s.right_bound_y * x >= 0;
  Reals length;
  root(length, x * x + y * y);
  const Reals by = ahead.at_apex + length;
  const Flags nearer = s.alive & within_left & within_right & (by < s.best);
  s.best = nearer ? by : s.best;
  const Flags on_left = s.alive & (y > 0);
  const Flags on_right = s.alive & ~(y > 0);
  const Flags bounds_left = on_left & within_left;
  const Flags bounds_right = on_right & within_right;
  s.left_x = on_left ? x : s.left_x;
  s.left_y = on_left ? y : s.left_y;
  s.at_left = on_left ? ahead.at_apex : s.at_left;
  s.left_bound_x = bounds_left ? x : s.left_bound_x;
  s.left_bound_y = bounds_left ? y : s.left_bound_y;
  s.right_x = on_right ? x : s.right_x;
  s.right_y = on_right ? y : s.right_y;
  s.at_right = on_right ? ahead.at_apex : s.at_right;
  s.right_bound_x = bounds_right ? x : s.right_bound_x;
  s.right_bound_y = bounds_right ? y : s.right_bound_y;

  Ids left, right;
  narrow(left, on_left);
  narrow(right, on_right);
  const Ids previous = (left & forward) | (right & ~forward);
  const Ids next = (left & ~forward) | (right & forward);
  const Ids neither = ~(left | right);
  s.edge = (ahead.next & next) | (ahead.previous & previous) | (s.edge & neither);
  s.across = (ahead.over_next & next) | (ahead.over_previous & previous) | (s.across & neither);
  s.right_vertex = (ahead.apex & right) | (s.right_vertex & ~right);
  going |= s.alive;
}

GEODESIC_LANES_INLINE void meet_circles(State& s) {
  const Reals base_x = s.left_x - s.right_x;
  const Reals base_y = s.left_y - s.right_y;
  const Reals square = base_x * base_x + base_y * base_y;
  const Reals sum = s.at_right + s.at_left;
  const Reals difference = s.at_right - s.at_left;
  const Reals sx = 0.5 * (square + difference * sum);
  const Reals sy2 = 0.25 * (sum * sum - square) * (square - difference * difference);
  const Flags meet = sy2 > 0;
  Reals sy;
  root(sy, meet ? sy2 : Reals{});
  const Reals per_base2 = 1.0 / square;
  const Reals along = sx * per_base2;
  const Reals down = sy * per_base2;
  const Reals x = s.right_x + along * base_x + down * base_y;
  const Reals y = s.right_y + along * base_y - down * base_x;
  const Flags in_sight = (x * s.left_bound_y - y * s.left_bound_x >= 0) &
                         (s.right_bound_x * y - s.right_bound_y * x >= 0);
  Reals straight;
  root(straight, x * x + y * y);
  const Reals least =
      s.crossed ? BackTrace::kLeastOfBest * s.best : BackTrace::kLeastOverOneFace * s.best;
  const Flags taken =
      s.beyond_is_surface & meet & in_sight & (straight >= least) & (straight < s.best);
  s.best = taken ? straight : s.best;
}

// The same steps as in BackTrace, each for all lanes.
GEODESIC_LANES_INLINE void trace(const FaceRecord* faces, const double* distance,
                                 BackTrace::Takes takes, TraceLanes& lanes) {
  const std::size_t parts = (lanes.count + kWide - 1) / kWide;
  State states[kMostParts];
  for (std::size_t part = 0; part < parts; ++part) {
    begin(faces, distance, lanes, part * kWide, states[part]);
  }
  Ahead ahead{};
  const int most = BackTrace::most_faces(takes);
  for (int step = 0; step < most; ++step) {
    Flags going = {};
    for (std::size_t part = 0; part < parts; ++part) {
      State& s = states[part];
      look_ahead(faces, distance, s, ahead);
      unfold(ahead, s, going);
      if (step + 1 < most) {
        s.beyond_is_surface &= ~__builtin_convertvector(s.edge == s.across, Flags);
      }
      // While the other parts have their turn.
      for (std::size_t j = 0; j < kWide; ++j) __builtin_prefetch(&faces[face_of(s.across[j])]);
    }
    if (!any(going)) break;
  }
  for (std::size_t part = 0; part < parts; ++part) {
    if (takes == BackTrace::Takes::virtual_sources) meet_circles(states[part]);
    std::memcpy(lanes.best.data() + part * kWide, &states[part].best, sizeof(Reals));
  }
}

void trace_plain(const FaceRecord* faces, const double* distance, BackTrace::Takes takes,
                 TraceLanes& lanes) {
  trace(faces, distance, takes, lanes);
}

#ifdef __x86_64__
__attribute__((target("avx2"))) void trace_avx2(const FaceRecord* faces, const double* distance,
                                                BackTrace::Takes takes, TraceLanes& lanes) {
  trace(faces, distance, takes, lanes);
}

__attribute__((target("avx512f,avx512vl,avx512dq"))) void trace_avx512(const FaceRecord* faces,
                                                                       const double* distance,
                                                                       BackTrace::Takes takes,
                                                                       TraceLanes& lanes) {
  trace(faces, distance, takes, lanes);
}
#endif

}  // namespace

void trace_lanes(const Triangulation& surface, std::span<const double> distance,
                 BackTrace::Takes takes, Vectors vectors, TraceLanes& lanes) {
  const FaceRecord* faces = surface.faces.data();
#ifdef __x86_64__
  if (vectors == Vectors::avx512) {
    return trace_avx512(faces, distance.data(), takes, lanes);
  }
  if (vectors == Vectors::avx2) {
    return trace_avx2(faces, distance.data(), takes, lanes);
  }
#endif
  (void)vectors;
  trace_plain(faces, distance.data(), takes, lanes);
}

}  // namespace geodesic
