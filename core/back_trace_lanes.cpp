#include "core/back_trace_lanes.h"

#include <cmath>
#include <cstring>

#include "core/field.h"

namespace geodesic {
namespace {

constexpr std::size_t kLanes = TraceLanes::kLanes;

// Arithmetic on four lanes, of GCC and Clang, which cut it into registers of whatever
// size there are. A comparison gives all bits of a lane or none.
constexpr std::size_t kWide = 4;
constexpr std::size_t kParts = kLanes / kWide;
using Reals = double __attribute__((vector_size(kWide * sizeof(double))));
using Flags = std::int64_t __attribute__((vector_size(kWide * sizeof(std::int64_t))));

#define GEODESIC_INLINE inline __attribute__((always_inline))

template <class T>
struct alignas(64) PerLane {
  T of[kLanes];
};

GEODESIC_INLINE void read(Reals& to, const double* from) { std::memcpy(&to, from, sizeof to); }

GEODESIC_INLINE void root(Reals& to, const Reals& of) {
  for (std::size_t i = 0; i < kWide; ++i) to[i] = std::sqrt(of[i]);
}

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

// Of four lanes.
struct State {
  Reals right_x, right_y, left_x, left_y, aim_x, aim_y;
  Reals right_bound_x, right_bound_y, left_bound_x, left_bound_y;
  Reals at_right, at_left, best;
  Flags alive, crossed;
};

// The faces that the traces go over next.
struct Ahead {
  PerLane<double> at_apex, along, height, base2;
};

GEODESIC_INLINE void begin(State& s) {
  s.right_bound_x = s.right_x;
  s.right_bound_y = s.right_y;
  s.left_bound_x = s.left_x;
  s.left_bound_y = s.left_y;
  Reals length;
  root(length, s.right_x * s.right_x + s.right_y * s.right_y);
  Reals by = s.at_right + length;
  s.best = by < s.best ? by : s.best;
  root(length, s.left_x * s.left_x + s.left_y * s.left_y);
  by = s.at_left + length;
  s.best = by < s.best ? by : s.best;
  s.crossed = Flags{};
}

// Unfolds the faces ahead over their bases. Says on which side their apexes are.
GEODESIC_INLINE void unfold(const Ahead& ahead, std::size_t first, State& s, Flags& on_left,
                            Flags& on_right) {
  Reals at_apex, along, height, base2;
  read(at_apex, ahead.at_apex.of + first);
  read(along, ahead.along.of + first);
  read(height, ahead.height.of + first);
  read(base2, ahead.base2.of + first);
  const Reals farther = s.at_right < s.at_left ? s.at_left : s.at_right;
  s.alive &= at_apex < farther;
  s.crossed |= s.alive;
  const Reals base_x = s.left_x - s.right_x;
  const Reals base_y = s.left_y - s.right_y;
  const Reals x = along / base2;
  const Reals y = height / base2;
  const Reals apex_x = s.right_x + x * base_x + y * base_y;
  const Reals apex_y = s.right_y + x * base_y + y * -base_x;
  const Flags within_left = apex_x * s.left_bound_y - apex_y * s.left_bound_x >= 0;
  const Flags within_right = s.right_bound_x * apex_y - s.right_bound_y * apex_x >= 0;
  Reals length;
  root(length, apex_x * apex_x + apex_y * apex_y);
  const Reals by = at_apex + length;
  const Flags nearer = s.alive & within_left & within_right & (by < s.best);
  s.best = nearer ? by : s.best;
  const Flags to_left = s.aim_x * apex_y - s.aim_y * apex_x > 0;
  on_left = s.alive & to_left;
  on_right = s.alive & ~to_left;
  const Flags bounds_left = on_left & within_left;
  const Flags bounds_right = on_right & within_right;
  s.left_x = on_left ? apex_x : s.left_x;
  s.left_y = on_left ? apex_y : s.left_y;
  s.at_left = on_left ? at_apex : s.at_left;
  s.left_bound_x = bounds_left ? apex_x : s.left_bound_x;
  s.left_bound_y = bounds_left ? apex_y : s.left_bound_y;
  s.right_x = on_right ? apex_x : s.right_x;
  s.right_y = on_right ? apex_y : s.right_y;
  s.at_right = on_right ? at_apex : s.at_right;
  s.right_bound_x = bounds_right ? apex_x : s.right_bound_x;
  s.right_bound_y = bounds_right ? apex_y : s.right_bound_y;
}

GEODESIC_INLINE void meet_circles(const Flags& beyond_is_surface, State& s) {
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
  const Reals along = sx / square;
  const Reals down = sy / square;
  const Reals x = s.right_x + along * base_x + down * base_y;
  const Reals y = s.right_y + along * base_y + down * -base_x;
  const Flags in_sight = (x * s.left_bound_y - y * s.left_bound_x >= 0) &
                         (s.right_bound_x * y - s.right_bound_y * x >= 0);
  Reals straight;
  root(straight, x * x + y * y);
  const Reals least =
      s.crossed ? BackTrace::kLeastOfBest * s.best : BackTrace::kLeastOverOneFace * s.best;
  const Flags taken =
      beyond_is_surface & meet & in_sight & (straight >= least) & (straight < s.best);
  s.best = taken ? straight : s.best;
}

// The same steps as in BackTrace::least, each for all lanes.
GEODESIC_INLINE void trace(const FaceRecord* faces, const double* distance, BackTrace::Takes takes,
                           TraceLanes& lanes) {
  // Lanes without a trace do the same in the first face, with nobody to see it.
  PerLane<double> at_right{};
  PerLane<double> at_left{};
  PerLane<std::int64_t> alive{};
  PerLane<std::int64_t> beyond_is_surface{};
  for (std::size_t i = 0; i < lanes.count; ++i) {
    at_right.of[i] = distance[lanes.right[i]];
    at_left.of[i] = distance[lanes.left[i]];
    alive.of[i] = -1;
    beyond_is_surface.of[i] = -1;
  }
  State states[kParts];
  for (std::size_t part = 0; part < kParts; ++part) {
    const std::size_t first = part * kWide;
    State& s = states[part];
    read(s.right_x, lanes.right_x.data() + first);
    read(s.right_y, lanes.right_y.data() + first);
    read(s.left_x, lanes.left_x.data() + first);
    read(s.left_y, lanes.left_y.data() + first);
    read(s.aim_x, lanes.aim_x.data() + first);
    read(s.aim_y, lanes.aim_y.data() + first);
    read(s.best, lanes.best.data() + first);
    read(s.at_right, at_right.of + first);
    read(s.at_left, at_left.of + first);
    std::memcpy(&s.alive, alive.of + first, sizeof s.alive);
    begin(s);
  }

  std::array<Halfedge, kLanes> edge = lanes.edge;
  std::array<std::uint32_t, kLanes> right_vertex = lanes.right;
  std::array<Halfedge, kLanes> edge_on_left{};
  std::array<Halfedge, kLanes> edge_on_right{};
  std::array<std::uint32_t, kLanes> apex_vertex{};
  Ahead ahead{};
  for (int step = 0; step < BackTrace::most_faces(takes); ++step) {
    for (std::size_t i = 0; i < lanes.count; ++i) {
      // A lane at its end goes on with what it last read, to no effect.
      if (alive.of[i] == 0) continue;
      Halfedge across = faces[face_of(edge[i])].ring[corner_of(edge[i])];
      const FaceRecord* face = &faces[face_of(across)];
      if (across == edge[i]) {
        beyond_is_surface.of[i] = 0;
        ahead.at_apex.of[i] = kUnreached;
        continue;
      }
      if (face->ring[corner_of(across)] != edge[i]) {
        across = nearest_beyond(faces, distance, edge[i]);
        face = &faces[face_of(across)];
      }
      const std::uint32_t c = corner_of(across);
      const std::uint32_t n = next_corner(c);
      const std::uint32_t apex = previous_corner(c);
      apex_vertex[i] = face->vertex[apex];
      ahead.at_apex.of[i] = distance[apex_vertex[i]];
      const bool forward = face->vertex[c] == right_vertex[i];
      ahead.base2.of[i] = face->dot[c] + face->dot[n];
      ahead.along.of[i] = face->dot[forward ? c : n];
      ahead.height.of[i] = face->area2;
      edge_on_left[i] = halfedge(face_of(across), forward ? apex : n);
      edge_on_right[i] = halfedge(face_of(across), forward ? n : apex);
    }
    PerLane<std::int64_t> on_left;
    PerLane<std::int64_t> on_right;
    for (std::size_t part = 0; part < kParts; ++part) {
      Flags left;
      Flags right;
      unfold(ahead, part * kWide, states[part], left, right);
      std::memcpy(on_left.of + part * kWide, &left, sizeof left);
      std::memcpy(on_right.of + part * kWide, &right, sizeof right);
    }
    std::int64_t any = 0;
    for (std::size_t i = 0; i < kLanes; ++i) {
      alive.of[i] = on_left.of[i] | on_right.of[i];
      any |= alive.of[i];
      const auto left = static_cast<std::uint32_t>(on_left.of[i]);
      const auto right = static_cast<std::uint32_t>(on_right.of[i]);
      edge[i] = (edge_on_left[i] & left) | (edge_on_right[i] & right) | (edge[i] & ~(left | right));
      right_vertex[i] = (apex_vertex[i] & right) | (right_vertex[i] & ~right);
    }
    if (any == 0) break;
    for (std::size_t i = 0; i < lanes.count; ++i) {
      __builtin_prefetch(&faces[face_of(faces[face_of(edge[i])].ring[corner_of(edge[i])])]);
    }
  }
  for (std::size_t part = 0; part < kParts; ++part) {
    Flags surface;
    std::memcpy(&surface, beyond_is_surface.of + part * kWide, sizeof surface);
    if (takes == BackTrace::Takes::virtual_sources) meet_circles(surface, states[part]);
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

Vectors best_vectors() {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512dq")) {
    return Vectors::avx512;
  }
  if (__builtin_cpu_supports("avx2")) return Vectors::avx2;
#endif
  return Vectors::plain;
}

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
