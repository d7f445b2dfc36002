// The error model of all layers: errors are values. Every function that can be
// given bad input returns `Result<T>`; exceptions are caught at the HTTP edge
// only. The codes are a closed set: a client may switch on their names, and one
// table in the server maps each to its HTTP status.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>

namespace geodesic {

enum class ErrorCode : std::uint8_t {
  bad_syntax,          // the request does not parse
  unknown_parameter,   // a parameter that no such query has
  route_unknown,       // no such path
  mesh_unknown,        // no mesh of that id
  method_not_allowed,  // the path exists, the HTTP method does not
  unauthorized,        // no token, or one that is not valid (any more)
  forbidden,           // the token lacks the scope that this needs
  not_acceptable,      // no format that the client accepts
  request_timeout,     // the body did not arrive in time
  length_required,     // a body without a length
  too_large,           // more bytes than a limit allows
  format_unknown,      // the bytes are of no format that we read
  mesh_invalid,        // a known format, but a mesh that cannot be used
  no_triangles,        // nothing to walk on: points, lines or an empty scene
  too_many_vertices,   // over the limit of vertices
  too_many_faces,      // over the limit of faces
  external_uri,        // the file refers to another file
  extension_required,  // the file requires an extension that we lack
  index_out_of_range,  // a vertex or face that the mesh does not have
  value_out_of_range,  // a number outside its domain
  method_unknown,      // no geodesic method of that name
  snap_too_far,        // the closest point is farther than `max_snap`
  no_hit,              // a ray misses the surface
  unsupported,         // valid, but not offered by this version
  digest_mismatch,     // the bytes are not those of the given digest
  job_unknown,         // no job of that id (any more)
  job_unfinished,      // the job has no result yet
  job_cancelled,       // the job was cancelled and has no result
  too_much_memory,     // the computation would take more memory than one may
  overloaded,          // the queue is full: try again later
  too_many_requests,   // this client asks for more than its share: try again later
  draining,            // the process is about to stop
  cancelled,           // the client is gone or the job was cancelled
  deadline,            // the time allowed is over
  store_failed,        // the store cannot read or write
  store_corrupt,       // stored bytes are not what was stored
  store_full,          // no room for an upload: the budget, the disk or a quota
  store_unavailable,   // the store does not answer: try again later
  internal,            // a fault of ours
};

// The name of a code as clients see it, such as "mesh_unknown".
[[nodiscard]] std::string_view name_of(ErrorCode code);

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
