// One try of a request to object storage, by libcurl, signed (AWS Signature Version 4).
//
// Versions of libcurl differ in how they sign: 7.88 signs path and query as they are,
// later ones sort and escape them. So both are passed on in the canonical form
// already: a key has unreserved characters and slashes only (RFC 3986), a query is
// sorted and escaped, and each of its names has a '='. Nor may a header be empty, and
// CURLOPT_PATH_AS_IS is refused by 8.14: a prefix has no segments "." and "..".
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/base/error.h"
#include "server/s3/s3_location.h"
#include "server/s3/s3_request.h"

using CURL = void;
using CURLM = void;

namespace geodesic::server {

// The SHA-256 of what a request sends, as it is signed: 64 hexadecimal digits. Errors: cancelled,
// and store_failed if the file cannot be read.
[[nodiscard]] Result<std::string> digest_of_body(const S3Request& request);

// A libcurl handle and the connections that it has kept. For one request at a time.
class S3Transfer {
 public:
  S3Transfer();  // throws std::bad_alloc
  ~S3Transfer();
  S3Transfer(const S3Transfer&) = delete;
  S3Transfer& operator=(const S3Transfer&) = delete;

  struct Outcome {
    S3Reply reply;
    int curl_code = 0;  // CURLE_OK: there was a reply
    std::string reason;
    // Not the storage's fault: cancelled, the file was refused (store_full) or the disk has failed.
    std::optional<Error> own_error = std::nullopt;
  };
  // `digest`: of what is sent.
  [[nodiscard]] Outcome run(const S3Location& location, const S3Request& request,
                            const std::string& digest);

 private:
  CURL* easy_;
  CURLM* multi_;
};

}  // namespace geodesic::server
