// The routes of the API: HTTP to request values, and answers to HTTP. The first
// and the last of a request's three steps; the one between is MeshCatalog's and
// FieldQueries'.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "proto/region/costs.h"
#include "proto/wire/parameters.h"
#include "proto/wire/reply_format.h"
#include "server/base/caller.h"
#include "server/base/current.h"
#include "server/base/lru_cache.h"
#include "server/base/turns.h"
#include "server/compute/jobs.h"
#include "server/compute/pool.h"
#include "server/config/config.h"
#include "server/http/cross_origin.h"
#include "server/http/message.h"
#include "server/http/reply_budget.h"
#include "server/metrics/metrics.h"
#include "server/query/field_queries.h"
#include "server/query/mesh_catalog.h"
#include "server/reply/bodies_in_use.h"
#include "server/routes/access.h"
#include "server/routes/static_files.h"
#include "server/store/job_records.h"

namespace geodesic::server {

class Routes {
 public:
  Routes(const Config& config, MeshCatalog& catalog, FieldQueries& queries, ComputePool& pool,
         Metrics& metrics);

  // Whether a request's body is worth receiving, by its head. Tells the request whose it is.
  [[nodiscard]] bool wants_body(HttpRequest& request) const;
  // Answers any request. May be called from any thread.
  [[nodiscard]] HttpResponse answer(HttpRequest& request);
  // Only probes, metrics and what is in the caches: for a listener of its own.
  [[nodiscard]] HttpResponse answer_admin(HttpRequest& request);

  // From now on /readyz says no, so that balancers look elsewhere.
  // Jobs end here at once.
  void start_draining() {
    draining_ = true;
    jobs_.hand_over();
  }
  // Returns when no job runs any more.
  void end_jobs() { jobs_.stop(); }

  // Who may do what; without tokens, everybody everything.
  [[nodiscard]] Access& access() { return access_; }
  [[nodiscard]] const Access& access() const { return access_; }

  // Keeps jobs there, so that they outlive this process. To be called before any request.
  void keep_jobs_in(JobRecords& records);
  // What is served at `/` instead of the plain page. To be called before any request.
  void set_viewer(StaticFiles viewer) { viewer_ = std::move(viewer); }
  // What is served below `/docs/`; without it, these paths lead to the API's page. Likewise.
  void set_docs(StaticFiles docs) { docs_ = std::move(docs); }

  // How the API's listener fares, for metrics and readiness. To be called before any request.
  struct Listener {
    std::uint64_t connections = 0;  // open now
    std::uint64_t accept_failures = 0;
    bool is_accepting = true;
  };
  void watch_listener(std::function<Listener()> look) { listener_ = std::move(look); }

  // Replaces the settings for requests to come.
  void set_config(const Config& config) {
    config_.set(config);
    replies_.set_budget(config.reply_cache_bytes);
    reply_budget_.set_budget(config.reply_memory_bytes);
  }

  // The most bytes that a body of this request may have.
  [[nodiscard]] std::uint64_t max_body(std::string_view method, std::string_view path) const;

  // A query on a mesh, wherever it was read from.
  struct Query {
    const std::string& mesh;
    std::string_view action;  // which one, such as "path"
    proto::Parameters& parameters;
    const std::string* accept;  // an Accept header; null: none
    const Caller& caller;
    const HttpRequest* reader;      // the GET it is, so that its reply has a tag; null: none
    const HttpRequest* packed_for;  // whose reply may be packed; null: nobody's
    bool json_only;
  };

 private:
  struct Call;  // a request with its path taken apart
  // Records of jobs that are read at once, each of which may have a large body.
  static constexpr std::size_t kRecordsAtOnce = 4;

  [[nodiscard]] HttpResponse route(HttpRequest& request);
  // What stands at a path for browsers; nothing: none of that.
  [[nodiscard]] std::optional<HttpResponse> page(const HttpRequest& request) const;
  // What the request is answered, before what all replies have in common.
  [[nodiscard]] HttpResponse dispatched(HttpRequest& request);
  [[nodiscard]] HttpResponse dispatch(Call& call);
  [[nodiscard]] HttpResponse one_mesh(Call& call);
  [[nodiscard]] HttpResponse operate(Call& call);
  [[nodiscard]] std::string metrics_text();
  [[nodiscard]] std::string cache_report() const;
  [[nodiscard]] HttpResponse add_mesh(Call& call);
  [[nodiscard]] static Result<void> check_own_digest(const Call& call,
                                                     const proto::ImportOptions& options);
  // A body of several parts becomes the one file that they are.
  [[nodiscard]] Result<std::string> join_parts(Call& call);
  [[nodiscard]] HttpResponse list_meshes(Call& call);
  [[nodiscard]] HttpResponse mesh_metadata(Call& call);
  [[nodiscard]] HttpResponse described(const Call& call, std::string json, int status = 200);
  [[nodiscard]] HttpResponse mesh_source(Call& call);
  [[nodiscard]] Result<HttpResponse> source_reply(const Call& call, std::uint64_t expected_bytes);
  [[nodiscard]] HttpResponse mesh_geometry(Call& call);
  [[nodiscard]] Result<HttpResponse> geometry_reply(const Call& call, proto::Format format,
                                                    const std::string& tag);
  [[nodiscard]] HttpResponse prepare_mesh(Call& call);
  [[nodiscard]] HttpResponse rename_mesh(Call& call);
  [[nodiscard]] HttpResponse delete_mesh(Call& call);
  [[nodiscard]] HttpResponse query(Call& call, std::string_view action);
  // Any query: parameters to a Request, its answer to the format asked for.
  template <class Request>
  [[nodiscard]] Result<HttpResponse> answer_query(const Query& query);
  [[nodiscard]] Result<HttpResponse> answer_any_query(const Query& query);
  // row_replies.cpp: a table whose rows are sent as they are done, once the first one is. It holds
  // `memory`, which grows. Errors besides: those of ReplyBudget::reserve, before anything is
  // computed.
  [[nodiscard]] Result<HttpResponse> stream_rows(Answered<proto::TableReply> answer,
                                                 const proto::TableRequest& request,
                                                 const proto::ReplyFormat& format,
                                                 std::shared_ptr<ReplyBudget::Share> memory);
  // Computes a sparse table into its reply. Errors: too_large, and those of ReplyBudget::reserve.
  [[nodiscard]] Result<void> collect_rows(Answered<proto::TableReply>& answer,
                                          ReplyBudget::Share& memory);
  // How large the file is that a mesh is of. Errors: mesh_unknown; `otherwise` where it is no glTF,
  // whose detail is the way out.
  struct GltfSize {
    std::uint64_t bytes = 0;
    std::uint64_t faces = 0;
  };
  [[nodiscard]] Result<GltfSize> size_of_gltf(const Query& query, const Error& otherwise,
                                              const Caller& caller);
  // Weights of faces that are in the file, if they are asked for; their memory comes to `memory`.
  // Errors: those of size_of_gltf, of MeshCatalog::face_numbers and of ReplyBudget::reserve.
  [[nodiscard]] Result<void> read_weights(const Query& query, proto::Costs& costs,
                                          ReplyBudget::Share& memory, const Caller& caller);
  // Errors: those of MeshCatalog::uploaded_gltf and of ReplyBudget::reserve.
  [[nodiscard]] Result<std::shared_ptr<const UploadedGltf>> upload_to_annotate(
      const Query& query, const std::vector<proto::VertexAttribute>& attributes,
      std::uint64_t file_bytes, ReplyBudget::Share& memory, const Caller& caller);
  [[nodiscard]] std::string query_cache_policy() const;
  // The memory for a body's JSON while it is taken apart; null where that is little.
  [[nodiscard]] Result<std::shared_ptr<ReplyBudget::Share>> memory_for_json(std::size_t bytes,
                                                                            const Caller& caller);
  [[nodiscard]] std::optional<HttpResponse> known_reply(const Query& query,
                                                        const std::string& identity,
                                                        const std::string& tag);
  void keep_reply(const Query& query, const std::string& identity, const HttpResponse& reply);
  [[nodiscard]] HttpResponse batch(Call& call);
  // `reserved`: becomes what the reply has reserved, to be held as long as the line.
  [[nodiscard]] std::string answer_line(const std::string& mesh, std::string_view text,
                                        const HttpRequest& request, const Caller& caller,
                                        std::shared_ptr<const void>& reserved);
  // Whether the client prefers not to wait for this one.
  [[nodiscard]] static bool may_be_job(const Call& call);
  [[nodiscard]] HttpResponse begin_job(Call& call);
  [[nodiscard]] HttpResponse answer_job(HttpRequest& request);
  [[nodiscard]] HttpResponse one_job(Call& call);
  // A job that is here. Errors: job_unknown, draining.
  [[nodiscard]] Result<JobReport> here(const std::string& id);
  // A job that is here or, if it is not, in the records: then it is taken over, or begun again
  // here. Errors: job_unknown; draining; those of the store, and of beginning a job.
  [[nodiscard]] Result<JobReport> look_up_job(const Call& call, const std::string& id);
  [[nodiscard]] Result<JobReport> take_over_job(const Call& call, const std::string& id);
  [[nodiscard]] HttpResponse job_result(Call& call, const std::string& id);
  [[nodiscard]] HttpResponse packed(HttpResponse response, const HttpRequest& reader);
  [[nodiscard]] HttpResponse job_events(Call& call, const std::string& id);
  [[nodiscard]] HttpResponse status();

  Current<Config> config_;
  Access access_;
  StaticFiles viewer_;
  StaticFiles docs_;
  const CrossOrigin cross_origin_;
  LruCache<HttpResponse> replies_;  // to GET, by mesh and question
  ReplyBudget reply_budget_;
  BodiesInUse geometries_;
  MeshCatalog& catalog_;
  FieldQueries& queries_;
  ComputePool& pool_;
  Metrics& metrics_;
  std::function<Listener()> listener_ = [] { return Listener{}; };
  std::atomic<bool> draining_{false};
  JobRecords* job_records_ = nullptr;
  Turns record_readers_{kRecordsAtOnce, std::chrono::milliseconds(500),
                        "too many jobs are looked for in the store"};
  Jobs jobs_;  // last: its threads use the others
};

}  // namespace geodesic::server
