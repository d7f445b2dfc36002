// The distance of any surface point from a field over the vertices, and the way
// by which it got there: the step that both point queries and the trace back use.
// Tang et al. 2007, section 3.3, steps 1 and 3.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/field/field.h"
#include "core/paths/window_paths.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"
#include "core/wavefront/virtual_source.h"

namespace geodesic {

// Where the shortest way to a point came from, one step back: a straight segment
// inside `face`, whose other end has the weights `bary` there.
struct StepBack {
  enum class To : std::uint8_t {
    nowhere,  // no way leads here
    edge,     // a point on the edge `base` of the face
    vertex,   // the vertex `vertex`
    source,   // the source `source`
  };
  To to = To::nowhere;
  double distance = kUnreached;  // of the point itself
  std::uint32_t face = kNone;
  std::array<double, 3> start{};  // the point's own weights in `face`
  std::array<double, 3> bary{};
  Halfedge base = kNone;
  std::uint32_t vertex = kNone;
  std::uint32_t source = kNone;
};

class PointArrivals {
 public:
  // All must outlive this object. The poll, if there is one, is asked once a face, for a
  // vertex or an edge may have as many as it likes; what is answered after it says to stop
  // is of no use.
  PointArrivals(const Adjacency& adjacency, const Field& field, Poll* poll = nullptr);
  PointArrivals(const PointArrivals&) = delete;  // it may refer to its own poll
  PointArrivals& operator=(const PointArrivals&) = delete;
  ~PointArrivals() = default;

  // The shortest way to a point that lies in `place.face`, through that face
  // only: over each side whose ends both have a distance, straight from each of
  // the face's corners, and straight from sources in the same face; of methods with a
  // wave for each of several sources, straight from those in the faces beside it, too.
  [[nodiscard]] StepBack through_face(const SurfacePoint& place) const;

  // Whether a step is to be taken rather than another one from the same point: a shorter
  // way, and of two that are as long, up to rounding, the one that is sooner at its end. Through
  // faces without area a way may lead back to where it is, so a step that stays there is last.
  [[nodiscard]] bool is_better(const StepBack& step, const StepBack& than) const;

  // The way to a vertex, by its parents.
  [[nodiscard]] StepBack by_parents(std::uint32_t vertex) const;

  // From a vertex of a `fast_marching` field to another one of a lesser distance: to
  // the least by way of an edge, or of the virtual edge of an obtuse face, which is
  // several steps. There always is one, except from a source: so a way that goes
  // down by such steps ends.
  [[nodiscard]] std::vector<StepBack> to_lesser_vertex(std::uint32_t vertex) const;

  // From a point of a face straight to one end of the side that starts at corner
  // c: to the end by which it is closer to the sources.
  [[nodiscard]] StepBack to_end_of_side(std::uint32_t face, std::uint32_t c,
                                        const std::array<double, 3>& start) const;

  // The faces that a way may come to the point by: those it lies in, and of `back_traced`, where no
  // windows lead through faces without width, those that are joined to it by such (line_gaps.h).
  [[nodiscard]] std::vector<SurfacePoint> all_faces_at(const SurfacePoint& point) const;

  // The distance of any point: by windows on a machine part, or the least over those faces.
  [[nodiscard]] double distance_at(const SurfacePoint& point) const;
  // What windows on a machine part say, if the field has kept them and the point's place is known.
  [[nodiscard]] std::optional<double> by_kept_windows(const SurfacePoint& point) const;

  // Null where the field has kept no such windows.
  [[nodiscard]] const WindowPaths* window_paths() const {
    return window_paths_ ? &*window_paths_ : nullptr;
  }

  // Whether the poll has said to stop, so that the answer is of no use; asks nobody.
  [[nodiscard]] bool was_stopped() const { return poll_->stopped(); }

 private:
  [[nodiscard]] int steps_to_go(const StepBack& step) const;
  [[nodiscard]] bool stopped() const { return poll_->cancelled(); }

  struct SourcePlace {
    std::uint32_t face;
    std::uint32_t source;
    std::array<double, 3> bary;
  };
  [[nodiscard]] Arrival over_base(std::uint32_t p, std::uint32_t q, const UnfoldedApex& apex) const;
  [[nodiscard]] StepBack straight_from_source(std::uint32_t vertex, std::uint32_t source) const;
  [[nodiscard]] std::span<const SourcePlace> sources_in(std::uint32_t face) const;
  [[nodiscard]] StepBack from_sources_in_face(const SurfacePoint& place) const;
  // Straight over the side that starts at corner c from sources in the faces beyond it; `apex`: the
  // place over that side.
  [[nodiscard]] StepBack from_sources_beyond(const SurfacePoint& place, std::uint32_t c,
                                             const UnfoldedApex& apex) const;
  // The same, or straight from those corners whose distance is below `limit`.
  [[nodiscard]] StepBack straight_in_face(const SurfacePoint& place, double limit) const;
  // through_face for `steiner`: from the face's corners and the points on its sides.
  [[nodiscard]] StepBack through_graph(const SurfacePoint& place) const;
  // through_face for the exact methods: from the face's corners and the windows on
  // its sides.
  [[nodiscard]] StepBack through_windows(const SurfacePoint& place) const;
  // The shortest way to a vertex through any face there, for the methods without
  // parents: those of graphs and windows, and `fast_marching`, whose virtual
  // triangles are no faces.
  [[nodiscard]] StepBack through_faces_at(std::uint32_t vertex) const;
  // A way back by distances alone goes on only to what is closer to the sources, or
  // it might not end. The distance of the vertex or the point on an edge at this
  // place, of the methods without parents; else kUnreached.
  [[nodiscard]] double below(const SurfacePoint& place) const;

  const Adjacency& adjacency_;
  const Field& field_;
  Cancel never_;
  Poll never_stopped_{never_};
  Poll* poll_;
  std::vector<SourcePlace> source_places_;  // ascending by face
  std::optional<WindowPaths> window_paths_;
};

}  // namespace geodesic
