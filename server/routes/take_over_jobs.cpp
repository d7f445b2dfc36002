// Jobs that outlive the server that took them: their questions and replies are kept in the store,
// where another server finds them.
#include <spdlog/spdlog.h>

#include <chrono>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "server/base/service_codes.h"
#include "server/compute/jobs.h"
#include "server/routes/call.h"
#include "server/routes/job_id.h"
#include "server/routes/routes.h"
#include "server/store/job_records.h"

namespace geodesic::server {
namespace {

JobRecord job_record_of(const JobReport& job) {
  JobRecord record;
  record.id = job.id;
  record.attempt = job.attempt;
  record.has_lease = job.lease.has_value();
  record.created = job.created;
  record.method = job.method;
  record.target = job.target;
  return record;
}

JobReport job_report_of(const JobRecord& record) {
  JobReport report;
  report.id = record.id;
  report.attempt = record.attempt;
  report.is_kept = true;
  report.method = record.method;
  report.target = record.target;
  report.created = record.created;
  report.started = record.end->started;
  report.finished = record.end->finished;
  return report;
}

tl::unexpected<Error> fail_handed_over_job() {
  return fail(ServiceCode::draining,
              "the server is about to stop; another one goes on with the job");
}

// Whether `keep()` kept it. What cannot be kept runs all the same, and goes with this process.
template <class Keep>
bool is_kept(const JobReport& job, const Keep& keep) {
  std::string why;
  try {
    const Result<bool> kept = keep();
    if (kept) return *kept;
    why = kept.error().detail;
  } catch (const std::exception& error) {  // of memory, or a library's
    why = error.what();
  }
  spdlog::warn("a job is not kept in the store: {}: {}", job.id, why);
  return false;
}

}  // namespace

void Routes::keep_jobs_in(JobRecords& records) {
  job_records_ = &records;
  Jobs::Keeper keeper;
  keeper.taken = [this](const JobReport& job, const HttpRequest& request) {
    // Nobody waits for a store of which it is known that it does not answer.
    if (!catalog_.store_health()) return false;
    return is_kept(job, [&] { return job_records_->keep(job_record_of(job), request); });
  };
  keeper.ended = [this](const JobReport& job, const HttpResponse& reply) {
    if (!catalog_.store_health()) return;
    (void)is_kept(job, [&] {
      JobRecord record = job_record_of(job);
      record.end = {job.started, job.finished.value_or(job.created), reply};
      return job_records_->keep(record);
    });
  };
  keeper.dropped = [this](const std::string& id) { job_records_->drop(id); };
  jobs_.set_keeper(std::move(keeper));
}

Result<JobReport> Routes::here(const std::string& id) {
  const auto job = jobs_.find(id);
  if (!job) return fail_unknown_job();
  if (job->is_handed_over) return fail_handed_over_job();
  return *job;
}

Result<JobReport> Routes::look_up_job(const Call& call, const std::string& id) {
  auto known = here(id);
  if (known || known.error().code != ServiceCode::job_unknown) return known;
  if (job_records_ == nullptr || !is_job_id(id)) return known;
  if (draining_) return fail(ServiceCode::draining, "the server is about to stop");
  // Nobody waits for a store of which it is known that it does not answer.
  if (auto store = catalog_.store_health(); !store) return fail(std::move(store.error()));
  const auto turn = record_readers_.take(Caller());
  if (!turn) return fail(turn.error());
  auto job = take_over_job(call, id);
  if (!job_records_->is_erased(id)) return job;
  jobs_.remove(id);  // somebody has asked for that meanwhile
  return fail_unknown_job();
}

Result<JobReport> Routes::take_over_job(const Call& call, const std::string& id) {
  auto record = job_records_->read(id);
  if (!record) return fail(std::move(record.error()));
  if (!*record) return fail_unknown_job();
  JobRecord& kept = (*record)->record;
  if (kept.end) {
    return jobs_.adopt(job_report_of(kept), std::move(kept.end->reply), call.request.caller.client);
  }
  HttpRequest again = std::move((*record)->request);
  again.id = call.request.id;
  again.remote = call.request.remote;
  again.caller.client = call.request.caller.client;
  again.caller.asked =
      std::make_shared<const Caller::Asked>(Caller::Asked{again.id, again.method, again.target});
  spdlog::info("{} job {} is begun again", again.id, id);
  auto job =
      jobs_.start(std::move(again), {.lease = kept.has_lease ? JobLease::renewed : JobLease::none,
                                     .id = id,
                                     .attempt = kept.attempt + 1,
                                     .created = kept.created});
  if (job && job->is_handed_over) return fail_handed_over_job();
  return job;
}

}  // namespace geodesic::server
