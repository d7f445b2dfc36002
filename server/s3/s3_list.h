// What is in a folder of a bucket, a page at a time (ListObjectsV2).
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "server/s3/s3_client.h"

namespace geodesic::server {

inline constexpr std::size_t kMostListed = 1000;  // of a page, as S3 has it

struct ListedObject {
  std::string name;  // of the key, below the folder
  std::uint64_t bytes = 0;
  std::int64_t written = 0;  // seconds since 1970; 0: not known
  std::string version;       // its entity tag
};

struct ListedPage {
  std::vector<ListedObject> objects;
  std::string next;  // the token of the page that follows; empty: this is the last one
};

// A page of what is in a folder, below the location's prefix, and has a name that begins with
// `beginning` and is greater than `after`; `token`: that of the page; empty: the first; `within`:
// as `S3Request` has it. Errors: those of `S3Client::send`; store_failed if there is no such
// bucket, or if no list comes back.
[[nodiscard]] Result<ListedPage> list_page(
    S3Client& client, const char* folder, std::string_view beginning, std::string_view after,
    const std::string& token, std::size_t most,
    std::chrono::milliseconds within = std::chrono::milliseconds(0));

// The error that says so.
[[nodiscard]] tl::unexpected<Error> no_bucket();

}  // namespace geodesic::server
