#include "server/metrics/metrics.h"

#include <prometheus/text_serializer.h>

#include <algorithm>
#include <ctime>

#include "server/base/process_usage.h"
#include "server/metrics/metric_families.h"

namespace geodesic::server {
namespace {

std::string_view known_method(std::string_view method) {
  for (const std::string_view known :
       {"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"}) {
    if (method == known) return method;
  }
  return "other";
}

// A counter that follows a count kept elsewhere.
void follow(prometheus::Counter& counter, std::uint64_t now) {
  const double behind = static_cast<double>(now) - counter.Value();
  if (behind > 0) counter.Increment(behind);
}

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
  families_->gauges("geodesicd_build_info", "Always 1; the version is a label")
      .Add({{"version", std::string(version)}})
      .Set(1);
  double now = 0;
  timespec time{};
  if (clock_gettime(CLOCK_REALTIME, &time) == 0) now = static_cast<double>(time.tv_sec);
  families_->gauge("process_start_time_seconds", "When the process started, in seconds since 1970")
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
  families_->solve_seconds.Add({{"method", std::string(method)}}, Families::kSeconds)
      .Observe(seconds);
}

void Metrics::queued(double seconds) { families_->queue_seconds.Observe(seconds); }

void Metrics::mesh_step(std::string_view step, double seconds) {
  families_->mesh_seconds.Add({{"step", std::string(step)}}, Families::kSeconds).Observe(seconds);
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
  follow(f.prepared_found, present.prepared.found);
  follow(f.prepared_missing, present.prepared.missing);
  follow(f.prepared_damaged, present.prepared.damaged);
  follow(f.prepared_written, present.prepared.written);
  follow(f.prepared_not_written, present.prepared.not_written);
  follow(f.prepared_fetched, present.prepared.fetched);
  follow(f.prepared_uploaded, present.prepared.uploaded);
  follow(f.prepared_bucket_damaged, present.prepared.bucket_damaged);
  follow(f.prepared_bucket_failed, present.prepared.bucket_failed);
  f.prepared_bytes.Set(static_cast<double>(present.prepared.bytes));
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
