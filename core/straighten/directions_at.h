// The angles of directions in which ways leave a point, counted as straightest_geodesic_at_angle
// counts them.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/base/vec3.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"

namespace geodesic {

class DirectionsAt {
 public:
  // Errors: value_out_of_range for `from` (at a vertex in no face, or where the faces are not one
  // fan: on an edge of three faces or more, at a pinched vertex); cancelled.
  [[nodiscard]] static Result<DirectionsAt> of(const Adjacency& adjacency, const SurfacePoint& from,
                                               const Cancel& cancel);

  // Of a vector in the plane of a face at the point, of any length but zero. In radians: from 0 to
  // below `total` if directions go all round; if not, between the two edges of the boundary. None
  // if the face is not at the point.
  [[nodiscard]] std::optional<double> angle_of(std::uint32_t face, Vec3 direction) const;
  // 1 if angles grow counter-clockwise in a face at the point, by the face's own winding, and -1 if
  // clockwise. None if the face is not at the point.
  [[nodiscard]] std::optional<int> sense_of(std::uint32_t face) const;

  // The sum of the angles of all faces there: 2 pi inside a face.
  [[nodiscard]] double total() const { return total_; }
  // Whether no boundary is in the way.
  [[nodiscard]] bool all_round() const { return all_round_; }
  // What angles are multiplied by so that they make a full turn: round a vertex where they are more
  // or less; on a boundary only if they are more. Knoppel, Crane, Pinkall and Schroder, "Globally
  // optimal direction fields", 2013.
  [[nodiscard]] double scale() const;

 private:
  // A face at a vertex, and where it begins in the turn round it.
  struct Sector {
    std::uint32_t face;
    std::uint32_t corner;
    double begin;      // the angle of the edge by which the turn enters it
    double size;       // its own angle
    bool from_next;    // that edge leads to the corner's next one
    bool is_backward;  // it is entered against the sense in which angles grow
  };

  DirectionsAt(const Adjacency& adjacency, const SurfacePoint& from)
      : adjacency_(&adjacency), from_(from) {}
  // That of a face at the vertex; null if it is not at it.
  [[nodiscard]] const Sector* sector_of(std::uint32_t face) const;
  // What is beyond the edge that the point is on, as a side of `face`; kNone if it is not there.
  [[nodiscard]] Halfedge beyond_edge(std::uint32_t face) const;
  [[nodiscard]] Result<void> turn_round_vertex(Poll& poll);
  [[nodiscard]] Result<void> look_across_edge(std::uint32_t side);
  // Adds the faces from that of `side` on, to where the fan ends or has come round.
  [[nodiscard]] Result<void> turn(Halfedge side, bool is_backward, Poll& poll);

  const Adjacency* adjacency_;
  SurfacePoint from_;
  double total_ = 0;
  bool all_round_ = true;
  std::vector<Sector> sectors_;   // by face; of a vertex
  std::uint32_t across_ = kNone;  // of a point on an edge: the side of from_.face that it is on
};

}  // namespace geodesic
