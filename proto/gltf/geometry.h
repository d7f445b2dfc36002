// The primitives of a glTF file with their bytes found and their counts known.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "core/base/error.h"
#include "core/mesh/triangle_soup.h"
#include "proto/gltf/accessor.h"
#include "proto/gltf_file/buffers.h"
#include "proto/gltf_file/document.h"
#include "proto/mesh/findings.h"

namespace geodesic::proto {

struct GltfGeometry {
  std::uint64_t vertices = 0;
  std::uint64_t faces = 0;
  GltfElements positions;
  std::optional<GltfElements> indices;
  std::shared_ptr<const TriangleSoup> draco;  // instead of the two above
};

// What the instances drawn so far come to, against the limits.
struct GltfRoom {
  std::uint64_t max_vertices = 0;
  std::uint64_t max_faces = 0;
  std::uint64_t vertices = 0;  // taken
  std::uint64_t faces = 0;

  // Whether so many more fit. Errors: too_many_vertices, too_many_faces.
  [[nodiscard]] Result<void> check(std::uint64_t more_vertices, std::uint64_t more_faces) const;
};

[[nodiscard]] bool draws_triangles(const GltfPrimitive& primitive);

// "mesh 0, primitive 2"
[[nodiscard]] std::string name_of_primitive(std::size_t mesh, std::size_t primitive);

// Finds each primitive's geometry once, whoever draws it. What it is given must
// outlive it.
class GltfGeometries {
 public:
  // `file_bytes` bounds what may be claimed without bytes of its own.
  GltfGeometries(const GltfDocument& document, GltfBuffers& buffers, std::uint64_t file_bytes,
                 Findings& findings);

  // Null: the primitive has no positions. `room`: how many vertices and faces may
  // still come, checked before anything is decoded or copied.
  // Errors name the primitive: those of `read_accessor` and of `decode_draco`.
  [[nodiscard]] Result<const GltfGeometry*> find(std::size_t mesh, std::size_t primitive,
                                                 const GltfRoom& room);

  // What an earlier `find` has found, or null.
  [[nodiscard]] const GltfGeometry* found(std::size_t mesh, std::size_t primitive) const;

 private:
  Result<GltfGeometry> read(const GltfPrimitive& primitive, const std::string& name,
                            const GltfRoom& room);
  Result<GltfGeometry> read_draco(const GltfPrimitive& primitive, const std::string& name,
                                  const GltfRoom& room);

  const GltfDocument& document_;
  GltfBuffers& buffers_;
  std::uint64_t file_bytes_;
  Findings& findings_;
  std::vector<std::vector<std::optional<GltfGeometry>>> known_;  // by mesh and primitive
  std::map<std::tuple<std::size_t, std::uint32_t, bool>, std::shared_ptr<const TriangleSoup>>
      draco_;
};

// An error of a primitive's parts, naming the primitive too.
[[nodiscard]] tl::unexpected<Error> in_primitive(Error error, std::size_t mesh,
                                                 std::size_t primitive);

}  // namespace geodesic::proto
