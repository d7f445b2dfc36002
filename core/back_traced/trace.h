// A look back from a vertex over the faces that the front has passed: what makes one
// update of the back-traced wavefront nearly exact.
//
// The paper's rule computes a vertex from the two nearest ones, across one face. But
// those two mostly see the source round different bumps of the surface, so that their
// circles do not quite fit together; crossing an edge costs about a hundredth of its
// length, and a front crosses hundreds. Evaluated across an edge K faces further back,
// the same rule errs K times less often.
//
// So, from the vertex w at the origin of a plane, faces are unfolded one after another
// along a ray. `to_right` and `to_left` are the ends of the edge that the ray crosses,
// and the funnel between `right_bound` and `left_bound` is what w sees through all the
// edges so far. An apex inside the funnel is visible from w: its distance and the
// straight line from it are the length of a path on the surface. After K faces the two
// circles of the paper (section 3.2) round the last edge's ends give the virtual source.
//
// Where the sides on the way differ by many powers of ten, rounding may turn what is unfolded:
// a corner misplaced by rounding, at the end of a side that is hardly longer than that. Such a
// trace begins anew, with care: it keeps account of how far what it unfolded may be turned, adds
// what that may take from a length, and ends before an edge that says nothing of a direction any
// more.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/back_traced/crowded_edges.h"
#include "core/back_traced/front_distances.h"
#include "core/base/tolerances.h"
#include "core/base/vec2.h"
#include "core/field/field.h"
#include "core/surface/face_record.h"
#include "core/surface/triangulation.h"
#include "core/surface/unfold_rounding.h"

namespace geodesic {

// Where a trace begins. w is at the origin, and the ray runs along the x axis: `to_right`
// is not above it, `to_left` not below.
struct TraceStart {
  Halfedge edge;        // on w's side: opposite w in their face
  std::uint32_t right;  // at its tail
  std::uint32_t left;
  Vec2 to_right;
  Vec2 to_left;  // counterclockwise from to_right, by less than pi
};

// A vertex seen from the origin, once the direction of `ray` is the x axis.
[[nodiscard]] inline Vec2 along_ray(Vec2 ray, Vec2 vertex) {
  const double length = norm(ray);
  return {dot(ray, vertex) / length, cross(ray, vertex) / length};
}

class BackTrace {
 public:
  // What a trace takes the least of: lengths of paths on the surface only, or distances from
  // virtual sources too.
  enum class Candidates : std::uint8_t { paths, virtual_sources };

  // How far back. What is enough for most traces leaves some unsure: where the best path
  // is longer than the straight way from the virtual source by a share of the way looked
  // back over, no vertex lies near the straight way, or the last edge's ends see two
  // sources. Further back, both come closer to the truth. Where it is longer by far, as on
  // slivers, no vertex is near the way there either.
  enum class Reach : std::uint8_t { near, far };

  // Where a surface bends much from vertex to vertex, more faces are worth their time: distances
  // some steps back are wrong by more there.
  enum class Depth : std::uint8_t { usual, deep };

  struct Rule {
    Candidates candidates;
    Depth depth = Depth::usual;
  };

  // At most so many faces are unfolded.
  [[nodiscard]] static constexpr int most_faces(Rule rule, Reach reach) {
    if (rule.depth == Depth::deep) return reach == Reach::near ? 24 : 72;
    if (reach == Reach::near) return rule.candidates == Candidates::paths ? 15 : 10;
    return rule.candidates == Candidates::paths ? 48 : 30;
  }
  // The shares between which a trace is unsure.
  struct Shares {
    double least, most;
  };
  [[nodiscard]] static constexpr Shares unsure(Candidates candidates) {
    return candidates == Candidates::paths ? Shares{0.001, 0.1} : Shares{0.003, 0.1};
  }

  // A virtual source nearer than this part of the best path would be of two sources.
  static constexpr double kLeastOfBest = 0.9;

  // Where distances grow beyond an edge, two waves may meet there: each of its ends was reached by
  // another, and no wave came from where the circles round them meet. Then the apex beyond it is
  // farther than straight from there, by more than this part of the way to the origin. So the
  // virtual source is not taken. `face` lies beyond the edge, its corner `c` to the edge's right,
  // or where it is not `forward`, to the left.
  static constexpr double kMostFarther = 0.01;
  [[nodiscard]] static bool has_reached_apex(const FaceRecord& face, std::uint32_t c, bool forward,
                                             double at_apex, Vec2 right, Vec2 left, Vec2 source) {
    const Vec2 to_apex = beyond(face, c, forward, right, left) - source;
    return at_apex <= norm(to_apex) + kMostFarther * norm(source);
  }

  // From the source of this number. What is given must outlive this object.
  BackTrace(const Triangulation& surface, const FrontDistances& distances, Rule rule,
            const CrowdedEdges* crowds = nullptr, std::uint32_t source = 0)
      : surface_(surface), distances_(distances), source_(source), rule_(rule), crowds_(crowds) {}

  // The least of `best`, of the ways along both sides of the face of `base` to the vertex
  // opposite it, and of what the trace from there finds, over the base at `crossing`: 0 at
  // its tail, 1 at its head. The distances at both are finite.
  [[nodiscard]] double over(Halfedge base, double crossing, double best) const {
    const FaceRecord& face = surface_.faces[face_of(base)];
    const std::uint32_t c = corner_of(base);
    const std::uint32_t n = next_corner(c);
    const double p = face.dot[c];
    const double q = face.dot[n];
    const double w = face.dot[previous_corner(c)];
    const double area = face.area2;
    const double at_tail = distance(face.vertex[c]);
    const double at_head = distance(face.vertex[n]);
    // Over the base as the x axis, times its length, w is at (p, area); the ray runs to
    // where it crosses the base from there.
    const double base2 = p + q;
    const double across = crossing * base2;
    const double along = across - p;
    const double scale = 1.0 / (std::sqrt(along * along + area * area) * std::sqrt(base2));
    const TraceStart start{base,
                           face.vertex[c],
                           face.vertex[n],
                           {scale * (area * area - p * along), scale * (-area * across)},
                           {scale * (area * area + q * along), scale * (area * (base2 - across))}};
    // No number where the face is too thin to say.
    const bool is_laid_out =
        start.to_right.x < kUnreached && !(surface_.has_lines && is_line(face));
    Spread spread{std::max({p + w, q + w, base2}), std::min({p + w, q + w, base2}), 0};
    double found = std::min({best, at_tail + std::sqrt(std::max(p + w, 0.0)),
                             at_head + std::sqrt(std::max(q + w, 0.0))});
    if (is_laid_out) found = trace<false>(start, found, spread);
    if (surface_.is_even || !spread.is_wide()) return found;
    best = std::min({best, at_tail + side_not_below(face, previous_corner(c)),
                     at_head + side_not_below(face, n)});
    // Over a shorter side, its ends are as good a crossing as any.
    const bool is_placed = base2 > tolerance::kLeastSide2 * std::max(p + w, q + w);
    return is_laid_out && is_placed ? trace<true>(start, best, spread) : best;
  }

  // The least of `best` and what the trace finds.
  [[nodiscard]] double least(const TraceStart& start, double best) const {
    Spread spread = spread_of(start);
    const double found = trace<false>(start, best, spread);
    return surface_.is_even || !spread.is_wide() ? found : trace<true>(start, best, spread);
  }

  // What was unfolded, by the squares of lengths.
  struct Spread {
    double farthest2;  // from the origin, or the longest side of the first face
    double start2;     // the shortest side of the first face
    double finest;     // one over the shortest of the edges that were crossed after that

    [[nodiscard]] bool is_wide() const {
      return farthest2 * finest > tolerance::kMostSpread2 ||
             !(farthest2 <= tolerance::kMostSpread2 * start2);
    }
  };
  [[nodiscard]] static Spread spread_of(const TraceStart& start) {
    const Vec2 base = start.to_left - start.to_right;
    const double right2 = dot(start.to_right, start.to_right);
    const double left2 = dot(start.to_left, start.to_left);
    const double base2 = dot(base, base);
    return {std::max({right2, left2, base2}), std::min({right2, left2, base2}), 0};
  }

 private:
  [[nodiscard]] double distance(std::uint32_t vertex) const {
    return distances_.at(vertex, source_);
  }

  // Where the apex of a face is, unfolded over the edge from `right` to `left`.
  [[nodiscard]] static Vec2 beyond(const FaceRecord& face, std::uint32_t c, bool forward,
                                   Vec2 right, Vec2 left) {
    const double per_base2 = 1.0 / (face.dot[c] + face.dot[next_corner(c)]);
    const double along = face.dot[forward ? c : next_corner(c)] * per_base2;
    const double height = face.area2 * per_base2;
    const Vec2 base = left - right;
    return {right.x + along * base.x + height * base.y, right.y + along * base.y - height * base.x};
  }

  // What stopped a trace before it had gone over as many faces as it may.
  enum class Ends : std::uint8_t { nowhere, at_border, where_distances_grow, lost };

  struct Trace {
    Vec2 right, left;
    Vec2 right_bound, left_bound;
    double at_right, at_left;
    std::uint32_t right_vertex;
    Halfedge edge, across;
    int faces = 0;
    Ends ends = Ends::nowhere;
    // With care only: by how much the edge ahead may be turned or scaled about one of its ends,
    // and by how much its ends may be off besides.
    double turn = 0;
    double rounding = 0;
  };

  template <bool kCareful>
  [[nodiscard]] double trace(const TraceStart& start, double best, Spread& spread) const {
    Trace trace{start.to_right,           start.to_left,        start.to_right, start.to_left,
                distance(start.right),    distance(start.left), start.right,    start.edge,
                surface_.ring(start.edge)};
    if constexpr (kCareful) {
      spread = spread_of(start);
      const FaceRecord& face = surface_.faces[face_of(start.edge)];
      take_account(trace, UnfoldRounding::of_corner(face, std::sqrt(spread.farthest2)));
    }
    best = look_back<kCareful>(trace, Reach::near, best, spread);
    if (trace.ends != Ends::nowhere && trace.ends != Ends::where_distances_grow) return best;
    double straight = straight_to_virtual_source(trace, best);
    if (trace.ends == Ends::nowhere && (kCareful || is_unsure(trace, straight, best))) {
      best = look_back<kCareful>(trace, Reach::far, best, spread);
      if (trace.ends != Ends::nowhere && trace.ends != Ends::where_distances_grow) return best;
      straight = straight_to_virtual_source(trace, best);
    }
    // Of a virtual source no account is kept: how far it is off depends on both distances.
    return !kCareful && rule_.candidates == Candidates::virtual_sources ? std::min(best, straight)
                                                                        : best;
  }

  // Goes on over the faces; the least of `best` and the ways past their vertices.
  template <bool kCareful>
  [[nodiscard]] double look_back(Trace& t, Reach reach, double best, Spread& spread) const {
    for (const int most = most_faces(rule_, reach); t.faces < most; ++t.faces) {
      if (t.across == t.edge) {
        t.ends = Ends::at_border;
        return best;
      }
      if (kCareful && !(t.turn <= tolerance::kMostTurn)) {
        t.ends = Ends::lost;
        return std::min(best, along_edge(t, spread));
      }
      if (surface_.ring(t.across) != t.edge) t.across = nearest_beyond(t.edge);
      const FaceRecord& face = surface_.faces[face_of(t.across)];
      if (surface_.has_lines && is_seen_along_line(face, t.right, t.left)) [[unlikely]] {
        t.ends = Ends::lost;
        return best;
      }
      const std::uint32_t c = corner_of(t.across);
      const std::uint32_t n = next_corner(c);
      const std::uint32_t apex = previous_corner(c);
      const double at_apex = distance(face.vertex[apex]);
      // Past the source, and where waves meet, distances grow; but over one thin face they
      // may as well.
      const bool may_be_farther = t.faces == 0 && at_apex < kUnreached;
      if (!(at_apex < std::max(t.at_right, t.at_left)) && !may_be_farther) {
        t.ends = Ends::where_distances_grow;
        return best;
      }
      // The apex over the edge, whichever way round the face has it.
      const bool forward = face.vertex[c] == t.right_vertex;
      const double per_base2 = 1.0 / (face.dot[c] + face.dot[n]);
      const Vec2 to_apex = beyond(face, c, forward, t.right, t.left);
      const double apex2 = dot(to_apex, to_apex);
      spread.farthest2 = std::max(spread.farthest2, apex2);
      spread.finest = std::max(spread.finest, per_base2);
      double rounding = 0;
      if constexpr (kCareful) {
        rounding = UnfoldRounding::of_corner(face, std::sqrt(spread.farthest2));
      }
      const bool within_left = cross(to_apex, t.left_bound) >= 0;
      const bool within_right = cross(t.right_bound, to_apex) >= 0;
      if (within_left && within_right) {
        const double straight = std::sqrt(apex2);
        best =
            std::min(best, at_apex + straight + may_lack<kCareful>(t, rounding, straight, spread));
      }
      if (to_apex.y > 0) {
        t.left = to_apex;
        t.at_left = at_apex;
        if (within_left) t.left_bound = to_apex;
        t.edge = halfedge(face_of(t.across), forward ? apex : n);
      } else {
        t.right = to_apex;
        t.at_right = at_apex;
        t.right_vertex = face.vertex[apex];
        if (within_right) t.right_bound = to_apex;
        t.edge = halfedge(face_of(t.across), forward ? n : apex);
      }
      t.across = surface_.ring(t.edge);
      if constexpr (kCareful) take_account(t, rounding);
    }
    return best;
  }

  // What is unfolded beyond the edge is as if turned about one of its ends.
  static void take_account(Trace& t, double rounding) {
    t.rounding = rounding;
    t.turn += rounding / norm(t.left - t.right);
  }
  template <bool kCareful>
  [[nodiscard]] static double may_lack(const Trace& t, double rounding, double straight,
                                       const Spread& spread) {
    if constexpr (!kCareful) return 0;
    return UnfoldRounding::lack(straight, std::sqrt(spread.farthest2), t.turn, rounding);
  }
  // The way along the ray to the edge, and along that to one of its ends.
  [[nodiscard]] double along_edge(const Trace& t, const Spread& spread) const {
    const Vec2 edge = t.left - t.right;
    const double share = t.right.y < 0 ? t.right.y / (t.right.y - t.left.y) : 0;
    const double length = norm(edge);
    const double straight = std::abs(t.right.x + share * edge.x);
    const double lack = UnfoldRounding::lack(straight, std::sqrt(spread.farthest2),
                                             tolerance::kMostTurn, t.rounding);
    return straight + lack +
           std::min(t.at_right + share * length, t.at_left + (1 - share) * length);
  }

  // The distance of the point where the two circles round the ends of the trace's edge
  // meet. kUnreached where they do not, and with virtual sources, where that point is not to be
  // taken for one.
  [[nodiscard]] double straight_to_virtual_source(const Trace& t, double best) const {
    const Vec2 base = t.left - t.right;
    const double base2 = dot(base, base);
    const double sum = t.at_right + t.at_left;
    const double difference = t.at_right - t.at_left;
    const double sx = 0.5 * (base2 + difference * sum);
    const double sy2 = 0.25 * (sum * sum - base2) * (base2 - difference * difference);
    if (!(sy2 > 0)) return kUnreached;
    const double sy = std::sqrt(sy2);
    const double per_base2 = 1.0 / base2;
    const double along = sx * per_base2;
    const double down = sy * per_base2;
    const Vec2 source{t.right.x + along * base.x + down * base.y,
                      t.right.y + along * base.y - down * base.x};
    const double straight = norm(source);
    if (rule_.candidates == Candidates::paths) return straight;
    const bool is_visible = cross(source, t.left_bound) >= 0 && cross(t.right_bound, source) >= 0;
    if (!is_visible) return kUnreached;
    // No wave came over the first edge: its ends were reached by two that meet there.
    if (t.faces == 0) return kUnreached;
    // Far nearer than any path back there: the two distances are of two sources.
    if (!(straight >= kLeastOfBest * best)) return kUnreached;
    if (t.ends == Ends::where_distances_grow) {
      const FaceRecord& face = surface_.faces[face_of(t.across)];
      const std::uint32_t c = corner_of(t.across);
      const double at_apex = distance(face.vertex[previous_corner(c)]);
      const bool forward = face.vertex[c] == t.right_vertex;
      if (!has_reached_apex(face, c, forward, at_apex, t.right, t.left, source)) return kUnreached;
    }
    return straight;
  }

  [[nodiscard]] bool is_unsure(const Trace& t, double straight, double best) const {
    const Shares shares = unsure(rule_.candidates);
    const double away = norm(t.right);
    return straight + shares.least * away < best && best < straight + shares.most * away;
  }

  // Of several faces on an edge the one whose apex is nearest to the source.
  [[nodiscard]] Halfedge nearest_beyond(Halfedge edge) const {
    if (const Halfedge known = crowds_ != nullptr ? crowds_->nearest_beyond(edge) : kNone;
        known != kNone) {
      return known;
    }
    const auto at_apex = [this](Halfedge h) {
      return distance(surface_.faces[face_of(h)].vertex[previous_corner(corner_of(h))]);
    };
    Halfedge nearest = surface_.ring(edge);
    for (Halfedge h = surface_.ring(nearest); h != edge; h = surface_.ring(h)) {
      if (at_apex(h) < at_apex(nearest)) nearest = h;
    }
    return nearest;
  }

  Triangulation surface_;
  FrontDistances distances_;
  std::uint32_t source_;
  Rule rule_;
  const CrowdedEdges* crowds_;
};

}  // namespace geodesic
