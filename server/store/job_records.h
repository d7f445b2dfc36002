// What is kept of jobs in the storage, so that a job outlives the server that runs it: its question
// from the moment when it is taken, and its reply once it has ended, which then counts. Any server
// that uses the storage can tell what a job came to, or begin it again. Where two have run it, what
// one of them has brought to a good end is not replaced by the other's failure.
//
// A record is checked against its digest when it is read. What is damaged, too large, of another
// version or too old is as if it were not there. Of a request's headers only those are kept that
// say what is asked, and in which form: it was allowed when it was taken, and who knows the id may
// ask.
//
// What one process has written is bounded by a budget: what was written first goes first. What a
// process left that is gone is erased by another one, a day after it was too old.
//
// All methods may be called from any thread. Errors are those of the storage.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

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
  // Has it erased by the next `tidy`; does not wait for the storage.
  void drop(const std::string& id);
  // Whether one of these was called for it lately: then nothing is read of it any more, and who has
  // read it just before should not use it.
  [[nodiscard]] bool is_erased(const std::string& id);
  // Erases what was dropped or has become too old, of this process and, now and then, of those that
  // are gone. Takes some seconds at most; what is left over comes next time.
  void tidy() noexcept;

 private:
  using Clock = std::chrono::steady_clock;
  struct Written {
    std::uint64_t bytes = 0;
    std::vector<ObjectKind> objects;
    Clock::time_point since;
    Clock::time_point too_old;
  };
  struct Kinds {
    ObjectKind record;
    ObjectKind body;
  };

  [[nodiscard]] Result<bool> write(const std::string& id, nlohmann::json head,
                                   std::string_view body, const Kinds& kinds,
                                   std::chrono::seconds life);
  [[nodiscard]] Result<std::optional<JobQuestion>> read(const std::string& id, const Kinds& kinds);
  void note(const std::string& id, std::uint64_t bytes, const std::vector<ObjectKind>& objects,
            std::chrono::seconds life);
  void note_erased(const std::string& id);  // with the lock
  // The objects of one that is forgotten; all that there may be of one that another process has
  // written. With the lock.
  std::vector<ObjectKind> forget(const std::string& id);
  // One to erase now, if there is any; with the lock.
  [[nodiscard]] std::optional<std::string> next_to_erase();

  ObjectStorage& storage_;
  const Limits limits_;
  std::mutex mutex_;
  std::map<std::string, Written> written_;  // by id
  std::vector<std::string> dropped_;
  std::deque<std::string> erased_;  // the last ones
  std::unordered_set<std::string> is_erased_;
  std::uint64_t bytes_ = 0;                  // of those
  std::optional<Clock::time_point> tidied_;  // of those that are gone; the tidying thread's
};

}  // namespace geodesic::server
