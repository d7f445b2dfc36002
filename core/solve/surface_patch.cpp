#include "core/solve/surface_patch.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "core/base/vec3.h"
#include "core/mesh/mesh.h"
#include "core/mesh/triangle_soup.h"
#include "core/surface/refined_surface.h"
#include "core/surface/unfold_rounding.h"

namespace geodesic {
namespace {

// The length of the straight lines from a place to two others. At a place that is `r` away, it is
// less by at most 2 r.
struct Lines {
  Vec3 from;
  Vec3 to;
  [[nodiscard]] double by(Vec3 place) const { return distance(from, place) + distance(place, to); }
};

}  // namespace

Result<SurfacePatch> SurfacePatch::cut(const Adjacency& adjacency, const SurfacePoint& from,
                                       const SurfacePoint& to, double longest,
                                       const Cancel& cancel) {
  const Mesh& mesh = adjacency.mesh();
  const Lines lines{position_of(mesh, from), position_of(mesh, to)};
  Poll poll(cancel);
  std::vector<double> by(mesh.vertex_count());
  for (std::uint32_t v = 0; v < mesh.vertex_count() && !poll.cancelled(); ++v) {
    by[v] = lines.by(mesh.positions()[v]);
  }
  SurfacePatch patch;
  const auto is_near = [&](std::uint32_t f) {
    const Triangle& corners = mesh.faces()[f];
    const double least = std::min({by[corners[0]], by[corners[1]], by[corners[2]]});
    return least <= longest || least - 2 * longest_side(adjacency.face(f)) <= longest;
  };
  for (std::uint32_t f = 0; f < mesh.face_count() && !poll.cancelled(); ++f) {
    if (is_near(f)) patch.faces_.push_back(f);
  }
  if (poll.stopped()) return fail_stopped(cancel);
  if (patch.faces_.empty() || patch.faces_.size() == mesh.face_count()) return patch;
  TriangleSoup soup;
  std::vector<std::uint32_t> number(mesh.vertex_count(), kNone);
  for (const std::uint32_t f : patch.faces_) {
    Triangle corners = mesh.faces()[f];
    for (std::uint32_t& v : corners) {
      if (number[v] == kNone) {
        number[v] = static_cast<std::uint32_t>(patch.vertices_.size());
        patch.vertices_.push_back(v);
        soup.positions.push_back(mesh.positions()[v]);
      }
      v = number[v];
    }
    soup.faces.push_back(corners);
  }
  // What the surface joins is joined already.
  auto cut = Mesh::build(soup, Weld::off, cancel);
  if (!cut) return fail(std::move(cut.error()));
  auto prepared = build_unrefined(std::make_shared<const Mesh>(std::move(*cut)), cancel);
  if (!prepared) return fail(std::move(prepared.error()));
  patch.adjacency_ = std::make_unique<const Adjacency>(std::move(*prepared));
  return patch;
}

std::optional<SurfacePoint> SurfacePatch::inside(const SurfacePoint& point) const {
  const Mesh& mesh = adjacency_->mesh();
  if (!point.at_vertex()) {
    const auto at = std::lower_bound(faces_.begin(), faces_.end(), point.face);
    if (at == faces_.end() || *at != point.face) return std::nullopt;
    const auto source = static_cast<std::uint32_t>(at - faces_.begin());
    const std::uint32_t f = mesh.face_of_source(source);
    return f == kNone ? std::nullopt : std::optional(SurfacePoint{f, point.bary, kNone});
  }
  const auto at = std::find(vertices_.begin(), vertices_.end(), point.vertex);
  if (at == vertices_.end()) return std::nullopt;
  const auto source = static_cast<std::size_t>(at - vertices_.begin());
  const std::uint32_t v = mesh.vertex_of_source()[source];
  return v == kNone ? std::nullopt : std::optional(point_at_vertex(*adjacency_, v));
}

void SurfacePatch::bring_back(Path& path) const {
  const Mesh& mesh = adjacency_->mesh();
  for (PathPoint& at : path.points) {
    SurfacePoint& point = at.point;
    if (point.face != kNone) point.face = faces_[mesh.source_of_face(point.face)];
    if (point.at_vertex()) point.vertex = vertices_[mesh.source_of_vertex(point.vertex)];
  }
}

}  // namespace geodesic
