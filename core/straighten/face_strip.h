// A strip of faces, each joined to the next over an edge, and its unfolding into
// the plane: what a path on the surface is straightened in.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/vec2.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"

namespace geodesic {

// One edge that a strip crosses, as the face before it and the face after it have
// it. The two halfedges are of one ring.
struct Portal {
  Halfedge out;
  Halfedge in;
};

// portals.size() + 1 faces: the first, and one behind each portal. No face is entered
// and left over the same edge.
struct FaceStrip {
  std::uint32_t first_face = kNone;
  std::vector<Portal> portals;

  [[nodiscard]] std::uint32_t face(std::size_t i) const {
    return i == 0 ? first_face : face_of(portals[i - 1].in);
  }
  [[nodiscard]] std::uint32_t last_face() const { return face(portals.size()); }

  // Goes on over a portal that leaves the last face. Where that is the edge by which
  // the face was entered, the face drops out: a path gets shorter by staying on
  // the edge. So a strip that goes back on itself unravels.
  void cross(Portal portal);
};

// Takes off the faces at either end that a path from one point to the other need
// not enter: while the first portal goes through `start`, the first face, and while
// the last portal goes through `end`, the last.
void trim_strip(const Adjacency& adjacency, const SurfacePoint& start, const SurfacePoint& end,
                FaceStrip& strip);

// A portal in the plane, as one sees it who walks along the strip.
struct UnfoldedPortal {
  Vec2 left;
  Vec2 right;
  std::uint32_t left_vertex;
  std::uint32_t right_vertex;
};

// The faces of a strip side by side in the plane; they may overlap there. Their
// windings play no part. Angles and lengths are those of the surface, up to a
// rounding error per face that stays small for needles.
struct UnfoldedStrip {
  std::vector<UnfoldedPortal> unfolded_portals;  // one per portal
  Vec2 start;
  Vec2 end;
  // Unit vectors from corner c to corner c + 1 of the first and of the last face.
  std::array<Vec2, 3> first_edges;
  std::array<Vec2, 3> last_edges;
  // 1 if corners 0, 1, 2 of the face lie counter-clockwise there, -1 if clockwise: the edges of a
  // face without width do not tell.
  double first_sense;
  double last_sense;
};

// Unfolds `strip` into `result`, whose memory is used again. `start` must lie in the
// first face and `end` in the last, whichever of their faces they name.
void unfold_strip(const Adjacency& adjacency, const FaceStrip& strip, const SurfacePoint& start,
                  const SurfacePoint& end, UnfoldedStrip& result);

}  // namespace geodesic
