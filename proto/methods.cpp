#include "proto/methods.h"

#include <array>

namespace geodesic::proto {

std::span<const MethodInfo> all_methods() {
  static const std::array<MethodInfo, 1> methods{{
      {Method::wavefront,
       "wavefront",
       "Tang, Wu, Zhang, Zhang: Fast Approximate Geodesic Paths on Triangle Mesh, 2007",
       false,
       "O(n log n)",
       {}},
  }};
  return methods;
}

std::string_view name_of(Method method) {
  for (const MethodInfo& info : all_methods()) {
    if (info.method == method) return info.name;
  }
  return {};
}

Result<Method> find_method(std::string_view name) {
  std::string known;
  for (const MethodInfo& info : all_methods()) {
    if (info.name == name) return info.method;
    known += known.empty() ? "" : ", ";
    known += info.name;
  }
  return fail(ErrorCode::method_unknown, "no such method; there are: " + known, "method");
}

}  // namespace geodesic::proto
