// Checks of single properties in the JSON of a glTF file: types, ranges and
// references. A check that fails keeps its error and returns false, and so does
// every caller; a message names the object, such as "accessor 3".
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/error.h"

namespace geodesic::proto {

inline constexpr std::uint64_t kGltfMaxBytes = std::uint64_t{1} << 53;  // whole in a double
inline constexpr std::uint64_t kGltfMaxInt = 0x7FFFFFFF;  // what tinygltf keeps in an int

// "accessor 3", made only when there is something to say.
struct GltfPlace {
  const char* kind;
  std::size_t index;
  std::optional<std::size_t> primitive = {};

  [[nodiscard]] std::string text() const;
};

class GltfChecks {
 public:
  using json = nlohmann::json;

  [[nodiscard]] tl::unexpected<Error> failed() { return fail(std::move(fault_)); }

  bool invalid(const std::string& detail) { return fault(ErrorCode::mesh_invalid, detail); }
  bool fault(ErrorCode code, const std::string& detail) {
    return fault(Error{code, detail, {}, {}, {}});
  }
  bool fault(Error error) {
    fault_ = std::move(error);
    return false;
  }

  // A property that is a whole number of [low, high], or absent if it may be.
  bool whole(json& object, const char* key, std::uint64_t low, std::uint64_t high,
             const GltfPlace& place, bool required = false);

  // A property that is an index into an array of `size` elements.
  bool reference(json& object, const char* key, std::size_t size, const GltfPlace& place,
                 bool required = false);

  // A property that is an array of such indices, or absent.
  bool references(json& object, const char* key, std::size_t size, const GltfPlace& place);

  // A property that is an array of `count` finite numbers, or absent.
  bool numbers(const json& object, const char* key, std::size_t count, const GltfPlace& place);

  // A property that is an array of finite numbers, or absent.
  bool any_numbers(const json& object, const char* key, const GltfPlace& place);

 private:
  Error fault_;
};

// Text of a stranger's, fit for a message: short and of plain letters.
[[nodiscard]] std::string quotable(const std::string& text);

// The message about a name that comes twice in one object, which readers take to mean either.
[[nodiscard]] std::string repeated_name(const std::string& name);

// 10.0 is a whole number too, and becomes 10. Leaves alone what is none.
void make_whole(nlohmann::json& value);

// Erases all other members of an object.
void keep_members(nlohmann::json& object, std::initializer_list<const char*> keys);

// The member of that name if it is an object, else null.
[[nodiscard]] nlohmann::json* object_member(nlohmann::json& object, std::string_view key);

}  // namespace geodesic::proto
