// The routes of queries on one mesh: parameters to a request, its answer to the
// format asked for.
#include <string_view>

#include "proto/parameters.h"
#include "proto/query_requests.h"
#include "proto/reply_format.h"
#include "server/call.h"
#include "server/encode_reply.h"
#include "server/routes.h"

namespace geodesic::server {

template <class Request>
HttpResponse Routes::answer_query(const Call& call) {
  auto parameters = call.parameters();
  if (!parameters) return call.problem(parameters.error());
  Request request;
  if (const auto read = proto::parse_request(*parameters, request); !read) {
    return call.problem(read.error());
  }
  const auto format =
      proto::parse_format(*parameters, call.request.header("Accept"), proto::formats_of(request));
  if (!format) return call.problem(format.error());
  if (const auto known = parameters->check_all_known(); !known) return call.problem(known.error());
  const auto answer = queries_.answer(call.id, request, call.request.caller);
  return answer ? encode(*answer, *format) : call.problem(answer.error());
}

HttpResponse Routes::query(Call& call, std::string_view action) {
  if (action == "distance") return answer_query<proto::DistanceRequest>(call);
  if (action == "path") return answer_query<proto::PathRequest>(call);
  if (action == "table") return answer_query<proto::TableRequest>(call);
  if (action == "isolines") return answer_query<proto::IsolinesRequest>(call);
  if (action == "samples") return answer_query<proto::SamplesRequest>(call);
  if (action == "trace") return answer_query<proto::TraceRequest>(call);
  return answer_query<proto::NearestRequest>(call);
}

}  // namespace geodesic::server
