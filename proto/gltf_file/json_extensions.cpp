#include "proto/gltf_file/json_extensions.h"

#include <algorithm>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>

#include "proto/gltf_file/extensions.h"

namespace geodesic::proto {
namespace {

using nlohmann::json;

constexpr std::string_view kMeshoptModes[] = {"ATTRIBUTES", "TRIANGLES", "INDICES"};
constexpr std::string_view kMeshoptFilters[] = {"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL",
                                                "COLOR"};

// The place of a text property in a list of names.
template <std::size_t N>
std::optional<std::size_t> named(const json& object, const char* key,
                                 const std::string_view (&names)[N]) {
  const auto it = object.find(key);
  if (it == object.end() || !it->is_string()) return std::nullopt;
  const auto* found = std::ranges::find(names, it->get_ref<const std::string&>());
  if (found == std::end(names)) return std::nullopt;
  return static_cast<std::size_t>(found - std::begin(names));
}

std::optional<std::size_t> accessor_of(const json& attributes, const char* key) {
  const auto it = attributes.find(key);
  if (it == attributes.end()) return std::nullopt;
  return it->get<std::size_t>();
}

}  // namespace

bool take_meshopt(json& view, std::size_t index, std::size_t buffers, GltfChecks& checks,
                  std::map<std::size_t, GltfMeshopt>& out) {
  json* extensions = object_member(view, "extensions");
  if (extensions == nullptr) return true;
  for (const std::string_view extension : kMeshoptExtensions) {
    const auto it = extensions->find(extension);
    if (it == extensions->end()) continue;
    const GltfPlace place{"bufferView", index};
    if (!it->is_object()) {
      return checks.invalid(place.text() + ": " + std::string(extension) + " is not an object.");
    }
    if (!checks.reference(*it, "buffer", buffers, place, true) ||
        !checks.whole(*it, "byteOffset", 0, kGltfMaxBytes, place) ||
        !checks.whole(*it, "byteLength", 1, kGltfMaxBytes, place, true) ||
        !checks.whole(*it, "byteStride", 1, 256, place, true) ||
        !checks.whole(*it, "count", 1, kGltfMaxBytes, place, true)) {
      return false;
    }
    const auto mode = named(*it, "mode", kMeshoptModes);
    if (!mode) {
      return checks.invalid(place.text() + " has no `mode` that meshopt compression knows.");
    }
    const auto filter = it->contains("filter") ? named(*it, "filter", kMeshoptFilters) : 0;
    if (!filter) {
      return checks.invalid(place.text() + " has no `filter` that meshopt compression knows.");
    }
    out[index] = {(*it)["buffer"].get<std::size_t>(),
                  it->value("byteOffset", std::uint64_t{0}),
                  (*it)["byteLength"].get<std::uint64_t>(),
                  {(*it)["count"].get<std::uint64_t>(), (*it)["byteStride"].get<std::uint64_t>(),
                   static_cast<MeshoptMode>(*mode), static_cast<MeshoptFilter>(*filter)}};
  }
  return true;
}

bool take_instancing(json& node, std::size_t index, std::size_t accessors, GltfChecks& checks,
                     std::map<std::size_t, GltfInstancing>& out) {
  json* extensions = object_member(node, "extensions");
  if (extensions == nullptr) return true;
  const auto it = extensions->find(kInstancingExtension);
  if (it == extensions->end()) return true;
  const GltfPlace place{"node", index};
  json* attributes = it->is_object() ? object_member(*it, "attributes") : nullptr;
  if (attributes == nullptr) {
    return checks.invalid(place.text() + ": " + std::string(kInstancingExtension) +
                          " has no `attributes`.");
  }
  for (const char* key : {"TRANSLATION", "ROTATION", "SCALE"}) {
    if (!checks.reference(*attributes, key, accessors, place)) return false;
  }
  const GltfInstancing instancing{accessor_of(*attributes, "TRANSLATION"),
                                  accessor_of(*attributes, "ROTATION"),
                                  accessor_of(*attributes, "SCALE")};
  // With attributes of its own alone, an application is to draw it once.
  if (instancing.translation || instancing.rotation || instancing.scale) out[index] = instancing;
  return true;
}

bool reduce_draco(json& primitive, const GltfPlace& place, std::size_t views, GltfChecks& checks) {
  json kept = json::object();
  if (json* extensions = object_member(primitive, "extensions")) {
    if (const auto it = extensions->find(kDracoExtension); it != extensions->end()) {
      json* ids = it->is_object() ? object_member(*it, "attributes") : nullptr;
      if (ids == nullptr) {
        return checks.invalid(place.text() + ": its Draco data has no `attributes`.");
      }
      if (!checks.reference(*it, "bufferView", views, place, true) ||
          !checks.whole(*ids, "POSITION", 0, kGltfMaxInt, place,
                        primitive["attributes"].contains("POSITION"))) {
        return false;
      }
      keep_members(*it, {"bufferView", "attributes"});
      keep_members(*ids, {"POSITION"});
      kept[std::string(kDracoExtension)] = std::move(*it);
    }
  }
  primitive.erase("extensions");
  if (!kept.empty()) primitive["extensions"] = std::move(kept);
  return true;
}

}  // namespace geodesic::proto
