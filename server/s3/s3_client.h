// Requests to a bucket of S3-compatible object storage, signed by libcurl.
//
// A request is tried up to three times: a lost connection or an answer that means
// "later" (429, 500, 502, 503, 504) is worth another try, after a wait that grows,
// within the location's timeout. At most 32 requests run at once and as many wait;
// more are refused at once, and so is any for a few seconds after the storage could
// not be reached: a storage that is down must not hold every thread of a server.
//
// Versions of libcurl differ in how they sign: 7.88 signs path and query as they are,
// later ones sort and escape them. So both are passed on in the canonical form
// already: a key has unreserved characters and slashes only (RFC 3986), a query is
// sorted and escaped, and each of its names has a '='. Nor may a header be empty, and
// CURLOPT_PATH_AS_IS is refused by 8.14: a prefix has no segments "." and "..".
//
// All methods may be called from any thread.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "server/s3/s3_location.h"

using CURL = void;

namespace geodesic::server {

struct S3Request {
  std::string method = "GET";  // GET, HEAD, PUT or DELETE
  std::string key;  // in the bucket, of letters, digits and - . _ ~ /; empty: the bucket itself
  std::map<std::string, std::string> query;  // unescaped
  std::optional<std::string_view> body;      // of a PUT; the bytes outlive the request
  std::uint64_t max_reply_bytes = 1 << 20;   // a longer body is cut there
  bool is_probe = false;                     // one short try, even when all else is refused
  // Where the body of a reply with 2xx is written, from the file's beginning; else `body` has it.
  std::optional<int> file = std::nullopt;
  // One try, which may take so long; 0: as long as the location and the sizes say.
  std::chrono::milliseconds within{0};
  std::function<bool()> stop = nullptr;  // called every 20 ms and with each piece of a body
};

struct S3Reply {
  int status = 0;
  std::string body;
  bool cut = false;                             // the body was longer than allowed
  std::optional<std::uint64_t> content_length;  // as the server has told it
  std::string entity_tag;                       // a strong one, without its quotes; or empty
  std::int64_t last_modified = 0;               // seconds since 1970; 0: not told
};

// What is between the quotes of an entity tag; nothing if it is weak.
[[nodiscard]] std::string strong_tag(std::string_view text);

class S3Client {
 public:
  explicit S3Client(S3Location location);
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

  struct Attempt {
    S3Reply reply;
    int curl_code = 0;  // CURLE_OK: there was a reply
    std::string reason;
  };
  [[nodiscard]] Attempt try_once(CURL* handle, const S3Request& request) const;
  [[nodiscard]] Result<S3Reply> send_with(CURL* handle, const S3Request& request);
  // Nothing to say while requests may be sent.
  [[nodiscard]] std::optional<std::string> why_resting() const;
  void rest(const std::string& reason);
  void end_rest();

  const S3Location location_;
  mutable std::mutex mutex_;
  std::condition_variable freed_;
  std::vector<CURL*> idle_;
  int running_ = 0;
  int waiting_ = 0;
  Clock::time_point resting_until_{};
  std::string resting_because_;
};

}  // namespace geodesic::server
