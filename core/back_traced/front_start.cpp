// How a front begins: the estimates of what is visible from the source.
#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "core/back_traced/front.h"
#include "core/back_traced/visibility_cones.h"
#include "core/base/tolerances.h"
#include "core/surface/line_gaps.h"
#include "core/surface/unfold_rounding.h"

namespace geodesic {
namespace {

// Faces that the look around from a source at a vertex crosses; beyond some hundred vertices the
// front does as well.
constexpr std::size_t kVisibleFaces = 2000;
// From a point inside a face it goes over the mesh's own faces, of which there may be many to one
// of the Delaunay triangulation: with 2,000, distances near the poles of a sphere are up to 4 % too
// long, and 20 % where that is stretched; with 10,000 0.2 % and 8 %.
constexpr std::size_t kVisibleFacesFromInside = 10'000;

// Of so many, memory is asked for.
constexpr std::size_t kFewCones = 16'384;

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

void BackTracedFront::start(std::span<const Source> sources, const detail::Worthwhile& worthwhile) {
  sources_ = sources;
  overlap_ = adjacency_.report().mean_edge;
  scratch_.crowds.reset(surface_, poll_);
  const double width = bucket_width(surface_.faces);
  for (FrontDomain& domain : domains_) domain.waiting.reset(width);
  least_gain_ = kLeastGain * width;
  // All look around together, those that have crossed fewer faces first, so that each soon meets
  // the others. Only the mesh's own faces say where a point inside one is, and what it sees over
  // them. The front goes on from there over the Delaunay triangulation, as from a vertex.
  for (const bool at_vertex : {true, false}) {
    const std::size_t most = at_vertex ? kVisibleFaces : kVisibleFacesFromInside;
    std::vector<VisibilityCone>& cones = scratch_.cones;
    cones.clear();
    for (std::uint32_t s = 0; s < sources.size() && !poll_.stopped(); ++s) {
      if (sources[s].point.at_vertex() == at_vertex) look_out_of_faces(s, cones, most);
    }
    std::vector<std::size_t> crossed(sources.size(), 0);
    look_around(
        at_vertex ? surface_ : adjacency_.triangulation(), cones, most, crossed, poll_,
        [&](std::uint32_t source, std::uint32_t v, double straight) {
          return has_several_sources()
                     ? straight + sources[source].offset < least_known(v) + overlap_
                     : worthwhile.is_nearest(v, straight);
        },
        [this](std::uint32_t source, std::uint32_t v, double straight) {
          see(v, straight, source);
        });
  }
}

// Sees the corners of the faces that a source is in, and adds its cones out of these, at most so
// many.
void BackTracedFront::look_out_of_faces(std::uint32_t number, std::vector<VisibilityCone>& cones,
                                        std::size_t most) {
  const SurfacePoint& source = sources_[number].point;
  const auto places = in_all_faces_at(adjacency_, source, poll_);
  const auto see = [this, number](std::uint32_t v, double straight) {
    this->see(v, straight, number);
  };
  const std::size_t end = cones.size() + most;
  const auto has_room = [&] {
    return cones.size() < end && (cones.size() < cones.capacity() || cones.size() < kFewCones ||
                                  poll_.may_take(2 * cones.size() * sizeof(VisibilityCone)));
  };
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
      if (is_line(face)) continue;
      if (!surface_.is_even && !(length > tolerance::kLeastSide * longest_side(face))) continue;
      if (!has_room()) continue;
      cones.push_back(cone_over(number, face, halfedge(face_of(corner), next_corner(c)), right,
                                to_right, to_left));
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
        if (!has_room()) continue;
        cones.push_back(
            cone_over(number, face, halfedge(place.face, c), face.vertex[c], tail, head));
      }
    }
    for (std::uint32_t c = 0; c < 3; ++c) {
      see(face.vertex[c], distance_to_corner(adjacency_.mesh(), place, c));
    }
  }
}

}  // namespace geodesic
