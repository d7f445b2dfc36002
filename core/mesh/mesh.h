// A triangle mesh: positions and faces, welded, ordered and checked once, then
// never changed. Shared by all queries through `shared_ptr<const Mesh>`.
//
// Two numberings live side by side. *Source* vertices and faces are those of
// the client's file, and the only ones a client ever sees. *Mesh* vertices and
// faces (just "vertex" and "face" in core) differ in three ways:
//   - source vertices at the same position are welded into one vertex, unless the
//     client wants only what its file joins;
//   - vertices follow a space-filling curve, and faces their vertices, so that
//     what is near on the surface is near in memory whatever the file's order;
//   - source faces that welding leaves with two equal corners are dropped: they
//     have no surface, and the two edges that they joined have become one.
// A face keeps the corner order of its source face, so barycentric coordinates
// need no translation.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/base/vec3.h"
#include "core/mesh/triangle_soup.h"

namespace geodesic {

inline constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

using Triangle = std::array<std::uint32_t, 3>;

struct Box {
  Vec3 min;
  Vec3 max;
};

// What `Mesh::build` makes one vertex of.
enum class Weld : std::uint8_t {
  by_position,  // source vertices at the same position
  // Nothing, so that faces are joined by the indices of the file alone; but corners
  // of one face at the same position become one even so, for an edge has a length.
  off,
};

class Mesh {
 public:
  // Coordinates beyond this are refused: the engine multiplies four lengths.
  static constexpr double kMaxCoordinate = 1e60;
  // Coordinates nearer to zero than this are taken as zero, for the same reason.
  static constexpr double kMinCoordinate = 1e-60;

  // Errors: mesh_invalid (a coordinate that is not finite or too large, or no
  // face with three different corners), index_out_of_range, no_triangles,
  // too_many_vertices and too_many_faces (more than 32-bit indices hold), cancelled.
  [[nodiscard]] static Result<Mesh> build(const TriangleSoup& soup, Weld weld = Weld::by_position);
  [[nodiscard]] static Result<Mesh> build(const TriangleSoup& soup, Weld weld,
                                          const Cancel& cancel);

  [[nodiscard]] std::uint32_t vertex_count() const {
    return static_cast<std::uint32_t>(positions_.size());
  }
  [[nodiscard]] std::uint32_t face_count() const {
    return static_cast<std::uint32_t>(faces_.size());
  }
  [[nodiscard]] std::uint32_t source_vertex_count() const {
    return static_cast<std::uint32_t>(vertex_of_source_.size());
  }
  [[nodiscard]] std::uint32_t source_face_count() const {
    return static_cast<std::uint32_t>(face_of_source_.size());
  }

  [[nodiscard]] std::span<const Vec3> positions() const { return positions_; }
  [[nodiscard]] std::span<const Triangle> faces() const { return faces_; }

  // Source vertex -> vertex, and back to the first source vertex welded into it.
  [[nodiscard]] std::span<const std::uint32_t> vertex_of_source() const {
    return vertex_of_source_;
  }
  [[nodiscard]] std::uint32_t source_of_vertex(std::uint32_t vertex) const {
    return source_of_vertex_[vertex];
  }
  // Source face -> face, kNone when it was dropped, and back.
  [[nodiscard]] std::uint32_t face_of_source(std::uint32_t source_face) const {
    return face_of_source_[source_face];
  }
  [[nodiscard]] std::uint32_t source_of_face(std::uint32_t face) const {
    return source_of_face_[face];
  }
  struct DroppedFace {
    std::uint32_t source_face;
    Triangle vertices;
  };
  // Ascending by source face.
  [[nodiscard]] std::span<const DroppedFace> dropped_faces() const { return dropped_; }
  // The vertices of a source face that was dropped (two or three are equal).
  [[nodiscard]] Triangle dropped_face(std::uint32_t source_face) const;

  [[nodiscard]] std::uint32_t dropped_face_count() const {
    return static_cast<std::uint32_t>(dropped_.size());
  }
  // Whether these are the corners of a face that counts as one without area: its
  // height is no more than rounding would leave of zero.
  [[nodiscard]] static bool is_without_area(Vec3 a, Vec3 b, Vec3 c);
  [[nodiscard]] std::uint32_t zero_area_face_count() const { return zero_area_faces_; }
  [[nodiscard]] const Box& box() const { return box_; }
  [[nodiscard]] double area() const { return area_; }

  // Heap memory held, for the byte budget of a cache.
  [[nodiscard]] std::size_t bytes() const;

 private:
  // The steps of building. Each leaves off when the poll says to stop.
  void weld(const TriangleSoup& soup, Weld weld, Poll& poll);
  void order_faces(const TriangleSoup& soup, Poll& poll);
  void measure(Poll& poll);

  std::vector<Vec3> positions_;
  std::vector<Triangle> faces_;
  std::vector<std::uint32_t> vertex_of_source_;
  std::vector<std::uint32_t> source_of_vertex_;
  std::vector<std::uint32_t> face_of_source_;
  std::vector<std::uint32_t> source_of_face_;
  std::vector<DroppedFace> dropped_;  // ascending by source face
  std::uint32_t zero_area_faces_ = 0;
  Box box_;
  double area_ = 0;
};

}  // namespace geodesic
