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
// edges so far. An apex inside the funnel is in sight of w: its distance and the
// straight line from it are the length of a path on the surface. After K faces the two
// circles of the paper (section 3.2) round the last edge's ends give the virtual source.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include "core/face_record.h"
#include "core/field.h"
#include "core/triangulation.h"
#include "core/vec2.h"

namespace geodesic {

// Where a trace begins. w is at the origin, and the ray runs along the x axis: `to_right`
// is not above it, `to_left` not below.
struct TraceStart {
  Halfedge edge;  // on w's side: opposite w in their face
  std::uint32_t right;
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
  // Which lengths to take: of paths on the surface only, or from virtual sources too.
  enum class Takes : std::uint8_t { paths, virtual_sources };

  // At most so many faces are unfolded for a trace: 0.007 to 0.015 % of error on scans.
  // Paths alone come as near to the truth when they look further: 0.011 to 0.013 %.
  static constexpr int kMostFaces = 10;
  static constexpr int kMostFacesForPaths = 17;
  [[nodiscard]] static constexpr int most_faces(Takes takes) {
    return takes == Takes::paths ? kMostFacesForPaths : kMostFaces;
  }

  // A virtual source nearer than this part of the best path would be of two sources.
  static constexpr double kLeastOfBest = 0.9;
  static constexpr double kLeastOverOneFace = 0.7;  // across a square, between its sides: 0.71

  // `distance` has an entry per vertex, kUnreached where there is none yet; `stops` are
  // the faces that have a source in them, ascending. All must outlive this object.
  BackTrace(const Triangulation& surface, std::span<const double> distance,
            std::span<const std::uint32_t> stops, Takes takes)
      : surface_(surface), distance_(distance), stops_(stops), takes_(takes) {}

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
    best = std::min(best, distance_[face.vertex[c]] + std::sqrt(std::max(p + w, 0.0)));
    best = std::min(best, distance_[face.vertex[n]] + std::sqrt(std::max(q + w, 0.0)));
    // Over the base as the x axis, times its length, w is at (p, area); the ray runs to
    // where it crosses the base from there.
    const double base2 = p + q;
    const double across = crossing * base2;
    const double along = across - p;
    const double scale = 1.0 / (std::sqrt(along * along + area * area) * std::sqrt(base2));
    // No number where the face is too thin to say.
    if (!(scale * (area * area - p * along) < kUnreached)) return best;
    return least({base,
                  face.vertex[c],
                  face.vertex[n],
                  {scale * (area * area - p * along), scale * (-area * across)},
                  {scale * (area * area + q * along), scale * (area * (base2 - across))}},
                 best);
  }

  // The least of `best` and what the trace finds.
  [[nodiscard]] double least(const TraceStart& start, double best) const {
    Vec2 right = start.to_right;
    Vec2 left = start.to_left;
    Vec2 right_bound = right;
    Vec2 left_bound = left;
    double at_right = distance_[start.right];
    double at_left = distance_[start.left];
    std::uint32_t right_vertex = start.right;
    Halfedge edge = start.edge;
    Halfedge across = surface_.ring(edge);
    bool beyond_is_source = false;
    int faces = 0;
    const int most = most_faces(takes_);
    for (; faces < most && across != edge; ++faces) {
      if (surface_.ring(across) != edge) across = nearest_beyond(edge);
      if (!stops_.empty() && std::binary_search(stops_.begin(), stops_.end(), face_of(across))) {
        beyond_is_source = true;
        break;
      }
      const FaceRecord& face = surface_.faces[face_of(across)];
      const std::uint32_t c = corner_of(across);
      const std::uint32_t n = next_corner(c);
      const std::uint32_t apex = previous_corner(c);
      const double at_apex = distance_[face.vertex[apex]];
      // Past the source, distances grow again.
      if (!(at_apex < std::max(at_right, at_left))) break;
      // The apex over the edge, whichever way round the face has it.
      const bool forward = face.vertex[c] == right_vertex;
      const double per_base2 = 1.0 / (face.dot[c] + face.dot[n]);
      const double along = (forward ? face.dot[c] : face.dot[n]) * per_base2;
      const double height = face.area2 * per_base2;
      const Vec2 base = left - right;
      const Vec2 to_apex{right.x + along * base.x + height * base.y,
                         right.y + along * base.y - height * base.x};
      const bool within_left = cross(to_apex, left_bound) >= 0;
      const bool within_right = cross(right_bound, to_apex) >= 0;
      if (within_left && within_right) best = std::min(best, at_apex + norm(to_apex));
      if (to_apex.y > 0) {
        left = to_apex;
        at_left = at_apex;
        if (within_left) left_bound = to_apex;
        edge = halfedge(face_of(across), forward ? apex : n);
      } else {
        right = to_apex;
        at_right = at_apex;
        right_vertex = face.vertex[apex];
        if (within_right) right_bound = to_apex;
        edge = halfedge(face_of(across), forward ? n : apex);
      }
      across = surface_.ring(edge);
    }
    // A ray that ends at a border has no virtual source beyond it.
    if (faces < most && across == edge) return best;
    if (takes_ == Takes::paths && !beyond_is_source) return best;

    // The two circles. In the face of a source itself they meet in the source.
    const Vec2 base = left - right;
    const double base2 = dot(base, base);
    const double sum = at_right + at_left;
    const double difference = at_right - at_left;
    const double sx = 0.5 * (base2 + difference * sum);
    const double sy2 = 0.25 * (sum * sum - base2) * (base2 - difference * difference);
    if (!(sy2 > 0)) return best;
    const double sy = std::sqrt(sy2);
    const double per_base2 = 1.0 / base2;
    const double along = sx * per_base2;
    const double down = sy * per_base2;
    const Vec2 source{right.x + along * base.x + down * base.y,
                      right.y + along * base.y - down * base.x};
    const bool in_sight = cross(source, left_bound) >= 0 && cross(right_bound, source) >= 0;
    if (!in_sight) return best;
    // Far nearer than any path back there: the two distances are of two sources.
    const double straight = norm(source);
    const double least = faces == 0 ? kLeastOverOneFace : kLeastOfBest;
    return straight >= least * best ? std::min(best, straight) : best;
  }

 private:
  // Of several faces on an edge the one whose apex is nearest to the source.
  [[nodiscard]] Halfedge nearest_beyond(Halfedge edge) const {
    const auto at_apex = [this](Halfedge h) {
      return distance_[surface_.faces[face_of(h)].vertex[previous_corner(corner_of(h))]];
    };
    Halfedge nearest = surface_.ring(edge);
    for (Halfedge h = surface_.ring(nearest); h != edge; h = surface_.ring(h)) {
      if (at_apex(h) < at_apex(nearest)) nearest = h;
    }
    return nearest;
  }

  Triangulation surface_;
  std::span<const double> distance_;
  std::span<const std::uint32_t> stops_;
  Takes takes_;
};

}  // namespace geodesic
