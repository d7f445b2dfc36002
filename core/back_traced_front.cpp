#include "core/back_traced_front.h"

#include <algorithm>

#include "core/vec3.h"
#include "core/virtual_source.h"

namespace geodesic {
namespace {

// Faces that the look around from a source crosses; beyond some hundred vertices the
// front does as well.
constexpr std::size_t kFacesInSight = 2000;

// A traced distance above its estimate by more than this part of the base edge: the
// estimate was of two sources, or the trace took the wrong side of something.
constexpr double kSuspicious = 0.01;

// A front goes on from the distance of a vertex that is behind it by more than this
// part of the edge between; seldom is one so old not settled.
constexpr double kOldEnough = 0.1;

// Faces round a vertex that a bend is unfolded over, before its angle is beyond pi.
constexpr int kMostFacesRound = 12;

// A triangle as seen from one of its corners, the next corner to the right.
struct SeenFrom {
  std::uint32_t right;
  std::uint32_t left;
  Vec2 to_right;
  Vec2 to_left;
};

// Not a number in it when the two corners are at the same place.
SeenFrom seen_from(const FaceRecord& face, std::uint32_t c) {
  const std::uint32_t n = next_corner(c);
  const double length = std::sqrt(std::max(face.length2(c), 0.0));
  return {face.vertex[n],
          face.vertex[previous_corner(c)],
          {length, 0},
          {face.dot[c] / length, face.area2 / length}};
}

}  // namespace

std::vector<std::uint32_t> BackTracedFront::start(const Source& from, std::uint32_t /*number*/) {
  const SurfacePoint& source = from.point;
  const Vec3 at = position_of(adjacency_.mesh(), source);
  const auto places = in_all_faces(adjacency_, source);
  // Only the mesh's own faces say where a point inside one is.
  surface_ = source.at_vertex() ? adjacency_.delaunay() : adjacency_.triangulation();
  std::vector<Wedge>& wedges = scratch_.wedges;
  wedges.clear();
  if (source.at_vertex()) {
    see(source.vertex, 0);
    lower(source.vertex, 0, kNone);
    for (const std::uint32_t corner : surface_.corners(source.vertex)) {
      const std::uint32_t c = corner_of(corner);
      const SeenFrom seen = seen_from(surface_.faces[face_of(corner)], c);
      see(seen.right, seen.to_right.x);
      see(seen.left, norm(seen.to_left));
      wedges.push_back({halfedge(face_of(corner), next_corner(c)), seen.right, seen.to_right,
                        seen.to_left, seen.to_right, seen.to_left});
    }
  }
  for (const SurfacePoint& place : places) {
    const FaceRecord& face = adjacency_.face(place.face);
    if (!source.at_vertex()) {
      stops_.push_back(place.face);
      for (std::uint32_t c = 0; c < 3; ++c) {
        // The triangle of the source and this side: where its ends are, with the source
        // at the origin and the side's direction as the x axis.
        const double base2 = face.length2(c);
        const double height = place.bary[previous_corner(c)] * face.area2;
        if (!(base2 > 0) || !(height > 0)) continue;
        const double base = std::sqrt(base2);
        const double foot =
            place.bary[next_corner(c)] * base2 + place.bary[previous_corner(c)] * face.dot[c];
        const Vec2 tail{-foot / base, -height / base};
        const Vec2 head{(base2 - foot) / base, -height / base};
        wedges.push_back({halfedge(place.face, c), face.vertex[c], tail, head, tail, head});
      }
    }
    for (const std::uint32_t v : face.vertex) {
      see(v, geodesic::distance(at, adjacency_.mesh().positions()[v]));
    }
  }
  std::sort(stops_.begin(), stops_.end());
  // In the first faces only: from here on the wave considers more.
  for (const std::uint32_t v : in_sight_) lower(v, distance_[v], kNone);
  look_around(surface_, wedges, kFacesInSight,
              [this](std::uint32_t v, double straight) { see(v, straight); });
  return {};
}

// The estimate of a vertex and its distance are both within an edge of those of its
// neighbours.
double BackTracedFront::lag() const {
  double longest2 = 0;
  for (const FaceRecord& face : surface_.faces) {
    for (std::uint32_t c = 0; c < 3; ++c) longest2 = std::max(longest2, face.length2(c));
  }
  return 2 * std::sqrt(longest2);
}

void BackTracedFront::see(std::uint32_t vertex, double straight) {
  if (!(straight < distance_[vertex])) return;
  if (distance_[vertex] == kUnreached) in_sight_.push_back(vertex);
  distance_[vertex] = straight;
}

void BackTracedFront::lower(std::uint32_t vertex, double estimate, Halfedge base) {
  if (!(estimate < scratch_.estimate[vertex])) return;
  scratch_.estimate[vertex] = estimate;
  scratch_.base[vertex] = base;
  scratch_.heap.push_or_lower(vertex, estimate);
}

void BackTracedFront::spread_from(std::uint32_t v) {
  if (adjacency_.is_pinched(v)) spread_along_edges(v);
  for (const std::uint32_t corner : surface_.corners(v)) {
    const std::uint32_t c = corner_of(corner);
    const FaceRecord& face = surface_.faces[face_of(corner)];
    const std::uint32_t ahead = face.vertex[next_corner(c)];
    const std::uint32_t behind = face.vertex[previous_corner(c)];
    const bool ahead_accepted = scratch_.heap.accepted(ahead);
    if (ahead_accepted == scratch_.heap.accepted(behind)) continue;
    const std::uint32_t base = ahead_accepted ? c : previous_corner(c);
    const double of_other = seen_by(v, ahead_accepted ? ahead : behind, face.length2(base));
    const double own = scratch_.estimate[v];
    const Arrival arrival = arrive(ahead_accepted ? own : of_other, ahead_accepted ? of_other : own,
                                   face.apex_over(base));
    lower(ahead_accepted ? behind : ahead, arrival.distance, halfedge(face_of(corner), base));
  }
}

// The distance of an accepted vertex, for a front that is at v: the one that it got, once
// it is old enough for that, or else its estimate. How old says the estimate alone, so
// that nothing depends on which vertices anywhere were accepted together.
double BackTracedFront::seen_by(std::uint32_t v, std::uint32_t other, double base2) {
  const double estimate = scratch_.estimate[other];
  const double age = scratch_.estimate[v] - estimate;
  if (!(age > 0) || !(age * age > kOldEnough * kOldEnough * base2)) return estimate;
  if (is_pending(other)) settle();
  return distance_[other];
}

// Where faces meet in nothing but the vertex, no triangle beyond it has two accepted
// ones.
void BackTracedFront::spread_along_edges(std::uint32_t v) {
  for (const std::uint32_t corner : surface_.corners(v)) {
    const FaceRecord& face = surface_.faces[face_of(corner)];
    const std::uint32_t c = corner_of(corner);
    for (const std::uint32_t side : {c, previous_corner(c)}) {
      const std::uint32_t w = side == c ? next_corner(c) : side;
      if (scratch_.heap.accepted(face.vertex[w])) continue;
      lower(face.vertex[w], scratch_.estimate[v] + std::sqrt(std::max(face.length2(side), 0.0)),
            halfedge(face_of(corner), next_corner(w)));
    }
  }
}

bool BackTracedFront::is_pending(std::uint32_t vertex) const {
  return std::find(pending_.begin(), pending_.begin() + pending_count_, vertex) !=
         pending_.begin() + pending_count_;
}

void BackTracedFront::accept(std::uint32_t vertex) {
  const Halfedge base = scratch_.base[vertex];
  if (base == kNone) return;  // straight from the source
  const FaceRecord& face = surface_.faces[face_of(base)];
  const std::uint32_t c = corner_of(base);
  if (pending_count_ == kTogether || is_pending(face.vertex[c]) ||
      is_pending(face.vertex[next_corner(c)])) {
    settle();
  }
  pending_[pending_count_++] = vertex;
}

void BackTracedFront::settle() {
  // None of them is seen by the others: the result is that of tracing all at once.
  std::array<double, kTogether> best{};
  std::array<std::size_t, kTogether> lane{};
  TraceLanes& lanes = lanes_;
  lanes.count = 0;
  for (std::size_t i = 0; i < pending_count_; ++i) {
    lane[i] = lanes.count;
    best[i] = begin_trace(pending_[i], lanes);
  }
  if (stops_.empty()) {
    trace_lanes(surface_, distance_, takes_, vectors_, lanes);
  } else {
    const BackTrace trace(surface_, distance_, stops_, takes_);
    for (std::size_t i = 0; i < lanes.count; ++i)
      lanes.best[i] = trace.least(lanes.start(i), lanes.best[i]);
  }
  for (std::size_t i = 0; i < pending_count_; ++i) {
    const bool in_lane = lane[i] < (i + 1 < pending_count_ ? lane[i + 1] : lanes.count);
    best[i] = doubted(pending_[i], in_lane ? lanes.best[lane[i]] : best[i]);
  }
  for (std::size_t i = 0; i < pending_count_; ++i) {
    distance_[pending_[i]] = best[i];
  }
  pending_count_ = 0;
}

// The best of what needs no trace, and the trace, if there is one, in the next lane.
double BackTracedFront::begin_trace(std::uint32_t vertex, TraceLanes& lanes) const {
  const Halfedge base = scratch_.base[vertex];
  const FaceRecord& face = surface_.faces[face_of(base)];
  const std::uint32_t c = corner_of(base);
  const SeenFrom seen = seen_from(face, previous_corner(c));
  const double by_right = distance_[seen.right] + seen.to_right.x;
  const double by_left =
      distance_[seen.left] + std::sqrt(std::max(face.length2(next_corner(c)), 0.0));
  const double best = std::min({distance_[vertex], by_right, by_left});
  // At a pinched vertex only one end may have a distance.
  if (!(std::max(by_right, by_left) < kUnreached) || !(seen.to_right.x > 0)) return best;
  const Arrival arrival = arrive(distance_[seen.right], distance_[seen.left], face.apex_over(c));
  if (arrival.which != Fig4::a) {
    return round_a_vertex(vertex, arrival.which == Fig4::b ? seen.right : seen.left, best);
  }
  const Vec2 aim = seen.to_right + arrival.crossing * (seen.to_left - seen.to_right);
  lanes.set(lanes.count++, {base, seen.right, seen.left, seen.to_right, seen.to_left, aim}, best);
  return best;
}

// A distance above what the front expected needs a second look.
double BackTracedFront::doubted(std::uint32_t vertex, double best) const {
  const Halfedge base = scratch_.base[vertex];
  const double base2 = surface_.faces[face_of(base)].length2(corner_of(base));
  const double above = best - scratch_.estimate[vertex];
  if (!(above > 0) || !(above * above > kSuspicious * kSuspicious * base2)) return best;
  return over_other_faces(vertex, base, best);
}

// The way to the vertex seems to bend at another one. On either side of that one, the
// faces round it are unfolded until the one its own way came through: if that way goes
// straight on past it, the trace begins there.
double BackTracedFront::round_a_vertex(std::uint32_t vertex, std::uint32_t bend,
                                       double best) const {
  const Halfedge bend_base = scratch_.base[bend];
  if (bend_base == kNone) return best;  // in sight of the source
  const BackTrace trace(surface_, distance_, stops_, takes_);
  const FaceRecord& last = surface_.faces[face_of(bend_base)];
  for (const std::uint32_t corner : surface_.corners(vertex)) {
    const std::uint32_t first = face_of(corner);
    const std::uint32_t c = corner_of(corner);
    const FaceRecord& face = surface_.faces[first];
    const bool ahead = face.vertex[next_corner(c)] == bend;
    if (first == face_of(bend_base) || (!ahead && face.vertex[previous_corner(c)] != bend))
      continue;
    // The bend to the right, mirrored if need be.
    const std::uint32_t b = ahead ? next_corner(c) : previous_corner(c);
    const std::uint32_t r = ahead ? previous_corner(c) : next_corner(c);
    const double length = std::sqrt(std::max(face.length2(ahead ? c : b), 0.0));
    if (!(length > 0)) continue;
    const Vec2 to_bend{length, 0};
    const Vec2 to_rim{face.dot[c] / length, face.area2 / length};
    const Halfedge out = halfedge(first, ahead ? b : r);

    Vec2 rim = to_rim;
    std::uint32_t rim_vertex = face.vertex[r];
    Halfedge edge = out;
    for (int faces = 0; faces < kMostFacesRound; ++faces) {
      const Halfedge across = surface_.ring(edge);
      if (across == edge || surface_.ring(across) != edge) break;
      const FaceRecord& next = surface_.faces[face_of(across)];
      const std::uint32_t at = corner_of(across);
      const std::uint32_t apex = previous_corner(at);
      const bool at_bend = next.vertex[at] == bend;
      const double base2 = next.dot[at] + next.dot[next_corner(at)];
      const Vec2 side = rim - to_bend;
      const Vec2 to_apex = to_bend +
                           ((at_bend ? next.dot[at] : next.dot[next_corner(at)]) / base2) * side +
                           (next.area2 / base2) * Vec2{side.y, -side.x};
      if (face_of(across) == face_of(bend_base)) {
        const std::uint32_t p = corner_of(bend_base);
        const Arrival arrival = arrive(distance_[last.vertex[p]],
                                       distance_[last.vertex[next_corner(p)]], last.apex_over(p));
        const bool from_rim = last.vertex[p] == rim_vertex;
        const Vec2 through = from_rim ? rim + arrival.crossing * (to_apex - rim)
                                      : to_apex + arrival.crossing * (rim - to_apex);
        const Vec2 aim = to_bend + distance_[bend] * unit(through - to_bend);
        // Past the bend on this side, and within the first face.
        if (cross(to_bend, aim) > 0 && cross(aim, to_rim) >= 0) {
          best = trace.least({out, bend, face.vertex[r], to_bend, to_rim, aim}, best);
        }
        break;
      }
      rim = to_apex;
      rim_vertex = next.vertex[apex];
      if (cross(to_bend, rim) < 0) break;  // beyond pi
      edge = halfedge(face_of(across), at_bend ? apex : next_corner(at));
    }
  }
  return best;
}

// Every other face whose ends promise a shorter way is asked.
double BackTracedFront::over_other_faces(std::uint32_t vertex, Halfedge base, double best) const {
  const BackTrace trace(surface_, distance_, stops_, takes_);
  for (const std::uint32_t corner : surface_.corners(vertex)) {
    const std::uint32_t c = corner_of(corner);
    const Halfedge opposite = halfedge(face_of(corner), next_corner(c));
    if (opposite == base) continue;
    const FaceRecord& face = surface_.faces[face_of(corner)];
    const SeenFrom seen = seen_from(face, c);
    const double at_right = distance_[seen.right];
    const double at_left = distance_[seen.left];
    if (!(std::max(at_right, at_left) < kUnreached) || !(seen.to_right.x > 0)) continue;
    const Arrival arrival = arrive(at_right, at_left, face.apex_over(next_corner(c)));
    if (arrival.which != Fig4::a || !(arrival.distance < best)) continue;
    const Vec2 aim = seen.to_right + arrival.crossing * (seen.to_left - seen.to_right);
    best = trace.least({opposite, seen.right, seen.left, seen.to_right, seen.to_left, aim}, best);
  }
  return best;
}

void BackTracedFront::forget(std::uint32_t vertex) {
  distance_[vertex] = kUnreached;
  scratch_.estimate[vertex] = kUnreached;
  scratch_.base[vertex] = kNone;
}

void BackTracedFront::end() {
  for (const std::uint32_t v : in_sight_) {
    if (!scratch_.heap.accepted(v)) forget(v);
  }
  in_sight_.clear();
  stops_.clear();
}

}  // namespace geodesic
