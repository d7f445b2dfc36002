#include "server/query/metrics.h"

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>

#include <array>
#include <functional>
#include <map>
#include <mutex>
#include <tuple>
#include <utility>

#include "server/base/process_usage.h"

namespace geodesic::server {
namespace {

using prometheus::BuildCounter;
using prometheus::BuildGauge;
using prometheus::BuildHistogram;
using prometheus::Counter;
using prometheus::Family;
using prometheus::Gauge;
using prometheus::Histogram;

// From a cached path (tenths of a millisecond) to an exact field of a million
// vertices (tens of seconds), two buckets and a half to a factor of ten.
const Histogram::BucketBoundaries kSeconds{0.0001, 0.00025, 0.0005, 0.001, 0.0025, 0.005,
                                           0.01,   0.025,   0.05,   0.1,   0.25,   0.5,
                                           1,      2.5,     5,      10,    30,     60};

std::string_view known_method(std::string_view method) {
  for (const std::string_view known : {"GET", "HEAD", "POST", "PUT", "DELETE", "OPTIONS"}) {
    if (method == known) return method;
  }
  return "other";
}

// A counter that follows a count kept elsewhere.
void follow(Counter& counter, std::uint64_t now) {
  const double behind = static_cast<double>(now) - counter.Value();
  if (behind > 0) counter.Increment(behind);
}

}  // namespace

struct Metrics::Families {
  struct PerRoute {
    Counter& requests;
    Histogram& seconds;
  };
  struct Cache {
    Gauge &bytes, &budget, &entries;
    Counter &hits, &misses, &evictions, &waits, &makes;
  };

  prometheus::Registry registry;

  Family<Histogram>& request_seconds =
      BuildHistogram()
          .Name("geodesicd_request_duration_seconds")
          .Help("From the head of a request to the last byte of its reply")
          .Register(registry);
  Family<Counter>& requests = BuildCounter()
                                  .Name("geodesicd_requests_total")
                                  .Help("Requests answered, by route, HTTP method and status")
                                  .Register(registry);
  Counter& received = BuildCounter()
                          .Name("geodesicd_received_bytes_total")
                          .Help("Bytes of request bodies")
                          .Register(registry)
                          .Add({});
  Counter& sent = BuildCounter()
                      .Name("geodesicd_sent_bytes_total")
                      .Help("Bytes of reply bodies")
                      .Register(registry)
                      .Add({});
  Family<Histogram>& solve_seconds = BuildHistogram()
                                         .Name("geodesicd_solve_duration_seconds")
                                         .Help("Computing one distance field, by geodesic method")
                                         .Register(registry);
  Histogram& queue_seconds = BuildHistogram()
                                 .Name("geodesicd_queue_duration_seconds")
                                 .Help("Waiting for a compute slot")
                                 .Register(registry)
                                 .Add({}, kSeconds);
  Family<Histogram>& mesh_seconds = BuildHistogram()
                                        .Name("geodesicd_mesh_duration_seconds")
                                        .Help("Making a mesh usable, by step")
                                        .Register(registry);
  Family<Gauge>& computations = BuildGauge()
                                    .Name("geodesicd_compute_jobs")
                                    .Help("Computations that run or wait for a compute slot")
                                    .Register(registry);
  Gauge& running = computations.Add({{"state", "running"}});
  Gauge& helping = computations.Add({{"state", "helping"}});  // gives way to whoever waits
  Gauge& waiting = computations.Add({{"state", "queued"}});
  Gauge& slots = BuildGauge()
                     .Name("geodesicd_compute_slots")
                     .Help("Computations that can run at once")
                     .Register(registry)
                     .Add({});
  Family<Counter>& ended = BuildCounter()
                               .Name("geodesicd_compute_jobs_total")
                               .Help("Computations that ended, by how")
                               .Register(registry);
  Counter& finished = ended.Add({{"outcome", "finished"}});
  Counter& rejected = ended.Add({{"outcome", "rejected"}});
  Counter& given_up = ended.Add({{"outcome", "given_up"}});
  Gauge& unanswering = BuildGauge()
                           .Name("geodesicd_compute_unanswering")
                           .Help("Computations that still run a second after they were cancelled")
                           .Register(registry)
                           .Add({});
  Counter& unanswered = BuildCounter()
                            .Name("geodesicd_compute_unanswered_total")
                            .Help("Computations that ran on for a second after being cancelled")
                            .Register(registry)
                            .Add({});
  Family<Gauge>& jobs = BuildGauge()
                            .Name("geodesicd_jobs")
                            .Help("Jobs (Prefer: respond-async), by state; ended: still kept")
                            .Register(registry);
  Gauge& compute_bytes = BuildGauge()
                             .Name("geodesicd_compute_memory_bytes")
                             .Help("Bytes that computations hold")
                             .Register(registry)
                             .Add({});
  Gauge& compute_budget = BuildGauge()
                              .Name("geodesicd_compute_memory_budget_bytes")
                              .Help("Bytes that computations may hold together; 0: any")
                              .Register(registry)
                              .Add({});
  Family<Counter>& memory_refusals =
      BuildCounter()
          .Name("geodesicd_compute_memory_refusals_total")
          .Help("Computations ended for want of memory: more than one may have, or beside others")
          .Register(registry);
  Counter& too_much_memory = memory_refusals.Add({{"reason", "too_much"}});
  Counter& crowded_out = memory_refusals.Add({{"reason", "crowded_out"}});
  Gauge& jobs_queued = jobs.Add({{"state", "queued"}});
  Gauge& jobs_running = jobs.Add({{"state", "running"}});
  Gauge& jobs_ended = jobs.Add({{"state", "ended"}});
  Gauge& job_bytes = BuildGauge()
                         .Name("geodesicd_job_bytes")
                         .Help("Bytes of jobs' requests that wait and replies that are kept")
                         .Register(registry)
                         .Add({});
  Family<Counter>& jobs_total = BuildCounter()
                                    .Name("geodesicd_jobs_total")
                                    .Help("Jobs that ended or were not taken, by how")
                                    .Register(registry);
  Counter& jobs_done = jobs_total.Add({{"outcome", "done"}});
  Counter& jobs_failed = jobs_total.Add({{"outcome", "failed"}});
  Counter& jobs_cancelled = jobs_total.Add({{"outcome", "cancelled"}});
  Counter& jobs_refused = jobs_total.Add({{"outcome", "refused"}});
  Gauge& reply_bytes = BuildGauge()
                           .Name("geodesicd_reply_memory_bytes")
                           .Help("Bytes reserved for large replies that are being made or sent")
                           .Register(registry)
                           .Add({});
  Gauge& reply_budget = BuildGauge()
                            .Name("geodesicd_reply_memory_budget_bytes")
                            .Help("Bytes that large replies may take together")
                            .Register(registry)
                            .Add({});
  Counter& replies_refused = BuildCounter()
                                 .Name("geodesicd_replies_refused_total")
                                 .Help("Replies that were not made for want of memory")
                                 .Register(registry)
                                 .Add({});
  Gauge& decoders = BuildGauge()
                        .Name("geodesicd_decoders")
                        .Help("Processes that decode a file")
                        .Register(registry)
                        .Add({});
  Family<Counter>& decodes = BuildCounter()
                                 .Name("geodesicd_decodes_total")
                                 .Help(
                                     "Files decoded in processes of their own, by how that "
                                     "ended; refused: the file has a fault")
                                 .Register(registry);
  Counter& decoded = decodes.Add({{"outcome", "decoded"}});
  Counter& decode_refused = decodes.Add({{"outcome", "refused"}});
  Counter& decode_crashed = decodes.Add({{"outcome", "crashed"}});
  Counter& decode_overtime = decodes.Add({{"outcome", "overtime"}});
  Counter& decode_cancelled = decodes.Add({{"outcome", "cancelled"}});
  Family<Gauge>& cache_bytes =
      BuildGauge().Name("geodesicd_cache_bytes").Help("Bytes held by a cache").Register(registry);
  Family<Gauge>& cache_budget = BuildGauge()
                                    .Name("geodesicd_cache_budget_bytes")
                                    .Help("Bytes a cache may hold")
                                    .Register(registry);
  Family<Gauge>& cache_entries = BuildGauge()
                                     .Name("geodesicd_cache_entries")
                                     .Help("Values held by a cache")
                                     .Register(registry);
  Family<Counter>& cache_lookups = BuildCounter()
                                       .Name("geodesicd_cache_lookups_total")
                                       .Help("Lookups in a cache, by result")
                                       .Register(registry);
  Family<Counter>& cache_evictions = BuildCounter()
                                         .Name("geodesicd_cache_evictions_total")
                                         .Help("Values a cache dropped for want of room")
                                         .Register(registry);
  Family<Counter>& cache_waits = BuildCounter()
                                     .Name("geodesicd_cache_flight_waits_total")
                                     .Help("Callers that waited for a value another was making")
                                     .Register(registry);
  Family<Counter>& cache_makes = BuildCounter()
                                     .Name("geodesicd_cache_makes_total")
                                     .Help("Values made for a cache")
                                     .Register(registry);
  Cache meshes = cache("meshes");
  Cache adjacency = cache("adjacency");
  Cache fields = cache("fields");
  Cache replies = cache("replies");
  Gauge& stored_meshes = BuildGauge()
                             .Name("geodesicd_store_meshes")
                             .Help("Meshes in the store")
                             .Register(registry)
                             .Add({});
  Gauge& stored_bytes = BuildGauge()
                            .Name("geodesicd_store_bytes")
                            .Help("Bytes of uploaded files in the store")
                            .Register(registry)
                            .Add({});
  Gauge& store_budget = BuildGauge()
                            .Name("geodesicd_store_budget_bytes")
                            .Help("Bytes the store may hold; 0: no limit")
                            .Register(registry)
                            .Add({});
  Family<Counter>& store_events = BuildCounter()
                                      .Name("geodesicd_store_events_total")
                                      .Help(
                                          "What befell the store: meshes evicted, uploads "
                                          "refused for want of room, meshes found damaged, "
                                          "operations that failed")
                                      .Register(registry);
  Counter& store_evictions = store_events.Add({{"event", "eviction"}});
  Counter& store_refusals = store_events.Add({{"event", "refusal"}});
  Counter& store_corrupt = store_events.Add({{"event", "corrupt"}});
  Counter& store_failures = store_events.Add({{"event", "failure"}});
  Gauge& connections = BuildGauge()
                           .Name("geodesicd_connections")
                           .Help("Open connections of the API's listener")
                           .Register(registry)
                           .Add({});
  Counter& accept_failures = BuildCounter()
                                 .Name("geodesicd_accept_failures_total")
                                 .Help("Failed attempts to accept a connection")
                                 .Register(registry)
                                 .Add({});
  Gauge& ready = BuildGauge()
                     .Name("geodesicd_ready")
                     .Help("1 while new requests are welcome")
                     .Register(registry)
                     .Add({});
  Gauge& resident = BuildGauge()
                        .Name("process_resident_memory_bytes")
                        .Help("Resident memory of the process")
                        .Register(registry)
                        .Add({});
  Gauge& virtual_bytes = BuildGauge()
                             .Name("process_virtual_memory_bytes")
                             .Help("Address space of the process")
                             .Register(registry)
                             .Add({});
  Counter& cpu = BuildCounter()
                     .Name("process_cpu_seconds_total")
                     .Help("User and system time of the process")
                     .Register(registry)
                     .Add({});
  Gauge& open_fds = BuildGauge()
                        .Name("process_open_fds")
                        .Help("Open file descriptors")
                        .Register(registry)
                        .Add({});
  Gauge& max_fds = BuildGauge()
                       .Name("process_max_fds")
                       .Help("The most file descriptors that may be open")
                       .Register(registry)
                       .Add({});

  // The library's own search by labels is too slow for every request.
  const PerRoute& of(std::string_view method, std::string_view route, int status) {
    const std::lock_guard lock(routes_mutex);
    const auto found = routes.find(std::tuple(method, route, status));
    if (found != routes.end()) return found->second;
    std::string by(method);
    std::string where(route);
    const PerRoute made{
        requests.Add({{"method", by}, {"route", where}, {"status", std::to_string(status)}}),
        request_seconds.Add({{"method", by}, {"route", where}}, kSeconds)};
    return routes.emplace(std::tuple(std::move(by), std::move(where), status), made).first->second;
  }
  std::mutex routes_mutex;
  // As std::less<>, which Clang 14 does not find for tuples of different types.
  struct Before {
    using is_transparent = void;
    static std::tuple<std::string_view, std::string_view, int> view(const auto& key) { return key; }
    bool operator()(const auto& a, const auto& b) const { return view(a) < view(b); }
  };
  std::map<std::tuple<std::string, std::string, int>, PerRoute, Before> routes;

  Cache cache(const char* name) {
    const prometheus::Labels labels{{"cache", name}};
    return {cache_bytes.Add(labels),
            cache_budget.Add(labels),
            cache_entries.Add(labels),
            cache_lookups.Add({{"cache", name}, {"result", "hit"}}),
            cache_lookups.Add({{"cache", name}, {"result", "miss"}}),
            cache_evictions.Add(labels),
            cache_waits.Add(labels),
            cache_makes.Add(labels)};
  }
};

namespace {

template <class Cache>
void read_cache(Cache& cache, const CacheStats& stats) {
  cache.bytes.Set(static_cast<double>(stats.bytes));
  cache.budget.Set(static_cast<double>(stats.budget));
  cache.entries.Set(static_cast<double>(stats.entries));
  follow(cache.hits, stats.hits);
  follow(cache.misses, stats.misses);
  follow(cache.evictions, stats.evictions);
  follow(cache.waits, stats.waits);
  follow(cache.makes, stats.makes);
}

}  // namespace

Metrics::Metrics(std::string_view version) : families_(std::make_unique<Families>()) {
  BuildGauge()
      .Name("geodesicd_build_info")
      .Help("Always 1; the version is a label")
      .Register(families_->registry)
      .Add({{"version", std::string(version)}})
      .Set(1);
  double now = 0;
  timespec time{};
  if (clock_gettime(CLOCK_REALTIME, &time) == 0) now = static_cast<double>(time.tv_sec);
  BuildGauge()
      .Name("process_start_time_seconds")
      .Help("When the process started, in seconds since 1970")
      .Register(families_->registry)
      .Add({})
      .Set(now);
}

Metrics::~Metrics() = default;

void Metrics::request(std::string_view method, std::string_view route, int status, double seconds,
                      std::uint64_t bytes_in, std::uint64_t bytes_out) {
  const std::string_view by = known_method(method);
  const std::string_view where = route.empty() ? "none" : route;
  const Families::PerRoute& of = families_->of(by, where, status);
  of.requests.Increment();
  of.seconds.Observe(seconds);
  families_->received.Increment(static_cast<double>(bytes_in));
  families_->sent.Increment(static_cast<double>(bytes_out));
}

void Metrics::solved(std::string_view method, double seconds) {
  families_->solve_seconds.Add({{"method", std::string(method)}}, kSeconds).Observe(seconds);
}

void Metrics::queued(double seconds) { families_->queue_seconds.Observe(seconds); }

void Metrics::mesh_step(std::string_view step, double seconds) {
  families_->mesh_seconds.Add({{"step", std::string(step)}}, kSeconds).Observe(seconds);
}

std::string Metrics::text(const Present& present) {
  Families& f = *families_;
  f.running.Set(static_cast<double>(present.pool.running - present.pool.helping));
  f.helping.Set(static_cast<double>(present.pool.helping));
  f.waiting.Set(static_cast<double>(present.pool.queued));
  f.slots.Set(static_cast<double>(present.pool.slots));
  follow(f.finished, present.pool.finished);
  follow(f.rejected, present.pool.rejected);
  follow(f.given_up, present.pool.given_up);
  f.unanswering.Set(static_cast<double>(present.pool.unanswering));
  follow(f.unanswered, present.pool.unanswered);
  f.compute_bytes.Set(static_cast<double>(present.memory.bytes));
  f.compute_budget.Set(static_cast<double>(present.memory.limits.all));
  follow(f.too_much_memory, present.memory.refused);
  follow(f.crowded_out, present.memory.crowded_out);
  f.jobs_queued.Set(static_cast<double>(present.jobs.queued));
  f.jobs_running.Set(static_cast<double>(present.jobs.running));
  f.jobs_ended.Set(static_cast<double>(present.jobs.ended));
  f.job_bytes.Set(static_cast<double>(present.jobs.bytes));
  follow(f.jobs_done, present.jobs.done);
  follow(f.jobs_failed, present.jobs.failed);
  follow(f.jobs_cancelled, present.jobs.cancelled);
  follow(f.jobs_refused, present.jobs.refused);
  f.reply_bytes.Set(static_cast<double>(present.reply_memory.bytes));
  f.reply_budget.Set(static_cast<double>(present.reply_memory.budget));
  follow(f.replies_refused, present.reply_memory.refused);
  f.decoders.Set(static_cast<double>(present.decoders.running));
  follow(f.decoded, present.decoders.decoded);
  follow(f.decode_refused, present.decoders.refused);
  follow(f.decode_crashed, present.decoders.crashed);
  follow(f.decode_overtime, present.decoders.overtime);
  follow(f.decode_cancelled, present.decoders.cancelled);
  read_cache(f.meshes, present.meshes);
  read_cache(f.adjacency, present.adjacency);
  read_cache(f.fields, present.fields);
  read_cache(f.replies, present.replies);
  f.stored_meshes.Set(static_cast<double>(present.store.meshes));
  f.stored_bytes.Set(static_cast<double>(present.store.bytes));
  f.store_budget.Set(static_cast<double>(present.store.max_bytes));
  follow(f.store_evictions, present.store.evictions);
  follow(f.store_refusals, present.store.refusals);
  follow(f.store_corrupt, present.store.corrupt);
  follow(f.store_failures, present.store.failures);
  f.connections.Set(static_cast<double>(present.connections));
  follow(f.accept_failures, present.accept_failures);
  f.ready.Set(present.ready ? 1 : 0);
  const ProcessUsage process = process_usage();
  f.resident.Set(process.resident_bytes);
  f.virtual_bytes.Set(process.virtual_bytes);
  f.cpu.Increment(std::max(process.cpu_seconds - f.cpu.Value(), 0.0));
  f.open_fds.Set(process.open_fds);
  f.max_fds.Set(process.max_fds);
  return prometheus::TextSerializer().Serialize(f.registry.Collect());
}

}  // namespace geodesic::server
