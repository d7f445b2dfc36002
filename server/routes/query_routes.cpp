// The routes of queries on one mesh: parameters to a request, its answer to the
// format asked for, and the tag by which a client knows it again.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "proto/region/read_costs.h"
#include "proto/region/read_regions.h"
#include "proto/wire/parameters.h"
#include "proto/wire/reply_format.h"
#include "proto/wire/requests.h"
#include "server/base/timed.h"
#include "server/http/cross_origin.h"
#include "server/http/entity_tag.h"
#include "server/http/finish_reply.h"
#include "server/reply/annotate_reply.h"
#include "server/reply/draw_reply.h"
#include "server/reply/encode_reply.h"
#include "server/routes/call.h"
#include "server/routes/engine_digest.h"
#include "server/routes/request_deadline.h"
#include "server/routes/routes.h"

namespace geodesic::server {
namespace {

// A table's entries in columns that are lines, all of which are kept until the last row.
std::uint64_t bytes_of_lines(const proto::TableRequest& request) {
  const auto& columns = request.to.empty() ? request.from : request.to;
  const auto lines = std::count_if(columns.begin(), columns.end(),
                                   [](const auto& column) { return !column.is_point(); });
  return request.from.size() * static_cast<std::uint64_t>(lines) * sizeof(double);
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
  for (const std::string_view part : {engine_digest(), query.action, proto::name_of(format)}) {
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

// What is small is made at once: it takes less time than to wait for a compute slot.
bool is_large(const ReplySize& size) {
  constexpr std::uint64_t kManyNumbers = 20'000;
  constexpr std::uint64_t kManyBytes = std::uint64_t{1} << 20;
  return size.numbers > kManyNumbers || size.bytes > kManyBytes;
}

// An answer in numbers, drawn, or in its file.
template <class Reply>
Result<HttpResponse> make_reply(Answered<Reply> answer, const proto::ReplyFormat& format,
                                const Cancel& cancel) {
  if constexpr (requires { draw(answer, format, cancel); }) {
    if (is_drawing(format.format)) return draw(answer, format, cancel);
  }
  if constexpr (requires { annotate(std::move(answer), format, cancel); }) {
    if (format.format == proto::Format::annotated) {
      return annotate(std::move(answer), format, cancel);
    }
  }
  return encode(std::move(answer), format, cancel);
}

// In every format, for those that are no JSON too.
template <class Reply>
std::string warnings_header(const Reply& reply) {
  std::string joined;
  if constexpr (requires { reply.warnings; }) {
    for (const std::string& warning : reply.warnings) {
      if (!joined.empty()) joined += "; ";
      joined += warning;
    }
  }
  return joined;
}

// Distances at points and paths may be read off a field that is kept, searched for, or taken from
// a field that ends at the points: the last digits depend on that, and so on what was asked
// before. All other answers follow from the question and the build alone.
template <class Request>
bool depends_on_caches(const Request&) {
  return false;
}
bool depends_on_caches(const proto::DistanceRequest& request) { return !request.at.empty(); }
bool depends_on_caches(const proto::PathRequest&) { return true; }
bool depends_on_caches(const proto::TableRequest& request) { return !request.sparse; }
bool depends_on_caches(const proto::LoopRequest& request) {
  return request.start != proto::LoopRequest::Start::plane;
}

// A reply that is sent as it is made: neither kept nor tagged.
template <class Request>
bool is_streamed(const Request& request) {
  if constexpr (requires { request.stream; }) return request.stream;
  return false;
}

// Whether its ways may be cheap instead of short.
template <class Request>
constexpr bool takes_costs(const Request&) {
  return std::is_same_v<Request, proto::DistanceRequest> ||
         std::is_same_v<Request, proto::PathRequest> ||
         std::is_same_v<Request, proto::TableRequest> ||
         std::is_same_v<Request, proto::IsolinesRequest>;
}

template <class Request>
std::string tag_of(const Request& request, const std::string& identity) {
  return depends_on_caches(request) ? weak_tag(entity_tag(identity)) : entity_tag(identity);
}

}  // namespace

template <class Request>
Result<HttpResponse> Routes::answer_query(const Query& query) {
  Request request;
  if (auto read = proto::parse_request(query.parameters, request); !read) {
    return fail(std::move(read.error()));
  }
  auto regions = proto::read_regions(query.parameters);
  if (!regions) return fail(std::move(regions.error()));
  proto::Costs costs;
  if (takes_costs(request)) {
    auto read = proto::read_costs(query.parameters);
    if (!read) return fail(std::move(read.error()));
    costs = std::move(*read);
  }
  std::span<const proto::Format> offered = proto::formats_of(request);
  if (query.json_only) {
    if (is_streamed(request)) {
      return fail(InputCode::not_acceptable,
                  "in a batch replies are JSON, and a stream is a reply of its own", "stream");
    }
    if (std::find(offered.begin(), offered.end(), proto::Format::json) == offered.end()) {
      return fail(InputCode::not_acceptable,
                  "in a batch replies are JSON, and this one is a drawing", "part");
    }
    offered = proto::kJsonOnly;
  }
  const auto format = proto::parse_format(query.parameters, query.accept, offered);
  if (!format) return fail(format.error());
  const auto caller = with_deadline(query.caller, query.parameters);
  if (!caller) return fail(caller.error());
  if (auto known = query.parameters.check_all_known(); !known) {
    return fail(std::move(known.error()));
  }
  std::vector<proto::VertexAttribute> attributes;
  std::uint64_t file_bytes = 0;
  if constexpr (requires { attributes_of(request, *format); }) {
    if (format->format == proto::Format::annotated) {
      auto named = attributes_of(request, *format);
      if (!named) return fail(std::move(named.error()));
      attributes = std::move(*named);
      const auto file = size_of_gltf(
          query, {InputCode::not_acceptable, "format=glb makes a file of it", "format", {}, {}},
          *caller);
      if (!file) return fail(file.error());
      file_bytes = file->bytes;
    }
  }
  const bool is_kept = query.reader != nullptr && !is_streamed(request);
  const std::string identity = is_kept ? identity_of(query, format->format) : std::string();
  const std::string tag = identity.empty() ? "" : tag_of(request, identity);
  if (!identity.empty()) {
    if (auto known = known_reply(query, identity, tag)) return std::move(*known);
  }
  const auto memory = reply_budget_.share_of_nothing(caller->client);
  const auto weights = read_weights(query, costs, *memory, *caller);
  if (!weights) return fail(weights.error());
  const AskedSurface surface(query.mesh, std::move(*regions), std::move(costs));
  if constexpr (std::is_same_v<Request, proto::TableRequest>) {
    if (auto more = memory->grow(bytes_of_lines(request)); !more) {
      return fail(std::move(more.error()));
    }
  }
  auto answer = queries_.answer(surface, request, *caller);
  if (!answer) return fail(std::move(answer.error()));
  // What was not in a slot yet waits for one as all others do. The nearest points are found
  // outside of one, and say nothing of a cache.
  constexpr bool is_quick = std::is_same_v<Request, proto::NearestRequest>;
  const bool had_slot = !answer->cache_hit.value_or(is_quick);
  const Caller rest = had_slot ? caller->finishing() : *caller;
  if (!attributes.empty()) {
    auto upload = upload_to_annotate(query, attributes, file_bytes, *memory, rest);
    if (!upload) return fail(std::move(upload.error()));
    answer->upload = std::move(*upload);
  }
  if constexpr (std::is_same_v<Request, proto::TableRequest>) {
    if (request.stream) {
      return stream_rows(std::move(*answer), request, *format, memory);
    }
    if (request.sparse) {
      if (auto all = collect_rows(*answer, *memory); !all) return fail(std::move(all.error()));
    }
  }
  const ReplySize size = size_of(*answer, *format);
  const auto make = [&](const Cancel& cancel) -> Result<HttpResponse> {
    const Timed encoding(*caller, Stage::encode);
    // Not before it has its slot: who waits for one has no use for the memory.
    if (is_large(size)) {
      if (auto more = memory->grow(size.bytes); !more) return fail(std::move(more.error()));
    }
    if (answer->complete) {
      auto completed = answer->complete(answer->reply, cancel);
      if (!completed) return fail(std::move(completed.error()));
    }
    if (answer->complete_drawing && is_drawing(format->format)) {
      auto completed = answer->complete_drawing(answer->reply, cancel);
      if (!completed) return fail(std::move(completed.error()));
    }
    const std::string warnings = warnings_header(answer->reply);
    auto made = make_reply(std::move(*answer), *format, cancel);
    if (!made) return made;
    if (!attributes.empty() && made->body && made->body->size() > config_->max_body_bytes) {
      return fail_limit(InputCode::not_acceptable,
                        "with the values in it, the file could not be uploaded again",
                        config_->max_body_bytes, made->body->size(), "format");
    }
    if (!warnings.empty()) made->set_header("Geo-Warnings", warnings);
    if (!identity.empty()) {
      made->set_header("ETag", tag);
      add_to_list(*made, "Vary", "Accept");
    }
    if (query.packed_for != nullptr) {
      Poll poll(cancel);
      pack(*query.packed_for, *made, &poll);
      if (poll.stopped()) return fail_stopped(poll);
    }
    if (is_large(size) && made->body) {
      memory->shrink(made->body->size());
      made->reserved = memory;
    }
    return made;
  };
  auto response = is_large(size) || is_drawing(format->format) ? queries_.in_slot(make, rest)
                                                               : make(Cancel(std::cref(*caller)));
  if (!response) {
    // Outside of a slot nobody else says what ended it.
    const bool is_late = response.error().code == ErrorCode::cancelled && caller->deadline_over();
    return is_late ? fail(caller->why_stopped()) : std::move(response);
  }
  if (!identity.empty()) {
    keep_reply(query, identity, *response);
    response->set_header("Cache-Control", query_cache_policy());
  }
  return response;
}

// The same question again needs neither a compute slot nor encoding and packing; nor
// does one whose answer the client has.
std::optional<HttpResponse> Routes::known_reply(const Query& query, const std::string& identity,
                                                const std::string& tag) {
  if (!catalog_.contains(query.mesh)) return std::nullopt;
  const auto kept = replies_.find(kept_as(query, identity));
  HttpResponse response;
  if (has_already(*query.reader, tag)) {
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
                                 auto kept = std::make_shared<HttpResponse>(reply);
                                 kept->reserved = nullptr;  // the cache has a budget of its own
                                 return kept;
                               });
}

Result<HttpResponse> Routes::answer_any_query(const Query& query) {
  struct Row {
    std::string_view name;
    Result<HttpResponse> (Routes::*answer)(const Query&);
  };
  static constexpr std::array<Row, kQueries.size()> kRows{{
      {"distance", &Routes::answer_query<proto::DistanceRequest>},
      {"path", &Routes::answer_query<proto::PathRequest>},
      {"table", &Routes::answer_query<proto::TableRequest>},
      {"isolines", &Routes::answer_query<proto::IsolinesRequest>},
      {"samples", &Routes::answer_query<proto::SamplesRequest>},
      {"measure", &Routes::answer_query<proto::MeasureRequest>},
      {"extent", &Routes::answer_query<proto::ExtentRequest>},
      {"voronoi", &Routes::answer_query<proto::VoronoiRequest>},
      {"trace", &Routes::answer_query<proto::TraceRequest>},
      {"loop", &Routes::answer_query<proto::LoopRequest>},
      {"logmap", &Routes::answer_query<proto::LogmapRequest>},
      {"nearest", &Routes::answer_query<proto::NearestRequest>},
  }};
  static_assert(std::ranges::equal(kRows, kQueries, {}, &Row::name), "a row for each query");
  for (const Row& row : kRows) {
    if (row.name == query.action) return (this->*row.answer)(query);
  }
  return fail(ErrorCode::internal, "a query that nobody answers");
}

// What it says holds for ever, but an engine may become better.
std::string Routes::query_cache_policy() const { return access_.audience() + ", max-age=86400"; }

Result<std::shared_ptr<ReplyBudget::Share>> Routes::memory_for_json(std::size_t bytes,
                                                                    const Caller& caller) {
  constexpr std::size_t kLittle = std::size_t{64} << 10;
  if (bytes <= kLittle) return nullptr;
  // An estimate: parsed, `[]` is a value and an allocation for two or three bytes of text.
  constexpr std::uint64_t kBytesOfByte = 24;
  // Its own account: a request that brings much may get much.
  return reply_budget_.reserve(bytes * kBytesOfByte, caller.client + " sends");
}

HttpResponse Routes::query(Call& call, std::string_view action) {
  const auto memory = memory_for_json(call.request.body.size(), call.request.caller);
  if (!memory) return call.problem(memory.error());
  auto parameters = call.parameters();
  if (!parameters) return call.problem(parameters.error());
  const bool is_get = call.is("GET");
  auto response = answer_any_query({call.id, action, *parameters, call.request.header("Accept"),
                                    call.request.caller, is_get ? &call.request : nullptr,
                                    &call.request, false});
  if (!response) response = call.problem(response.error());
  add_to_list(*response, "Vary", "Accept");
  return std::move(*response);
}

}  // namespace geodesic::server
