// Files of a storage that were read once and found to have the digest they are stored under, so
// that they can be sent as they are read. A file that has been touched since is read again.
#pragma once

#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "server/base/reply_file.h"

namespace geodesic::server {

// Thread-safe.
class VerifiedFiles {
 public:
  // Whether the file has the digest of the mesh's id: by reading it, unless that was done when the
  // file was in the same `state`. Who asks for the same mesh meanwhile waits for the outcome;
  // others do not wait. `stop` is asked every few milliseconds. Errors: cancelled.
  [[nodiscard]] Result<bool> is_whole(const ReplyFile& file, std::string_view id,
                                      const std::string& state, const std::function<bool()>& stop);

 private:
  // The caller holds `mutex_`.
  [[nodiscard]] bool is_verified(const std::string& id, const std::string& state) const;

  std::mutex mutex_;
  std::map<std::string, std::string> verified_;  // the states of files that were, by id
  std::set<std::string> verifying_;              // ids of those that are read for it now
  std::condition_variable verify_done_;          // of one of these
};

}  // namespace geodesic::server
