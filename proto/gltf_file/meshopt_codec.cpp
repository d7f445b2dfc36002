// The one place that includes meshoptimizer. Its decoders are made for untrusted
// bytes, but not for untrusted layouts, which they assert: those are checked here.
#include "proto/gltf_file/meshopt_codec.h"

#include <meshoptimizer.h>

#include <algorithm>

#include "proto/wire/input_codes.h"

namespace geodesic::proto {
namespace {

// Bytes that one byte may stand for. Vertices: where nothing changes, version 0 has
// two bits for sixteen bytes, and version 1 one byte for 256 elements of four.
// Indices: a byte makes a triangle, or one index.
#if MESHOPTIMIZER_VERSION >= 230
constexpr unsigned kNewestVertexVersion = 1;
constexpr std::uint64_t kVertexClaimsPerByte = 1024;
#else
constexpr unsigned kNewestVertexVersion = 0;
constexpr std::uint64_t kVertexClaimsPerByte = 64;
#endif
constexpr unsigned kNewestIndexVersion = 1;
constexpr std::uint64_t kIndexClaimsPerByte = 12;
// What headers, tails and the last, unfilled block may claim beyond that.
constexpr std::uint64_t kClaimsForFree = 16384;

constexpr std::uint64_t kMostStride = 256;

unsigned newest_version(MeshoptMode mode) {
  return mode == MeshoptMode::attributes ? kNewestVertexVersion : kNewestIndexVersion;
}

unsigned codec_of(MeshoptMode mode) {
  switch (mode) {
    case MeshoptMode::attributes:
      return 0xA0;
    case MeshoptMode::triangles:
      return 0xE0;
    case MeshoptMode::indices:
      return 0xD0;
  }
  return 0;
}

// What the extension allows and the decoders take for granted; an empty text if so.
std::string fault_of(const MeshoptLayout& layout) {
  const std::uint64_t stride = layout.stride;
  if (layout.mode == MeshoptMode::attributes) {
    if (stride == 0 || stride % 4 != 0 || stride > kMostStride) {
      return "a stride that is no multiple of 4 up to 256";
    }
  } else if (stride != 2 && stride != 4) {
    return "indices that have neither 2 nor 4 bytes";
  }
  if (layout.mode == MeshoptMode::triangles && layout.count % 3 != 0) {
    return "a count that is no multiple of 3";
  }
  if (layout.mode != MeshoptMode::attributes && layout.filter != MeshoptFilter::none) {
    return "a filter that is only for attributes";
  }
  if (layout.filter == MeshoptFilter::octahedral && stride != 4 && stride != 8) {
    return "an octahedral filter, but a stride that is neither 4 nor 8";
  }
  if (layout.filter == MeshoptFilter::quaternion && stride != 8) {
    return "a quaternion filter, but a stride that is not 8";
  }
  return {};
}

bool decode_into(std::vector<std::byte>& out, std::span<const std::byte> bytes,
                 const MeshoptLayout& layout) {
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  switch (layout.mode) {
    case MeshoptMode::attributes:
      return meshopt_decodeVertexBuffer(out.data(), layout.count, layout.stride, data,
                                        bytes.size()) == 0;
    case MeshoptMode::triangles:
      return meshopt_decodeIndexBuffer(out.data(), layout.count, layout.stride, data,
                                       bytes.size()) == 0;
    case MeshoptMode::indices:
      return meshopt_decodeIndexSequence(out.data(), layout.count, layout.stride, data,
                                         bytes.size()) == 0;
  }
  return false;
}

void filter(std::vector<std::byte>& out, const MeshoptLayout& layout) {
  switch (layout.filter) {
    case MeshoptFilter::octahedral:
      return meshopt_decodeFilterOct(out.data(), layout.count, layout.stride);
    case MeshoptFilter::quaternion:
      return meshopt_decodeFilterQuat(out.data(), layout.count, layout.stride);
    case MeshoptFilter::exponential:
      return meshopt_decodeFilterExp(out.data(), layout.count, layout.stride);
    case MeshoptFilter::none:
    case MeshoptFilter::colour:
      return;
  }
}

}  // namespace

bool is_known_meshopt(std::span<const std::byte> bytes, const MeshoptLayout& layout) {
  if (bytes.empty() || layout.filter == MeshoptFilter::colour) return false;
  const auto first = std::to_integer<unsigned>(bytes[0]);
  return (first & 0xF0U) != codec_of(layout.mode) || (first & 0x0FU) <= newest_version(layout.mode);
}

Result<std::vector<std::byte>> decode_meshopt(std::span<const std::byte> bytes,
                                              const MeshoptLayout& layout, std::uint64_t max_bytes,
                                              const std::string& name) {
  if (const std::string fault = fault_of(layout); !fault.empty()) {
    return fail(ErrorCode::mesh_invalid, name + ": its compressed data claims " + fault + ".");
  }
  if (!bytes.empty() && !is_known_meshopt(bytes, layout)) {
    return fail(InputCode::extension_required,
                name +
                    " is compressed by a newer version of meshopt compression, or a filter for "
                    "colours, which is not supported.");
  }
  // The counts are below 2^53 and the stride is at most 2^8.
  const std::uint64_t size = layout.count * layout.stride;
  const std::uint64_t per_byte =
      layout.mode == MeshoptMode::attributes ? kVertexClaimsPerByte : kIndexClaimsPerByte;
  if (size > kClaimsForFree + per_byte * bytes.size()) {
    return fail(ErrorCode::mesh_invalid, name + " claims " + std::to_string(layout.count) +
                                             " elements of " + std::to_string(layout.stride) +
                                             " bytes, compressed into " +
                                             std::to_string(bytes.size()) + " bytes.");
  }
  if (size > max_bytes) {
    return fail_limit(ErrorCode::too_large, name + " decodes to too many bytes.", max_bytes, size);
  }
  std::vector<std::byte> out(size);
  if (!decode_into(out, bytes, layout)) {
    return fail(ErrorCode::mesh_invalid, name + ": its compressed data does not decode.");
  }
  filter(out, layout);
  return out;
}

}  // namespace geodesic::proto
