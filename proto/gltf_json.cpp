#include "proto/gltf_json.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "proto/gltf_extensions.h"

namespace geodesic::proto {
namespace {

using nlohmann::json;

constexpr std::uint64_t max_bytes = std::uint64_t{1} << 53;  // whole numbers in a double
constexpr std::uint64_t max_int = 0x7FFFFFFF;                // what tinygltf keeps in an int

// "accessor 3", made only when there is something to say.
struct Place {
  const char* kind;
  std::size_t index;
  std::optional<std::size_t> primitive = {};

  [[nodiscard]] std::string text() const {
    std::string text = std::string(kind) + " " + std::to_string(index);
    if (primitive) text += ", primitive " + std::to_string(*primitive);
    return text;
  }
};

// Text of a stranger's, fit for a message: short and of plain letters.
std::string quotable(const std::string& text) {
  std::string plain = text.substr(0, 64);
  for (char& c : plain) {
    if (c < 0x20 || c > 0x7E) c = '?';
  }
  return plain;
}

// The walk over the document. A check that fails keeps its error in `fault_`
// and returns false, and so does every caller.
class Reduction {
 public:
  explicit Reduction(const DecodeLimits& limits) : limits_(limits) {}

  Result<ReducedGltf> run(json root) {
    if (!asset(root) || !extensions(root) || !arrays(root) || !buffers(root)) return failed();
    if (!views(root) || !accessors(root) || !meshes(root) || !nodes(root) || !scenes(root)) {
      return failed();
    }
    keep(root, {"asset", "scene", "scenes", "nodes", "meshes", "accessors", "bufferViews"});
    out_.json = root.dump(-1, ' ', false, json::error_handler_t::replace);
    return std::move(out_);
  }

 private:
  tl::unexpected<Error> failed() { return fail(std::move(fault_)); }

  bool invalid(const std::string& detail) { return fault(ErrorCode::mesh_invalid, detail); }

  bool fault(ErrorCode code, const std::string& detail) {
    fault_ = Error{code, detail, {}, {}, {}};
    return false;
  }

  static void keep(json& object, std::initializer_list<const char*> keys) {
    for (auto it = object.begin(); it != object.end();) {
      const bool wanted = std::ranges::any_of(keys, [&](const char* k) { return it.key() == k; });
      it = wanted ? std::next(it) : object.erase(it);
    }
  }

  static void set_extensions(json& object, json kept) {
    object.erase("extensions");
    if (!kept.empty()) object["extensions"] = std::move(kept);
  }

  // A property that is a whole number of [low, high], or absent if it may be.
  bool whole(json& object, const char* key, std::uint64_t low, std::uint64_t high,
             const Place& place, bool required = false) {
    const auto it = object.find(key);
    if (it == object.end()) {
      return !required || invalid(place.text() + " has no `" + key + "`.");
    }
    if (it->is_number_float()) {  // 10.0 is a whole number too
      const double value = it->get<double>();
      if (value >= 0 && value < static_cast<double>(max_bytes) && value == std::floor(value)) {
        *it = static_cast<std::uint64_t>(value);
      }
    }
    if (!it->is_number_unsigned() || it->get<std::uint64_t>() < low ||
        it->get<std::uint64_t>() > high) {
      return invalid(place.text() + ": `" + key + "` is not a whole number from " +
                     std::to_string(low) + " to " + std::to_string(high) + ".");
    }
    return true;
  }

  // A property that is an index into an array of `size` elements.
  bool reference(json& object, const char* key, std::size_t size, const Place& place,
                 bool required = false) {
    const auto it = object.find(key);
    if (it == object.end() && !required) return true;
    if (size == 0) {
      return invalid(place.text() + ": `" + key + "` refers to what the file does not have.");
    }
    return whole(object, key, 0, size - 1, place, required);
  }

  bool references(json& object, const char* key, std::size_t size, const Place& place) {
    const auto it = object.find(key);
    if (it == object.end()) return true;
    if (!it->is_array()) return invalid(place.text() + ": `" + key + "` is not an array.");
    for (const json& item : *it) {
      if (!item.is_number_unsigned() || item.get<std::uint64_t>() >= size) {
        return invalid(place.text() + ": `" + key + "` refers to what the file does not have.");
      }
    }
    return true;
  }

  bool numbers(const json& object, const char* key, std::size_t count, const Place& place) {
    const auto it = object.find(key);
    if (it == object.end()) return true;
    const bool good =
        it->is_array() && it->size() == count && std::ranges::all_of(*it, [](const json& v) {
          return v.is_number() && std::isfinite(v.get<double>());
        });
    return good || invalid(place.text() + ": `" + key + "` is not an array of " +
                           std::to_string(count) + " numbers.");
  }

  // The name is for people; a wrong type is no reason to refuse a mesh.
  static void name(json& object) {
    if (const auto it = object.find("name"); it != object.end() && !it->is_string()) {
      object.erase(it);
    }
  }

  static json* member(json& object, std::string_view key) {
    const auto it = object.find(key);
    return it != object.end() && it->is_object() ? &*it : nullptr;
  }

  bool asset(json& root) {
    if (!root.is_object()) return invalid("The glTF's JSON is not an object.");
    const json* asset = member(root, "asset");
    if (asset == nullptr || !asset->contains("version") || !(*asset)["version"].is_string()) {
      return invalid("The glTF has no `asset.version`.");
    }
    const auto& version = (*asset)["version"].get_ref<const std::string&>();
    if (!version.starts_with("2.")) {
      return invalid("The glTF is of version " + quotable(version) + "; only 2.x is read.");
    }
    root["asset"] = {{"version", "2.0"}};
    return true;
  }

  bool extensions(json& root) {
    const auto it = root.find("extensionsRequired");
    if (it == root.end()) return true;
    if (!it->is_array()) return invalid("`extensionsRequired` is not an array.");
    for (const json& item : *it) {
      if (!item.is_string()) return invalid("`extensionsRequired` holds what is not a string.");
      const auto& extension = item.get_ref<const std::string&>();
      if (!is_accepted_extension(extension)) {
        return fault(
            ErrorCode::extension_required,
            "The file requires the extension " + quotable(extension) + ", which is not supported.");
      }
    }
    return true;
  }

  // Each array that is kept holds objects, and not too many of them: what is a
  // few bytes of JSON becomes half a kilobyte of structure.
  bool arrays(json& root) {
    for (const char* key : {"buffers", "bufferViews", "accessors", "meshes", "nodes", "scenes"}) {
      const auto it = root.find(key);
      if (it == root.end()) continue;
      if (!it->is_array()) return invalid(std::string(key) + " is not an array.");
      if (!counted(it->size())) return false;
      for (std::size_t i = 0; i < it->size(); ++i) {
        if (!(*it)[i].is_object()) {
          return invalid(std::string(key) + ": element " + std::to_string(i) +
                         " is not an object.");
        }
      }
    }
    return true;
  }

  bool counted(std::size_t more) {
    objects_ += more;
    if (objects_ <= limits_.max_gltf_objects) return true;
    fault_ = Error{ErrorCode::too_large,
                   "The glTF lists too many nodes, accessors and the like.",
                   {},
                   limits_.max_gltf_objects,
                   objects_};
    return false;
  }

  static std::size_t size_of(const json& root, const char* key) {
    const auto it = root.find(key);
    return it == root.end() ? 0 : it->size();
  }

  bool buffers(json& root) {
    buffer_count_ = size_of(root, "buffers");
    for (std::size_t i = 0; i < buffer_count_; ++i) {
      json& item = root["buffers"][i];
      const Place place{"buffer", i};
      if (!whole(item, "byteLength", 1, max_bytes, place, true)) return false;
      GltfBuffer buffer;
      buffer.byte_length = item["byteLength"].get<std::uint64_t>();
      if (const auto it = item.find("uri"); it != item.end()) {
        if (!it->is_string()) return invalid(place.text() + ": `uri` is not a string.");
        buffer.uri = std::move(it->get_ref<std::string&>());
      }
      out_.buffers.push_back(std::move(buffer));
    }
    return true;
  }

  bool views(json& root) {
    out_.absent_view = size_of(root, "bufferViews");
    for (std::size_t i = 0; i < out_.absent_view; ++i) {
      json& view = root["bufferViews"][i];
      const Place place{"bufferView", i};
      if (!reference(view, "buffer", buffer_count_, place, true) ||
          !whole(view, "byteOffset", 0, max_bytes, place) ||
          !whole(view, "byteLength", 1, max_bytes, place, true) ||
          !whole(view, "byteStride", 4, 252, place)) {
        return false;
      }
      if (const auto it = view.find("byteStride");
          it != view.end() && it->get<std::uint64_t>() % 4 != 0) {
        return invalid(place.text() + ": `byteStride` is not a multiple of 4.");
      }
      json kept = json::object();
      if (json* extensions = member(view, "extensions")) {
        for (const auto extension : meshopt_extensions) {
          if (extensions->contains(extension)) kept[std::string(extension)] = json::object();
        }
      }
      set_extensions(view, std::move(kept));
      keep(view, {"buffer", "byteOffset", "byteLength", "byteStride", "extensions"});
    }
    if (!root.contains("bufferViews")) root["bufferViews"] = json::array();
    root["bufferViews"].push_back({{"buffer", 0}, {"byteLength", 1}});
    return true;
  }

  bool accessors(json& root) {
    out_.accessors = size_of(root, "accessors");
    for (std::size_t i = 0; i < out_.accessors; ++i) {
      json& accessor = root["accessors"][i];
      const Place place{"accessor", i};
      if (!reference(accessor, "bufferView", out_.absent_view, place) ||
          !whole(accessor, "byteOffset", 0, max_bytes, place) ||
          !whole(accessor, "componentType", gltf_int8, gltf_float32, place, true) ||
          !whole(accessor, "count", 1, max_bytes, place, true)) {
        return false;
      }
      if (const auto it = accessor.find("normalized"); it != accessor.end() && !it->is_boolean()) {
        return invalid(place.text() + ": `normalized` is neither true nor false.");
      }
      static constexpr std::string_view types[] = {"SCALAR", "VEC2", "VEC3", "VEC4",
                                                   "MAT2",   "MAT3", "MAT4"};
      const auto type = accessor.find("type");
      if (type == accessor.end() || !type->is_string() ||
          std::ranges::count(types, type->get_ref<const std::string&>()) == 0) {
        return invalid(place.text() + " has no `type` that glTF knows.");
      }
      if (accessor.contains("sparse") && !sparse(accessor["sparse"], place)) return false;
      if (!accessor.contains("bufferView")) accessor["bufferView"] = out_.absent_view;
      keep(accessor,
           {"bufferView", "byteOffset", "componentType", "normalized", "count", "type", "sparse"});
    }
    return true;
  }

  bool sparse(json& sparse, const Place& place) {
    if (!sparse.is_object() || member(sparse, "indices") == nullptr ||
        member(sparse, "values") == nullptr) {
      return invalid(place.text() + ": `sparse` lacks its indices or values.");
    }
    json& indices = sparse["indices"];
    json& values = sparse["values"];
    keep(sparse, {"count", "indices", "values"});
    return whole(sparse, "count", 1, max_int, place, true) &&
           reference(indices, "bufferView", out_.absent_view, place, true) &&
           whole(indices, "byteOffset", 0, max_int, place) &&
           whole(indices, "componentType", gltf_uint8, gltf_uint32, place, true) &&
           reference(values, "bufferView", out_.absent_view, place, true) &&
           whole(values, "byteOffset", 0, max_int, place);
  }

  bool meshes(json& root) {
    out_.meshes = size_of(root, "meshes");
    for (std::size_t i = 0; i < out_.meshes; ++i) {
      json& mesh = root["meshes"][i];
      name(mesh);
      const auto primitives = mesh.find("primitives");
      if (primitives == mesh.end() || !primitives->is_array()) {
        return invalid(Place{"mesh", i}.text() + " has no array of `primitives`.");
      }
      if (!counted(primitives->size())) return false;
      for (std::size_t j = 0; j < primitives->size(); ++j) {
        if (!primitive((*primitives)[j], Place{"mesh", i, j})) return false;
      }
      out_.primitives += primitives->size();
      keep(mesh, {"name", "primitives"});
    }
    return true;
  }

  bool primitive(json& primitive, const Place& place) {
    if (!primitive.is_object()) return invalid(place.text() + " is not an object.");
    json* attributes = member(primitive, "attributes");
    if (attributes == nullptr) return invalid(place.text() + " has no `attributes`.");
    if (!reference(*attributes, "POSITION", out_.accessors, place) ||
        !reference(primitive, "indices", out_.accessors, place) ||
        !whole(primitive, "mode", gltf_points, gltf_triangle_fan, place)) {
      return false;
    }
    keep(*attributes, {"POSITION"});
    if (const auto it = primitive.find("targets"); it != primitive.end()) {
      const bool some = it->is_array() && !it->empty();
      *it = some ? json::array({json::object()}) : json::array();
    }
    json kept = json::object();
    if (json* extensions = member(primitive, "extensions")) {
      if (const auto it = extensions->find(draco_extension); it != extensions->end()) {
        json* ids = it->is_object() ? member(*it, "attributes") : nullptr;
        if (ids == nullptr) return invalid(place.text() + ": its Draco data has no `attributes`.");
        if (!reference(*it, "bufferView", out_.absent_view, place, true) ||
            !whole(*ids, "POSITION", 0, max_int, place, attributes->contains("POSITION"))) {
          return false;
        }
        keep(*it, {"bufferView", "attributes"});
        keep(*ids, {"POSITION"});
        kept[std::string(draco_extension)] = std::move(*it);
      }
    }
    set_extensions(primitive, std::move(kept));
    keep(primitive, {"attributes", "indices", "mode", "targets", "extensions"});
    return true;
  }

  bool nodes(json& root) {
    out_.nodes = size_of(root, "nodes");
    for (std::size_t i = 0; i < out_.nodes; ++i) {
      json& node = root["nodes"][i];
      const Place place{"node", i};
      name(node);
      if (!reference(node, "mesh", out_.meshes, place) ||
          !references(node, "children", out_.nodes, place) || !numbers(node, "matrix", 16, place) ||
          !numbers(node, "translation", 3, place) || !numbers(node, "rotation", 4, place) ||
          !numbers(node, "scale", 3, place)) {
        return false;
      }
      if (node.contains("skin")) node["skin"] = 0;  // that there is one is all that counts
      json kept = json::object();
      if (json* extensions = member(node, "extensions")) {
        if (extensions->contains(instancing_extension)) {
          kept[std::string(instancing_extension)] = json::object();
        }
      }
      set_extensions(node, std::move(kept));
      keep(node, {"name", "mesh", "children", "matrix", "translation", "rotation", "scale", "skin",
                  "extensions"});
    }
    return true;
  }

  bool scenes(json& root) {
    out_.scenes = size_of(root, "scenes");
    for (std::size_t i = 0; i < out_.scenes; ++i) {
      json& scene = root["scenes"][i];
      if (!references(scene, "nodes", out_.nodes, Place{"scene", i})) return false;
      keep(scene, {"nodes"});
    }
    const auto it = root.find("scene");
    if (it == root.end()) return true;
    if (!it->is_number_unsigned() || it->get<std::uint64_t>() >= out_.scenes) {
      return invalid("`scene` refers to a scene that the file does not have.");
    }
    return true;
  }

  const DecodeLimits& limits_;
  ReducedGltf out_;
  Error fault_;
  std::size_t buffer_count_ = 0;
  std::uint64_t objects_ = 0;
};

}  // namespace

Result<ReducedGltf> reduce_gltf(std::string_view text, const DecodeLimits& limits) {
  try {
    return Reduction(limits).run(json::parse(text));
  } catch (const json::parse_error& e) {
    return fail(ErrorCode::mesh_invalid,
                "The glTF's JSON does not parse at byte " + std::to_string(e.byte) + ".");
  } catch (const json::exception&) {  // a number beyond all bounds
    return fail(ErrorCode::mesh_invalid, "The glTF's JSON holds a number out of range.");
  }
}

}  // namespace geodesic::proto
