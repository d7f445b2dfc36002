// The geodesic methods that a client can ask for by name, and what each can be told.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/field/method.h"

namespace geodesic::proto {

using geodesic::Method;
using geodesic::MethodOptions;

// What asks for a parameter: the queries that answer with paths, those that answer with
// distances, or both. The others refuse it, for they do not depend on it.
enum class Serves : std::uint8_t { all, paths, distances };

inline constexpr double kNoStandard = std::numeric_limits<double>::quiet_NaN();

// A parameter that some methods have and others refuse: a number with inclusive bounds,
// or one of a few words.
struct MethodParameter {
  std::string_view name;
  bool whole;  // else any number
  double minimum;
  double maximum;
  // Without it; kNoStandard: then the method is not told.
  double standard;
  Serves serves;
  std::string_view meaning;
  // Tells the method the value.
  void (*set)(MethodOptions& options, double value);
  // What the value adds to `field_key`; null: fields do not depend on it.
  std::string (*key)(const MethodOptions& options);
  // Of a word; then `standard` is the place of one of them, and there are no bounds.
  std::vector<std::string_view> choices = {};
};

struct MethodInfo {
  Method method;
  std::string_view name;
  std::string_view about;  // for whom it is, and how far off: a sentence or two
  std::string_view paper;
  bool exact;
  std::string_view cost;                    // how time grows with the vertices
  std::vector<MethodParameter> parameters;  // besides from, to and max
};

// What a query is answered by that names no method.
inline constexpr Method kDefaultMethod = Method::back_traced;

// A method and what it was told.
struct MethodChoice {
  Method which = kDefaultMethod;
  MethodOptions options;
};

// The default first.
[[nodiscard]] std::span<const MethodInfo> all_methods();
[[nodiscard]] const MethodInfo& info_of(Method method);
[[nodiscard]] inline std::string_view name_of(Method method) { return info_of(method).name; }
// Errors: method_unknown, listing those there are.
[[nodiscard]] Result<Method> find_method(std::string_view name);

// Whether the distances of its fields are floats (core/field/vertex_distances.h). Those at points
// inside faces, which are computed from them, are not.
[[nodiscard]] inline bool has_floats(const MethodChoice& choice) {
  return choice.which == Method::back_traced && !choice.options.error_at_most;
}

// What its distances are relative to the true ones: within a tolerance they are not below either.
[[nodiscard]] inline Bound bound_of(const MethodChoice& choice) {
  if (choice.which != Method::back_traced) return Bound::none;
  return choice.options.error_at_most ? Bound::upper : choice.options.bound;
}

// A text that is the same for two choices exactly if their fields are.
[[nodiscard]] std::string field_key(const MethodChoice& choice);

// All of them as JSON, for clients to choose from.
[[nodiscard]] std::string methods_json();

}  // namespace geodesic::proto
