// Where a bucket is and how to reach it, read from a URL:
//
//   s3://BUCKET[/PREFIX][?endpoint=URL&region=NAME&style=path|virtual&timeout=SECONDS]
//
//   endpoint   http://HOST[:PORT] or https://…; default: Amazon's for the region
//   region     default us-east-1
//   style      path: ENDPOINT/BUCKET/KEY, the default where an endpoint is given;
//              virtual: BUCKET.ENDPOINT/KEY, the default on Amazon
//   timeout    seconds of silence before a request is given up; default 10
//
// Credentials are never in the URL but in the environment: AWS_ACCESS_KEY_ID,
// AWS_SECRET_ACCESS_KEY and, for temporary ones, AWS_SESSION_TOKEN.
#pragma once

#include <chrono>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "server/config/config.h"

namespace geodesic::server {

struct S3Location {
  std::string url;     // of the bucket, such as http://localhost:9000/meshes; no slash at its end
  std::string bucket;  // letters, digits, '-' and '.'
  std::string prefix;  // of every key: empty or ending in '/'
  std::string region;
  std::chrono::seconds timeout{10};
  std::string access_key;
  std::string secret_key;
  std::string session_token;  // may be empty

  // For people: s3://BUCKET/PREFIX.
  [[nodiscard]] std::string name() const;
  // Whether what is sent there passes over a network unencrypted.
  [[nodiscard]] bool is_exposed() const;
};

// Whether a store's name is one of object storage.
[[nodiscard]] bool is_s3_url(std::string_view text);

// `bad_syntax` with a sentence that says what is wrong; `unknown_parameter`.
[[nodiscard]] Result<S3Location> parse_s3_url(std::string_view text,
                                              const Environment& environment);

}  // namespace geodesic::server
