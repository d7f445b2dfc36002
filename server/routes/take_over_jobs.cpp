// Jobs that outlive the server that took them: their questions and replies are kept in the store,
// where another server finds them.
#include <spdlog/spdlog.h>

#include <chrono>
#include <functional>
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

// How long one waits for the few that read records.
constexpr std::chrono::seconds kRecordPatience{2};

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
  report.method = record.method;
  report.target = record.target;
  report.created = record.created;
  report.started = record.end->started;
  report.finished = record.end->finished;
  return report;
}

// What cannot be kept runs all the same, and goes with this process.
void warn_if_not(const JobReport& job, const Result<bool>& kept) {
  if (!kept) spdlog::warn("a job is not kept in the store: {}: {}", job.id, kept.error().detail);
}

}  // namespace

void Routes::keep_jobs_in(JobRecords& records) {
  job_records_ = &records;
  Jobs::Keeper keeper;
  keeper.taken = [this](const JobReport& job, const HttpRequest& request) {
    // Nobody waits for a store of which it is known that it does not answer.
    if (!catalog_.store_health()) return false;
    const auto kept = job_records_->keep(job_record_of(job), request);
    warn_if_not(job, kept);
    return kept.value_or(false);
  };
  keeper.ended = [this](const JobReport& job, const HttpResponse& reply,
                        const std::function<bool()>& is_removed) {
    if (!catalog_.store_health()) return;
    JobRecord record = job_record_of(job);
    record.end = {job.started, job.finished.value_or(job.created), reply};
    warn_if_not(job, job_records_->keep(record));
    if (is_removed()) (void)job_records_->erase(job.id);
  };
  jobs_.set_keeper(std::move(keeper));
}

Result<JobReport> Routes::look_up_job(const Call& call, const std::string& id) {
  if (const auto job = jobs_.find(id)) {
    if (!job->is_handed_over) return *job;
    return fail(ServiceCode::draining,
                "the server is about to stop; another one goes on with the job");
  }
  if (job_records_ == nullptr || !is_job_id(id)) return fail_unknown_job();
  if (draining_) return fail(ServiceCode::draining, "the server is about to stop");
  if (!record_readers_.try_acquire_for(kRecordPatience)) {
    return fail(ServiceCode::overloaded, "too many jobs are looked for in the store");
  }
  const auto let_go = [this](void*) { record_readers_.release(); };
  const std::unique_ptr<void, decltype(let_go)> place(this, let_go);
  return take_over_job(call, id);
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
  return jobs_.start(std::move(again),
                     {.lease = kept.has_lease ? JobLease::renewed : JobLease::none,
                      .id = id,
                      .attempt = kept.attempt + 1,
                      .created = kept.created});
}

}  // namespace geodesic::server
