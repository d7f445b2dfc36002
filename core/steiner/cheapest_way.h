// What a field of costs says of any point: what it costs to get there, and by which way.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/cancel.h"
#include "core/field/field.h"
#include "core/steiner/strip_graph.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"

namespace geodesic {

// Of a field by steiner_field or steiner_field_towards with a cost, which must have kept its
// details where it is asked of points that are no vertices, and of ways. All that are referred to
// must outlive this.
class CheapestWays {
 public:
  // Of no use if the poll says to stop.
  CheapestWays(const Adjacency& adjacency, const Field& field, Poll& poll);

  // The last step of the cheapest way to a point: straight inside a face from a node of the graph,
  // or from a source.
  struct LastStep {
    double cost = kUnreached;  // of the whole way, with the source's offset
    std::uint32_t node = kNone;
    std::uint32_t source = kNone;  // where the way begins; kNone: there is none
  };
  // Of no use if the poll says to stop.
  [[nodiscard]] LastStep last_step_to(const SurfacePoint& point) const;

  // The nodes of the way that ends with this step, from the source on. Of no use if the poll says
  // to stop. O(n) for n faces.
  [[nodiscard]] std::vector<Crossing> way_of(const LastStep& last) const;

 private:
  struct SourcePlace {
    std::uint32_t face;
    std::uint32_t source;
  };
  void consider_node(std::uint32_t node, double d, double step, LastStep& best) const;
  [[nodiscard]] std::uint32_t source_of_node(std::uint32_t node) const;

  const Adjacency& adjacency_;
  const Field& field_;
  Poll& poll_;
  std::vector<SourcePlace> source_places_;  // ascending by face
};

}  // namespace geodesic
