#include "server/http/problem.h"

#include <nlohmann/json.hpp>

namespace geodesic::server {

namespace {

struct Row {
  int status;
  std::string_view title;
  int retry_after = 0;
};

Row row_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::bad_syntax:
      return {400, "The request does not parse"};
    case ErrorCode::unknown_parameter:
      return {400, "No such parameter"};
    case ErrorCode::route_unknown:
      return {404, "No such path"};
    case ErrorCode::mesh_unknown:
      return {404, "No such mesh"};
    case ErrorCode::method_not_allowed:
      return {405, "The path does not allow this HTTP method"};
    case ErrorCode::unauthorized:
      return {401, "A valid token is required"};
    case ErrorCode::forbidden:
      return {403, "This is not allowed"};
    case ErrorCode::not_acceptable:
      return {406, "No acceptable format"};
    case ErrorCode::request_timeout:
      return {408, "The request did not arrive in time"};
    case ErrorCode::length_required:
      return {411, "The length of the body is required"};
    case ErrorCode::too_large:
      return {413, "Over a limit"};
    case ErrorCode::format_unknown:
      return {415, "Format not known"};
    case ErrorCode::mesh_invalid:
      return {422, "The mesh cannot be used"};
    case ErrorCode::no_triangles:
      return {422, "No triangles"};
    case ErrorCode::too_many_vertices:
      return {422, "Too many vertices"};
    case ErrorCode::too_many_faces:
      return {422, "Too many faces"};
    case ErrorCode::external_uri:
      return {422, "The file refers to another file"};
    case ErrorCode::extension_required:
      return {422, "The file requires an extension that is not offered"};
    case ErrorCode::index_out_of_range:
      return {422, "Index out of range"};
    case ErrorCode::value_out_of_range:
      return {422, "Value out of range"};
    case ErrorCode::method_unknown:
      return {422, "No such geodesic method"};
    case ErrorCode::snap_too_far:
      return {422, "The surface is too far from the point"};
    case ErrorCode::no_hit:
      return {422, "The ray misses the surface"};
    case ErrorCode::unsupported:
      return {422, "Not offered"};
    case ErrorCode::digest_mismatch:
      return {422, "The bytes do not have the given digest"};
    case ErrorCode::job_unknown:
      return {404, "No such job"};
    case ErrorCode::job_unfinished:
      return {409, "The job has not ended"};
    case ErrorCode::job_cancelled:
      return {409, "The job was cancelled"};
    case ErrorCode::too_much_memory:
      return {422, "More memory than a computation may take"};
    case ErrorCode::overloaded:
      return {503, "Overloaded", 1};
    case ErrorCode::too_many_requests:
      return {429, "More than this client's share", 1};
    case ErrorCode::draining:
      return {503, "About to stop", 1};
    case ErrorCode::cancelled:
      return {499, "Cancelled"};  // nginx's "client closed request"; RFC 9110 has none
    case ErrorCode::deadline:
      return {504, "The time allowed is over"};
    case ErrorCode::store_failed:
      return {500, "The store failed"};
    case ErrorCode::store_corrupt:
      return {500, "Stored bytes are damaged"};
    case ErrorCode::store_full:
      return {507, "The store is full"};
    case ErrorCode::store_unavailable:
      return {503, "The store does not answer", 5};
    case ErrorCode::internal:
      return {500, "Internal error"};
  }
  return {500, "Internal error"};
}

}  // namespace

int http_status(ErrorCode code) { return row_of(code).status; }

std::string_view problem_title(ErrorCode code) { return row_of(code).title; }

int retry_after_seconds(ErrorCode code) { return row_of(code).retry_after; }

std::string to_problem_json(const Error& error, std::string_view instance,
                            std::string_view request_id, int status) {
  // Ordered: people read these.
  nlohmann::ordered_json problem;
  problem["type"] = "/problems/" + std::string(name_of(error.code));
  problem["title"] = problem_title(error.code);
  problem["status"] = status != 0 ? status : http_status(error.code);
  problem["detail"] = error.detail;
  problem["instance"] = instance;
  problem["code"] = name_of(error.code);
  if (!error.parameter.empty()) problem["parameter"] = error.parameter;
  if (error.limit) problem["limit"] = *error.limit;
  if (error.actual) problem["actual"] = *error.actual;
  problem["request_id"] = request_id;
  return problem.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace geodesic::server
