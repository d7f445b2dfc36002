#include "server/routes/routes.h"

#include <chrono>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/replies/replies.h"
#include "proto/wire/query_limits.h"
#include "server/base/service_codes.h"
#include "server/base/stage_times.h"
#include "server/http/finish_reply.h"
#include "server/reply/encode_reply.h"
#include "server/routes/call.h"
#include "server/routes/documents.h"
#include "server/routes/embedded_text.h"
#include "server/routes/engine_digest.h"

namespace geodesic::server {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kMostCacheEntries = 1000;  // in a report

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

// A job mostly waits: for the store, or for its turn in a compute slot. So more of
// them run than there are slots, and half of those, a client's share, is all slots.
Jobs::Limits job_limits(const Config& config, std::size_t slots) {
  Jobs::Limits limits;
  limits.jobs = config.max_jobs;
  limits.running = 2 * slots;
  limits.bytes = config.job_result_bytes;
  limits.keep = std::chrono::seconds(config.job_seconds);
  limits.lease = std::chrono::seconds(config.job_lease_seconds);
  return limits;
}

// Up to twice as long, so that those who are refused together do not come back together.
std::chrono::seconds spread(std::chrono::seconds wait) {
  thread_local std::minstd_rand random(std::random_device{}());
  return wait +
         std::chrono::seconds(std::uniform_int_distribution<std::int64_t>(0, wait.count())(random));
}

HttpResponse text_reply(std::string_view text, std::string type) {
  HttpResponse response;
  response.set_body(std::string(text), std::move(type));
  return response;
}

// What a query starts from may be large, and is held while it waits and computes. On an account of
// its own, as a body's JSON is: a request that starts from much may get much.
void count_sources(ReplyBudget& budget, Caller& caller) {
  caller.reserve = [share = budget.share_of_nothing(caller.client + " starts")](
                       std::uint64_t bytes) { return ReplyBudget::take_part(share, bytes); };
}

// What a kept reply takes, its headers and its key by a guess.
std::size_t bytes_of(const HttpResponse& reply) { return reply.body->size() + 2048; }

}  // namespace

Routes::Routes(const Config& config, MeshCatalog& catalog, FieldQueries& queries, ComputePool& pool,
               Metrics& metrics)
    : config_(config),
      cross_origin_(config.cors_origins, config.cors_write_origins),
      replies_(config.reply_cache_bytes, bytes_of),
      reply_budget_(config.reply_memory_bytes),
      catalog_(catalog),
      queries_(queries),
      pool_(pool),
      metrics_(metrics),
      jobs_(job_limits(config, pool.slots()),
            [this](HttpRequest& request) { return answer_job(request); }) {}

std::uint64_t Routes::max_body(std::string_view method, std::string_view path) const {
  const bool upload = method == "PUT" || (method == "POST" && path == "/v1/meshes");
  return upload ? config_->max_body_bytes : config_->max_json_bytes;
}

bool Routes::wants_body(HttpRequest& request) const {
  return !cross_origin_.refuse(request) && access_.admits(request);
}

HttpResponse Routes::answer(HttpRequest& request) {
  request.caller.times = std::make_shared<StageTimes>();
  HttpResponse response;
  if (CrossOrigin::is_preflight(request)) {
    response = cross_origin_.answer_preflight(request);
  } else {
    auto refusal = cross_origin_.refuse(request);
    response = refusal ? std::move(*refusal) : route(request);
    cross_origin_.allow(request, response);
  }
  // How long the queue is, the code alone does not know.
  const bool is_refused = response.status == 429 || response.status == 503;
  for (auto& [name, value] : response.headers) {
    if (!is_refused || draining_ || name != "Retry-After" || value != "1") continue;
    value = std::to_string(spread(pool_.retry_after(request.caller.client)).count());
  }
  finish_reply(request, response);
  add_timing(*request.caller.times, response);
  return response;
}

HttpResponse Routes::route(HttpRequest& request) {
  if (auto refusal = access_.check(request)) return std::move(*refusal);
  return dispatched(request);
}

HttpResponse Routes::dispatched(HttpRequest& request) {
  Call call{request,
            request.method == "HEAD" ? "GET" : std::string_view(request.method),
            split(request.path),
            {},
            {}};
  HttpResponse response = dispatch(call);
  // Whatever a path answers to, it says which methods that are.
  if (call.is("OPTIONS") && response.status == 405) {
    response.status = 204;
    response.body = nullptr;
    response.content_type.clear();
  }
  response.route = std::move(call.route);
  return response;
}

HttpResponse Routes::answer_admin(HttpRequest& request) {
  Call call{request,
            request.method == "HEAD" ? "GET" : std::string_view(request.method),
            split(request.path),
            {},
            {}};
  HttpResponse response = operate(call);
  finish_reply(request, response);
  response.route = std::move(call.route);
  return response;
}

std::optional<HttpResponse> Routes::page(const HttpRequest& request) const {
  // Below it links are relative, so it ends with a slash.
  if (!request.base_path.empty() && request.path == request.base_path) {
    return redirect(308, request.base_path + "/");
  }
  if (auto file = viewer_.find(request)) return file;
  if (request.path == "/") return text_reply(start_page(), "text/html; charset=utf-8");
  if (auto document = find_document(request)) return document;
  if (auto file = docs_.find(request)) return file;
  // There may be a site tomorrow.
  if (request.path == "/docs/") return redirect(307, "api/");
  if (request.path == "/docs/errors/") return redirect(307, "../api/");
  return missing_document(request);
}

HttpResponse Routes::dispatch(Call& call) {
  const auto& s = call.segments;
  const auto reads = [&](const char* route, auto reply) {
    call.route = route;
    return call.is("GET") ? reply() : call.not_allowed("GET, HEAD");
  };
  if (auto file = page(call.request)) {
    // One name in metrics for the many files of the documentation.
    call.route = call.request.path.starts_with("/docs/") ? "/docs/{page}" : call.request.path;
    return call.is("GET") ? std::move(*file) : call.not_allowed("GET, HEAD");
  }
  const auto plain = [&](auto reply) {
    return [&call, reply] {
      const auto none = call.check_no_parameters();
      return none ? reply() : call.problem(none.error());
    };
  };
  if (call.request.path == "/v1/methods") {
    return reads("/v1/methods", plain([] { return json_reply(proto::methods_json()); }));
  }
  if (call.request.path == "/v1/status") {
    return reads("/v1/status", plain([this] { return status(); }));
  }
  if (s.size() >= 2 && s[0] == "v1" && s[1] == "meshes") {
    if (may_be_job(call)) return begin_job(call);
    if (s.size() > 3) count_sources(reply_budget_, call.request.caller);
    if (s.size() > 2) return one_mesh(call);
    call.route = "/v1/meshes";
    if (call.is("POST")) return add_mesh(call);
    if (call.is("GET")) return list_meshes(call);
    return call.not_allowed("GET, HEAD, POST");
  }
  if (s.size() >= 2 && s[0] == "v1" && s[1] == "jobs") return one_job(call);
  if (call.request.path == "*" && call.is("OPTIONS")) {
    return call.not_allowed("GET, HEAD, POST, PUT, PATCH, DELETE");
  }
  if (config_->admin_listen.host.empty()) return operate(call);
  return call.problem(ServiceCode::route_unknown, "there is nothing here");
}

// /livez, /readyz, /metrics and /debug/cache.
HttpResponse Routes::operate(Call& call) {
  const std::string& path = call.request.path;
  if (path != "/livez" && path != "/readyz" && path != "/metrics" && path != "/debug/cache") {
    return call.problem(ServiceCode::route_unknown, "there is nothing here");
  }
  call.route = path;
  if (!call.is("GET")) return call.not_allowed("GET, HEAD");
  HttpResponse response;
  if (path == "/metrics") {
    response = text_reply(metrics_text(), "text/plain; version=0.0.4; charset=utf-8");
  } else if (path == "/debug/cache") {
    response = json_reply(cache_report());
  } else {
    if (path == "/readyz") {
      if (draining_) return call.problem(ServiceCode::draining, "about to stop");
      if (!listener_().is_accepting) {
        return call.problem(ServiceCode::overloaded, "connections wait that cannot be accepted");
      }
      const std::string* const excluded = call.request.parameter("exclude");
      if (excluded != nullptr && *excluded != "store") {
        return call.problem(Error{
            ErrorCode::value_out_of_range, "only the store can be left out", "exclude", {}, {}});
      }
      const auto store = catalog_.store_health();
      if (!store && excluded == nullptr) return call.problem(store.error());
    }
    response = json_reply(R"({"status":"ok"})");
  }
  response.set_header("Cache-Control", "no-store");
  return response;
}

std::string Routes::metrics_text() {
  Metrics::Present present;
  present.pool = pool_.stats();
  present.memory = pool_.memory();
  present.meshes = catalog_.mesh_cache();
  present.adjacency = catalog_.adjacency_cache();
  present.fields = queries_.field_cache();
  present.replies = replies_.stats();
  present.reply_memory = reply_budget_.stats();
  present.store = catalog_.store_stats();
  present.prepared = catalog_.prepared_stats();
  present.jobs = jobs_.stats();
  present.decoders = catalog_.decoder_stats();
  const Listener listener = listener_();
  present.connections = listener.connections;
  present.accept_failures = listener.accept_failures;
  present.ready = !draining_ && listener.is_accepting && catalog_.store_health();
  return metrics_.text(present);
}

// What is in the caches, the most recently used first.
std::string Routes::cache_report() const {
  const auto report = [](const std::vector<CacheEntry>& entries) {
    ordered_json list = ordered_json::array();
    for (const CacheEntry& entry : entries) {
      list.push_back({{"key", entry.key}, {"bytes", entry.bytes}});
    }
    return list;
  };
  return ordered_json{{"meshes", report(catalog_.cached_meshes(kMostCacheEntries))},
                      {"adjacency", report(catalog_.cached_adjacency(kMostCacheEntries))},
                      {"fields", report(queries_.cached_fields(kMostCacheEntries))}}
      .dump();
}

HttpResponse Routes::status() {
  const auto config = config_.get();
  const ComputePool::Stats pool = pool_.stats();
  const ComputeMemory::Stats memory = pool_.memory();
  const Jobs::Stats jobs = jobs_.stats();
  const ReplyBudget::Stats replies = reply_budget_.stats();
  const ordered_json status{
      {"name", "geodesicd"},
      {"version", GEODESIC_VERSION},
      {"engine", engine_digest()},
      {"draining", draining_.load()},
      {"meshes", catalog_.size()},
      {"limits",
       {{"max_body_bytes", config->max_body_bytes},
        {"max_json_bytes", config->max_json_bytes},
        {"max_vertices", config->max_vertices},
        {"max_faces", config->max_faces},
        {"max_sources", proto::kMaxSources},
        {"max_curve_points", proto::kMaxCurvePoints},
        {"max_curve_pieces", proto::kMaxCurvePieces},
        {"max_points", proto::kMaxPoints},
        {"max_via", proto::kMaxVia},
        {"max_loop_points", proto::kMaxLoopPoints},
        {"max_table_entries", proto::kMaxTableEntries},
        {"max_streamed_entries", proto::kMaxStreamedEntries},
        {"max_line_entries", proto::kMaxLineEntries},
        {"max_sparse_entries", proto::kMaxSparseEntries},
        {"max_landmarks", proto::kMaxLandmarks},
        {"max_steiner_nodes", proto::kMaxSteinerNodes},
        {"max_levels", proto::kMaxLevels},
        {"max_isoline_segments", proto::kMaxIsolineSegments},
        {"max_samples", proto::kMaxSamples},
        {"max_radii", proto::kMaxRadii},
        {"max_label_attributes", proto::kMaxLabelAttributes},
        {"max_fields", proto::kMaxFields},
        {"max_relax", proto::kMaxRelax},
        {"max_region_shapes", proto::kMaxRegionShapes},
        {"max_face_ranges", proto::kMaxFaceRanges},
        {"max_walls", proto::kMaxWalls},
        {"max_line_points", proto::kMaxLinePoints},
        {"max_line_vertices", proto::kMaxLineVertices},
        {"max_slopes", proto::kMaxSlopes},
        {"max_batch_lines", kMaxBatchLines},
        {"reply_memory_bytes", config->reply_memory_bytes},
        {"max_jobs", config->max_jobs},
        {"job_result_bytes", config->job_result_bytes},
        {"job_seconds", config->job_seconds},
        {"job_lease_seconds", config->job_lease_seconds},
        {"body_timeout_seconds", config->body_timeout_seconds},
        {"queue", config->queue},
        {"query_memory_bytes", memory.limits.query},
        {"compute_memory_bytes", memory.limits.all}}},
      {"compute",
       {{"slots", pool.slots},
        {"running", pool.running},
        {"queued", pool.queued},
        {"finished", pool.finished},
        {"rejected", pool.rejected},
        {"given_up", pool.given_up},
        {"unanswering", pool.unanswering},
        {"unanswered", pool.unanswered},
        {"memory_bytes", memory.bytes}}},
      {"jobs",
       {{"queued", jobs.queued},
        {"running", jobs.running},
        {"ended", jobs.ended},
        {"bytes", jobs.bytes}}},
      {"replies",
       {{"bytes", replies.bytes}, {"budget", replies.budget}, {"refused", replies.refused}}},
      {"caches",
       {{"meshes", cache_json(catalog_.mesh_cache())},
        {"adjacency", cache_json(catalog_.adjacency_cache())},
        {"fields", cache_json(queries_.field_cache())},
        {"replies", cache_json(replies_.stats())}}}};
  HttpResponse response = json_reply(status.dump());
  response.set_header("Cache-Control", "no-store");
  return response;
}

}  // namespace geodesic::server
