// Every metric that Prometheus is told: its name, what it says to operators, and its labels. A new
// one gets a line here, and metrics.cpp sets it.
#pragma once

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>

#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>

#include "server/metrics/metrics.h"

namespace geodesic::server {

// In the order in which they are told.
struct Metrics::Families {
  using Counter = prometheus::Counter;
  using Gauge = prometheus::Gauge;
  using Histogram = prometheus::Histogram;
  template <class Metric>
  using Family = prometheus::Family<Metric>;

  struct PerRoute {
    Counter& requests;
    Histogram& seconds;
  };
  struct Cache {
    Gauge &bytes, &budget, &entries;
    Counter &hits, &misses, &evictions, &waits, &makes;
  };

  // From a cached path (tenths of a millisecond) to an exact field of a million
  // vertices (tens of seconds), two buckets and a half to a factor of ten.
  static inline const Histogram::BucketBoundaries kSeconds{
      0.0001, 0.00025, 0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05,
      0.1,    0.25,    0.5,    1,     2.5,    5,     10,   30,    60};

  prometheus::Registry registry;

  // Families by their names, and those of one series, which has no labels.
  Family<Counter>& counters(const char* name, const char* help) {
    return prometheus::BuildCounter().Name(name).Help(help).Register(registry);
  }
  Family<Gauge>& gauges(const char* name, const char* help) {
    return prometheus::BuildGauge().Name(name).Help(help).Register(registry);
  }
  Family<Histogram>& histograms(const char* name, const char* help) {
    return prometheus::BuildHistogram().Name(name).Help(help).Register(registry);
  }
  Counter& counter(const char* name, const char* help) { return counters(name, help).Add({}); }
  Gauge& gauge(const char* name, const char* help) { return gauges(name, help).Add({}); }
  Histogram& histogram(const char* name, const char* help) {
    return histograms(name, help).Add({}, kSeconds);
  }

  Family<Histogram>& request_seconds =
      histograms("geodesicd_request_duration_seconds",
                 "From the head of a request to the last byte of its reply");
  Family<Counter>& requests =
      counters("geodesicd_requests_total", "Requests answered, by route, HTTP method and status");
  Counter& received = counter("geodesicd_received_bytes_total", "Bytes of request bodies");
  Counter& sent = counter("geodesicd_sent_bytes_total", "Bytes of reply bodies");
  Family<Histogram>& solve_seconds = histograms("geodesicd_solve_duration_seconds",
                                                "Computing one distance field, by geodesic method");
  Histogram& queue_seconds =
      histogram("geodesicd_queue_duration_seconds", "Waiting for a compute slot");
  Family<Histogram>& mesh_seconds =
      histograms("geodesicd_mesh_duration_seconds", "Making a mesh usable, by step");
  Family<Gauge>& computations =
      gauges("geodesicd_compute_jobs", "Computations that run or wait for a compute slot");
  Gauge& running = computations.Add({{"state", "running"}});
  Gauge& helping = computations.Add({{"state", "helping"}});  // gives way to whoever waits
  Gauge& waiting = computations.Add({{"state", "queued"}});
  Gauge& slots = gauge("geodesicd_compute_slots", "Computations that can run at once");
  Family<Counter>& ended =
      counters("geodesicd_compute_jobs_total", "Computations that ended, by how");
  Counter& finished = ended.Add({{"outcome", "finished"}});
  Counter& rejected = ended.Add({{"outcome", "rejected"}});
  Counter& given_up = ended.Add({{"outcome", "given_up"}});
  Gauge& unanswering = gauge("geodesicd_compute_unanswering",
                             "Computations that still run a second after they were cancelled");
  Counter& unanswered = counter("geodesicd_compute_unanswered_total",
                                "Computations that ran on for a second after being cancelled");
  Family<Gauge>& jobs =
      gauges("geodesicd_jobs", "Jobs (Prefer: respond-async), by state; ended: still kept");
  Gauge& compute_bytes = gauge("geodesicd_compute_memory_bytes", "Bytes that computations hold");
  Gauge& compute_budget = gauge("geodesicd_compute_memory_budget_bytes",
                                "Bytes that computations may hold together; 0: any");
  Family<Counter>& memory_refusals =
      counters("geodesicd_compute_memory_refusals_total",
               "Computations ended for want of memory: more than one may have, or beside others");
  Counter& too_much_memory = memory_refusals.Add({{"reason", "too_much"}});
  Counter& crowded_out = memory_refusals.Add({{"reason", "crowded_out"}});
  Gauge& jobs_queued = jobs.Add({{"state", "queued"}});
  Gauge& jobs_running = jobs.Add({{"state", "running"}});
  Gauge& jobs_ended = jobs.Add({{"state", "ended"}});
  Gauge& job_bytes =
      gauge("geodesicd_job_bytes", "Bytes of jobs' requests that wait and replies that are kept");
  Family<Counter>& jobs_total =
      counters("geodesicd_jobs_total", "Jobs that ended or were not taken, by how");
  Counter& jobs_done = jobs_total.Add({{"outcome", "done"}});
  Counter& jobs_failed = jobs_total.Add({{"outcome", "failed"}});
  Counter& jobs_cancelled = jobs_total.Add({{"outcome", "cancelled"}});
  Counter& jobs_refused = jobs_total.Add({{"outcome", "refused"}});
  Gauge& reply_bytes = gauge("geodesicd_reply_memory_bytes",
                             "Bytes reserved for large replies that are being made or sent");
  Gauge& reply_budget =
      gauge("geodesicd_reply_memory_budget_bytes", "Bytes that large replies may take together");
  Counter& replies_refused =
      counter("geodesicd_replies_refused_total", "Replies that were not made for want of memory");
  Gauge& decoders = gauge("geodesicd_decoders", "Processes that decode a file");
  Family<Counter>& decodes = counters(
      "geodesicd_decodes_total",
      "Files decoded in processes of their own, by how that ended; refused: the file has a fault");
  Counter& decoded = decodes.Add({{"outcome", "decoded"}});
  Counter& decode_refused = decodes.Add({{"outcome", "refused"}});
  Counter& decode_crashed = decodes.Add({{"outcome", "crashed"}});
  Counter& decode_overtime = decodes.Add({{"outcome", "overtime"}});
  Counter& decode_cancelled = decodes.Add({{"outcome", "cancelled"}});
  Family<Gauge>& cache_bytes = gauges("geodesicd_cache_bytes", "Bytes held by a cache");
  Family<Gauge>& cache_budget = gauges("geodesicd_cache_budget_bytes", "Bytes a cache may hold");
  Family<Gauge>& cache_entries = gauges("geodesicd_cache_entries", "Values held by a cache");
  Family<Counter>& cache_lookups =
      counters("geodesicd_cache_lookups_total", "Lookups in a cache, by result");
  Family<Counter>& cache_evictions =
      counters("geodesicd_cache_evictions_total", "Values a cache dropped for want of room");
  Family<Counter>& cache_waits = counters("geodesicd_cache_flight_waits_total",
                                          "Callers that waited for a value another was making");
  Family<Counter>& cache_makes = counters("geodesicd_cache_makes_total", "Values made for a cache");
  Cache meshes = cache("meshes");
  Cache adjacency = cache("adjacency");
  Cache fields = cache("fields");
  Cache replies = cache("replies");
  Gauge& stored_meshes = gauge("geodesicd_store_meshes",
                               "Meshes in the store; of a bucket, those that this server knows");
  Gauge& stored_bytes = gauge("geodesicd_store_bytes", "Bytes of these meshes' files");
  Gauge& store_budget =
      gauge("geodesicd_store_budget_bytes", "Bytes the store may hold; 0: no limit");
  Family<Counter>& store_events =
      counters("geodesicd_store_events_total",
               "What befell the store: meshes evicted, uploads refused for want of room, meshes "
               "found damaged, operations that failed");
  Counter& store_evictions = store_events.Add({{"event", "eviction"}});
  Counter& store_refusals = store_events.Add({{"event", "refusal"}});
  Counter& store_corrupt = store_events.Add({{"event", "corrupt"}});
  Counter& store_failures = store_events.Add({{"event", "failure"}});
  Family<Counter>& prepared_lookups = counters(
      "geodesicd_prepared_lookups_total", "Meshes looked for among the prepared ones, by result");
  Counter& prepared_found = prepared_lookups.Add({{"result", "hit"}});
  Counter& prepared_missing = prepared_lookups.Add({{"result", "miss"}});
  Counter& prepared_damaged = prepared_lookups.Add({{"result", "damaged"}});
  Family<Counter>& prepared_writes =
      counters("geodesicd_prepared_writes_total",
               "Prepared meshes that were to be kept, by outcome; failed: no room, or an error");
  Counter& prepared_written = prepared_writes.Add({{"outcome", "written"}});
  Counter& prepared_not_written = prepared_writes.Add({{"outcome", "failed"}});
  Family<Counter>& prepared_bucket =
      counters("geodesicd_prepared_bucket_total",
               "Prepared meshes read from and written to the bucket behind them, and what failed");
  Counter& prepared_fetched = prepared_bucket.Add({{"outcome", "read"}});
  Counter& prepared_uploaded = prepared_bucket.Add({{"outcome", "written"}});
  Counter& prepared_bucket_damaged = prepared_bucket.Add({{"outcome", "damaged"}});
  Counter& prepared_bucket_failed = prepared_bucket.Add({{"outcome", "failed"}});
  Gauge& prepared_bytes = gauge("geodesicd_prepared_bytes", "Bytes of prepared meshes' files");
  Gauge& connections = gauge("geodesicd_connections", "Open connections of the API's listener");
  Counter& accept_failures =
      counter("geodesicd_accept_failures_total", "Failed attempts to accept a connection");
  Gauge& ready = gauge("geodesicd_ready", "1 while new requests are welcome");
  Gauge& resident = gauge("process_resident_memory_bytes", "Resident memory of the process");
  Gauge& virtual_bytes = gauge("process_virtual_memory_bytes", "Address space of the process");
  Counter& cpu = counter("process_cpu_seconds_total", "User and system time of the process");
  Gauge& open_fds = gauge("process_open_fds", "Open file descriptors");
  Gauge& max_fds = gauge("process_max_fds", "The most file descriptors that may be open");

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

}  // namespace geodesic::server
