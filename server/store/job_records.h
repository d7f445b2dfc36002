// What is kept of jobs in the storage, so that a job outlives the server that runs it: its question
// from the moment when it is taken, and in the question's place its reply once it has ended. Any
// server that uses the storage can tell what a job came to, or begin it again.
//
// A record is checked against its digest when it is read. What is damaged, of another version or
// too old is as if it were not there. What credentials a request came with is not kept: it was
// allowed when it was taken, and who knows the id may ask.
//
// What one process has written is bounded by a budget: the oldest goes first. What a process left
// that is gone is erased by another one, a day after it was too old.
//
// All methods may be called from any thread. Errors are those of the storage.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "server/http/message.h"
#include "server/store/object_storage.h"

namespace geodesic::server {

struct JobRecord {
  using Time = std::chrono::system_clock::time_point;

  std::string id;
  std::uint64_t attempt = 1;  // how often it has been begun
  bool has_lease = true;
  Time created;
  std::string method;  // of its request
  std::string target;
  struct End {
    std::optional<Time> started;
    Time finished;
    HttpResponse reply;  // its status, headers and body
  };
  std::optional<End> end;  // nothing: it has not ended
};

struct JobQuestion {
  JobRecord record;
  HttpRequest request;  // of a job that has not ended
};

class JobRecords {
 public:
  struct Limits {
    std::uint64_t bytes = std::uint64_t{256} << 20;  // written by this process, and not yet erased
    std::chrono::seconds keep{600};                  // a reply
  };

  JobRecords(ObjectStorage& storage, const Limits& limits) : storage_(storage), limits_(limits) {}

  // Keeps what a job asks. False: it is larger than the budget.
  [[nodiscard]] Result<bool> keep(const JobRecord& record, const HttpRequest& request);
  // Keeps what it came to instead, with `record.end`. Likewise.
  [[nodiscard]] Result<bool> keep(const JobRecord& record);
  // Nothing if there is none.
  [[nodiscard]] Result<std::optional<JobQuestion>> read(const std::string& id);
  [[nodiscard]] Result<void> erase(const std::string& id);
  // Erases what has become too old, of this process and, now and then, of those that are gone.
  void tidy();

 private:
  using Clock = std::chrono::steady_clock;
  struct Written {
    std::uint64_t bytes = 0;
    bool has_bodies = false;  // large ones
    Clock::time_point too_old;
  };

  [[nodiscard]] Result<bool> write(const std::string& id, nlohmann::json head,
                                   std::string_view body, ObjectKind kind,
                                   std::chrono::seconds life);
  void note(const std::string& id, std::uint64_t bytes, bool has_body, std::chrono::seconds life);
  // Forgets one; whether it may have large bodies. With the lock.
  bool forget(const std::string& id);

  ObjectStorage& storage_;
  const Limits limits_;
  std::mutex mutex_;
  std::map<std::string, Written> written_;  // by id
  std::uint64_t bytes_ = 0;                 // of those
  std::optional<Clock::time_point> tidied_;
};

}  // namespace geodesic::server
