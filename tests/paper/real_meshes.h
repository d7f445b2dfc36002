// The optional folder of scanned meshes with exact distances from vertex 0, which
// the tests and the benchmark read. Its place is the environment's
// GEODESIC_SHARED, else the build's.
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/mesh/triangle_soup.h"
#include "proto/formats/decode_mesh.h"

namespace geodesic::fixtures {

struct RealMesh {
  TriangleSoup soup;
  // Exact distances from source vertex 0, one per source vertex; not finite, or
  // huge, where there is none.
  std::vector<double> exact;
};

inline constexpr const char* kRealMeshes[] = {"bunny35k", "horse", "nefertiti", "fandisk_m1"};

// A vertex in no face has a huge or infinite reference.
[[nodiscard]] inline bool has_reference(double exact) { return exact < 1e9; }

[[nodiscard]] inline std::filesystem::path shared_folder() {
  const char* from_environment = std::getenv("GEODESIC_SHARED");
  return from_environment != nullptr ? from_environment : GEODESIC_SHARED;
}

[[nodiscard]] inline std::vector<std::byte> read_bytes(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  std::vector<std::byte> bytes(text.size());
  std::memcpy(bytes.data(), text.data(), text.size());
  return bytes;
}

// Nothing when the folder does not have both the mesh and its distances. Errors:
// those of decode_mesh; mesh_invalid when there is not one distance per vertex.
[[nodiscard]] inline std::optional<Result<RealMesh>> load_real_mesh(const std::string& name) {
  static_assert(std::endian::native == std::endian::little, "references are little-endian");
  const std::filesystem::path folder = shared_folder() / "meshes";
  const auto mesh_file = folder / (name + ".glb");
  const auto exact_file = folder / "reference" / (name + ".v0.f64");
  if (!std::filesystem::exists(mesh_file) || !std::filesystem::exists(exact_file)) return {};
  auto decoded = proto::decode_mesh(read_bytes(mesh_file), proto::DecodeLimits{});
  if (!decoded) return Result<RealMesh>(fail(decoded.error()));
  const auto bytes = read_bytes(exact_file);
  if (bytes.size() != decoded->soup.positions.size() * sizeof(double)) {
    return Result<RealMesh>(fail(ErrorCode::mesh_invalid, "not one reference per vertex"));
  }
  RealMesh mesh{std::move(decoded->soup), {}};
  mesh.exact.resize(mesh.soup.positions.size());
  std::memcpy(mesh.exact.data(), bytes.data(), bytes.size());
  return Result<RealMesh>(std::move(mesh));
}

}  // namespace geodesic::fixtures
