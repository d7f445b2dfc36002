// What the decoder keeps of a glTF file: nodes, meshes, accessors and buffer
// views as plain values, without the JSON, and without what has no bearing on
// geometry. Every reference between these arrays is proved to be in range when
// a document is made (gltf_file/json.cpp); what is said about bytes is proved when
// the bytes are read (gltf/accessor.cpp).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "proto/gltf_file/meshopt_codec.h"
#include "proto/gltf_file/transform.h"

namespace geodesic::proto {

struct GltfBuffer {
  std::uint64_t byte_length = 0;
  std::optional<std::string> uri;  // none: the binary chunk of a GLB
};

// Where the compressed bytes of a buffer view are, and what they decode to.
struct GltfMeshopt {
  std::size_t buffer = 0;
  std::uint64_t offset = 0;
  std::uint64_t length = 0;
  MeshoptLayout layout;
};

struct GltfBufferView {
  std::size_t buffer = 0;
  std::uint64_t offset = 0;
  std::uint64_t length = 0;
  std::uint64_t stride = 0;            // bytes from one element to the next; 0: tightly packed
  std::optional<GltfMeshopt> meshopt;  // then the bytes above are only a fallback
};

struct GltfSparse {
  std::uint64_t count = 0;
  std::size_t index_view = 0;
  std::uint64_t index_offset = 0;
  int index_type = 0;
  std::size_t value_view = 0;
  std::uint64_t value_offset = 0;
};

// glTF's numbers for the type of one component.
enum GltfComponent : int {
  gltf_int8 = 5120,
  gltf_uint8 = 5121,
  gltf_int16 = 5122,
  gltf_uint16 = 5123,
  gltf_uint32 = 5125,
  gltf_float32 = 5126,
};

struct GltfAccessor {
  std::optional<std::size_t> view;  // none: zeros, or what `sparse` says
  std::uint64_t offset = 0;
  std::uint64_t count = 0;
  int component_type = 0;
  int components = 1;  // 1 for SCALAR … 16 for MAT4
  bool normalized = false;
  std::optional<GltfSparse> sparse;
  std::vector<double> min;  // as said, one a component; or empty
  std::vector<double> max;
};

struct GltfDraco {
  std::size_t view = 0;
  std::uint32_t position_id = 0;  // unique id of the attribute in the Draco bitstream
};

// glTF's numbers for what a primitive draws.
enum GltfMode : int {
  gltf_points = 0,
  gltf_lines = 1,
  gltf_line_loop = 2,
  gltf_line_strip = 3,
  gltf_triangles = 4,
  gltf_triangle_strip = 5,
  gltf_triangle_fan = 6,
};

struct GltfPrimitive {
  int mode = gltf_triangles;
  std::optional<std::size_t> position;
  std::optional<std::size_t> indices;
  std::optional<GltfDraco> draco;
  std::optional<std::size_t> material;  // not proved to be there: geometry does not depend on it
  // Of each morph target the accessor of what it adds to the positions, if it does.
  std::vector<std::optional<std::size_t>> targets;
};

struct GltfMesh {
  std::string name;
  std::vector<double> weights;  // of its primitives' targets; what is missing is 0
  std::vector<GltfPrimitive> primitives;
};

// The accessors of EXT_mesh_gpu_instancing; at least one is there.
struct GltfInstancing {
  std::optional<std::size_t> translation;
  std::optional<std::size_t> rotation;
  std::optional<std::size_t> scale;
};

struct GltfNode {
  std::string name;
  std::optional<std::size_t> mesh;
  std::vector<std::size_t> children;
  GltfTransform to_parent;
  bool has_skin = false;
  std::vector<double> weights;               // instead of its mesh's, when there are any
  std::optional<GltfInstancing> instancing;  // how its mesh is drawn
};

struct GltfDocument {
  std::vector<GltfBuffer> buffers;
  std::vector<GltfBufferView> views;
  std::vector<GltfAccessor> accessors;
  std::vector<GltfMesh> meshes;
  std::vector<std::string> material_names;  // the first kMostMaterials
  std::size_t materials = 0;                // of the file
  std::vector<GltfNode> nodes;
  std::vector<std::vector<std::size_t>> scenes;  // root nodes of each
  std::vector<std::string> scene_names;
  std::optional<std::size_t> scene;  // the default one
  bool has_rtc_center = false;       // CESIUM_RTC: all positions are relative to it
};

}  // namespace geodesic::proto
