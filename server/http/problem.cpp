#include "server/http/problem.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "proto/wire/cut_to.h"
#include "proto/wire/input_codes.h"
#include "server/base/service_codes.h"

namespace geodesic::server {

namespace {

struct Row {
  ErrorCode code;
  int status;
  std::string_view title;
  int retry_after = 0;
};

constexpr std::array kRows{
    Row{InputCode::bad_syntax, 400, "The request does not parse"},
    Row{InputCode::unknown_parameter, 400, "No such parameter"},
    Row{ServiceCode::route_unknown, 404, "No such path"},
    Row{ServiceCode::mesh_unknown, 404, "No such mesh"},
    Row{ServiceCode::method_not_allowed, 405, "The path does not allow this HTTP method"},
    Row{ServiceCode::unauthorized, 401, "A valid token is required"},
    Row{ServiceCode::forbidden, 403, "This is not allowed"},
    Row{InputCode::not_acceptable, 406, "No acceptable format"},
    Row{ServiceCode::request_timeout, 408, "The request did not arrive in time"},
    Row{ServiceCode::length_required, 411, "The length of the body is required"},
    Row{ErrorCode::too_large, 413, "Over a limit"},
    Row{InputCode::format_unknown, 415, "Format not known"},
    Row{ErrorCode::mesh_invalid, 422, "The mesh cannot be used"},
    Row{ErrorCode::no_triangles, 422, "No triangles"},
    Row{ErrorCode::too_many_vertices, 422, "Too many vertices"},
    Row{ErrorCode::too_many_faces, 422, "Too many faces"},
    Row{InputCode::external_uri, 422, "The file refers to another file"},
    Row{InputCode::extension_required, 422, "The file requires an extension that is not offered"},
    Row{ErrorCode::index_out_of_range, 422, "Index out of range"},
    Row{ErrorCode::value_out_of_range, 422, "Value out of range"},
    Row{InputCode::method_unknown, 422, "No such geodesic method"},
    Row{ServiceCode::snap_too_far, 422, "The surface is too far from the point"},
    Row{ServiceCode::outside_region, 422, "The point is not on the part asked about"},
    Row{ErrorCode::no_hit, 422, "The ray misses the surface"},
    Row{ErrorCode::no_loop, 422, "No such closed curve"},
    Row{ErrorCode::unsupported, 422, "Not offered"},
    Row{ServiceCode::digest_mismatch, 422, "The bytes do not have the given digest"},
    Row{ServiceCode::job_unknown, 404, "No such job"},
    Row{ServiceCode::job_unfinished, 409, "The job has not ended"},
    Row{ServiceCode::job_cancelled, 409, "The job was cancelled"},
    Row{ServiceCode::too_much_memory, 422, "More memory than a computation may take"},
    Row{ServiceCode::overloaded, 503, "Overloaded", 1},
    Row{ServiceCode::too_many_requests, 429, "More than this client's share", 1},
    Row{ServiceCode::draining, 503, "About to stop", 1},
    // nginx's "client closed request"; RFC 9110 has none.
    Row{ErrorCode::cancelled, 499, "Cancelled"},
    Row{ServiceCode::deadline, 504, "The time allowed is over"},
    Row{ServiceCode::store_failed, 500, "The store failed"},
    Row{InputCode::store_corrupt, 500, "Stored bytes are damaged"},
    Row{ServiceCode::store_full, 507, "The store is full"},
    Row{ServiceCode::store_unavailable, 503, "The store does not answer", 5},
    Row{ErrorCode::internal, 500, "Internal error"},
};

constexpr std::size_t kMostDetailBytes = 2000;
constexpr std::size_t kMostParameterBytes = 200;

const Row& row_of(ErrorCode code) {
  const auto* const row =
      std::find_if(kRows.begin(), kRows.end(), [&](const Row& r) { return r.code == code; });
  return row == kRows.end() ? kRows.back() : *row;
}

}  // namespace

std::vector<ErrorCode> all_error_codes() {
  std::vector<ErrorCode> codes;
  for (const Row& row : kRows) codes.push_back(row.code);
  return codes;
}

int http_status(ErrorCode code) { return row_of(code).status; }

std::string_view problem_title(ErrorCode code) { return row_of(code).title; }

int retry_after_seconds(ErrorCode code) { return row_of(code).retry_after; }

std::string to_problem_json(const Error& error, const HttpRequest& request, int status,
                            std::string_view instance) {
  // Ordered: people read these.
  nlohmann::ordered_json problem;
  problem["type"] = request.base_path + "/docs/errors/#" + std::string(error.code.name());
  problem["title"] = problem_title(error.code);
  problem["status"] = status != 0 ? status : http_status(error.code);
  // Both may have words of the request or of a file in them.
  problem["detail"] = proto::cut_to(error.detail, kMostDetailBytes);
  problem["instance"] = instance.empty() ? std::string_view(request.target) : instance;
  problem["code"] = error.code.name();
  if (!error.parameter.empty())
    problem["parameter"] = proto::cut_to(error.parameter, kMostParameterBytes);
  if (error.limit) problem["limit"] = *error.limit;
  if (error.actual) problem["actual"] = *error.actual;
  problem["request_id"] = request.id;
  return problem.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace geodesic::server
