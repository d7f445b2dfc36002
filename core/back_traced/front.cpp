#include "core/back_traced/front.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "core/back_traced/arrive_lanes.h"
#include "core/base/lane_arithmetic.h"
#include "core/base/sort_few.h"

namespace geodesic {
namespace {

// Where a mesh is much finer than elsewhere, a bucket holds more than one front's worth
// of vertices: those farther than the least by more than this part of their face's
// shortest side are left for another round, so many times.
constexpr double kEarly = 0.5;
constexpr int kMostRoundsInBucket = 256;

// Corners at a vertex, but for a few vertices: with as many always, no branch depends on
// how many there are, which nobody could predict.
constexpr std::size_t kMostCorners = 8;

// A traced distance above its estimate by more than this part of the base edge: the
// estimate was of two sources, or the trace took the wrong side of something.
constexpr double kSuspicious = 0.02;

// At corner c, the side to the nearer of the other two corners, and the farther one: at
// [2c + 1] where the next corner is nearer than the previous one, else at [2c].
constexpr std::array<std::uint8_t, 6> kNearerSide{2, 0, 0, 1, 1, 2};
constexpr std::array<std::uint8_t, 6> kFartherCorner{1, 2, 2, 0, 0, 1};

}  // namespace

// Estimates and distances differ by at most the longest side between neighbours. So a vertex is
// accepted before all that are farther by more than twice that.
double BackTracedFront::lag() {
  if (lag_ < kUnreached) return lag_;
  double longest2 = 0;
  for (const FaceRecord& face : surface_.faces) {
    for (std::uint32_t c = 0; c < 3; ++c) longest2 = std::max(longest2, face.length2(c));
  }
  lag_ = 2 * std::sqrt(longest2);
  return lag_;
}

void BackTracedFront::see(std::uint32_t vertex, double straight) {
  if (!(straight < distance_[vertex])) return;
  distance_[vertex] = straight;
  if (surface_.is_crowded) scratch_.crowds.tell(surface_, vertex, straight);
  lower(vertex, straight, kNone, 0);
}

// Inlined by force: it is most of what spreading does.
__attribute__((always_inline)) inline void BackTracedFront::lower(std::uint32_t vertex,
                                                                  double estimate, Halfedge base,
                                                                  float crossing) {
  FrontVertex& known = scratch_.vertices[vertex];
  const double before = std::abs(known.estimate);
  if (!(estimate < before + least_gain_)) return;
  // Visible from the source, but for those that go on past it, it has its base all the same.
  if (known.base == kNone && base != kNone && before < kUnreached) {
    known.base = base;
    known.crossing = crossing;
  }
  if (known.is_accepted()) {
    // Within a bucket it may have been too early.
    if (!(estimate < before - least_gain_) || !scratch_.waiting.is_now(before)) return;
    known = {estimate, base, crossing};
    scratch_.waiting.push_back(vertex);
    return;
  }
  if (!(estimate < before)) return;
  known = {estimate, base, crossing};
  scratch_.waiting.push(vertex, estimate, before);
}

bool BackTracedFront::accept_next(double last) {
  scratch_.round.clear();
  while (scratch_.round.empty()) {
    if (scratch_.waiting.empty()) return false;
    if (last < kUnreached && scratch_.waiting.is_beyond(last)) return false;
    take_round();
  }
  trace_round();
  ask_other_faces();
  // Only now, so that no result depends on which vertices were traced together.
  for (std::size_t i = 0; i < scratch_.round.size(); ++i) {
    const std::uint32_t v = scratch_.round[i];
    distance_[v] = scratch_.best[i];
    if (surface_.is_crowded) scratch_.crowds.tell(surface_, v, scratch_.best[i]);
    scratch_.vertices[v].estimate *= -1;
  }
  return true;
}

void BackTracedFront::take_round() {
  std::vector<std::uint32_t>& round = scratch_.round;
  scratch_.waiting.take(round);
  double least = kUnreached;
  std::size_t count = 0;
  for (const std::uint32_t v : round) {
    const FrontVertex& known = scratch_.vertices[v];
    if (known.is_accepted()) continue;
    round[count++] = v;
    least = std::min(least, known.estimate);
    __builtin_prefetch(&surface_.corner_begin[v]);
    if (known.base != kNone) __builtin_prefetch(&surface_.faces[face_of(known.base)]);
  }
  round.resize(count);
  count = 0;
  for (const std::uint32_t v : round) {
    if (is_early(v, least)) {
      scratch_.waiting.push_back(v);
      continue;
    }
    round[count++] = v;
    __builtin_prefetch(surface_.corners(v).data());
  }
  rounds_in_bucket_ = count < round.size() ? rounds_in_bucket_ + 1 : 0;
  round.resize(count);
  // So that nothing depends on the order in which they came to wait, and because what is
  // near in number is near in memory.
  sort_few(round);
}

// Whether one of those to be accepted may yet have a say in the estimate of the vertex.
bool BackTracedFront::is_early(std::uint32_t vertex, double least) const {
  const FrontVertex& known = scratch_.vertices[vertex];
  if (known.base == kNone || rounds_in_bucket_ == kMostRoundsInBucket) return false;
  const double after = known.estimate - least;
  return after * after > kEarly * kEarly * surface_.faces[face_of(known.base)].shortest2();
}

void BackTracedFront::trace_round() {
  const std::vector<std::uint32_t>& round = scratch_.round;
  scratch_.best.resize(round.size());
  const std::size_t at_once = std::min(kMostCorners, surface_.all_corners.size());
  for (std::uint32_t i = 0; i < round.size(); ++i) {
    if (poll_.cancelled()) break;
    // For the spread: a few at a time, for many at once would have to queue.
    const std::size_t begin = std::min<std::size_t>(surface_.corner_begin[round[i]],
                                                    surface_.all_corners.size() - at_once);
    for (const std::uint32_t corner : surface_.all_corners.subspan(begin, at_once)) {
      __builtin_prefetch(&surface_.faces[face_of(corner)]);
    }
    const FrontVertex& known = scratch_.vertices[round[i]];
    double& best = scratch_.best[i];
    best = distance_[round[i]];
    if (known.base == kNone) continue;  // straight from the source
    const bool bends_at_tail = known.crossing == ArrivalLanes::kBendsAtTail;
    if (!bends_at_tail && known.crossing != ArrivalLanes::kBendsAtHead) {
      trace(i, known.base, known.crossing, best);
      continue;
    }
    const FaceRecord& face = surface_.faces[face_of(known.base)];
    const std::uint32_t c = corner_of(known.base);
    const std::uint32_t n = next_corner(c);
    const auto length = [&](std::uint32_t side) {
      return surface_.is_even ? std::sqrt(std::max(face.length2(side), 0.0))
                              : side_not_below(face, side);
    };
    const double by_tail = distance_[face.vertex[c]] + length(previous_corner(c));
    const double by_head = distance_[face.vertex[n]] + length(n);
    best = std::min({best, by_tail, by_head});
    // At a pinched vertex only one end may have a distance.
    if (!(std::max(by_tail, by_head) < kUnreached)) continue;
    trace_past_vertex(i, face.vertex[bends_at_tail ? c : n]);
  }
  flush_traces();
}

// Adds a trace for the vertex at `place` of the round. It ends early where it cannot be less than
// `best`. The caller gives `best`, because the round's own value depends on which other traces of
// the vertex are done.
void BackTracedFront::trace(std::uint32_t place, Halfedge base, double crossing, double best) {
  traced_[traces_.add(base, crossing, best)] = place;
  if (traces_.full()) flush_traces();
}

void BackTracedFront::trace(std::uint32_t place, const TraceStart& start, double best) {
  traced_[traces_.add(start, best)] = place;
  if (traces_.full()) flush_traces();
}

void BackTracedFront::flush_traces() {
  if (traces_.count == 0) return;
  trace_lanes(surface_, distance_, candidates_, vectors_, traces_, &scratch_.crowds);
  for (std::size_t i = 0; i < traces_.count; ++i) {
    double& best = scratch_.best[traced_[i]];
    best = std::min(best, traces_.best[i]);
  }
  traces_.clear();
}

// A distance above what the front expected needs a second look: every other face whose
// ends promise a shorter way is asked.
void BackTracedFront::ask_other_faces() {
  const std::vector<std::uint32_t>& round = scratch_.round;
  std::vector<Halfedge>& bases = scratch_.bases;
  std::vector<BackTracedScratch::Ask>& asks = scratch_.asks;
  bases.clear();
  asks.clear();
  for (std::uint32_t i = 0; i < round.size(); ++i) {
    if (!is_doubtful(round[i], scratch_.best[i])) continue;
    for (const std::uint32_t corner : surface_.corners(round[i])) {
      if (poll_.cancelled()) break;
      const std::uint32_t n = next_corner(corner_of(corner));
      const Halfedge base = halfedge(face_of(corner), n);
      const FaceRecord& face = surface_.faces[face_of(corner)];
      if (base == scratch_.vertices[round[i]].base) continue;
      if (!(distance_[face.vertex[n]] + distance_[face.vertex[next_corner(n)]] < kUnreached))
        continue;
      bases.push_back(base);
      asks.push_back({i, scratch_.best[i]});
    }
  }
  arrive_over_bases(bases.size(), [&](std::size_t at, double distance, float crossing) {
    const bool straight = crossing >= 0 && crossing <= 1;
    const auto [place, best] = asks[at];
    if (straight && distance < best) trace(place, bases[at], crossing, best);
  });
  flush_traces();
}

bool BackTracedFront::is_doubtful(std::uint32_t vertex, double best) const {
  const FrontVertex& known = scratch_.vertices[vertex];
  if (known.base == kNone) return false;
  const double base2 = surface_.faces[face_of(known.base)].length2(corner_of(known.base));
  const double above = best - known.estimate;
  return above > 0 && above * above > kSuspicious * kSuspicious * base2;
}

template <class Tell>
void BackTracedFront::arrive_over_bases(std::size_t count, Tell tell) {
  if (count == 0) return;
  constexpr std::size_t kLanes = ArrivalLanes::kLanes;
  std::vector<Halfedge>& bases = scratch_.bases;
  // Lanes without one of their own do the same as the first, with nobody to see it.
  bases.resize((count + kLanes - 1) / kLanes * kLanes, bases[0]);
  std::fill(bases.begin() + static_cast<std::ptrdiff_t>(count), bases.end(), bases[0]);
  ArrivalLanes arrivals;
  for (std::size_t first = 0; first < count; first += kLanes) {
    if (poll_.cancelled()) return;
    arrive_lanes(surface_.faces, distance_,
                 std::span<const Halfedge, kLanes>(bases.data() + first, kLanes), vectors_,
                 arrivals);
    for (std::size_t i = 0; i < kLanes && first + i < count; ++i) {
      tell(first + i, arrivals.distance[i], arrivals.crossing[i]);
    }
  }
}

void BackTracedFront::spread() {
  for (const std::uint32_t v : scratch_.round) {
    if (adjacency_.is_pinched(v)) spread_along_edges(v);
  }
  const std::size_t corners = list_corners();
  std::vector<Halfedge>& bases = scratch_.bases;
  bases.resize(corners + ArrivalLanes::kLanes);
  const FaceRecord* const faces = surface_.faces.data();
  const double* const distance = distance_.data();
  const FrontVertex* const vertices = scratch_.vertices.data();
  Halfedge* next = bases.data();
  for (std::size_t i = 0; i < corners; ++i) {
    const std::uint32_t corner = scratch_.corners[i];
    const FaceRecord& face = faces[face_of(corner)];
    const std::uint32_t c = corner_of(corner);
    const double own = distance[face.vertex[c]];
    const double at_ahead = distance[face.vertex[lanes::kNextCorner[c]]];
    const double at_behind = distance[face.vertex[lanes::kPreviousCorner[c]]];
    const double nearer = std::min(at_ahead, at_behind);
    const double farther = std::max(at_ahead, at_behind);
    // Without a branch, which nobody could predict.
    const std::size_t which = 2 * c + static_cast<std::size_t>(at_ahead < at_behind);
    *next = corner - c + kNearerSide[which];
    __builtin_prefetch(&vertices[face.vertex[kFartherCorner[which]]]);
    next += static_cast<std::size_t>((nearer < kUnreached) & (own < farther));
  }
  const auto count = static_cast<std::size_t>(next - bases.data());
  arrive_over_bases(count, [&](std::size_t at, double distance, float crossing) {
    lower(opposite(bases[at]), distance, bases[at], crossing);
  });
}

// The corners at the round's vertices, one after the other; how many there are. Behind
// them is what nobody asked for.
std::size_t BackTracedFront::list_corners() {
  std::vector<std::uint32_t>& corners = scratch_.corners;
  const std::span<const std::uint32_t> all = surface_.all_corners;
  std::size_t count = 0;
  for (const std::uint32_t v : scratch_.round) {
    const std::size_t begin = surface_.corner_begin[v];
    const std::size_t at_vertex = surface_.corner_begin[v + 1] - begin;
    const std::size_t room = count + std::max(at_vertex, kMostCorners);
    if (corners.size() < room) corners.resize(2 * room);
    if (at_vertex <= kMostCorners && begin + kMostCorners <= all.size()) [[likely]] {
      std::memcpy(corners.data() + count, all.data() + begin, kMostCorners * sizeof(std::uint32_t));
    } else {
      std::memcpy(corners.data() + count, all.data() + begin, at_vertex * sizeof(std::uint32_t));
    }
    count += at_vertex;
  }
  return count;
}

// Where faces meet in nothing but the vertex, no triangle beyond it has two accepted
// ones.
void BackTracedFront::spread_along_edges(std::uint32_t v) {
  for (const std::uint32_t corner : surface_.corners(v)) {
    const FaceRecord& face = surface_.faces[face_of(corner)];
    const std::uint32_t c = corner_of(corner);
    for (const std::uint32_t side : {c, previous_corner(c)}) {
      const std::uint32_t w = side == c ? next_corner(c) : side;
      const std::uint32_t tail = next_corner(w);
      lower(face.vertex[w], distance_[v] + std::sqrt(std::max(face.length2(side), 0.0)),
            halfedge(face_of(corner), tail),
            tail == c ? ArrivalLanes::kBendsAtTail : ArrivalLanes::kBendsAtHead);
    }
  }
}

void BackTracedFront::forget(std::uint32_t vertex) {
  distance_[vertex] = kUnreached;
  scratch_.vertices[vertex] = {};
}

void BackTracedFront::end() {
  std::vector<std::uint32_t>& left = scratch_.round;
  left.clear();
  while (!scratch_.waiting.empty()) scratch_.waiting.take(left);
  for (const std::uint32_t v : left) {
    if (!scratch_.vertices[v].is_accepted()) forget(v);
  }
  rounds_in_bucket_ = 0;
}

}  // namespace geodesic
