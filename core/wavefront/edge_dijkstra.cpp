#include "core/wavefront/edge_dijkstra.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "core/field/vertex_front.h"

namespace geodesic {
namespace {

class EdgeDijkstra {
 public:
  EdgeDijkstra(const Adjacency& adjacency, const Detour& detour, Field& field, VertexHeap& heap)
      : adjacency_(adjacency),
        positions_(adjacency.mesh().positions()),
        is_even_(adjacency.triangulation().is_even),
        detour_(field.sources.size() == 1 ? detour : Detour{}),
        field_(field),
        distance_(field.distance.doubles()),
        heap_(heap) {}

  void start(const Source& source, std::uint32_t number) {
    if (source.point.at_vertex()) {
      lower(source.point.vertex, source.offset, {kNone, number}, number);
    }
    for (const SurfacePoint& place : in_all_faces(adjacency_, source.point)) {
      for (std::uint32_t c = 0; c < 3; ++c) {
        const double d = distance_to_corner(adjacency_.mesh(), place, c);
        lower(adjacency_.face(place.face).vertex[c], source.offset + d, {kNone, number}, number);
      }
    }
  }

  void spread_from(std::uint32_t v) {
    if (detour_.is_bounded() && detour_.is_too_far(distance_[v] - field_.sources[0].offset,
                                                   adjacency_.mesh().positions()[v])) {
      return;
    }
    const std::uint32_t source = field_.nearest_source.empty() ? 0 : field_.nearest_source[v];
    for (const std::uint32_t corner : adjacency_.corners(v)) {
      const FaceRecord& face = adjacency_.face(face_of(corner));
      const std::uint32_t c = corner_of(corner);
      const std::uint32_t behind = previous_corner(c);
      for (const auto& [w, side] :
           {std::pair{face.vertex[next_corner(c)], c}, std::pair{face.vertex[behind], behind}}) {
        if (heap_.accepted(w)) continue;
        const double length = is_even_ ? std::sqrt(std::max(face.length2(side), 0.0))
                                       : distance(positions_[v], positions_[w]);
        lower(w, distance_[v] + length, {v, v}, source);
      }
    }
  }

  // What is still considered is not final.
  void forget(std::uint32_t v) {
    distance_[v] = kUnreached;
    field_.parents[v] = {};
    if (!field_.nearest_source.empty()) field_.nearest_source[v] = kNone;
  }

 private:
  void lower(std::uint32_t v, double d, Parents parents, std::uint32_t source) {
    if (!(d < distance_[v])) return;
    distance_[v] = d;
    field_.parents[v] = parents;
    if (!field_.nearest_source.empty()) field_.nearest_source[v] = source;
    heap_.push_or_lower(v, d);
  }

  const Adjacency& adjacency_;
  const std::span<const Vec3> positions_;
  // Else rounding may leave nothing of a face's short side.
  const bool is_even_;
  const Detour detour_;
  Field& field_;
  std::span<double> distance_;  // the field's
  VertexHeap& heap_;
};

}  // namespace

Result<Field> edge_dijkstra_field(const Adjacency& adjacency, std::span<const Source> sources,
                                  const FieldLimits& limits, WavefrontScratch& scratch,
                                  const Cancel& cancel) {
  const std::size_t vertex_count = adjacency.mesh().vertex_count();
  Field field = unreached_field(Method::dijkstra, sources, vertex_count);
  field.parents.assign(vertex_count, {});
  VertexHeap& heap = scratch.heap;
  heap.reset(vertex_count);
  EdgeDijkstra front(adjacency, limits.detour, field, heap);
  Poll poll(cancel);
  auto settled = settle_vertices(front, heap, limits, scratch.is_target, poll, field);
  if (!settled) return fail(std::move(settled.error()));
  return field;
}

}  // namespace geodesic
