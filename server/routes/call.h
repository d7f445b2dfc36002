// A request with its path taken apart: what every route works on.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "proto/wire/input_codes.h"
#include "proto/wire/parameters.h"
#include "server/base/service_codes.h"
#include "server/http/message.h"
#include "server/routes/routes.h"

namespace geodesic::server {

// The queries on a mesh, by the last segment of their paths.
inline constexpr std::array<std::string_view, 12> kQueries{
    "distance", "path",    "table", "isolines", "samples", "measure",
    "extent",   "voronoi", "trace", "loop",     "logmap",  "nearest"};

// Lines of a batch, each of which is answered.
inline constexpr std::size_t kMaxBatchLines = 100'000;

[[nodiscard]] inline bool is_query(std::string_view name) {
  return std::find(kQueries.begin(), kQueries.end(), name) != kQueries.end();
}

struct Routes::Call {
  HttpRequest& request;
  std::string_view method;                 // HEAD is answered as GET
  std::vector<std::string_view> segments;  // of the path
  std::string id;                          // of the mesh, where the path has one
  std::string route;                       // the path's pattern, for the log

  [[nodiscard]] HttpResponse problem(const Error& error) const {
    return HttpResponse::problem(error, request);
  }
  [[nodiscard]] HttpResponse problem(ErrorCode code, std::string detail) const {
    return problem(Error{code, std::move(detail), {}, {}, {}});
  }
  [[nodiscard]] HttpResponse not_allowed(std::string allowed) const {
    HttpResponse response = problem(ServiceCode::method_not_allowed, "allowed here: " + allowed);
    response.set_header("Allow", allowed + ", OPTIONS");
    return response;
  }
  [[nodiscard]] bool is(std::string_view name) const { return method == name; }

  // Errors: unknown_parameter. For what takes no parameters.
  [[nodiscard]] Result<void> check_no_parameters() const {
    return proto::Parameters::from_query(request.query).check_all_known();
  }

  // The parameters of a query: of the URL for GET, of the JSON body for POST.
  [[nodiscard]] Result<proto::Parameters> parameters() const {
    if (is("GET")) return proto::Parameters::from_query(request.query);
    if (!request.query.empty()) {
      return fail(InputCode::unknown_parameter, "with POST, parameters are in the body",
                  request.query.front().first);
    }
    return proto::Parameters::from_json(request.body);
  }
};

}  // namespace geodesic::server
