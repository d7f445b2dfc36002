#include "core/exact/surface.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "core/field/straight_away.h"
#include "core/surface/refined_surface.h"

namespace geodesic::exact {
namespace {

// On scans stretched 8 times, the windows on the Delaunay triangulation over those on the mesh
// are this part of the estimates' ratio, from 0.68 to 0.79.
constexpr double kFewerWindows = 0.75;

// Of so many faces or more, some are looked at: they are numbered along a curve that fills
// space, so those come from everywhere.
constexpr std::size_t kSample = 8192;
std::size_t stride_through(std::size_t faces) { return std::max<std::size_t>(faces / kSample, 1); }

double crossings_on_mesh(const Adjacency& adjacency, std::span<const Source> sources, Poll& poll) {
  const StraightAway straight(adjacency.mesh(), sources);
  const auto faces = adjacency.faces();
  const std::size_t stride = stride_through(faces.size());
  double sum = 0;
  for (std::size_t f = 0; f < faces.size() && !poll.cancelled(); f += stride) {
    const auto extents = straight.extents_across(faces[f].vertex);
    if (extents) sum += (*extents)[0] + (*extents)[1] + (*extents)[2];
  }
  return static_cast<double>(stride) * sum;
}

double crossings_in_any_direction(const Triangulation& surface, Poll& poll) {
  const std::size_t stride = stride_through(surface.faces.size());
  double sum = 0;
  for (std::size_t f = 0; f < surface.faces.size() && !poll.cancelled(); f += stride) {
    const FaceRecord& face = surface.faces[f];
    for (std::uint32_t c = 0; c < 3; ++c) sum += std::sqrt(std::max(face.length2(c), 0.0));
  }
  return 2 / std::numbers::pi * static_cast<double>(stride) * sum;
}

}  // namespace

std::size_t count_edges(const Adjacency& adjacency, const Triangulation& surface) {
  return adjacency.report().edges +
         (surface.corner_begin.size() - 1 - adjacency.mesh().vertex_count()) +
         (surface.faces.size() - adjacency.faces().size());
}

bool is_refined(const Adjacency& adjacency, const Triangulation& surface) {
  return adjacency.refined() != nullptr &&
         surface.faces.data() == adjacency.refined()->triangulation().faces.data();
}

std::vector<PlaceInFace> places_on(const Adjacency& adjacency, const Triangulation& surface,
                                   const SurfacePoint& point, Poll& poll) {
  std::vector<PlaceInFace> places;
  if (surface.faces.data() == adjacency.faces().data()) {
    for (const SurfacePoint& in_face : in_all_faces(adjacency, point)) {
      PlaceInFace place{in_face.face, in_face.bary, {}};
      for (std::uint32_t c = 0; c < 3; ++c) {
        place.to_corner[c] = distance_to_corner(adjacency.mesh(), in_face, c);
      }
      places.push_back(place);
    }
    return places;
  }
  if (!is_refined(adjacency, surface)) return {};
  for (const RefinedSurface::Place& known :
       adjacency.refined()->places_of(adjacency.triangulation(), point.face, point.bary, poll)) {
    PlaceInFace place{known.face, known.weights, {}};
    const std::array<double, 3>& weights = known.weights;
    // A source at a vertex that was added would make a pseudo-source of it.
    if (std::count(weights.begin(), weights.end(), 0.0) > 1) return {};
    const FaceRecord& record = surface.faces[known.face];
    for (std::uint32_t c = 0; c < 3; ++c) {
      // Along the two sides that leave the corner.
      const double p = weights[next_corner(c)];
      const double q = weights[previous_corner(c)];
      place.to_corner[c] = std::sqrt(std::max(p * p * record.length2(c) +
                                                  q * q * record.length2(previous_corner(c)) +
                                                  2 * p * q * record.dot[c],
                                              0.0));
    }
    places.push_back(place);
  }
  return places;
}

namespace {

// `worth`: how often the crossings count on a surface where points may have no place: on the
// Delaunay triangulation, and on a refined surface whose faces are wound differently, at some
// vertices.
Triangulation surface_of_fewest(const Adjacency& adjacency, std::span<const Source> sources,
                                double worth, Poll& poll) {
  const Triangulation mesh = adjacency.triangulation();
  const Triangulation delaunay = adjacency.delaunay();
  const bool is_flipped = delaunay.faces.data() != mesh.faces.data();
  if ((!is_flipped && adjacency.refined() == nullptr) || sources.empty()) return mesh;
  const auto has_all = [&](const Triangulation& surface) {
    return std::all_of(sources.begin(), sources.end(), [&](const Source& source) {
      return source.point.at_vertex() || !places_on(adjacency, surface, source.point, poll).empty();
    });
  };
  Triangulation best = mesh;
  double fewest = crossings_on_mesh(adjacency, sources, poll);
  // Fewer windows come of any other than these lines say.
  const auto consider = [&](const Triangulation& other, double factor) {
    const double crossings = factor * kFewerWindows * crossings_in_any_direction(other, poll);
    if (!(crossings < fewest) || !has_all(other)) return;
    best = other;
    fewest = crossings;
  };
  if (is_flipped) consider(delaunay, worth);
  if (adjacency.refined() != nullptr) {
    consider(adjacency.refined()->triangulation(), mesh.is_oriented ? 1 : worth);
  }
  return poll.stopped() ? mesh : best;
}

}  // namespace

Triangulation surface_for_windows(const Adjacency& adjacency, std::span<const Source> sources,
                                  Poll& poll) {
  return surface_of_fewest(adjacency, sources, 1, poll);
}

Triangulation surface_of_part(const Adjacency& adjacency, std::span<const Source> sources,
                              Poll& poll) {
  return surface_of_fewest(adjacency, sources, 3, poll);
}

Triangulation surface_with_directions(const Adjacency& adjacency, std::span<const Source> sources,
                                      Poll& poll) {
  const Triangulation mesh = adjacency.triangulation();
  const RefinedSurface* refined = adjacency.refined();
  if (refined == nullptr || !refined->has_all_directions(mesh)) return mesh;
  constexpr double kNeverWorth = kUnreached;
  return surface_of_fewest(adjacency, sources, kNeverWorth, poll);
}

}  // namespace geodesic::exact
