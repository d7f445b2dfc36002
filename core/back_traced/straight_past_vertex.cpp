// Ways that seem to bend at a vertex, and pass it straight.
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/back_traced/part_trace.h"
#include "core/base/tolerances.h"
#include "core/base/vec2.h"
#include "core/surface/unfold_rounding.h"
#include "core/wavefront/virtual_source.h"

namespace geodesic {
namespace {

// Faces round a vertex that a bend is unfolded over, before its angle is beyond pi.
constexpr int kMostFacesRound = 12;

// Whether rounding may turn what is beyond the face by more than 1e-12, so that it is not unfolded
// round a bend.
bool is_too_thin(const FaceRecord& face) {
  return !(face.longest2() <= tolerance::kMostSpread2 * face.shortest2());
}

}  // namespace

// The way to the vertex seems to bend at the vertex `bend`. On either side of `bend`, the faces
// round it are unfolded up to the face that the way to `bend` came through. If that way, continued
// straight, passes `bend` and stays in the first face, a trace along it is added.
void PartTrace::trace_past_vertex(std::uint32_t place, std::uint32_t bend) {
  const auto distance = [&, number = source(place)](std::uint32_t v) {
    return distances_.at(v, number);
  };
  double best = best_[place];
  const Slot of_bend = distances_.find_slot(bend, source(place));
  if (of_bend == kNone) return;
  const Halfedge bend_base = front_.vertices[of_bend].base;
  if (bend_base == kNone) return;  // visible from the source
  const FaceRecord& last = surface_.faces[face_of(bend_base)];
  for (const std::uint32_t corner : surface_.corners(vertex(place))) {
    if (poll_.cancelled()) return;
    const std::uint32_t first = face_of(corner);
    const std::uint32_t c = corner_of(corner);
    const FaceRecord& face = surface_.faces[first];
    if ((!surface_.is_even && is_too_thin(face)) || is_line(face)) continue;
    const bool ahead = face.vertex[next_corner(c)] == bend;
    if (first == face_of(bend_base) || (!ahead && face.vertex[previous_corner(c)] != bend))
      continue;
    // The bend to the right, mirrored if need be until the trace begins.
    const std::uint32_t b = ahead ? next_corner(c) : previous_corner(c);
    const std::uint32_t r = ahead ? previous_corner(c) : next_corner(c);
    const double length = std::sqrt(std::max(face.length2(ahead ? c : b), 0.0));
    if (!(length > 0)) continue;
    const Vec2 to_bend{length, 0};
    const Vec2 to_rim{face.dot[c] / length, face.area2 / length};
    best = std::min(best, distance(face.vertex[r]) + norm(to_rim));
    const Halfedge out = halfedge(first, ahead ? b : r);

    Vec2 rim = to_rim;
    std::uint32_t rim_vertex = face.vertex[r];
    Halfedge edge = out;
    for (int faces = 0; faces < kMostFacesRound; ++faces) {
      const Halfedge across = surface_.ring(edge);
      if (across == edge || surface_.ring(across) != edge) break;
      const FaceRecord& next = surface_.faces[face_of(across)];
      if ((!surface_.is_even && is_too_thin(next)) || is_line(next)) break;
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
        const Arrival arrival = arrive(distance(last.vertex[p]),
                                       distance(last.vertex[next_corner(p)]), last.apex_over(p));
        const bool from_rim = last.vertex[p] == rim_vertex;
        const Vec2 through = from_rim ? rim + arrival.crossing * (to_apex - rim)
                                      : to_apex + arrival.crossing * (rim - to_apex);
        const Vec2 aim = to_bend + distance(bend) * unit(through - to_bend);
        // Past the bend on this side, and within the first face.
        if (cross(to_bend, aim) > 0 && cross(aim, to_rim) >= 0) {
          TraceStart start{out, bend, face.vertex[r], along_ray(aim, to_bend),
                           along_ray(aim, to_rim)};
          if (!ahead) {
            std::swap(start.right, start.left);
            std::swap(start.to_right, start.to_left);
            start.to_right.y *= -1;
            start.to_left.y *= -1;
          }
          trace(place, start, best);
        }
        break;
      }
      rim = to_apex;
      rim_vertex = next.vertex[apex];
      if (cross(to_bend, rim) < 0) break;  // beyond pi
      edge = halfedge(face_of(across), at_bend ? apex : next_corner(at));
    }
  }
  best_[place] = std::min(best_[place], best);
}

}  // namespace geodesic
