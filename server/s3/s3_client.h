// Requests to a bucket of S3-compatible object storage.
//
// A request is tried up to three times: a lost connection or an answer that means
// "later" (429, 500, 502, 503, 504) is worth another try, after a wait that grows,
// within the location's timeout. At most 32 requests run at once and as many wait;
// more are refused at once, and so is any for a few seconds after the storage could
// not be reached: a storage that is down must not hold every thread of a server. Nor is
// one asked that has answered "later" to a request which is tried but once.
//
// All methods may be called from any thread.
#pragma once

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "server/s3/s3_location.h"
#include "server/s3/s3_request.h"
#include "server/s3/s3_transfer.h"

namespace geodesic::server {

class S3Client {
 public:
  // `label`: what the log calls this storage.
  explicit S3Client(S3Location location, std::string label = "store");
  ~S3Client();
  S3Client(const S3Client&) = delete;
  S3Client& operator=(const S3Client&) = delete;

  [[nodiscard]] const S3Location& location() const { return location_; }

  // Answers with a status of 2xx and 404; everything else is an error:
  // `store_unavailable` when it may work later, `store_full` when there is no
  // room, `cancelled` when `stop` said so, `store_failed` otherwise, with S3's own code, such as
  // "AccessDenied".
  [[nodiscard]] Result<S3Reply> send(const S3Request& request);

 private:
  using Clock = std::chrono::steady_clock;
  class Turn;

  [[nodiscard]] Result<S3Reply> send_with(S3Transfer& transfer, const S3Request& request);
  // Nothing to say while requests may be sent.
  [[nodiscard]] std::optional<std::string> why_resting() const;
  void rest(const std::string& reason);
  // For a request that was begun then and has had a reply.
  void end_rest(Clock::time_point begun);

  const S3Location location_;
  const std::string label_;
  mutable std::mutex mutex_;
  std::condition_variable freed_;
  std::vector<std::unique_ptr<S3Transfer>> idle_;
  int running_ = 0;
  int waiting_ = 0;
  Clock::time_point resting_since_{};
  Clock::time_point resting_until_{};
  std::string resting_because_;
};

}  // namespace geodesic::server
