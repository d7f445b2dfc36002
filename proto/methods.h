// The geodesic methods that a client can ask for by name.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"

namespace geodesic::proto {

enum class Method : std::uint8_t { wavefront };

struct MethodInfo {
  Method method;
  std::string_view name;
  std::string_view paper;
  bool exact;
  std::string_view cost;                     // how time grows with the vertices
  std::vector<std::string_view> parameters;  // besides from, to and max
};

[[nodiscard]] std::span<const MethodInfo> all_methods();
[[nodiscard]] std::string_view name_of(Method method);
// Errors: method_unknown, listing those there are.
[[nodiscard]] Result<Method> find_method(std::string_view name);

}  // namespace geodesic::proto
