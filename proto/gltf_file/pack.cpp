#include "proto/gltf_file/pack.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "proto/gltf_file/container.h"
#include "proto/gltf_file/extensions.h"
#include "proto/gltf_file/json_checks.h"
#include "proto/wire/input_codes.h"
#include "proto/wire/json_outline.h"

namespace geodesic::proto {
namespace {

using nlohmann::ordered_json;

constexpr std::uint64_t kMostPackedBytes = std::uint64_t{1} << 53;
constexpr std::size_t kBufferAlignment = 8;

std::optional<unsigned> hexadecimal(char c) {
  if (c >= '0' && c <= '9') return static_cast<unsigned>(c - '0');
  if (c >= 'a' && c <= 'f') return static_cast<unsigned>(c - 'a' + 10);
  if (c >= 'A' && c <= 'F') return static_cast<unsigned>(c - 'A' + 10);
  return std::nullopt;
}

// What is no escape stays as it is.
std::string percent_decoded(std::string_view text) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto high = i + 2 < text.size() ? hexadecimal(text[i + 1]) : std::nullopt;
    const auto low = i + 2 < text.size() ? hexadecimal(text[i + 2]) : std::nullopt;
    if (text[i] == '%' && high && low) {
      decoded += static_cast<char>(*high * 16 + *low);
      i += 2;
    } else {
      decoded += text[i];
    }
  }
  return decoded;
}

std::string fit_for_message(std::string text) {
  text.resize(std::min<std::size_t>(text.size(), 64));
  for (char& c : text) {
    if (c < 0x20 || c > 0x7E) c = '?';
  }
  return text;
}

void append_little_endian(std::string& out, std::uint64_t value) {
  for (int i = 0; i < 4; ++i) out += static_cast<char>(value >> (8 * i) & 0xFF);
}

std::optional<std::uint64_t> whole_number(const ordered_json& object, const char* key,
                                          std::optional<std::uint64_t> absent) {
  const auto it = object.find(key);
  if (it == object.end()) return absent;
  if (!it->is_number_unsigned() || it->get<std::uint64_t>() > kMostPackedBytes) {
    return std::nullopt;
  }
  return it->get<std::uint64_t>();
}

class Packing {
 public:
  Packing(ordered_json document, const NamedFiles& files)
      : document_(std::move(document)), files_(files) {}

  Result<std::string> run() {
    for (const char* key : {"buffers", "bufferViews"}) {
      const auto it = document_.find(key);
      if (it == document_.end()) continue;
      bool good = it->is_array();
      for (const ordered_json& item : *it) good = good && item.is_object();
      if (!good)
        return fail(ErrorCode::mesh_invalid, std::string(key) + " is no array of objects.");
    }
    if (auto merged = merge_buffers(); !merged) return fail(std::move(merged.error()));
    if (auto moved = move_views(); !moved) return fail(std::move(moved.error()));
    return written();
  }

 private:
  // Where a buffer of the document is now.
  struct Place {
    std::uint64_t buffer = 0;
    std::uint64_t offset = 0;
    std::optional<std::uint64_t> length;  // of those in the binary chunk
  };

  Result<void> merge_buffers() {
    ordered_json kept = ordered_json::array();
    const ordered_json none = ordered_json::array();
    const ordered_json& buffers = document_.contains("buffers") ? document_["buffers"] : none;
    for (std::size_t i = 0; i < buffers.size(); ++i) {
      const std::string name = "buffer " + std::to_string(i);
      const auto uri = buffers[i].find("uri");
      const bool is_text = uri != buffers[i].end() && uri->is_string();
      if (!is_text || uri->get_ref<const std::string&>().starts_with("data:")) {
        places_.push_back({1 + kept.size(), 0, {}});
        kept.push_back(buffers[i]);
        continue;
      }
      const auto bytes = file_of(uri->get_ref<const std::string&>());
      if (!bytes) {
        return fail(InputCode::external_uri,
                    name + " is in " + fit_for_message(uri->get_ref<const std::string&>()) +
                        ", which is not among the parts.");
      }
      const auto length = whole_number(buffers[i], "byteLength", std::nullopt);
      if (!length || *length > bytes->size()) {
        return fail(ErrorCode::mesh_invalid, name + " claims more bytes than the " +
                                                 std::to_string(bytes->size()) +
                                                 " of its file, or no number of them.");
      }
      if (auto placed = place(*bytes, *length); !placed) return placed;
    }
    // Without a chunk of their own, views keep to the buffers that they have.
    if (binary_.empty()) {
      for (Place& place : places_) --place.buffer;
    } else {
      kept.insert(kept.begin(), ordered_json{{"byteLength", binary_.size()}});
    }
    if (!kept.empty()) document_["buffers"] = std::move(kept);
    return {};
  }

  // A file that several buffers are in is there once: otherwise few bytes would become
  // as many as there are buffers times as many.
  Result<void> place(std::string_view file, std::uint64_t length) {
    const auto known = placed_.find(file.data());
    if (known != placed_.end() && length <= *known->second.length) {
      places_.push_back({0, known->second.offset, length});
      return {};
    }
    if (known != placed_.end()) {
      again_ += length;
      if (again_ > file.size()) {
        return fail(ErrorCode::too_large, "Several buffers are ever longer parts of one file.");
      }
    }
    binary_.resize((binary_.size() + kBufferAlignment - 1) / kBufferAlignment * kBufferAlignment);
    places_.push_back({0, binary_.size(), length});
    placed_[file.data()] = places_.back();
    binary_ += file.substr(0, length);
    return {};
  }

  [[nodiscard]] std::optional<std::string_view> file_of(const std::string& uri) const {
    std::string name = percent_decoded(uri);
    if (name.starts_with("./")) name.erase(0, 2);
    auto file = files_.find(name);
    if (file == files_.end()) file = files_.find(name.substr(name.rfind('/') + 1));
    if (file == files_.end()) return std::nullopt;
    return file->second;
  }

  Result<void> move_views() {
    if (!document_.contains("bufferViews")) return {};
    ordered_json& views = document_["bufferViews"];
    for (std::size_t i = 0; i < views.size(); ++i) {
      const std::string name = "bufferView " + std::to_string(i);
      if (auto moved = move_part(views[i], name); !moved) return moved;
      const auto extensions = views[i].find("extensions");
      if (extensions == views[i].end() || !extensions->is_object()) continue;
      for (const std::string_view extension : kMeshoptExtensions) {
        const auto it = extensions->find(std::string(extension));
        if (it == extensions->end() || !it->is_object()) continue;
        if (auto moved = move_part(*it, name + ", its compressed data,"); !moved) return moved;
      }
    }
    return {};
  }

  // Of a view or its compressed data. Checked against its own buffer, or it might reach
  // into the next one now.
  Result<void> move_part(ordered_json& part, const std::string& name) {
    const auto buffer = whole_number(part, "buffer", std::nullopt);
    if (!buffer || *buffer >= places_.size()) {
      return fail(ErrorCode::mesh_invalid,
                  name + " refers to a buffer that the file does not have.");
    }
    const Place& place = places_[*buffer];
    part["buffer"] = place.buffer;
    if (!place.length) return {};
    const auto offset = whole_number(part, "byteOffset", 0);
    const auto length = whole_number(part, "byteLength", std::nullopt);
    if (!offset || !length || *offset + *length > *place.length) {
      return fail(ErrorCode::mesh_invalid, name + " reaches beyond buffer " +
                                               std::to_string(*buffer) + ", which has " +
                                               std::to_string(*place.length) + " bytes.");
    }
    if (*offset + place.offset != 0) part["byteOffset"] = *offset + place.offset;
    return {};
  }

  Result<std::string> written() {
    std::string json = document_.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
    json.resize((json.size() + 3) / 4 * 4, ' ');
    binary_.resize((binary_.size() + 3) / 4 * 4);
    const std::uint64_t size = 12 + 8 + json.size() + (binary_.empty() ? 0 : 8 + binary_.size());
    if (size > std::numeric_limits<std::uint32_t>::max()) {
      return fail_limit(ErrorCode::too_large, "The parts do not fit into one GLB.",
                        std::numeric_limits<std::uint32_t>::max(), size);
    }
    std::string glb = "glTF";
    glb.reserve(size);
    append_little_endian(glb, 2);
    append_little_endian(glb, size);
    append_little_endian(glb, json.size());
    glb += "JSON" + json;
    if (!binary_.empty()) {
      append_little_endian(glb, binary_.size());
      glb.append("BIN\0", 4);
      glb += binary_;
    }
    return glb;
  }

  ordered_json document_;
  const NamedFiles& files_;
  std::vector<Place> places_;
  std::map<const char*, Place> placed_;  // by file, the longest of those from it
  std::uint64_t again_ = 0;              // bytes of files that were placed before
  std::string binary_;
};

}  // namespace

Result<std::string> pack_gltf(std::string_view document, const NamedFiles& files,
                              const DecodeLimits& limits) {
  const auto text = open_gltf(std::as_bytes(std::span(document))).json;
  if (const auto shape = check_json_shape(text, limits); !shape) return fail(shape.error());
  const JsonOutline outline = outline_of_json(text);
  if (outline.most_members > kMostOrderedMembers) {
    return fail_limit(ErrorCode::too_large, "The glTF's JSON has an object of too many members.",
                      kMostOrderedMembers, outline.most_members);
  }
  auto parsed = ordered_json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!parsed.is_object()) {
    return fail(ErrorCode::mesh_invalid, "The glTF's JSON does not parse, or is not an object.");
  }
  if (outline.repeated_name) {
    return fail(ErrorCode::mesh_invalid, repeated_name(*outline.repeated_name));
  }
  return Packing(std::move(parsed), files).run();
}

}  // namespace geodesic::proto
