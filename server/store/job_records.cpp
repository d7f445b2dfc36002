#include "server/store/job_records.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>
#include <vector>

#include "server/base/sha256.h"
#include "server/http/head.h"

namespace geodesic::server {
namespace {

using nlohmann::json;

// A record is this line, the digest of the rest as 64 digits, and CBOR (RFC 8949), whose strings
// may be any bytes. A larger body is an object of its own, with its digest in the record.
constexpr std::string_view kBegin = "geodesicd job 1\n";
constexpr std::size_t kDigits = 64;
constexpr std::size_t kInside = std::size_t{64} << 10;
constexpr std::chrono::hours kKeepQuestions{24};
// Of the processes that are gone.
constexpr std::chrono::hours kTidyEvery{1};

json pairs_of(const std::vector<NameValue>& values) {
  json list = json::array();
  for (const auto& [name, value] : values) list.push_back({name, value});
  return list;
}

std::vector<NameValue> values_of(const json& pairs) {
  std::vector<NameValue> values;
  for (const json& pair : pairs) {
    values.emplace_back(pair.at(0).get<std::string>(), pair.at(1).get<std::string>());
  }
  return values;
}

std::int64_t milliseconds_of(JobRecord::Time time) {
  return std::chrono::floor<std::chrono::milliseconds>(time).time_since_epoch().count();
}

JobRecord::Time time_of(const json& number) {
  return JobRecord::Time(std::chrono::milliseconds(number.get<std::int64_t>()));
}

// Not what says who asked, or is meant for the connection.
bool may_be_kept(const NameValue& header) {
  constexpr std::array<std::string_view, 6> kNot{
      "Authorization", "Cookie", "Connection", "Expect", "Content-Length", "Transfer-Encoding"};
  return std::none_of(kNot.begin(), kNot.end(), [&](std::string_view name) {
    return equals_ignoring_case(header.first, name);
  });
}

json begin_head(const JobRecord& record) {
  return {{"id", record.id},
          {"attempt", record.attempt},
          {"has_lease", record.has_lease},
          {"created", milliseconds_of(record.created)},
          {"method", record.method},
          {"target", record.target}};
}

json head_of(const JobRecord& record, const HttpRequest& request) {
  json head = begin_head(record);
  std::vector<NameValue> headers;
  std::copy_if(request.headers.begin(), request.headers.end(), std::back_inserter(headers),
               may_be_kept);
  head["path"] = request.path;
  head["base_path"] = request.base_path;
  head["authority"] = request.authority;
  head["query"] = pairs_of(request.query);
  head["headers"] = pairs_of(headers);
  return head;
}

json head_of(const JobRecord& record, const JobRecord::End& end) {
  json head = begin_head(record);
  head["finished"] = milliseconds_of(end.finished);
  if (end.started) head["started"] = milliseconds_of(*end.started);
  head["status"] = end.reply.status;
  head["type"] = end.reply.content_type;
  head["headers"] = pairs_of(end.reply.headers);
  return head;
}

JobQuestion question_in(const json& head) {
  JobQuestion question;
  JobRecord& record = question.record;
  record.id = head.at("id").get<std::string>();
  record.attempt = head.at("attempt").get<std::uint64_t>();
  record.has_lease = head.at("has_lease").get<bool>();
  record.created = time_of(head.at("created"));
  record.method = head.at("method").get<std::string>();
  record.target = head.at("target").get<std::string>();
  if (head.contains("finished")) {
    JobRecord::End& end = record.end.emplace();
    end.finished = time_of(head.at("finished"));
    if (head.contains("started")) end.started = time_of(head.at("started"));
    end.reply.status = head.at("status").get<int>();
    end.reply.content_type = head.at("type").get<std::string>();
    end.reply.headers = values_of(head.at("headers"));
    return question;
  }
  HttpRequest& request = question.request;
  request.method = record.method;
  request.target = record.target;
  request.path = head.at("path").get<std::string>();
  request.base_path = head.at("base_path").get<std::string>();
  request.authority = head.at("authority").get<std::string>();
  request.query = values_of(head.at("query"));
  request.headers = values_of(head.at("headers"));
  return question;
}

bool is_too_old(const JobRecord& record, std::chrono::seconds keep) {
  const auto now = std::chrono::system_clock::now();
  return record.end ? record.end->finished + keep < now : record.created + kKeepQuestions < now;
}

}  // namespace

Result<bool> JobRecords::keep(const JobRecord& record, const HttpRequest& request) {
  return write(record.id, head_of(record, request), request.body, ObjectKind::job_body,
               kKeepQuestions);
}

Result<bool> JobRecords::keep(const JobRecord& record) {
  const auto& body = record.end->reply.body;
  return write(record.id, head_of(record, *record.end), body ? *body : std::string_view(),
               ObjectKind::job_reply, limits_.keep);
}

Result<bool> JobRecords::write(const std::string& id, json head, std::string_view body,
                               ObjectKind kind, std::chrono::seconds life) {
  if (body.size() > limits_.bytes) return false;
  const bool is_inside = body.size() <= kInside;
  if (is_inside) {
    head["body"] = body;
  } else {
    head["body_digest"] = sha256_hex(body);
    head["body_bytes"] = body.size();
    if (auto done = storage_.write(kind, id, body); !done) return fail(std::move(done.error()));
  }
  std::string bytes;
  json::to_cbor(head, bytes);
  bytes.insert(0, std::string(kBegin) + sha256_hex(bytes));
  if (auto done = storage_.write(ObjectKind::job, id, bytes); !done) {
    return fail(std::move(done.error()));
  }
  note(id, bytes.size() + (is_inside ? 0 : body.size()), !is_inside, life);
  return true;
}

Result<std::optional<JobQuestion>> JobRecords::read(const std::string& id) {
  auto object = storage_.read(ObjectKind::job, id, 2 * kInside);
  if (!object) return fail(std::move(object.error()));
  if (!*object) return std::nullopt;
  const auto unusable = [&](const char* why) {
    spdlog::warn("what is kept of job {} cannot be used: {}", id, why);
    return std::nullopt;
  };
  const std::string_view bytes = (*object)->bytes;
  if (!bytes.starts_with(kBegin)) return unusable("it is of another version");
  const std::string_view rest = bytes.substr(std::min(bytes.size(), kBegin.size() + kDigits));
  if (sha256_hex(rest) != bytes.substr(kBegin.size(), kDigits)) return unusable("it is damaged");
  try {
    const json head = json::from_cbor(rest);
    JobQuestion found = question_in(head);
    auto& end = found.record.end;
    if (found.record.id != id) return unusable("it is another job's");
    if (is_too_old(found.record, limits_.keep)) return std::nullopt;
    std::string body;
    if (head.contains("body")) {
      body = head.at("body").get<std::string>();
    } else {
      auto kept = storage_.read(end ? ObjectKind::job_reply : ObjectKind::job_body, id,
                                head.at("body_bytes").get<std::uint64_t>());
      if (!kept) return fail(std::move(kept.error()));
      if (!*kept || sha256_hex((*kept)->bytes) != head.at("body_digest").get<std::string>()) {
        return unusable("its body is gone or damaged");
      }
      body = std::move((*kept)->bytes);
    }
    if (end) {
      end->reply.body = std::make_shared<const std::string>(std::move(body));
    } else {
      found.request.body = std::move(body);
    }
    return found;
  } catch (const json::exception& error) {
    return unusable(error.what());
  }
}

bool JobRecords::forget(const std::string& id) {
  const auto found = written_.find(id);
  if (found == written_.end()) return true;  // another process has written it
  const bool has_bodies = found->second.has_bodies;
  bytes_ -= found->second.bytes;
  written_.erase(found);
  return has_bodies;
}

Result<void> JobRecords::erase(const std::string& id) {
  bool has_bodies = true;
  {
    const std::lock_guard lock(mutex_);
    has_bodies = forget(id);
  }
  return storage_.erase_job(id, has_bodies);
}

void JobRecords::note(const std::string& id, std::uint64_t bytes, bool has_body,
                      std::chrono::seconds life) {
  const std::lock_guard lock(mutex_);
  Written& written = written_[id];
  written.bytes += bytes;  // the body of its question stays until all is erased
  written.has_bodies |= has_body;
  written.too_old = Clock::now() + life;
  bytes_ += bytes;
}

void JobRecords::tidy() {
  std::vector<std::pair<std::string, bool>> old;
  bool others = false;
  {
    const std::lock_guard lock(mutex_);
    const Clock::time_point now = Clock::now();
    others = !tidied_ || now >= *tidied_ + kTidyEvery;
    if (others) tidied_ = now;
    std::vector<std::pair<Clock::time_point, std::string>> by_age;
    for (const auto& [id, written] : written_) by_age.emplace_back(written.too_old, id);
    std::sort(by_age.begin(), by_age.end());
    for (const auto& [too_old, id] : by_age) {
      if (too_old > now && bytes_ <= limits_.bytes) break;
      old.emplace_back(id, forget(id));
    }
  }
  // What cannot be erased now, somebody erases a day later.
  for (const auto& [id, has_bodies] : old) (void)storage_.erase_job(id, has_bodies);
  if (others) (void)storage_.erase_old_jobs(limits_.keep + kKeepQuestions);
}

}  // namespace geodesic::server
