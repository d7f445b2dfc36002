#include "server/routes.h"

#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/query_limits.h"
#include "proto/query_replies.h"
#include "server/call.h"
#include "server/embedded_text.h"
#include "server/encode_reply.h"

namespace geodesic::server {
namespace {

using nlohmann::ordered_json;

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

HttpResponse text_reply(std::string_view text, std::string type) {
  HttpResponse response;
  response.set_body(std::string(text), std::move(type));
  return response;
}

}  // namespace

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
