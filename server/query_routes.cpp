// The routes of queries on one mesh: parameters to a request, its answer to the
// format asked for, and the tag by which a client knows it again.
#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/parameters.h"
#include "proto/query_requests.h"
#include "proto/reply_format.h"
#include "server/call.h"
#include "server/cross_origin.h"
#include "server/draw_reply.h"
#include "server/encode_reply.h"
#include "server/entity_tag.h"
#include "server/routes.h"
#include "server/timed.h"

namespace geodesic::server {
namespace {

constexpr std::uint64_t kLongestDeadline = 3'600'000;  // milliseconds

// The caller, with less time if the query says so: `deadline_ms`, from now.
Result<Caller> hurried(const Caller& caller, proto::Parameters& parameters) {
  const auto milliseconds = parameters.whole("deadline_ms");
  if (!milliseconds) return fail(milliseconds.error());
  Caller hurried = caller;
  if (!*milliseconds) return hurried;
  if (**milliseconds < 1 || **milliseconds > kLongestDeadline) {
    return fail_limit(ErrorCode::value_out_of_range, "a deadline is 1 to 3600000 milliseconds off",
                      kLongestDeadline, **milliseconds, "deadline_ms");
  }
  const auto deadline = Caller::Clock::now() + std::chrono::milliseconds(**milliseconds);
  hurried.deadline = std::min(deadline, caller.deadline.value_or(deadline));
  return hurried;
}

// The tag of the reply to a GET: over all that decides its bytes.
std::string tag_of(const Routes::Query& query, proto::Format format) {
  std::vector<std::pair<std::string_view, std::string_view>> parameters;
  for (const auto& [name, value] : query.reader->query) {
    if (name != "format" && name != "deadline_ms") parameters.emplace_back(name, value);
  }
  // Their order matters only among those of one name.
  std::stable_sort(parameters.begin(), parameters.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  // A NUL is in none of them.
  std::string key = GEODESIC_VERSION;
  for (const std::string_view part :
       {std::string_view(query.mesh), query.action, proto::name_of(format)}) {
    key += '\0';
    key += part;
  }
  for (const auto& [name, value] : parameters) {
    key += '\0';
    key += name;
    key += '\0';
    key += value;
  }
  return entity_tag(key);
}

}  // namespace

template <class Request>
Result<HttpResponse> Routes::answer_query(const Query& query) {
  Request request;
  if (auto read = proto::parse_request(query.parameters, request); !read) {
    return fail(std::move(read.error()));
  }
  const auto offered = query.json_only ? proto::kJsonOnly : proto::formats_of(request);
  const auto format = proto::parse_format(query.parameters, query.accept, offered);
  if (!format) return fail(format.error());
  const auto caller = hurried(query.caller, query.parameters);
  if (!caller) return fail(caller.error());
  if (auto known = query.parameters.check_all_known(); !known) {
    return fail(std::move(known.error()));
  }
  const std::string tag = query.reader != nullptr ? tag_of(query, format->format) : "";
  if (!tag.empty() && catalog_.contains(query.mesh) && has_already(*query.reader, tag)) {
    HttpResponse response = not_modified(tag);
    response.set_header("Cache-Control", query_cache_policy());
    return response;
  }
  if (!tag.empty()) {
    if (auto kept = kept_reply(query.mesh, tag)) return std::move(*kept);
  }
  auto answer = queries_.answer(query.mesh, request, *caller);
  if (!answer) return fail(std::move(answer.error()));
  Result<HttpResponse> response;
  if constexpr (requires(const Cancel& cancel) { draw(*answer, *format, cancel); }) {
    if (is_drawing(format->format)) {
      response = queries_.in_slot(
          [&](const Cancel& cancel) {
            const Timed encoding(*caller, Stage::encode);
            return draw(*answer, *format, cancel);
          },
          *caller);
      if (!response) return response;
    }
  }
  if (!is_drawing(format->format)) {
    const Timed encoding(*caller, Stage::encode);
    response = encode(std::move(*answer), *format);
  }
  if (!tag.empty()) {
    response->set_header("ETag", tag);
    keep_reply(query.mesh, tag, *response);
    response->set_header("Cache-Control", query_cache_policy());
  }
  return response;
}

// The same question again needs neither a compute slot nor encoding.
std::optional<HttpResponse> Routes::kept_reply(const std::string& mesh, const std::string& tag) {
  const auto kept = replies_.find(mesh + tag);
  // Only of a mesh that is there: and it counts as used, as if it had been asked itself.
  if (!kept || !catalog_.use(mesh)) return std::nullopt;
  HttpResponse response = *kept;
  for (auto& [name, value] : response.headers) {
    if (name == "Geo-Cache") value = "hit";
  }
  response.set_header("Cache-Control", query_cache_policy());
  return response;
}

void Routes::keep_reply(const std::string& mesh, const std::string& tag,
                        const HttpResponse& reply) {
  // One large reply is not worth many small ones.
  constexpr std::uint64_t kShare = 16;
  if (!reply.body || reply.body->size() > config_->reply_cache_bytes / kShare) return;
  (void)replies_.get_or_create(mesh + tag, [&]() -> Result<std::shared_ptr<const HttpResponse>> {
    return std::make_shared<const HttpResponse>(reply);
  });
}

Result<HttpResponse> Routes::answer_any_query(const Query& query) {
  if (query.action == "distance") return answer_query<proto::DistanceRequest>(query);
  if (query.action == "path") return answer_query<proto::PathRequest>(query);
  if (query.action == "table") return answer_query<proto::TableRequest>(query);
  if (query.action == "isolines") return answer_query<proto::IsolinesRequest>(query);
  if (query.action == "samples") return answer_query<proto::SamplesRequest>(query);
  if (query.action == "trace") return answer_query<proto::TraceRequest>(query);
  return answer_query<proto::NearestRequest>(query);
}

// What it says holds for ever, but an engine may become better.
std::string Routes::query_cache_policy() const { return access_.audience() + ", max-age=86400"; }

HttpResponse Routes::query(Call& call, std::string_view action) {
  auto parameters = call.parameters();
  if (!parameters) return call.problem(parameters.error());
  const bool is_get = call.is("GET");
  auto response = answer_any_query({call.id, action, *parameters, call.request.header("Accept"),
                                    call.request.caller, is_get ? &call.request : nullptr, false});
  if (!response) response = call.problem(response.error());
  add_to_list(*response, "Vary", "Accept");
  return std::move(*response);
}

}  // namespace geodesic::server
