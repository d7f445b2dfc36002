// The routes of jobs: a request that its client would rather not wait for
// (`Prefer: respond-async`), and how it is getting on.
#include <spdlog/fmt/fmt.h>

#include <array>
#include <chrono>
#include <cmath>
#include <ctime>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "server/base/service_codes.h"
#include "server/base/stage_times.h"
#include "server/compute/jobs.h"
#include "server/http/finish_reply.h"
#include "server/http/head.h"
#include "server/http/prefer.h"
#include "server/http/request_log.h"
#include "server/reply/encode_reply.h"
#include "server/routes/call.h"
#include "server/routes/job_id.h"
#include "server/routes/routes.h"

namespace geodesic::server {
namespace {

using nlohmann::ordered_json;

// A stream says something at least so often, or nobody could tell that it lives.
constexpr std::chrono::seconds kHeartbeat{5};
// How often a stream's thread asks whether its client is still there.
constexpr std::chrono::seconds kAskEvery{1};
// The id of a stream's last event. A browser that connects again names it, and 204
// keeps it from trying for ever.
constexpr std::string_view kLastEvent = "end";

// A job runs at the server that took it. Balancers send what is about one mesh to one server,
// by the first digits of its id, and else go by those of X-Request-Id, which they give. A job's id
// begins with the same digits, so that who asks about it comes to the server that has it.
std::string routing_digits(std::string_view mesh, std::string_view request) {
  for (const std::string_view id : {mesh, request}) {
    const std::string_view digits = id.substr(0, kRoutingDigits);
    if (digits.size() == kRoutingDigits && is_hexadecimal(digits)) return std::string(digits);
  }
  return make_request_id().substr(0, kRoutingDigits);
}

// RFC 3339 in UTC.
std::string as_text(JobReport::Time time) {
  using namespace std::chrono;
  const std::time_t seconds = system_clock::to_time_t(floor<std::chrono::seconds>(time));
  std::tm utc{};
  ::gmtime_r(&seconds, &utc);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}.{:03}Z", utc.tm_year + 1900,
                     utc.tm_mon + 1, utc.tm_mday, utc.tm_hour, utc.tm_min, utc.tm_sec,
                     floor<milliseconds>(time).time_since_epoch().count() % 1000);
}

ordered_json seconds_of(std::chrono::milliseconds time) {
  return std::chrono::duration_cast<std::chrono::seconds>(time).count();
}

std::string job_json(const JobReport& job, const std::string& base_path) {
  const auto moment = [](const std::optional<JobReport::Time>& time) {
    return time ? ordered_json(as_text(*time)) : ordered_json();
  };
  const std::string self = base_path + "/v1/jobs/" + job.id;
  const bool has_result = job.state == JobState::done || job.state == JobState::failed;
  const ordered_json json{{"id", job.id},
                          // For whoever begins it anew it has not ended.
                          {"state", name_of(job.is_handed_over ? JobState::queued : job.state)},
                          {"attempt", job.attempt},
                          {"kept", job.is_kept},
                          {"progress", std::round(job.progress * 1e4) / 1e4},
                          {"method", job.method},
                          {"target", job.target},
                          {"created", as_text(job.created)},
                          {"started", moment(job.started)},
                          {"finished", moment(job.finished)},
                          {"status", has_result ? ordered_json(job.status) : ordered_json()},
                          {"lease_seconds", job.lease ? seconds_of(*job.lease) : ordered_json()},
                          {"result", has_result ? ordered_json(self + "/result") : ordered_json()},
                          {"events", self + "/events"}};
  return json.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

HttpResponse job_reply(const JobReport& job, const HttpRequest& request, int status = 200) {
  HttpResponse response = json_reply(job_json(job, request.base_path), status);
  response.set_header("Cache-Control", "no-store");
  return response;
}

// What an event says of the job. Any server can compare it with what it would say.
std::string event_id(const JobReport& job) {
  if (has_ended(job.state)) return std::string(kLastEvent);
  return fmt::format("{}-{}-{}", job.attempt, name_of(job.state), std::lround(job.progress * 1e4));
}

// One event of a stream; the last one is named after the job's end.
std::string event_of(const JobReport& job, const std::string& base_path) {
  return fmt::format("event: {}\nid: {}\ndata: {}\n\n",
                     has_ended(job.state) ? name_of(job.state) : "progress", event_id(job),
                     job_json(job, base_path));
}

// A stream of events under way.
class JobEvents {
 public:
  JobEvents(Jobs& jobs, Jobs::Handle job, const HttpRequest& request)
      : jobs_(jobs), job_(std::move(job)), caller_(request.caller), base_path_(request.base_path) {
    // Who connects again is not told twice.
    const std::string* const last = request.header("Last-Event-ID");
    JobReport report = jobs_.report(job_);
    if (last != nullptr && *last == event_id(report)) told_ = std::move(report);
  }

  // The next event, or a sign of life; false at the end.
  bool next(std::string& chunk) {
    if (told_ && has_ended(told_->state)) return false;
    for (auto waited = std::chrono::seconds(0); waited < kHeartbeat; waited += kAskEvery) {
      JobReport report = told_ ? jobs_.wait_for_news(job_, *told_, kAskEvery) : jobs_.report(job_);
      if (caller_()) return false;
      if (report.is_handed_over) return false;  // another server will tell the end
      if (told_ && report == *told_) continue;
      chunk = event_of(report, base_path_);
      told_ = std::move(report);
      return true;
    }
    chunk = ": still there\n\n";
    return true;
  }

 private:
  Jobs& jobs_;
  const Jobs::Handle job_;
  const Caller caller_;
  const std::string base_path_;
  std::optional<JobReport> told_;
};

}  // namespace

// What may take long: uploads, preparing, and queries.
bool Routes::may_be_job(const Call& call) {
  if (!prefers(call.request, "respond-async") || call.request.method == "HEAD") return false;
  const auto& s = call.segments;
  if (s.size() == 2) return call.is("POST");
  if (s.size() == 3) return call.is("PUT");
  if (s.size() != 4) return false;
  if (is_query(s[3])) return call.is("GET") || call.is("POST");
  return call.is("POST") && (s[3] == "prepare" || s[3] == "batch");
}

HttpResponse Routes::begin_job(Call& call) {
  call.route = "/v1/meshes";
  if (call.segments.size() > 2) call.route += "/{id}";
  if (call.segments.size() > 3) call.route += "/" + std::string(call.segments[3]);
  std::string body = std::move(call.request.body);  // not copied
  HttpRequest later = call.request;
  later.body = std::move(body);
  // Whoever fetches the result has not got it, whatever they had before; and it is they who say
  // whether it may be packed.
  std::erase_if(later.headers, [](const NameValue& header) {
    return equals_ignoring_case(header.first, "Prefer") ||
           equals_ignoring_case(header.first, "If-None-Match") ||
           equals_ignoring_case(header.first, "Accept-Encoding");
  });
  const bool goes_on = prefers(call.request, "keep");
  const std::string digits = routing_digits(
      call.segments.size() > 2 ? call.segments[2] : std::string_view(), call.request.id);
  const JobLease lease = goes_on ? JobLease::none : JobLease::renewed;
  const auto job = jobs_.start(std::move(later), {.lease = lease, .id_begins = digits});
  if (!job) return call.problem(job.error());
  HttpResponse response = job_reply(*job, call.request, 202);
  response.set_header("Location", call.request.base_path + "/v1/jobs/" + job->id);
  response.set_header("Preference-Applied", goes_on ? "respond-async, keep" : "respond-async");
  return response;
}

// What the request's own connection would have been answered; but it is for those who know the
// job, and for as long as the job is kept.
HttpResponse Routes::answer_job(HttpRequest& request) {
  request.caller.times = std::make_shared<StageTimes>();
  HttpResponse response = dispatched(request);
  finish_reply(request, response);
  add_timing(*request.caller.times, response);
  response.set_header("Cache-Control", "no-store");
  response.reserved = nullptr;  // the jobs have a budget of their own
  return response;
}

HttpResponse Routes::one_job(Call& call) {
  const auto& s = call.segments;
  const std::string_view part = s.size() == 4 ? s[3] : "";
  if (s.size() < 3 || s.size() > 4 || (s.size() == 4 && part != "result" && part != "events")) {
    return call.problem(ServiceCode::route_unknown, "there is nothing here");
  }
  call.route = "/v1/jobs/{id}";
  if (s.size() == 4) call.route += "/" + std::string(part);
  const std::string id(s[2]);
  const auto none = call.check_no_parameters();
  if (s.size() == 4) {
    if (!call.is("GET")) return call.not_allowed("GET, HEAD");
    if (!none) return call.problem(none.error());
    return part == "result" ? job_result(call, id) : job_events(call, id);
  }
  if (!none && (call.is("DELETE") || call.is("GET"))) return call.problem(none.error());
  if (call.is("DELETE")) {
    if (!is_job_id(id)) return call.problem(ServiceCode::job_unknown, "this is no id of a job");
    // What cannot be erased now is tried again, until this process ends. Before it is forgotten
    // here: or whoever asks meanwhile would find it there.
    if (job_records_ != nullptr && (!catalog_.store_health() || !job_records_->erase(id))) {
      job_records_->drop(id);
    }
    // To cancel again, or what is forgotten, changes nothing.
    jobs_.remove(id);
    HttpResponse response;
    response.status = 204;
    return response;
  }
  if (!call.is("GET")) return call.not_allowed("GET, HEAD, DELETE");
  const auto job = look_up_job(call, id);
  if (!job) return call.problem(job.error());
  return job_reply(*job, call.request);
}

HttpResponse Routes::job_result(Call& call, const std::string& id) {
  if (auto known = look_up_job(call, id); !known) return call.problem(known.error());
  auto result = jobs_.result(id);
  if (!result) return call.problem(result.error());
  return packed(std::move(*result), call.request);
}

// Packed as its reader wishes; what is large, in a compute slot.
HttpResponse Routes::packed(HttpResponse response, const HttpRequest& reader) {
  constexpr std::size_t kLarge = std::size_t{1} << 20;
  if (!response.body || response.body->size() < kLarge) return response;
  const auto done = queries_.in_slot(
      [&](const Cancel& cancel) -> Result<void> {
        Poll poll(cancel);
        pack(reader, response, &poll);
        if (poll.stopped()) return fail_stopped(poll);
        return {};
      },
      reader.caller);
  return done ? std::move(response) : HttpResponse::problem(done.error(), reader);
}

HttpResponse Routes::job_events(Call& call, const std::string& id) {
  HttpResponse response;
  response.set_header("Cache-Control", "no-store");
  const std::string* const last = call.request.header("Last-Event-ID");
  const bool is_told = last != nullptr && *last == kLastEvent;
  // Who knows the end does not have the job begun again.
  if (auto known = is_told ? here(id) : look_up_job(call, id); !known) {
    return call.problem(known.error());
  }
  if (is_told) {
    response.status = 204;
    return response;
  }
  Jobs::Handle job = jobs_.hold(id);
  if (!job) return call.problem(fail_unknown_job().value());
  response.content_type = "text/event-stream";
  response.set_header("X-Accel-Buffering", "no");  // a proxy that gathers replies must not
  auto events = std::make_shared<JobEvents>(jobs_, std::move(job), call.request);
  response.stream = [events](std::string& chunk) { return events->next(chunk); };
  return response;
}

}  // namespace geodesic::server
