// The bytes behind the buffers of a glTF file: the binary chunk as it lies in
// the file, and base64 data URIs and compressed views decoded when first needed.
// What nobody reads is never decoded; what is elsewhere is never fetched.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "proto/gltf_file/document.h"

namespace geodesic::proto {

// Not for several threads at once: reading may decode. `document` and `binary`
// must outlive it.
class GltfBuffers {
 public:
  // `has_binary`: the file is a GLB with a binary chunk, which may be empty.
  // `max_decompressed`: how many bytes compressed views may come to in all.
  GltfBuffers(const GltfDocument& document, std::span<const std::byte> binary, bool has_binary,
              std::uint64_t max_decompressed);

  // The bytes of a buffer view, decompressed, valid as long as this object.
  // Errors: external_uri; mesh_invalid when the view or its buffer reaches past the
  // bytes present; those of `decode_meshopt`.
  [[nodiscard]] Result<std::span<const std::byte>> view(std::size_t index);

 private:
  Result<std::span<const std::byte>> buffer(std::size_t index);
  Result<std::span<const std::byte>> part(std::size_t index, std::uint64_t offset,
                                          std::uint64_t length, const std::string& name);
  Result<std::span<const std::byte>> decompressed(std::size_t view);

  const GltfDocument& document_;
  std::span<const std::byte> binary_;
  bool has_binary_;
  std::vector<std::optional<std::vector<std::byte>>> decoded_;  // of data URIs
  std::map<std::size_t, std::vector<std::byte>> decompressed_;  // of views
  std::uint64_t decompressed_left_;                             // bytes still allowed
};

// Base64 with or without padding; nothing when a character is not of its alphabet.
[[nodiscard]] std::optional<std::vector<std::byte>> decode_base64(std::string_view text);

}  // namespace geodesic::proto
