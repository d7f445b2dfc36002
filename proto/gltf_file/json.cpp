#include "proto/gltf_file/json.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "proto/gltf_file/extensions.h"
#include "proto/gltf_file/json_checks.h"
#include "proto/gltf_file/json_extensions.h"
#include "proto/wire/input_codes.h"
#include "proto/wire/json_outline.h"

namespace geodesic::proto {
namespace {

using nlohmann::json;

// The walk over the document. A check that fails keeps its error in `checks_`
// and returns false, and so does every caller.
class Reduction {
 public:
  explicit Reduction(const DecodeLimits& limits) : limits_(limits) {}

  Result<ReducedGltf> run(json root) {
    if (!asset(root) || !extensions(root) || !arrays(root) || !buffers(root))
      return checks_.failed();
    materials(root);
    if (!views(root) || !accessors(root) || !meshes(root) || !nodes(root) || !scenes(root)) {
      return checks_.failed();
    }
    keep_members(root, {"asset", "scene", "scenes", "nodes", "meshes", "accessors", "bufferViews"});
    out_.json = root.dump(-1, ' ', false, json::error_handler_t::replace);
    return std::move(out_);
  }

 private:
  // The name is for people; a wrong type is no reason to refuse a mesh.
  static void name(json& object) {
    if (const auto it = object.find("name"); it != object.end() && !it->is_string()) {
      object.erase(it);
    }
  }

  bool asset(json& root) {
    if (!root.is_object()) return checks_.invalid("The glTF's JSON is not an object.");
    const json* asset = object_member(root, "asset");
    if (asset == nullptr || !asset->contains("version") || !(*asset)["version"].is_string()) {
      return checks_.invalid("The glTF has no `asset.version`.");
    }
    const auto& version = (*asset)["version"].get_ref<const std::string&>();
    if (!version.starts_with("2.")) {
      return checks_.invalid("The glTF is of version " + quotable(version) + "; only 2.x is read.");
    }
    root["asset"] = {{"version", "2.0"}};
    return true;
  }

  bool extensions(json& root) {
    if (const json* used = object_member(root, "extensions")) {
      out_.has_rtc_center = used->contains(kRtcExtension);
    }
    const auto it = root.find("extensionsRequired");
    if (it == root.end()) return true;
    if (!it->is_array()) return checks_.invalid("`extensionsRequired` is not an array.");
    for (const json& item : *it) {
      if (!item.is_string())
        return checks_.invalid("`extensionsRequired` holds what is not a string.");
      const auto& extension = item.get_ref<const std::string&>();
      if (!is_accepted_extension(extension)) {
        return checks_.fault(
            InputCode::extension_required,
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
      if (!it->is_array()) return checks_.invalid(std::string(key) + " is not an array.");
      if (!counted(it->size())) return false;
      for (std::size_t i = 0; i < it->size(); ++i) {
        if (!(*it)[i].is_object()) {
          return checks_.invalid(std::string(key) + ": element " + std::to_string(i) +
                                 " is not an object.");
        }
      }
    }
    return true;
  }

  bool counted(std::size_t more) {
    objects_ += more;
    if (objects_ <= limits_.max_gltf_objects) return true;
    return checks_.fault(Error{ErrorCode::too_large,
                               "The glTF lists too many nodes, accessors and the like.",
                               {},
                               limits_.max_gltf_objects,
                               objects_});
  }

  static std::size_t size_of(const json& root, const char* key) {
    const auto it = root.find(key);
    return it == root.end() ? 0 : it->size();
  }

  bool buffers(json& root) {
    buffer_count_ = size_of(root, "buffers");
    for (std::size_t i = 0; i < buffer_count_; ++i) {
      json& item = root["buffers"][i];
      const GltfPlace place{"buffer", i};
      if (!checks_.whole(item, "byteLength", 1, kGltfMaxBytes, place, true)) return false;
      GltfBuffer buffer;
      buffer.byte_length = item["byteLength"].get<std::uint64_t>();
      if (const auto it = item.find("uri"); it != item.end()) {
        if (!it->is_string()) return checks_.invalid(place.text() + ": `uri` is not a string.");
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
      const GltfPlace place{"bufferView", i};
      if (!checks_.reference(view, "buffer", buffer_count_, place, true) ||
          !checks_.whole(view, "byteOffset", 0, kGltfMaxBytes, place) ||
          !checks_.whole(view, "byteLength", 1, kGltfMaxBytes, place, true) ||
          !checks_.whole(view, "byteStride", 4, 252, place)) {
        return false;
      }
      if (const auto it = view.find("byteStride");
          it != view.end() && it->get<std::uint64_t>() % 4 != 0) {
        return checks_.invalid(place.text() + ": `byteStride` is not a multiple of 4.");
      }
      if (!take_meshopt(view, i, buffer_count_, checks_, out_.meshopt)) return false;
      keep_members(view, {"buffer", "byteOffset", "byteLength", "byteStride"});
    }
    if (!root.contains("bufferViews")) root["bufferViews"] = json::array();
    root["bufferViews"].push_back({{"buffer", 0}, {"byteLength", 1}});
    return true;
  }

  bool accessors(json& root) {
    out_.accessors = size_of(root, "accessors");
    for (std::size_t i = 0; i < out_.accessors; ++i) {
      json& accessor = root["accessors"][i];
      const GltfPlace place{"accessor", i};
      if (!checks_.reference(accessor, "bufferView", out_.absent_view, place) ||
          !checks_.whole(accessor, "byteOffset", 0, kGltfMaxBytes, place) ||
          !checks_.whole(accessor, "componentType", gltf_int8, gltf_float32, place, true) ||
          !checks_.whole(accessor, "count", 1, kGltfMaxBytes, place, true)) {
        return false;
      }
      if (const auto it = accessor.find("normalized"); it != accessor.end() && !it->is_boolean()) {
        return checks_.invalid(place.text() + ": `normalized` is neither true nor false.");
      }
      static constexpr std::string_view kTypes[] = {"SCALAR", "VEC2", "VEC3", "VEC4",
                                                    "MAT2",   "MAT3", "MAT4"};
      const auto type = accessor.find("type");
      if (type == accessor.end() || !type->is_string() ||
          std::ranges::count(kTypes, type->get_ref<const std::string&>()) == 0) {
        return checks_.invalid(place.text() + " has no `type` that glTF knows.");
      }
      if (accessor.contains("byteOffset") && !accessor.contains("bufferView")) {
        return checks_.invalid(place.text() + " has a `byteOffset` but no `bufferView`.");
      }
      for (const char* bound : {"min", "max"}) {
        if (!checks_.numbers(accessor, bound, components_of(*type), place)) return false;
      }
      if (accessor.contains("sparse") && !sparse(accessor["sparse"], place)) return false;
      if (!accessor.contains("bufferView")) accessor["bufferView"] = out_.absent_view;
      keep_members(accessor, {"bufferView", "byteOffset", "componentType", "normalized", "count",
                              "type", "sparse", "min", "max"});
    }
    return true;
  }

  static std::size_t components_of(const std::string& type) {
    if (type == "SCALAR") return 1;
    const auto side = static_cast<std::size_t>(type.back() - '0');
    return type.starts_with("MAT") ? side * side : side;
  }

  bool sparse(json& sparse, const GltfPlace& place) {
    if (!sparse.is_object() || object_member(sparse, "indices") == nullptr ||
        object_member(sparse, "values") == nullptr) {
      return checks_.invalid(place.text() + ": `sparse` lacks its indices or values.");
    }
    json& indices = sparse["indices"];
    json& values = sparse["values"];
    keep_members(sparse, {"count", "indices", "values"});
    return checks_.whole(sparse, "count", 1, kGltfMaxInt, place, true) &&
           checks_.reference(indices, "bufferView", out_.absent_view, place, true) &&
           checks_.whole(indices, "byteOffset", 0, kGltfMaxInt, place) &&
           checks_.whole(indices, "componentType", gltf_uint8, gltf_uint32, place, true) &&
           checks_.reference(values, "bufferView", out_.absent_view, place, true) &&
           checks_.whole(values, "byteOffset", 0, kGltfMaxInt, place);
  }

  // What they are called is all that is kept. Nothing that is wrong with them is a reason to refuse
  // a mesh.
  void materials(json& root) {
    const auto it = root.find("materials");
    if (it == root.end() || !it->is_array()) return;
    out_.materials = it->size();
    for (std::size_t i = 0; i < std::min(out_.materials, kMostMaterials); ++i) {
      const json& one = (*it)[i];
      const bool is_named = one.is_object() && one.contains("name") && one["name"].is_string();
      out_.material_names.push_back(is_named ? told_name(one["name"].get_ref<const std::string&>())
                                             : std::string());
    }
  }

  // A number that is no material's stands for one that is not there.
  static void material(json& primitive) {
    const auto it = primitive.find("material");
    if (it == primitive.end()) return;
    make_whole(*it);
    if (!it->is_number_unsigned() || it->get<std::uint64_t>() > kGltfMaxInt) *it = kGltfMaxInt;
  }

  bool meshes(json& root) {
    out_.meshes = size_of(root, "meshes");
    for (std::size_t i = 0; i < out_.meshes; ++i) {
      json& mesh = root["meshes"][i];
      name(mesh);
      const auto primitives = mesh.find("primitives");
      if (primitives == mesh.end() || !primitives->is_array()) {
        return checks_.invalid(GltfPlace{"mesh", i}.text() + " has no array of `primitives`.");
      }
      if (!counted(primitives->size())) return false;
      for (std::size_t j = 0; j < primitives->size(); ++j) {
        if (!primitive((*primitives)[j], GltfPlace{"mesh", i, j})) return false;
      }
      out_.primitives += primitives->size();
      for (const json& one : *primitives) {
        if (size_of(one, "targets") == size_of(primitives->front(), "targets")) continue;
        return checks_.invalid(GltfPlace{"mesh", i}.text() +
                               ": its primitives have different numbers of morph targets.");
      }
      if (!checks_.any_numbers(mesh, "weights", GltfPlace{"mesh", i})) return false;
      keep_members(mesh, {"name", "primitives", "weights"});
    }
    return true;
  }

  bool primitive(json& primitive, const GltfPlace& place) {
    if (!primitive.is_object()) return checks_.invalid(place.text() + " is not an object.");
    json* attributes = object_member(primitive, "attributes");
    if (attributes == nullptr) return checks_.invalid(place.text() + " has no `attributes`.");
    if (!checks_.reference(*attributes, "POSITION", out_.accessors, place) ||
        !checks_.reference(primitive, "indices", out_.accessors, place) ||
        !checks_.whole(primitive, "mode", gltf_points, gltf_triangle_fan, place)) {
      return false;
    }
    keep_members(*attributes, {"POSITION"});
    if (primitive.contains("targets") && !targets(primitive["targets"], place)) return false;
    if (!reduce_draco(primitive, place, out_.absent_view, checks_)) return false;
    material(primitive);
    keep_members(primitive, {"attributes", "indices", "mode", "targets", "extensions", "material"});
    return true;
  }

  bool targets(json& targets, const GltfPlace& place) {
    if (!targets.is_array()) return checks_.invalid(place.text() + ": `targets` is not an array.");
    if (!counted(targets.size())) return false;
    for (json& target : targets) {
      if (!target.is_object()) {
        return checks_.invalid(place.text() + ": one of its `targets` is not an object.");
      }
      if (!checks_.reference(target, "POSITION", out_.accessors, place)) return false;
      keep_members(target, {"POSITION"});
    }
    return true;
  }

  bool nodes(json& root) {
    out_.nodes = size_of(root, "nodes");
    for (std::size_t i = 0; i < out_.nodes; ++i) {
      json& node = root["nodes"][i];
      const GltfPlace place{"node", i};
      name(node);
      if (!checks_.reference(node, "mesh", out_.meshes, place) ||
          !checks_.references(node, "children", out_.nodes, place) ||
          !checks_.numbers(node, "matrix", 16, place) ||
          !checks_.numbers(node, "translation", 3, place) ||
          !checks_.numbers(node, "rotation", 4, place) ||
          !checks_.numbers(node, "scale", 3, place)) {
        return false;
      }
      if (!checks_.any_numbers(node, "weights", place) || !placement(node, place)) return false;
      if (node.contains("skin")) node["skin"] = 0;  // that there is one is all that counts
      if (!take_instancing(node, i, out_.accessors, checks_, out_.instancing)) return false;
      keep_members(node, {"name", "mesh", "children", "matrix", "translation", "rotation", "scale",
                          "skin", "weights"});
    }
    return true;
  }

  bool placement(const json& node, const GltfPlace& place) {
    if (node.contains("matrix") &&
        (node.contains("translation") || node.contains("rotation") || node.contains("scale"))) {
      return checks_.invalid(place.text() + " has a `matrix` and parts of one.");
    }
    const auto rotation = node.find("rotation");
    if (rotation == node.end()) return true;
    const bool good = std::ranges::all_of(
        *rotation, [](const json& value) { return std::abs(value.get<double>()) <= 1.001; });
    return good || checks_.invalid(place.text() + ": `rotation` is no unit quaternion.");
  }

  bool scenes(json& root) {
    out_.scenes = size_of(root, "scenes");
    for (std::size_t i = 0; i < out_.scenes; ++i) {
      json& scene = root["scenes"][i];
      if (!checks_.references(scene, "nodes", out_.nodes, GltfPlace{"scene", i})) return false;
      name(scene);
      keep_members(scene, {"name", "nodes"});
    }
    const auto it = root.find("scene");
    if (it == root.end()) return true;
    if (!it->is_number_unsigned() || it->get<std::uint64_t>() >= out_.scenes) {
      return checks_.invalid("`scene` refers to a scene that the file does not have.");
    }
    return true;
  }

  const DecodeLimits& limits_;
  ReducedGltf out_;
  GltfChecks checks_;
  std::size_t buffer_count_ = 0;
  std::uint64_t objects_ = 0;
};

}  // namespace

Result<ReducedGltf> reduce_gltf(std::string_view text, const DecodeLimits& limits) {
  try {
    json root = json::parse(text);
    // glTF 2.0, "JSON Encoding": names within JSON objects must be unique.
    if (const auto name = outline_of_json(text).repeated_name) {
      return fail(ErrorCode::mesh_invalid, repeated_name(*name));
    }
    return Reduction(limits).run(std::move(root));
  } catch (const json::parse_error& e) {
    return fail(ErrorCode::mesh_invalid,
                "The glTF's JSON does not parse at byte " + std::to_string(e.byte) + ".");
  } catch (const json::exception&) {  // a number beyond all bounds
    return fail(ErrorCode::mesh_invalid, "The glTF's JSON holds a number out of range.");
  }
}

}  // namespace geodesic::proto
