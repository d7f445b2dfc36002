#include "proto/gltf_file/buffers.h"

#include <array>
#include <cstdint>
#include <string>
#include <utility>

#include "proto/wire/input_codes.h"

namespace geodesic::proto {
namespace {

constexpr std::uint8_t kNotBase64 = 0xFF;

constexpr std::array<std::uint8_t, 256> base64_values() {
  std::array<std::uint8_t, 256> values{};
  values.fill(kNotBase64);
  constexpr std::string_view kAlphabet =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (std::size_t i = 0; i < kAlphabet.size(); ++i) {
    values[static_cast<unsigned char>(kAlphabet[i])] = static_cast<std::uint8_t>(i);
  }
  return values;
}

std::string name_of_buffer(std::size_t index) { return "buffer " + std::to_string(index); }

}  // namespace

std::optional<std::vector<std::byte>> decode_base64(std::string_view text) {
  static constexpr auto kValues = base64_values();
  for (int i = 0; i < 2 && text.ends_with('='); ++i) text.remove_suffix(1);
  if (text.size() % 4 == 1) return std::nullopt;
  std::vector<std::byte> bytes(text.size() / 4 * 3 + text.size() % 4 * 3 / 4);
  std::size_t out = 0;
  std::uint32_t bits = 0;
  std::uint8_t bad = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::uint8_t value = kValues[static_cast<unsigned char>(text[i])];
    bad |= value;  // a good value is below 64
    bits = bits << 6 | (value & 63u);
    if (i % 4 == 3) {
      bytes[out++] = static_cast<std::byte>(bits >> 16);
      bytes[out++] = static_cast<std::byte>(bits >> 8);
      bytes[out++] = static_cast<std::byte>(bits);
    }
  }
  if (text.size() % 4 == 2) bytes[out++] = static_cast<std::byte>(bits >> 4);
  if (text.size() % 4 == 3) {
    bytes[out++] = static_cast<std::byte>(bits >> 10);
    bytes[out++] = static_cast<std::byte>(bits >> 2);
  }
  if (bad >= 64) return std::nullopt;
  return bytes;
}

GltfBuffers::GltfBuffers(const GltfDocument& document, std::span<const std::byte> binary,
                         bool has_binary, std::uint64_t max_decompressed)
    : document_(document),
      binary_(binary),
      has_binary_(has_binary),
      decoded_(document.buffers.size()),
      decompressed_left_(max_decompressed) {}

Result<std::span<const std::byte>> GltfBuffers::buffer(std::size_t index) {
  const GltfBuffer& buffer = document_.buffers[index];
  std::span<const std::byte> bytes;
  if (!buffer.uri) {
    if (index != 0 || !has_binary_) {
      return fail(ErrorCode::mesh_invalid, name_of_buffer(index) + " has no data.");
    }
    bytes = binary_;
  } else {
    auto& decoded = decoded_[index];
    if (!decoded) {
      const std::string_view uri = *buffer.uri;
      const std::size_t comma = uri.find(',');
      if (!uri.starts_with("data:")) {
        return fail(InputCode::external_uri, name_of_buffer(index) +
                                                 " is in another file; only files with "
                                                 "everything embedded are read.");
      }
      if (comma == std::string_view::npos || !uri.substr(0, comma).ends_with(";base64")) {
        return fail(ErrorCode::mesh_invalid,
                    name_of_buffer(index) + ": its data URI is not in base64.");
      }
      decoded = decode_base64(uri.substr(comma + 1));
      if (!decoded) {
        return fail(ErrorCode::mesh_invalid,
                    name_of_buffer(index) + ": its data URI is not valid base64.");
      }
    }
    bytes = *decoded;
  }
  if (buffer.byte_length > bytes.size()) {
    return fail(ErrorCode::mesh_invalid, name_of_buffer(index) + " claims " +
                                             std::to_string(buffer.byte_length) + " bytes, but " +
                                             std::to_string(bytes.size()) + " are present.");
  }
  return bytes.first(buffer.byte_length);
}

Result<std::span<const std::byte>> GltfBuffers::part(std::size_t index, std::uint64_t offset,
                                                     std::uint64_t length,
                                                     const std::string& name) {
  const auto bytes = buffer(index);
  if (!bytes) return fail(bytes.error());
  // Both are below 2^53 (gltf_file/json.cpp): the sum does not overflow.
  if (offset + length > bytes->size()) {
    return fail(ErrorCode::mesh_invalid,
                name + " reaches to byte " + std::to_string(offset + length) + " of " +
                    name_of_buffer(index) + ", which has " + std::to_string(bytes->size()) + ".");
  }
  return bytes->subspan(offset, length);
}

Result<std::span<const std::byte>> GltfBuffers::decompressed(std::size_t index) {
  const GltfBufferView& view = document_.views[index];
  const std::string name = "bufferView " + std::to_string(index);
  if (const auto it = decompressed_.find(index); it != decompressed_.end()) return it->second;
  const GltfMeshopt& meshopt = *view.meshopt;
  const auto bytes =
      part(meshopt.buffer, meshopt.offset, meshopt.length, name + ": its compressed data");
  if (!bytes) return fail(bytes.error());
  if (!is_known_meshopt(*bytes, meshopt.layout)) {
    // Too new for us: a file may have the plain bytes as well.
    if (const auto plain = part(view.buffer, view.offset, view.length, name)) return *plain;
  }
  auto plain = decode_meshopt(*bytes, meshopt.layout, decompressed_left_, name);
  if (!plain) return fail(std::move(plain.error()));
  if (view.length > plain->size()) {
    return fail(ErrorCode::mesh_invalid, name + " claims " + std::to_string(view.length) +
                                             " bytes, but its compressed data decodes to " +
                                             std::to_string(plain->size()) + ".");
  }
  decompressed_left_ -= plain->size();
  return decompressed_.emplace(index, std::move(*plain)).first->second;
}

Result<std::span<const std::byte>> GltfBuffers::view(std::size_t index) {
  const GltfBufferView& view = document_.views[index];
  if (view.meshopt) return decompressed(index);
  return part(view.buffer, view.offset, view.length, "bufferView " + std::to_string(index));
}

}  // namespace geodesic::proto
