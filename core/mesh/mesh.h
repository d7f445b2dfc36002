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
// A mesh of some of a file's faces (cut_mesh.h) has the file's numbers, too: there source vertices
// and source faces may be on no part of it.
// A face keeps the corner order of its source face, so barycentric coordinates
// need no translation.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>

#include "core/base/cancel.h"
#include "core/base/error.h"
#include "core/base/shared_array.h"
#include "core/base/vec3.h"
#include "core/mesh/triangle_soup.h"

namespace geodesic {

inline constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

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

  struct DroppedFace {
    std::uint32_t source_face;
    Triangle vertices;
  };
  // All that a mesh consists of. Written to a file and read back, it is the same mesh. Arrays are
  // indexed by what their names end with.
  struct Parts {
    SharedArray<Vec3> positions;  // of vertices
    SharedArray<Triangle> faces;
    SharedArray<std::uint32_t> vertex_of_source;
    SharedArray<std::uint32_t> source_of_vertex;
    SharedArray<std::uint32_t> face_of_source;
    SharedArray<std::uint32_t> source_of_face;
    SharedArray<DroppedFace> dropped;  // ascending by source face
    std::uint32_t zero_area_faces = 0;
    Box box;
    double area = 0;
  };
  // `parts` are those of a mesh that `build` has made; they are not checked.
  explicit Mesh(Parts parts) : parts_(std::move(parts)) {}
  [[nodiscard]] const Parts& parts() const { return parts_; }

  [[nodiscard]] std::uint32_t vertex_count() const {
    return static_cast<std::uint32_t>(parts_.positions.size());
  }
  [[nodiscard]] std::uint32_t face_count() const {
    return static_cast<std::uint32_t>(parts_.faces.size());
  }
  [[nodiscard]] std::uint32_t source_vertex_count() const {
    return static_cast<std::uint32_t>(parts_.vertex_of_source.size());
  }
  [[nodiscard]] std::uint32_t source_face_count() const {
    return static_cast<std::uint32_t>(parts_.face_of_source.size());
  }

  [[nodiscard]] std::span<const Vec3> positions() const { return parts_.positions; }
  [[nodiscard]] std::span<const Triangle> faces() const { return parts_.faces; }

  // Source vertex -> vertex, and back to the first source vertex welded into it. kNone for those
  // that are on no face of a mesh that was cut out of another.
  [[nodiscard]] std::span<const std::uint32_t> vertex_of_source() const {
    return parts_.vertex_of_source;
  }
  [[nodiscard]] std::uint32_t source_of_vertex(std::uint32_t vertex) const {
    return parts_.source_of_vertex[vertex];
  }
  // Source face -> face, kNone when it was dropped or cut away, and back.
  [[nodiscard]] std::uint32_t face_of_source(std::uint32_t source_face) const {
    return parts_.face_of_source[source_face];
  }
  [[nodiscard]] std::uint32_t source_of_face(std::uint32_t face) const {
    return parts_.source_of_face[face];
  }
  // Ascending by source face.
  [[nodiscard]] std::span<const DroppedFace> dropped_faces() const { return parts_.dropped; }
  // The vertices of a source face that was dropped (two or three are equal).
  [[nodiscard]] Triangle dropped_face(std::uint32_t source_face) const;
  // Whether a source face was dropped. One that was cut away was not.
  [[nodiscard]] bool is_dropped(std::uint32_t source_face) const;

  [[nodiscard]] std::uint32_t dropped_face_count() const {
    return static_cast<std::uint32_t>(parts_.dropped.size());
  }
  // Whether these are the corners of a face that counts as one without area: its
  // height is no more than rounding would leave of zero.
  [[nodiscard]] static bool is_without_area(Vec3 a, Vec3 b, Vec3 c);
  [[nodiscard]] std::uint32_t zero_area_face_count() const { return parts_.zero_area_faces; }
  [[nodiscard]] const Box& box() const { return parts_.box; }
  [[nodiscard]] double area() const { return parts_.area; }

  // Memory held, for the byte budget of a cache.
  [[nodiscard]] std::size_t bytes() const;

 private:
  Parts parts_;
};

}  // namespace geodesic
