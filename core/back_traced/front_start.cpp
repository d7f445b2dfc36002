// How a front begins: the estimates of what is visible from the source.
#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "core/back_traced/front.h"
#include "core/back_traced/visibility_cones.h"
#include "core/base/tolerances.h"
#include "core/surface/line_gaps.h"
#include "core/surface/side_not_below.h"

namespace geodesic {
namespace {

// Faces that the look around from a source at a vertex crosses; beyond some hundred vertices the
// front does as well.
constexpr std::size_t kVisibleFaces = 2000;
// From a point inside a face it goes over the mesh's own faces, of which there may be many to one
// of the Delaunay triangulation: with 2,000, distances near the poles of a sphere are up to 4 % too
// long, and 20 % where that is stretched; with 10,000 0.2 % and 8 %.
constexpr std::size_t kVisibleFacesFromInside = 10'000;

// A bucket's width, of the mean of the faces' shortest sides. Errors are the same with
// half of it; with the double, means grow by a twentieth.
constexpr double kBucketWidth = 0.25;
// … which is taken from so many faces.
constexpr std::size_t kSampledFaces = 128;

// An accepted vertex waits again when its estimate turns out to be less by this part of
// a bucket's width.
constexpr double kLeastGain = 0.001;

double bucket_width(std::span<const FaceRecord> faces) {
  const std::size_t step = faces.size() / kSampledFaces + 1;
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t f = 0; f < faces.size(); f += step, ++count) {
    sum += std::sqrt(std::max(faces[f].shortest2(), 0.0));
  }
  return kBucketWidth * sum / static_cast<double>(std::max<std::size_t>(count, 1));
}

}  // namespace

void BackTracedFront::start(const SurfacePoint& source, const detail::Worthwhile& worthwhile) {
  const auto places = in_all_faces_at(adjacency_, source, poll_);
  // Only the mesh's own faces say where a point inside one is, and what it sees over them. The
  // front goes on from there over the Delaunay triangulation, as from a vertex.
  scratch_.crowds.reset(surface_, poll_);
  const std::size_t most_faces = source.at_vertex() ? kVisibleFaces : kVisibleFacesFromInside;
  const double width = bucket_width(surface_.faces);
  for (FrontDomain& domain : domains_) domain.waiting.reset(width);
  least_gain_ = kLeastGain * width;
  std::vector<VisibilityCone>& cones = scratch_.cones;
  cones.clear();
  if (source.at_vertex()) {
    see(source.vertex, 0);
    for (const std::uint32_t corner : surface_.corners(source.vertex)) {
      if (poll_.cancelled()) return;
      const std::uint32_t c = corner_of(corner);
      const FaceRecord& face = surface_.faces[face_of(corner)];
      const std::uint32_t right = face.vertex[next_corner(c)];
      const double length = std::sqrt(std::max(face.length2(c), 0.0));
      const Vec2 to_right{length, 0};
      const Vec2 to_left{face.dot[c] / length, face.area2 / length};  // may be no number
      see(right, side_not_below(face, c));
      see(face.vertex[previous_corner(c)],
          std::max(norm(to_left), side_not_below(face, previous_corner(c))));
      if (cones.size() == most_faces || is_line(face)) continue;
      if (!surface_.is_even && !(length > tolerance::kLeastSide * longest_side(face))) continue;
      cones.push_back(
          cone_over(face, halfedge(face_of(corner), next_corner(c)), right, to_right, to_left));
    }
  }
  for (const SurfacePoint& place : places) {
    if (poll_.cancelled()) return;
    const FaceRecord& face = adjacency_.face(place.face);
    if (!source.at_vertex()) {
      for (std::uint32_t c = 0; c < 3; ++c) {
        // The triangle of the source and this side: where its ends are, with the source
        // at the origin and the side's direction as the x axis.
        const double base2 = face.length2(c);
        const double height = place.bary[previous_corner(c)] * face.area2;
        if (!(base2 > 0) || !(height > 0) || is_line(face)) continue;
        const double base = std::sqrt(base2);
        const double foot =
            place.bary[next_corner(c)] * base2 + place.bary[previous_corner(c)] * face.dot[c];
        const Vec2 tail{-foot / base, -height / base};
        const Vec2 head{(base2 - foot) / base, -height / base};
        if (cones.size() == most_faces) continue;
        cones.push_back(cone_over(face, halfedge(place.face, c), face.vertex[c], tail, head));
      }
    }
    for (std::uint32_t c = 0; c < 3; ++c) {
      see(face.vertex[c], distance_to_corner(adjacency_.mesh(), place, c));
    }
  }
  look_around(
      source.at_vertex() ? surface_ : adjacency_.triangulation(), cones, most_faces,
      [&](std::uint32_t v, double straight) { return worthwhile.is_nearest(v, straight); },
      [this](std::uint32_t v, double straight) { see(v, straight); });
}

}  // namespace geodesic
