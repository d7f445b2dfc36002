#include "server/routes.h"

#include <algorithm>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/methods.h"
#include "proto/parameters.h"
#include "proto/query_limits.h"
#include "proto/query_replies.h"
#include "proto/query_requests.h"
#include "server/embedded_text.h"
#include "server/encode_reply.h"
#include "server/sha256.h"

namespace geodesic::server {
namespace {

using nlohmann::ordered_json;

constexpr std::uint64_t kPageDefault = 100;
constexpr std::uint64_t kPageMost = 1000;

std::vector<std::string_view> split(std::string_view path) {
  std::vector<std::string_view> segments;
  while (!path.empty()) {
    path.remove_prefix(1);  // the slash
    const std::size_t slash = path.find('/');
    segments.push_back(path.substr(0, slash));
    path = slash == std::string_view::npos ? "" : path.substr(slash);
  }
  return segments;
}

ordered_json cache_json(const CacheStats& stats) {
  return {{"bytes", stats.bytes}, {"budget", stats.budget},      {"entries", stats.entries},
          {"hits", stats.hits},   {"misses", stats.misses},      {"makes", stats.makes},
          {"waits", stats.waits}, {"evictions", stats.evictions}};
}

std::string_view media_type_of(std::string_view format) {
  if (format == "glb") return "model/gltf-binary";
  if (format == "gltf") return "model/gltf+json";
  return "application/octet-stream";
}

HttpResponse text_reply(std::string_view text, std::string type) {
  HttpResponse response;
  response.set_body(std::string(text), std::move(type));
  return response;
}

}  // namespace

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
    HttpResponse response = problem(ErrorCode::method_not_allowed, "allowed here: " + allowed);
    response.set_header("Allow", std::move(allowed));
    return response;
  }
  [[nodiscard]] bool is(std::string_view name) const { return method == name; }

  // The parameters of a query: of the URL for GET, of the JSON body for POST.
  [[nodiscard]] Result<proto::Parameters> parameters() const {
    if (is("GET")) return proto::Parameters::from_query(request.query);
    if (!request.query.empty()) {
      return fail(ErrorCode::unknown_parameter, "with POST, parameters are in the body",
                  request.query.front().first);
    }
    return proto::Parameters::from_json(request.body);
  }
};

Routes::Routes(const Config& config, MeshCatalog& catalog, FieldQueries& queries, ComputePool& pool)
    : config_(config), catalog_(catalog), queries_(queries), pool_(pool) {}

std::uint64_t Routes::max_body(std::string_view method, std::string_view path) const {
  const bool upload = method == "PUT" || (method == "POST" && path == "/v1/meshes");
  return upload ? config_.max_body_bytes : config_.max_json_bytes;
}

HttpResponse Routes::answer(HttpRequest& request) {
  Call call{request,
            request.method == "HEAD" ? "GET" : std::string_view(request.method),
            split(request.path),
            {},
            {}};
  HttpResponse response = dispatch(call);
  response.route = std::move(call.route);
  return response;
}

HttpResponse Routes::answer_admin(HttpRequest& request) {
  Call call{request,
            request.method == "HEAD" ? "GET" : std::string_view(request.method),
            split(request.path),
            {},
            {}};
  return probe(call);
}

HttpResponse Routes::dispatch(Call& call) {
  const auto& s = call.segments;
  const auto reads = [&](const char* route, auto reply) {
    call.route = route;
    return call.is("GET") ? reply() : call.not_allowed("GET, HEAD");
  };
  if (call.request.path == "/") {
    return reads("/", [] { return text_reply(start_page(), "text/html; charset=utf-8"); });
  }
  if (call.request.path == "/openapi.yaml") {
    return reads("/openapi.yaml", [] { return text_reply(openapi_yaml(), "application/yaml"); });
  }
  if (call.request.path == "/v1/methods") {
    return reads("/v1/methods", [] { return json_reply(proto::methods_json()); });
  }
  if (call.request.path == "/v1/status") {
    return reads("/v1/status", [&] { return status(); });
  }
  if (s.size() >= 2 && s[0] == "v1" && s[1] == "meshes") {
    if (s.size() > 2) return one_mesh(call);
    call.route = "/v1/meshes";
    if (call.is("POST")) return add_mesh(call);
    if (call.is("GET")) return list_meshes(call);
    return call.not_allowed("GET, HEAD, POST");
  }
  if (config_.admin_listen.host.empty()) return probe(call);
  return call.problem(ErrorCode::route_unknown, "there is nothing here");
}

// /livez and /readyz.
HttpResponse Routes::probe(Call& call) const {
  const bool ready = call.request.path == "/readyz";
  if (!ready && call.request.path != "/livez") {
    return call.problem(ErrorCode::route_unknown, "there is nothing here");
  }
  call.route = call.request.path;
  if (!call.is("GET")) return call.not_allowed("GET, HEAD");
  if (ready && draining_) return call.problem(ErrorCode::draining, "about to stop");
  if (ready) {
    if (const auto store = catalog_.store_health(); !store) return call.problem(store.error());
  }
  return json_reply(R"({"status":"ok"})");
}

HttpResponse Routes::one_mesh(Call& call) {
  call.id = std::string(call.segments[2]);
  call.route = "/v1/meshes/{id}";
  const std::string_view action = call.segments.size() == 4 ? call.segments[3] : "";
  const bool plain = call.segments.size() == 3;
  if (plain) {
    if (call.is("GET")) return mesh_metadata(call);
    if (call.is("PUT")) return put_mesh(call);
    if (call.is("DELETE")) return delete_mesh(call);
    return call.not_allowed("GET, HEAD, PUT, DELETE");
  }
  constexpr std::string_view kActions[] = {"source",   "prepare", "distance", "path",   "table",
                                           "isolines", "samples", "trace",    "nearest"};
  if (std::find(std::begin(kActions), std::end(kActions), action) == std::end(kActions)) {
    return call.problem(ErrorCode::route_unknown, "a mesh has nothing of this name");
  }
  call.route += "/" + std::string(action);
  if (action == "source") return call.is("GET") ? mesh_source(call) : call.not_allowed("GET, HEAD");
  if (action == "prepare") return call.is("POST") ? prepare_mesh(call) : call.not_allowed("POST");
  if (!call.is("GET") && !call.is("POST")) return call.not_allowed("GET, HEAD, POST");
  return query(call, action);
}

HttpResponse Routes::add_mesh(Call& call) {
  if (auto known = proto::Parameters::from_query(call.request.query).check_all_known(); !known) {
    return call.problem(known.error());
  }
  const auto upload = catalog_.add(std::move(call.request.body), call.request.client_gone);
  if (!upload) return call.problem(upload.error());
  HttpResponse response = json_reply(upload->metadata, upload->created ? 201 : 200);
  response.set_header("Location", "/v1/meshes/" + upload->id);
  return response;
}

HttpResponse Routes::put_mesh(Call& call) {
  if (!is_mesh_id(call.id)) {
    return call.problem(ErrorCode::digest_mismatch,
                        "a mesh is put under the SHA-256 of its bytes, in lower-case hexadecimal");
  }
  if (sha256_hex(call.request.body) != call.id) {
    return call.problem(ErrorCode::digest_mismatch, "the bytes have another SHA-256 than the URL");
  }
  return add_mesh(call);
}

HttpResponse Routes::list_meshes(Call& call) {
  auto parameters = proto::Parameters::from_query(call.request.query);
  const auto limit = parameters.whole("limit");
  if (!limit) return call.problem(limit.error());
  const auto cursor = parameters.text("cursor");
  if (!cursor) return call.problem(cursor.error());
  if (auto known = parameters.check_all_known(); !known) return call.problem(known.error());
  const std::uint64_t count = limit->value_or(kPageDefault);
  if (count < 1 || count > kPageMost) {
    return call.problem(Error{ErrorCode::value_out_of_range, "a page has 1 to 1000 meshes", "limit",
                              kPageMost, count});
  }
  if (*cursor && !is_mesh_id(**cursor)) {
    return call.problem(
        Error{ErrorCode::bad_syntax, "this is no cursor of ours", "cursor", {}, {}});
  }
  const auto ids = catalog_.list(cursor->value_or(""), count + 1);
  std::string page = "{\"meshes\":[";
  bool first = true;
  for (std::size_t i = 0; i < std::min<std::size_t>(ids.size(), count); ++i) {
    const auto metadata = catalog_.metadata(ids[i], call.request.client_gone);
    if (!metadata && metadata.error().code == ErrorCode::mesh_unknown) continue;  // just deleted
    if (!metadata) return call.problem(metadata.error());
    if (!first) page += ',';
    first = false;
    page += *metadata;
  }
  page += "],\"next\":";
  page += ids.size() > count ? "\"" + ids[count - 1] + "\"" : "null";
  page += "}";
  return json_reply(std::move(page));
}

HttpResponse Routes::mesh_metadata(Call& call) {
  const auto metadata = catalog_.metadata(call.id, call.request.client_gone);
  return metadata ? json_reply(*metadata) : call.problem(metadata.error());
}

HttpResponse Routes::mesh_source(Call& call) {
  const auto metadata = catalog_.metadata(call.id, call.request.client_gone);
  if (!metadata) return call.problem(metadata.error());
  auto bytes = catalog_.source(call.id);
  if (!bytes) return call.problem(bytes.error());
  const auto description = ordered_json::parse(*metadata, nullptr, false);
  HttpResponse response;
  response.set_body(std::move(*bytes), std::string(media_type_of(description.value("format", ""))));
  response.set_header("Cache-Control", "public, max-age=31536000, immutable");
  response.set_header("X-Content-Type-Options", "nosniff");
  return response;
}

HttpResponse Routes::prepare_mesh(Call& call) {
  const auto adjacency = catalog_.adjacency(call.id, call.request.client_gone);
  if (!adjacency) return call.problem(adjacency.error());
  return mesh_metadata(call);
}

HttpResponse Routes::delete_mesh(Call& call) {
  queries_.forget(call.id);
  if (const auto removed = catalog_.remove(call.id); !removed) return call.problem(removed.error());
  queries_.forget(call.id);  // what a query under way has put back meanwhile
  HttpResponse response;
  response.status = 204;
  return response;
}

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
  const auto answer = queries_.answer(call.id, request, call.request.client_gone);
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

HttpResponse Routes::status() const {
  const ComputePool::Stats pool = pool_.stats();
  const ordered_json status{{"name", "geodesicd"},
                            {"version", GEODESIC_VERSION},
                            {"draining", draining_.load()},
                            {"meshes", catalog_.size()},
                            {"limits",
                             {{"max_body_bytes", config_.max_body_bytes},
                              {"max_json_bytes", config_.max_json_bytes},
                              {"max_vertices", config_.max_vertices},
                              {"max_faces", config_.max_faces},
                              {"max_sources", proto::kMaxSources},
                              {"max_points", proto::kMaxPoints},
                              {"max_via", proto::kMaxVia},
                              {"max_table_entries", proto::kMaxTableEntries},
                              {"max_steiner_nodes", proto::kMaxSteinerNodes},
                              {"max_levels", proto::kMaxLevels},
                              {"max_isoline_segments", proto::kMaxIsolineSegments},
                              {"max_samples", proto::kMaxSamples},
                              {"body_timeout_seconds", config_.body_timeout_seconds},
                              {"queue", config_.queue}}},
                            {"compute",
                             {{"slots", pool.slots},
                              {"running", pool.running},
                              {"queued", pool.queued},
                              {"finished", pool.finished},
                              {"rejected", pool.rejected},
                              {"given_up", pool.given_up}}},
                            {"caches",
                             {{"meshes", cache_json(catalog_.mesh_cache())},
                              {"adjacency", cache_json(catalog_.adjacency_cache())},
                              {"fields", cache_json(queries_.field_cache())}}}};
  return json_reply(status.dump());
}

}  // namespace geodesic::server
