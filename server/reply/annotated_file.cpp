#include "server/reply/annotated_file.h"

#include <openssl/evp.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "proto/gltf_file/container.h"

namespace geodesic::server {
namespace {

constexpr std::size_t kGlbHeader = 12;
constexpr std::size_t kChunkHeader = 8;
// Between two questions whether anybody waits.
constexpr std::size_t kPiece = std::size_t{3} << 16;

tl::unexpected<Error> other_file() {
  return fail(ErrorCode::internal, "what is to change in the file does not fit it");
}

void append(std::string& out, std::string_view bytes, Poll& poll) {
  while (!bytes.empty() && !poll.cancelled()) {
    const std::string_view piece = bytes.substr(0, kPiece);
    out += piece;
    bytes.remove_prefix(piece.size());
  }
}

void append_base64(std::string& out, std::string_view bytes, Poll& poll) {
  std::string text;
  while (!bytes.empty() && !poll.cancelled()) {
    const std::string_view piece = bytes.substr(0, kPiece);  // of threes, but for the last one
    text.resize((piece.size() + 2) / 3 * 4 + 1);
    const int size = ::EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                                       reinterpret_cast<const unsigned char*>(piece.data()),
                                       static_cast<int>(piece.size()));
    out.append(text, 0, static_cast<std::size_t>(size));
    bytes.remove_prefix(piece.size());
  }
}

void append_number(std::string& out, std::uint64_t value) {
  for (int i = 0; i < 4; ++i) out += static_cast<char>(value >> (8 * i) & 0xFF);
}

// The values in the file's order. What says where they are comes from a process that has read a
// file of anybody's, so nothing of it is taken on trust.
Result<std::string> values_in_order(const proto::GltfAnnotation& annotation,
                                    const std::vector<proto::VertexAttribute>& attributes,
                                    const std::vector<std::string>& floats, Poll& poll) {
  if (attributes.size() != floats.size()) return other_file();
  std::string values;
  for (std::size_t k = 0; k < attributes.size(); ++k) {
    const std::uint64_t each = attributes[k].components * sizeof(float);
    const std::uint64_t vertices = floats[k].size() / each;
    for (const proto::VertexRun& run : annotation.runs) {
      if (run.first > vertices || run.count > vertices - run.first) return other_file();
      append(values, std::string_view(floats[k]).substr(run.first * each, run.count * each), poll);
      if (poll.cancelled()) return fail_stopped(poll);
    }
  }
  return values;
}

// The document with the values in it where they belong there.
std::string document_of(const proto::GltfAnnotation& annotation, std::string_view values,
                        Poll& poll) {
  const std::string_view json = annotation.json;
  if (annotation.values_at == proto::GltfAnnotation::kInChunk) return annotation.json;
  std::string text;
  text.reserve(json.size() + (values.size() + 2) / 3 * 4 + 4);
  append(text, json.substr(0, annotation.values_at), poll);
  append_base64(text, values, poll);
  append(text, json.substr(annotation.values_at), poll);
  return text;
}

}  // namespace

Result<std::string> write_annotated(std::string_view file, const proto::GltfAnnotation& annotation,
                                    const std::vector<proto::VertexAttribute>& attributes,
                                    const std::vector<std::string>& floats, Poll& poll) {
  const bool in_chunk = annotation.values_at == proto::GltfAnnotation::kInChunk;
  if (!in_chunk && annotation.values_at > annotation.json.size()) return other_file();
  const auto values = values_in_order(annotation, attributes, floats, poll);
  if (!values) return fail(values.error());
  std::string json = document_of(annotation, *values, poll);
  if (poll.stopped()) return fail_stopped(poll);
  if (!file.starts_with("glTF")) return in_chunk ? other_file() : Result<std::string>(json);

  const auto container = proto::open_glb(std::as_bytes(std::span(file)));
  if (!container || (in_chunk && !container->has_binary)) return other_file();
  json.append((4 - json.size() % 4) % 4, ' ');
  const std::size_t binary_size =
      container->has_binary ? container->binary.size() + (in_chunk ? values->size() : 0) : 0;
  const std::size_t size = kGlbHeader + kChunkHeader + json.size() +
                           (container->has_binary ? kChunkHeader + binary_size : 0) +
                           (file.size() - container->trailing_bytes - container->others_at);
  if (size > std::numeric_limits<std::uint32_t>::max()) return other_file();
  std::string glb = "glTF";
  glb.reserve(size + container->trailing_bytes);
  append_number(glb, 2);
  append_number(glb, size);
  append_number(glb, json.size());
  glb += "JSON";
  append(glb, json, poll);
  if (container->has_binary) {
    append_number(glb, binary_size);
    glb.append("BIN\0", 4);
    append(glb, {reinterpret_cast<const char*>(container->binary.data()), container->binary.size()},
           poll);
    if (in_chunk) append(glb, *values, poll);
  }
  append(glb, file.substr(container->others_at), poll);
  if (poll.stopped()) return fail_stopped(poll);
  return glb;
}

}  // namespace geodesic::server
