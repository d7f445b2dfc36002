#include "proto/gltf_file/container.h"

#include <cstdint>
#include <cstring>
#include <string>

#include "proto/mesh/text_tokens.h"

namespace geodesic::proto {
namespace {

constexpr std::uint32_t kJsonChunk = 0x4E4F534A;    // "JSON"
constexpr std::uint32_t kBinaryChunk = 0x004E4942;  // "BIN\0"
constexpr std::size_t kHeaderSize = 12;
constexpr std::size_t kChunkHeaderSize = 8;

std::uint32_t read_u32(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i-- > 0;)
    value = value << 8 | std::to_integer<std::uint32_t>(bytes[at + i]);
  return value;
}

std::string_view as_text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace

Result<GltfContainer> open_glb(std::span<const std::byte> bytes) {
  if (bytes.size() < kHeaderSize) {
    return fail(ErrorCode::mesh_invalid, "The GLB ends within its 12-byte header.");
  }
  if (const std::uint32_t version = read_u32(bytes, 4); version != 2) {
    return fail(ErrorCode::mesh_invalid,
                "The GLB is of version " + std::to_string(version) + "; only version 2 is read.");
  }
  const std::uint32_t length = read_u32(bytes, 8);
  if (length < kHeaderSize || length > bytes.size()) {
    return fail(ErrorCode::mesh_invalid, "The GLB header claims " + std::to_string(length) +
                                             " bytes, but " + std::to_string(bytes.size()) +
                                             " are present.");
  }
  GltfContainer container;
  container.trailing_bytes = bytes.size() - length;
  bytes = bytes.first(length);
  std::size_t at = kHeaderSize;
  for (std::size_t chunk = 0; at < bytes.size(); ++chunk) {
    const std::string name = "GLB chunk " + std::to_string(chunk);
    if (bytes.size() - at < kChunkHeaderSize) {
      return fail(ErrorCode::mesh_invalid, name + " ends within its 8-byte header.");
    }
    const std::uint32_t size = read_u32(bytes, at);
    const std::uint32_t type = read_u32(bytes, at + 4);
    at += kChunkHeaderSize;
    if (size > bytes.size() - at) {
      return fail(ErrorCode::mesh_invalid, name + " claims " + std::to_string(size) +
                                               " bytes, but " + std::to_string(bytes.size() - at) +
                                               " are left.");
    }
    if (size % 4 != 0) {
      return fail(ErrorCode::mesh_invalid,
                  name + " has " + std::to_string(size) + " bytes, which is no multiple of 4.");
    }
    const auto content = bytes.subspan(at, size);
    at += size;
    if (chunk == 0 && type != kJsonChunk) {
      return fail(ErrorCode::mesh_invalid, "GLB chunk 0 is not the JSON chunk.");
    }
    if (type == kJsonChunk || type == kBinaryChunk) container.others_at = at;
    if (chunk == 0) {
      container.json = as_text(content);
      // Padding is to be spaces; some exporters write zeros.
      while (container.json.ends_with('\0')) container.json.remove_suffix(1);
    } else if (chunk == 1 && type == kBinaryChunk) {
      container.binary = content;
      container.has_binary = true;
    } else if (type == kJsonChunk || type == kBinaryChunk) {
      return fail(ErrorCode::mesh_invalid,
                  name + " is a JSON or BIN chunk, which is not to be there.");
    }  // chunks of other types are to be ignored
  }
  if (container.json.empty()) {
    return fail(ErrorCode::mesh_invalid, "The GLB has no JSON chunk, or an empty one.");
  }
  return container;
}

GltfContainer open_gltf(std::span<const std::byte> bytes) {
  GltfContainer container;
  container.json = text_of_file(bytes);
  return container;
}

Result<void> check_json_shape(std::string_view json, const DecodeLimits& limits) {
  std::uint64_t depth = 0;
  std::uint64_t values = 1;
  for (std::size_t at = 0; at < json.size(); ++at) {
    switch (json[at]) {
      case '"': {
        // To the closing quote: one that an even number of backslashes precedes.
        const std::size_t begin = at;
        for (;;) {
          const std::size_t from = at + 1;
          at = json.find('"', from);
          if (at == std::string_view::npos) {
            return fail(ErrorCode::mesh_invalid, "The glTF's JSON does not parse at byte " +
                                                     std::to_string(begin + 1) +
                                                     ", where a string begins that has no end.");
          }
          std::size_t slashes = 0;
          while (at - slashes > from && json[at - slashes - 1] == '\\') ++slashes;
          if (slashes % 2 == 0) break;
        }
        break;
      }
      case '{':
      case '[':
        if (++depth > limits.max_json_depth) {
          return fail_limit(ErrorCode::mesh_invalid, "The glTF's JSON is nested too deep.",
                            limits.max_json_depth, depth);
        }
        ++values;
        break;
      case '}':
      case ']':
        if (depth > 0) --depth;
        break;
      case ',':
        ++values;
        break;
      default:
        break;
    }
  }
  if (values > limits.max_json_values) {
    return fail_limit(ErrorCode::too_large, "The glTF's JSON holds too many values.",
                      limits.max_json_values, values);
  }
  return {};
}

}  // namespace geodesic::proto
