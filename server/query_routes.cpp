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
#include "server/finish_reply.h"
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

// All that decides the bytes of the reply to a GET.
std::string identity_of(const Routes::Query& query, proto::Format format) {
  std::vector<std::pair<std::string_view, std::string_view>> parameters;
  for (const auto& [name, value] : query.reader->query) {
    if (name != "format" && name != "deadline_ms") parameters.emplace_back(name, value);
  }
  // Their order matters only among those of one name.
  std::stable_sort(parameters.begin(), parameters.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  // A NUL is in none of them.
  std::string identity = query.mesh;
  for (const std::string_view part :
       {std::string_view(GEODESIC_VERSION), query.action, proto::name_of(format)}) {
    identity += '\0';
    identity += part;
  }
  for (const auto& [name, value] : parameters) {
    identity += '\0';
    identity += name;
    identity += '\0';
    identity += value;
  }
  return identity;
}

// A reply is kept as it is sent. A long question is known by its tag, lest the questions
// take more memory than the replies.
std::string kept_as(const Routes::Query& query, const std::string& identity) {
  constexpr std::size_t kLongest = 512;
  std::string key = identity.size() <= kLongest ? identity : query.mesh + entity_tag(identity);
  if (admits_gzip(*query.reader)) key.append(1, '\0').append("gzip");
  return key;
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
  const std::string identity =
      query.reader != nullptr ? identity_of(query, format->format) : std::string();
  if (!identity.empty()) {
    if (auto known = known_reply(query, identity)) return std::move(*known);
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
  if (!identity.empty()) {
    response->set_header("ETag", entity_tag(identity));
    add_to_list(*response, "Vary", "Accept");
    pack(*query.reader, *response);
    keep_reply(query, identity, *response);
    response->set_header("Cache-Control", query_cache_policy());
  }
  return response;
}

// The same question again needs neither a compute slot nor encoding and packing; nor
// does one whose answer the client has.
std::optional<HttpResponse> Routes::known_reply(const Query& query, const std::string& identity) {
  if (!catalog_.contains(query.mesh)) return std::nullopt;
  const auto kept = replies_.find(kept_as(query, identity));
  const bool conditional = query.reader->header("If-None-Match") != nullptr;
  HttpResponse response;
  if (const std::string tag = conditional ? entity_tag(identity) : "";
      conditional && has_already(*query.reader, tag)) {
    response = not_modified(tag);
  } else if (kept && catalog_.use(query.mesh)) {  // it counts as used, as if asked itself
    response = *kept;
    for (auto& [name, value] : response.headers) {
      if (name == "Geo-Cache") value = "hit";
    }
  } else {
    return std::nullopt;
  }
  response.set_header("Cache-Control", query_cache_policy());
  return response;
}

void Routes::keep_reply(const Query& query, const std::string& identity,
                        const HttpResponse& reply) {
  // One large reply is not worth many small ones.
  constexpr std::uint64_t kShare = 16;
  if (!reply.body || reply.body->size() > config_->reply_cache_bytes / kShare) return;
  (void)replies_.get_or_create(kept_as(query, identity),
                               [&]() -> Result<std::shared_ptr<const HttpResponse>> {
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
