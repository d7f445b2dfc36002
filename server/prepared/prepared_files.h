// Prepared meshes in a directory of this machine, so that a server that starts again need not
// prepare them anew: a file each, mapped when it is wanted. The directory is a cache. Whatever is
// missing, damaged or of another build is prepared afresh, and any file may be removed at any time,
// but not cut short. Several processes, of several builds too, may share the directory: they share
// the pages that they have mapped.
//
// A thread of its own writes the files, one after the other, beside the queries. They are not
// synced: what a loss of power leaves of one fails its checksum. A file is in use while somebody
// holds its mesh. What was used longest ago goes when a budget or the disk wants room, and what was
// not used for a week goes too.
//
// A bucket may stand behind the directories of many machines. What is not in the directory is
// fetched from there. What was written here, or is found here, is uploaded unless it is known to be
// there. Whoever may write to the bucket is trusted: the checksum is no signature.
//
// All methods may be called from any thread.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "core/base/error.h"
#include "core/surface/adjacency.h"
#include "server/base/turns.h"
#include "server/prepared/prepared_bucket.h"
#include "server/prepared/prepared_folder.h"

namespace geodesic::server {

class PreparedFiles {
 public:
  struct Limits {
    std::uint64_t bytes = 0;         // of all files; 0: no limit
    std::uint64_t fewest_faces = 0;  // smaller meshes are not kept
  };
  struct Stats {
    std::uint64_t found = 0;    // lookups that mapped a file
    std::uint64_t missing = 0;  // lookups without a file that can be used
    std::uint64_t damaged = 0;  // lookups, of both, that found a damaged file here; it is removed
    std::uint64_t written = 0;
    std::uint64_t not_written = 0;  // for want of room, or because of an error
    std::uint64_t bytes = 0;        // of all files, when they were last counted
    std::uint64_t fetched = 0;      // files that came from the bucket
    std::uint64_t uploaded = 0;
    std::uint64_t bucket_damaged = 0;  // files that came damaged
    std::uint64_t bucket_failed = 0;   // requests to the bucket that failed
  };

  // Makes the directory, and the folder geodesicd-prepared in it, where all files are. `engine`:
  // the digest of the build. `bucket` may be null. Errors: store_failed, with a sentence for the
  // operator.
  [[nodiscard]] static Result<std::unique_ptr<PreparedFiles>> open(
      const std::filesystem::path& directory, const Limits& limits, std::string engine,
      std::unique_ptr<PreparedBucket> bucket = nullptr);
  ~PreparedFiles();
  PreparedFiles(const PreparedFiles&) = delete;
  PreparedFiles& operator=(const PreparedFiles&) = delete;

  // A mesh that was written, or that the bucket has; null if there is none. Reads the whole file;
  // few do so at once, others wait. `stop` is called every few milliseconds while it waits, then
  // once for each MiB, and every 20 ms while the bucket is asked. Errors: cancelled.
  [[nodiscard]] Result<std::shared_ptr<const Adjacency>> find(const std::string& id,
                                                              const std::function<bool()>& stop);
  // Queues a mesh to be written. It is skipped if nobody else holds it when its turn comes. Does
  // not wait.
  void keep(const std::string& id, const std::shared_ptr<const Adjacency>& adjacency);
  // Removes a mesh's file. A system call: cheap.
  void forget(const std::string& id);
  // Removes a mesh's files, of all builds, in the bucket too. Lists the directory and the bucket,
  // which may take ten seconds.
  void erase(const std::string& id);

  [[nodiscard]] Stats stats() const;
  // Waits until all that was to be written and uploaded is.
  void wait();
  // Removes what is too old or too much; the thread does it each hour.
  void tidy();

 private:
  using Held = std::weak_ptr<const Adjacency>;
  struct Wanted {
    std::string id;
    Held adjacency;
    bool is_here = false;  // it has its file, and is to be uploaded
  };
  struct Fetching {
    std::string id;
    bool is_unwanted = false;  // it was removed meanwhile
  };
  struct Found {
    std::shared_ptr<const Adjacency> adjacency;  // null: there is none
    bool is_damaged = false;                     // there was a file, which is removed
  };

  PreparedFiles(std::unique_ptr<PreparedFolder> folder, const Limits& limits, std::string engine,
                std::unique_ptr<PreparedBucket> bucket);
  [[nodiscard]] std::string name_of(const std::string& id) const;
  void write_files();  // the thread
  // Says whether it has a file now.
  [[nodiscard]] bool write(const Wanted& wanted);
  [[nodiscard]] Result<void> write_file(const std::string& id, const Adjacency& adjacency);
  // In the directory.
  [[nodiscard]] Result<Found> find_here(const std::string& id, const std::function<bool()>& stop);
  // Makes a file of what the bucket has, and says whether it did. Errors: cancelled.
  [[nodiscard]] Result<bool> fetch(const std::string& name, const std::function<bool()>& stop);
  [[nodiscard]] Result<bool> fetch_file(const std::string& name, const std::function<bool()>& stop);
  [[nodiscard]] Result<std::shared_ptr<const Adjacency>> find_in_bucket(
      const std::string& id, const std::function<bool()>& stop);
  // What is in the directory; the second says whether it was not yet there.
  void upload(const std::string& name);
  [[nodiscard]] Result<bool> upload_file(const std::string& name);
  void erase_in_bucket(const std::string& name);
  // What is known of a name in the bucket: that it is there, and whether it is sound.
  [[nodiscard]] std::optional<bool> is_sound_in_bucket(const std::string& name) const;
  void learn(const std::string& name, std::optional<bool> is_sound);
  // What the bucket could not do, and what the directory could not.
  void count_failure(const Error& error);
  void count_not_written(const Error& error);
  void touch_what_is_used();
  void remove(const std::string& name);
  void report(std::string& last, const std::string& what);

  static constexpr std::size_t kReadersAtOnce = 2;
  static constexpr std::size_t kFetchersAtOnce = 4;

  const std::unique_ptr<PreparedFolder> folder_;
  const Limits limits_;
  const std::string engine_;
  const std::unique_ptr<PreparedBucket> bucket_;  // or null
  Turns readers_{kReadersAtOnce, std::chrono::seconds(0), "prepared files are being read"};
  Turns fetchers_{kFetchersAtOnce, std::chrono::seconds(0), "prepared files are being fetched"};
  std::atomic<bool> is_stopping_{false};
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Wanted> wanted_;
  std::string writing_;                   // the mesh that is being written; empty: none
  std::atomic<bool> is_unwanted_{false};  // it was removed meanwhile
  std::list<Fetching> fetching_;
  std::map<std::string, Held> used_;       // meshes whose files were found or written
  std::map<std::string, bool> in_bucket_;  // names that are there, and whether they are sound
  Stats stats_;
  std::string reported_;         // what went wrong last
  std::string bucket_reported_;  // with the bucket
  std::thread writer_;
};

}  // namespace geodesic::server
