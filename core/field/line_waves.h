// Sources that are lines or faces, and the waves that leave the lines.
//
// Round a point, lines of equal distance are circles. Beside a line they are straight: a wave
// leaves it at right angles, and distances there are linear. Bommes, Kobbelt, "Accurate computation
// of geodesic distance fields for polygonal curves on triangle meshes", 2007. A strip, there a
// linear window, is the part of such a wave that crosses one edge. Its lines of flow are straight
// over any number of faces. Where they meet a vertex, the strip parts; what bends round that vertex
// is no strip any more, but the circles of a source there.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/field/vertex_distances.h"
#include "core/surface/adjacency.h"
#include "core/surface/point.h"

namespace geodesic {

// A straight piece of a source line, within one face or on one of its sides. Both ends have an
// exact zero for the same corner where it runs along the side opposite.
struct LineSegment {
  std::uint32_t face = kNone;
  std::array<double, 3> from{};  // weights of the face's corners
  std::array<double, 3> to{};
  std::uint32_t item = 0;  // which of the things that were asked for it belongs to

  // The halfedge that it runs along, or kNone.
  [[nodiscard]] Halfedge along() const;
};

// What a field starts from besides points.
struct SourceLines {
  std::vector<LineSegment> segments;
  // By face: the item that has the whole face, or kNone. Empty: none has any.
  std::vector<std::uint32_t> item_of_face;
  // By the number of a source: the item that it belongs to. The ends of all segments are sources.
  std::vector<std::uint32_t> item_of_source;

  [[nodiscard]] bool has_face(std::uint32_t f) const {
    return !item_of_face.empty() && item_of_face[f] != kNone;
  }
  [[nodiscard]] std::size_t bytes() const {
    return segments.capacity() * sizeof(LineSegment) +
           (item_of_face.capacity() + item_of_source.capacity()) * sizeof(std::uint32_t);
  }
};

// A part of an edge over which a wave enters the face of a halfedge. In the frame of
// VisibleInterval (window_table.h): the edge on the x axis, the face above. Distances grow along
// (b, c), a unit vector: that of the point (x, y) is value + b (x - begin) + c y, all in mesh
// units.
struct LineStrip {
  double begin;
  double end;
  double value;  // at `begin`
  double b;
  double c;  // above 0
  Halfedge into;
  std::uint32_t parent;   // the strip over the edge before; kNone: from the segment itself
  std::uint32_t segment;  // where it began
  std::uint32_t crossed;  // faces since then

  [[nodiscard]] double at(double p) const { return value + b * (p - begin); }
  [[nodiscard]] double least() const { return b < 0 ? at(end) : value; }
};

// A face over one of its halfedges, which runs from (0, 0) to (base, 0).
struct FaceOnBase {
  double base;
  double left;   // from the beginning of the base to the apex
  double right;  // and from its end
  double apex_x;
  double apex_y;
  double apex_back;  // base - apex_x, with the digits of its own

  [[nodiscard]] static FaceOnBase of(const Adjacency& adjacency, Halfedge h);
};

// Where the straight way from the lines to a point came from.
struct LineArrival {
  double distance = kUnreached;
  SurfacePoint place;             // the point, in the face that it is seen in
  std::uint32_t strip = kNone;    // into the point's face, or
  std::uint32_t segment = kNone;  // the segment in the same face
};

class LineWaves {
 public:
  // `given`: the number of sources that were asked for. Vertices that strips have met come after
  // them.
  // `strips` in any order, empty if no details are kept; one whose `into` is kNone is none. Of no
  // use if the poll says to stop.
  LineWaves(const Adjacency& adjacency, std::shared_ptr<const SourceLines> lines,
            std::uint32_t given, std::vector<LineStrip> strips, bool has_strips, Poll& poll);

  // The least over the strips and segments that the point sees straight, in the faces it lies in.
  // 0 in a face that is a source. kUnreached where no strips are kept. The poll, if there is one,
  // is asked once a face.
  [[nodiscard]] LineArrival arrive(const Adjacency& adjacency, const SurfacePoint& point,
                                   Poll* poll = nullptr) const;
  // What an arrival that is not kUnreached is from.
  [[nodiscard]] std::uint32_t item_of(const LineArrival& arrival) const;

  // The strips into a halfedge's face, if they are kept, and the segments within a face that run
  // along no side of it; numbers both.
  [[nodiscard]] std::span<const std::uint32_t> strips_into(Halfedge h) const {
    return std::span(order_).subspan(begin_[h], begin_[h + 1] - begin_[h]);
  }
  [[nodiscard]] std::span<const std::uint32_t> segments_within(std::uint32_t f) const;

  [[nodiscard]] const SourceLines& lines() const { return *lines_; }
  [[nodiscard]] const LineStrip& strip(std::uint32_t number) const { return strips_[number]; }
  [[nodiscard]] std::uint32_t given() const { return given_; }

  // The item that a source of the field belongs to.
  [[nodiscard]] std::uint32_t item_of_source(std::uint32_t source) const {
    return source < given_ ? lines_->item_of_source[source] : later_items_[source - given_];
  }
  // Of the sources that were added, one after the other.
  void add_item(std::uint32_t item) { later_items_.push_back(item); }

  [[nodiscard]] std::size_t bytes() const;

 private:
  void arrive_in_face(const Adjacency& adjacency, const SurfacePoint& place,
                      LineArrival& best) const;

  std::shared_ptr<const SourceLines> lines_;
  std::uint32_t given_;
  bool has_strips_;
  std::vector<LineStrip> strips_;
  std::vector<std::uint32_t> begin_;        // by halfedge, and the end: its strips in `order_`
  std::vector<std::uint32_t> order_;        // numbers of strips
  std::vector<std::uint32_t> in_face_;      // numbers of segments within faces, by face
  std::vector<std::uint32_t> later_items_;  // by source, from `given` on
};

// A point, by its three weights of a face's corners, in the plane of that face: corner 0 at the
// origin, corner 1 on the x axis, corner 2 above it. Mesh units. `face` is over halfedge 0 here and
// below.
struct FlatPoint {
  double x;
  double y;
};
[[nodiscard]] FlatPoint flat_point(const FaceOnBase& face, const std::array<double, 3>& bary);

// A point beside a segment of the same face.
struct BesideSegment {
  double along;   // of the foot of its perpendicular, from the segment's beginning
  double aside;   // its distance from the segment's line, above 0 on the left of it
  double length;  // of the segment
};
[[nodiscard]] BesideSegment beside(const FaceOnBase& face, const LineSegment& segment,
                                   const std::array<double, 3>& bary);

// Of an edge's length, how far beyond its ends a strip or segment is still taken to go.
inline constexpr double kStripSlack = 1e-12;

}  // namespace geodesic
