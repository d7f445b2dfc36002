#include "proto/gltf_file/json_checks.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace geodesic::proto {
namespace {

bool is_finite_number(const nlohmann::json& value) {
  return value.is_number() && std::isfinite(value.get<double>());
}

}  // namespace

std::string GltfPlace::text() const {
  std::string text = std::string(kind) + " " + std::to_string(index);
  if (primitive) text += ", primitive " + std::to_string(*primitive);
  return text;
}

bool GltfChecks::whole(json& object, const char* key, std::uint64_t low, std::uint64_t high,
                       const GltfPlace& place, bool required) {
  const auto it = object.find(key);
  if (it == object.end()) {
    return !required || invalid(place.text() + " has no `" + key + "`.");
  }
  make_whole(*it);
  if (!it->is_number_unsigned() || it->get<std::uint64_t>() < low ||
      it->get<std::uint64_t>() > high) {
    return invalid(place.text() + ": `" + key + "` is not a whole number from " +
                   std::to_string(low) + " to " + std::to_string(high) + ".");
  }
  return true;
}

bool GltfChecks::reference(json& object, const char* key, std::size_t size, const GltfPlace& place,
                           bool required) {
  const auto it = object.find(key);
  if (it == object.end() && !required) return true;
  if (size == 0) {
    return invalid(place.text() + ": `" + key + "` refers to what the file does not have.");
  }
  return whole(object, key, 0, size - 1, place, required);
}

bool GltfChecks::references(json& object, const char* key, std::size_t size,
                            const GltfPlace& place) {
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

bool GltfChecks::numbers(const json& object, const char* key, std::size_t count,
                         const GltfPlace& place) {
  const auto it = object.find(key);
  if (it == object.end()) return true;
  const bool good =
      it->is_array() && it->size() == count && std::ranges::all_of(*it, is_finite_number);
  return good || invalid(place.text() + ": `" + key + "` is not an array of " +
                         std::to_string(count) + " numbers.");
}

bool GltfChecks::any_numbers(const json& object, const char* key, const GltfPlace& place) {
  const auto it = object.find(key);
  if (it == object.end()) return true;
  const bool good = it->is_array() && std::ranges::all_of(*it, is_finite_number);
  return good || invalid(place.text() + ": `" + key + "` is not an array of numbers.");
}

void make_whole(nlohmann::json& value) {
  if (!value.is_number_float()) return;
  const double number = value.get<double>();
  if (number >= 0 && number < static_cast<double>(kGltfMaxBytes) && number == std::floor(number)) {
    value = static_cast<std::uint64_t>(number);
  }
}

std::string quotable(const std::string& text) {
  std::string plain = text.substr(0, 64);
  for (char& c : plain) {
    if (c < 0x20 || c > 0x7E) c = '?';
  }
  return plain;
}

std::string repeated_name(const std::string& name) {
  return "The glTF's JSON has the name " + quotable(name) + " twice in one object.";
}

void keep_members(nlohmann::json& object, std::initializer_list<const char*> keys) {
  for (auto it = object.begin(); it != object.end();) {
    const bool wanted = std::ranges::any_of(keys, [&](const char* k) { return it.key() == k; });
    it = wanted ? std::next(it) : object.erase(it);
  }
}

nlohmann::json* object_member(nlohmann::json& object, std::string_view key) {
  const auto it = object.find(key);
  return it != object.end() && it->is_object() ? &*it : nullptr;
}

}  // namespace geodesic::proto
