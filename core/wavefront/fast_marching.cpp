#include "core/wavefront/fast_marching.h"

#include <limits>
#include <span>
#include <utility>

#include "core/field/straight_floor.h"
#include "core/field/vertex_front.h"

namespace geodesic {
namespace {

// On scanned meshes 999 sections of 1000 hold a vertex this near; what is farther
// makes a poorer triangle than none.
constexpr int kMostUnfolded = 12;

using Point2 = std::array<double, 2>;

double dot2(const Point2& a, const Point2& b) { return a[0] * b[0] + a[1] * b[1]; }

double cross2(const Point2& a, const Point2& b) { return a[0] * b[1] - a[1] * b[0]; }

// The origin as the apex over the base p -> q.
UnfoldedApex origin_over(const Point2& p, const Point2& q) {
  const double pp = dot2(p, p);
  const double qq = dot2(q, q);
  const double pq = dot2(p, q);
  return {pp - pq, qq - pq, std::abs(cross2(p, q)), pp, qq};
}

// The least number above `floor` where adding nothing but rounding got there: so
// that whatever a distance was computed from is less than it.
double above(double d, double floor) {
  return d > floor ? d : std::nextafter(floor, std::numeric_limits<double>::infinity());
}

// An edge that the splitting section is unfolded across: from p, on the side of the
// face's `first`, to q.
struct CrossedEdge {
  Halfedge h;  // on the side of the obtuse vertex
  std::uint32_t p;
  Point2 p_at;
  Point2 q_at;
};

// Calls `crosses` with every edge that is unfolded across, in order.
template <class Crosses>
ObtuseSplit unfold_section(const Adjacency& adjacency, std::uint32_t f, std::uint32_t c,
                           Crosses crosses) {
  const FaceRecord& face = adjacency.face(f);
  const std::uint32_t n = next_corner(c);
  ObtuseSplit split{
      face.vertex[c], face.vertex[n], face.vertex[previous_corner(c)], kNone, {}, {}, {}};
  const double side2 = face.length2(c);
  if (!(side2 > 0)) return split;
  const double side = std::sqrt(side2);
  split.first_at = {side, 0};
  split.second_at = {face.dot[c] / side, face.area2 / side};

  // The edge to cross, from p on the side of `first` to q on that of `second`. The
  // section passes between them, so every point of it beyond sees the origin.
  Halfedge edge = halfedge(f, n);
  std::uint32_t p = split.first;
  std::uint32_t q = split.second;
  Point2 p_at = split.first_at;
  Point2 q_at = split.second_at;
  for (int unfolded = 0; unfolded < kMostUnfolded; ++unfolded) {
    const Halfedge across = adjacency.ring(edge);
    if (across == edge || adjacency.ring(across) != edge) break;
    crosses(CrossedEdge{edge, p, p_at, q_at});
    const FaceRecord& beyond = adjacency.face(face_of(across));
    const std::uint32_t base = corner_of(across);
    const std::uint32_t tip = previous_corner(base);
    const UnfoldedApex apex = beyond.apex_over(base);
    if (!(apex.base2() > 0)) break;
    const double part = (beyond.vertex[base] == p ? apex.from_p : apex.from_q) / apex.base2();
    const double rise = apex.height / apex.base2();
    const Point2 along{q_at[0] - p_at[0], q_at[1] - p_at[1]};
    const Point2 at{p_at[0] + part * along[0] + rise * along[1],
                    p_at[1] + part * along[1] - rise * along[0]};
    const bool near_first = dot2(at, split.first_at) > 0;
    const bool near_second = dot2(at, split.second_at) > 0;
    const std::uint32_t found = beyond.vertex[tip];
    if (near_first && near_second) {
      // Round a cone of few faces the strip may come back to where it began.
      if (found == split.obtuse || found == split.first || found == split.second) break;
      split.far = found;
      split.far_at = at;
      break;
    }
    if (near_first == near_second) break;  // rounding in a face without area
    const std::uint32_t kept = near_first ? q : p;
    edge = halfedge(face_of(across), beyond.vertex[base] == kept ? tip : next_corner(base));
    (near_first ? p : q) = found;
    (near_first ? p_at : q_at) = at;
  }
  return split;
}

class FastMarching {
 public:
  FastMarching(const Adjacency& adjacency, Field& field, FastMarchingScratch& scratch)
      : adjacency_(adjacency),
        field_(field),
        distance_(field.distance.doubles()),
        heap_(scratch.heap),
        scratch_(scratch) {}

  // Their preprocessing: the virtual triangles, listed by face and by far vertex.
  // Incomplete if the poll says to stop.
  void split_obtuse_faces(Poll& poll) {
    scratch_.split_of_face.assign(adjacency_.mesh().face_count(), kNone);
    scratch_.first_by_far.assign(adjacency_.mesh().vertex_count(), kNone);
    scratch_.splits.clear();
    for (std::uint32_t f = 0; f < adjacency_.mesh().face_count() && !poll.cancelled(); ++f) {
      const FaceRecord& face = adjacency_.face(f);
      for (std::uint32_t c = 0; c < 3; ++c) {
        if (!(face.dot[c] < 0)) continue;
        const ObtuseSplit split = split_obtuse(adjacency_, f, c);
        if (split.far == kNone) continue;
        const auto number = static_cast<std::uint32_t>(scratch_.splits.size());
        scratch_.split_of_face[f] = number;
        scratch_.splits.push_back({split, std::exchange(scratch_.first_by_far[split.far], number)});
        break;
      }
    }
  }

  void start(const Source& source, std::uint32_t number) {
    if (source.point.at_vertex()) lower(source.point.vertex, source.offset, number);
    for (const SurfacePoint& place : in_all_faces(adjacency_, source.point)) {
      for (std::uint32_t c = 0; c < 3; ++c) {
        lower(adjacency_.face(place.face).vertex[c],
              source.offset + distance_to_corner(adjacency_.mesh(), place, c), number);
      }
    }
  }

  // Everything that the newly accepted v now gives a distance to: its neighbours
  // along edges, the third vertices of faces of which it is the second, and the
  // obtuse vertices that it is the far vertex of, along the virtual edge and over the
  // bases of the two virtual triangles.
  void spread_from(std::uint32_t v) {
    const double dv = distance_[v];
    for (const std::uint32_t corner : adjacency_.corners(v)) {
      const std::uint32_t f = face_of(corner);
      const std::uint32_t ahead = next_corner(corner_of(corner));
      const std::uint32_t behind = previous_corner(corner_of(corner));
      spread_in_face(v, f, ahead, behind, corner_of(corner));
      spread_in_face(v, f, behind, ahead, behind);
    }
    for (std::uint32_t s = scratch_.first_by_far[v]; s != kNone; s = scratch_.splits[s].next) {
      const ObtuseSplit& split = scratch_.splits[s].split;
      if (heap_.accepted(split.obtuse)) continue;
      const double length = std::sqrt(dot2(split.far_at, split.far_at));
      lower(split.obtuse, above(dv + length, dv), source_of(v));
      if (heap_.accepted(split.first)) update(split, split.first, split.first_at);
      if (heap_.accepted(split.second)) update(split, split.second, split.second_at);
    }
  }

  // What is still considered is not final.
  void forget(std::uint32_t v) {
    distance_[v] = kUnreached;
    if (!field_.nearest_source.empty()) field_.nearest_source[v] = kNone;
  }

 private:
  // From v to the vertex at corner `to`; the face's third vertex is at `other`, and
  // `side` is the side from v to the vertex.
  void spread_in_face(std::uint32_t v, std::uint32_t f, std::uint32_t to, std::uint32_t other,
                      std::uint32_t side) {
    const FaceRecord& face = adjacency_.face(f);
    const std::uint32_t w = face.vertex[to];
    if (heap_.accepted(w)) return;
    const double dv = distance_[v];
    lower(w, above(dv + std::sqrt(std::max(face.length2(side), 0.0)), dv), source_of(v));
    if (const ObtuseSplit* split = split_at(f, w)) {
      if (heap_.accepted(split->far)) {
        update(*split, v, v == split->first ? split->first_at : split->second_at);
      }
      return;
    }
    if (!heap_.accepted(face.vertex[other])) return;
    const std::uint32_t base = next_corner(to);
    const std::uint32_t p = face.vertex[base];
    const std::uint32_t q = face.vertex[next_corner(base)];
    update(w, p, q, face.apex_over(base), std::min(distance_[p], distance_[q]));
  }

  // Through the virtual triangle of an obtuse vertex, one end of its base and the
  // far vertex.
  void update(const ObtuseSplit& split, std::uint32_t end, const Point2& end_at) {
    update(split.obtuse, end, split.far, origin_over(end_at, split.far_at), distance_[end]);
  }

  void update(std::uint32_t w, std::uint32_t p, std::uint32_t q, const UnfoldedApex& apex,
              double floor) {
    const Arrival arrival = arrive_plane_wave(distance_[p], distance_[q], apex);
    // Their condition u < t: a wave that reaches w before an end of the base did not
    // come over the base. Only at obtuse angles that could not be split.
    if (arrival.distance < std::max(distance_[p], distance_[q])) return;
    lower(w, above(arrival.distance, floor), source_of(arrival.crossing <= 0.5 ? p : q));
  }

  // The split of a face at its vertex w, if it has one there.
  [[nodiscard]] const ObtuseSplit* split_at(std::uint32_t f, std::uint32_t w) const {
    const std::uint32_t number = scratch_.split_of_face[f];
    if (number == kNone || scratch_.splits[number].split.obtuse != w) return nullptr;
    return &scratch_.splits[number].split;
  }

  [[nodiscard]] std::uint32_t source_of(std::uint32_t v) const {
    return field_.nearest_source.empty() ? 0 : field_.nearest_source[v];
  }

  void lower(std::uint32_t v, double d, std::uint32_t source) {
    if (!(d < distance_[v])) return;
    // Long before it is accepted: to find its faces, their list is waited for.
    if (distance_[v] == kUnreached) __builtin_prefetch(adjacency_.corners(v).data());
    distance_[v] = d;
    if (!field_.nearest_source.empty()) field_.nearest_source[v] = source;
    heap_.push_or_lower(v, d);
  }

  const Adjacency& adjacency_;
  Field& field_;
  std::span<double> distance_;  // the field's
  VertexHeap& heap_;
  FastMarchingScratch& scratch_;
};

}  // namespace

ObtuseSplit split_obtuse(const Adjacency& adjacency, std::uint32_t f, std::uint32_t c) {
  return unfold_section(adjacency, f, c, [](const CrossedEdge&) {});
}

std::vector<FaceSegment> virtual_edge(const Adjacency& adjacency, std::uint32_t f,
                                      std::uint32_t c) {
  std::vector<CrossedEdge> crossed;
  const ObtuseSplit split =
      unfold_section(adjacency, f, c, [&](const CrossedEdge& edge) { crossed.push_back(edge); });
  if (split.far == kNone) return {};
  std::vector<FaceSegment> segments;
  std::uint32_t face = f;
  std::array<double, 3> from{0, 0, 0};
  from[c] = 1;
  for (const CrossedEdge& edge : crossed) {
    // The line to the far vertex passes p on its right and q on its left.
    const double right = cross2(edge.p_at, split.far_at);
    const double left = cross2(split.far_at, edge.q_at);
    const double part = right + left > 0 ? std::clamp(right / (right + left), 0.0, 1.0) : 0.5;
    const auto weights_in = [&](Halfedge h) {
      const bool from_p = adjacency.face(face_of(h)).vertex[corner_of(h)] == edge.p;
      std::array<double, 3> bary{0, 0, 0};
      bary[corner_of(h)] = from_p ? 1 - part : part;
      bary[next_corner(corner_of(h))] = from_p ? part : 1 - part;
      return bary;
    };
    segments.push_back({face, from, weights_in(edge.h)});
    const Halfedge across = adjacency.ring(edge.h);
    face = face_of(across);
    from = weights_in(across);
  }
  std::array<double, 3> end{0, 0, 0};
  end[previous_corner(corner_of(adjacency.ring(crossed.back().h)))] = 1;
  segments.push_back({face, from, end});
  return segments;
}

Result<Field> fast_marching_field(const Adjacency& adjacency, std::span<const Source> sources,
                                  const FieldLimits& limits, FastMarchingScratch& scratch,
                                  const Cancel& cancel) {
  const std::size_t vertex_count = adjacency.mesh().vertex_count();
  Field field = unreached_field(Method::fast_marching, sources, vertex_count);
  VertexHeap& heap = scratch.heap;
  heap.reset(vertex_count);
  FastMarching front(adjacency, field, scratch);
  Poll poll(cancel);
  front.split_obtuse_faces(poll);
  if (poll.stopped()) return fail_stopped(cancel);
  auto settled = settle_vertices(front, heap, limits, scratch.is_target, poll, field);
  if (!settled) return fail(std::move(settled.error()));
  raise_to_straight_lines(adjacency.mesh(), field, poll);
  if (poll.stopped()) return fail_stopped(cancel);
  if (limits.max < kUnreached) field.forget_beyond(limits.max);
  field.count_reached();
  return field;
}

}  // namespace geodesic
