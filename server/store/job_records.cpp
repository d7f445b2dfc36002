#include "server/store/job_records.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <exception>
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

// A record is this line, the digest of the rest as 64 digits, and MessagePack, whose strings may be
// any bytes. A larger body is an object of its own, with its digest in the record. The digest is
// against damage. Who may write to the storage is not to harm the process all the same. In
// MessagePack only lists and maps are nested, and `FlatEnough` is told of each. Version 1 was CBOR,
// where strings are as well, and the library's reader calls itself for each of these unasked.
constexpr std::string_view kBegin = "geodesicd job 2\n";
constexpr std::size_t kDigits = 64;
constexpr std::size_t kInside = std::size_t{64} << 10;
constexpr std::chrono::hours kKeepQuestions{24};
// Of the processes that are gone.
constexpr std::chrono::hours kTidyEvery{1};
constexpr std::chrono::seconds kTidyFor{2};
constexpr std::size_t kMostDropped = 10'000;     // what is more is erased when it is too old
constexpr std::size_t kMostRemembered = 10'000;  // that are remembered
constexpr int kMostNesting = 4;                  // of what a record holds

// Ends the reading of what is nested more deeply.
class FlatEnough : public json::json_sax_t {
 public:
  bool null() override { return true; }
  bool boolean(bool /*value*/) override { return true; }
  bool number_integer(number_integer_t /*value*/) override { return true; }
  bool number_unsigned(number_unsigned_t /*value*/) override { return true; }
  bool number_float(number_float_t /*value*/, const string_t& /*text*/) override { return true; }
  bool string(string_t& /*value*/) override { return true; }
  bool binary(binary_t& /*value*/) override { return true; }
  bool start_object(std::size_t /*size*/) override { return ++depth_ <= kMostNesting; }
  bool key(string_t& /*value*/) override { return true; }
  bool end_object() override { return --depth_ >= 0; }
  bool start_array(std::size_t /*size*/) override { return ++depth_ <= kMostNesting; }
  bool end_array() override { return --depth_ >= 0; }
  bool parse_error(std::size_t /*at*/, const std::string& /*token*/,
                   const nlohmann::detail::exception& /*error*/) override {
    return false;
  }

 private:
  int depth_ = 0;
};

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
  constexpr std::int64_t kLatest = 9'000'000'000'000;  // in the year 2255; nanoseconds have no more
  return JobRecord::Time(
      std::chrono::milliseconds(std::clamp(number.get<std::int64_t>(), std::int64_t{0}, kLatest)));
}

// Not what says who asked, or is meant for the connection.
bool may_be_kept(const NameValue& header) {
  constexpr std::array<std::string_view, 3> kKept{"Accept", "Content-Type", "Content-Disposition"};
  return std::any_of(kKept.begin(), kKept.end(), [&](std::string_view name) {
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
  return write(record.id, head_of(record, request), request.body,
               {ObjectKind::job, ObjectKind::job_body}, kKeepQuestions);
}

Result<bool> JobRecords::keep(const JobRecord& record) {
  constexpr Kinds kEnd{ObjectKind::job_end, ObjectKind::job_reply};
  const HttpResponse& reply = record.end->reply;
  if (reply.status >= 400) {
    const auto other = storage_.read(kEnd.record, record.id, kMostJobBytes);
    if (other && *other) return true;
  }
  return write(record.id, head_of(record, *record.end),
               reply.body ? *reply.body : std::string_view(), kEnd, limits_.keep);
}

Result<bool> JobRecords::write(const std::string& id, json head, std::string_view body,
                               const Kinds& kinds, std::chrono::seconds life) {
  if (body.size() > limits_.bytes) return false;
  const bool is_inside = body.size() <= kInside;
  std::vector<ObjectKind> objects{kinds.record};
  if (is_inside) {
    head["body"] = body;
  } else {
    head["body_digest"] = sha256_hex(body);
    head["body_bytes"] = body.size();
    objects.push_back(kinds.body);
    if (auto done = storage_.write(kinds.body, id, body); !done) {
      return fail(std::move(done.error()));
    }
  }
  std::string bytes;
  json::to_msgpack(head, bytes);
  bytes.insert(0, std::string(kBegin) + sha256_hex(bytes));
  if (bytes.size() > kMostJobBytes) return false;
  if (auto done = storage_.write(kinds.record, id, bytes); !done) {
    return fail(std::move(done.error()));
  }
  note(id, bytes.size() + (is_inside ? 0 : body.size()), objects, life);
  return true;
}

Result<std::optional<JobQuestion>> JobRecords::read(const std::string& id) {
  if (is_erased(id)) return std::nullopt;
  auto end = read(id, {ObjectKind::job_end, ObjectKind::job_reply});
  if (!end || *end) return end;
  return read(id, {ObjectKind::job, ObjectKind::job_body});
}

Result<std::optional<JobQuestion>> JobRecords::read(const std::string& id, const Kinds& kinds) {
  auto object = storage_.read(kinds.record, id, kMostJobBytes);
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
    FlatEnough flat;
    if (!json::sax_parse(rest, &flat, json::input_format_t::msgpack)) {
      return unusable("it is no record");
    }
    const json head = json::from_msgpack(rest);
    JobQuestion found = question_in(head);
    auto& end = found.record.end;
    if (found.record.id != id || end.has_value() != (kinds.record == ObjectKind::job_end)) {
      return unusable("it is another one's");
    }
    if (is_too_old(found.record, limits_.keep)) return std::nullopt;
    std::string body;
    if (head.contains("body")) {
      body = head.at("body").get<std::string>();
    } else {
      const auto size = head.at("body_bytes").get<std::uint64_t>();
      if (size > limits_.bytes) return unusable("its body is larger than the budget");
      auto kept = storage_.read(kinds.body, id, size);
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

std::vector<ObjectKind> JobRecords::forget(const std::string& id) {
  const auto found = written_.find(id);
  if (found == written_.end()) return {kJobObjects.begin(), kJobObjects.end()};
  std::vector<ObjectKind> objects = std::move(found->second.objects);
  bytes_ -= found->second.bytes;
  written_.erase(found);
  return objects;
}

Result<void> JobRecords::erase(const std::string& id) {
  {
    const std::lock_guard lock(mutex_);
    note_erased(id);
    (void)forget(id);
  }
  return storage_.erase_job(id, kJobObjects);  // others may have written, too
}

void JobRecords::drop(const std::string& id) {
  const std::lock_guard lock(mutex_);
  note_erased(id);
  if (dropped_.size() < kMostDropped) dropped_.push_back(id);
}

bool JobRecords::is_erased(const std::string& id) {
  const std::lock_guard lock(mutex_);
  return is_erased_.contains(id);
}

void JobRecords::note_erased(const std::string& id) {
  if (!is_erased_.insert(id).second) return;
  erased_.push_back(id);
  if (erased_.size() <= kMostRemembered) return;
  is_erased_.erase(erased_.front());
  erased_.pop_front();
}

void JobRecords::note(const std::string& id, std::uint64_t bytes,
                      const std::vector<ObjectKind>& objects, std::chrono::seconds life) {
  const std::lock_guard lock(mutex_);
  Written& written = written_[id];
  written.bytes += bytes;
  written.objects.insert(written.objects.end(), objects.begin(), objects.end());
  written.since = Clock::now();
  written.too_old = written.since + life;
  bytes_ += bytes;
}

std::optional<std::string> JobRecords::next_to_erase() {
  if (!dropped_.empty()) {
    std::string id = std::move(dropped_.back());
    dropped_.pop_back();
    return id;
  }
  const Clock::time_point now = Clock::now();
  auto first = written_.end();
  for (auto entry = written_.begin(); entry != written_.end(); ++entry) {
    if (entry->second.too_old <= now) return entry->first;
    if (first == written_.end() || entry->second.since < first->second.since) first = entry;
  }
  if (bytes_ <= limits_.bytes || first == written_.end()) return std::nullopt;
  return first->first;
}

void JobRecords::tidy() noexcept {
  try {
    const Clock::time_point end = Clock::now() + kTidyFor;
    while (Clock::now() < end) {
      std::vector<ObjectKind> objects;
      std::optional<std::string> id;
      {
        const std::lock_guard lock(mutex_);
        id = next_to_erase();
        if (!id) break;
        // Somebody may have written it anew since it was dropped: then it is erased whole.
        objects = forget(*id);
      }
      // What cannot be erased now, somebody erases a day later.
      if (!storage_.erase_job(*id, objects)) return;
    }
    const Clock::time_point now = Clock::now();
    if (tidied_ && now < *tidied_ + kTidyEvery) return;
    tidied_ = now;
    (void)storage_.erase_old_jobs(limits_.keep + kKeepQuestions);
  } catch (const std::exception& error) {
    spdlog::warn("what is kept of old jobs is not erased: {}", error.what());
  }
}

}  // namespace geodesic::server
