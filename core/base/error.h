// The error model of all layers: errors are values. Every function that can be
// given bad input returns `Result<T>`; exceptions are caught at the HTTP edge
// only. The names of the codes are a closed set: a client may switch on them, and one
// table in the server (server/http/problem.cpp) maps each to its HTTP status.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>

namespace geodesic {

// A kind of error, told by its name: what a program branches on. The floors above the engine add
// kinds of their own (proto/wire/input_codes.h, server/base/service_codes.h), so this is no
// enumeration.
class ErrorCode {
 public:
  // The name must outlive the code, as a literal does.
  constexpr explicit ErrorCode(std::string_view name) : name_(name) {}

  // As clients see it, such as "mesh_invalid".
  [[nodiscard]] constexpr std::string_view name() const { return name_; }
  friend constexpr bool operator==(ErrorCode a, ErrorCode b) { return a.name_ == b.name_; }

  // The engine's own.
  static const ErrorCode too_large;           // more bytes or elements than a limit allows
  static const ErrorCode mesh_invalid;        // a mesh that cannot be used
  static const ErrorCode no_triangles;        // nothing to walk on: points, lines or an empty scene
  static const ErrorCode too_many_vertices;   // over the limit of vertices
  static const ErrorCode too_many_faces;      // over the limit of faces
  static const ErrorCode index_out_of_range;  // a vertex or face that the mesh does not have
  static const ErrorCode value_out_of_range;  // a number outside its domain
  static const ErrorCode no_hit;              // a ray misses the surface
  static const ErrorCode no_loop;             // no closed curve where one was asked for
  static const ErrorCode unsupported;         // valid, but not offered by this version
  static const ErrorCode cancelled;           // whoever asked does not want the answer any more
  static const ErrorCode internal;            // a fault of ours

 private:
  std::string_view name_;
};

inline constexpr ErrorCode ErrorCode::too_large{"too_large"};
inline constexpr ErrorCode ErrorCode::mesh_invalid{"mesh_invalid"};
inline constexpr ErrorCode ErrorCode::no_triangles{"no_triangles"};
inline constexpr ErrorCode ErrorCode::too_many_vertices{"too_many_vertices"};
inline constexpr ErrorCode ErrorCode::too_many_faces{"too_many_faces"};
inline constexpr ErrorCode ErrorCode::index_out_of_range{"index_out_of_range"};
inline constexpr ErrorCode ErrorCode::value_out_of_range{"value_out_of_range"};
inline constexpr ErrorCode ErrorCode::no_hit{"no_hit"};
inline constexpr ErrorCode ErrorCode::no_loop{"no_loop"};
inline constexpr ErrorCode ErrorCode::unsupported{"unsupported"};
inline constexpr ErrorCode ErrorCode::cancelled{"cancelled"};
inline constexpr ErrorCode ErrorCode::internal{"internal"};

struct Error {
  ErrorCode code = ErrorCode::internal;
  std::string detail;                   // one sentence for a person
  std::string parameter;                // the offending parameter, such as "from[2]"; may be empty
  std::optional<std::uint64_t> limit;   // the bound that was exceeded …
  std::optional<std::uint64_t> actual;  // … and by what
};

template <class T>
using Result = tl::expected<T, Error>;

// `return fail(ErrorCode::no_hit, "the ray misses the surface", "to");`
[[nodiscard]] inline tl::unexpected<Error> fail(ErrorCode code, std::string detail,
                                                std::string parameter = {}) {
  return tl::unexpected<Error>(Error{code, std::move(detail), std::move(parameter), {}, {}});
}

[[nodiscard]] inline tl::unexpected<Error> fail(Error error) {
  return tl::unexpected<Error>(std::move(error));
}

// A bound that was exceeded, with both numbers for the reply.
[[nodiscard]] inline tl::unexpected<Error> fail_limit(ErrorCode code, std::string detail,
                                                      std::uint64_t limit, std::uint64_t actual,
                                                      std::string parameter = {}) {
  return tl::unexpected<Error>(Error{code, std::move(detail), std::move(parameter), limit, actual});
}

}  // namespace geodesic
