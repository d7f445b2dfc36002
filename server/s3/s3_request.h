// A request to a bucket of object storage, and its reply.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace geodesic::server {

struct S3Request {
  std::string method = "GET";  // GET, HEAD, PUT or DELETE
  std::string key;  // in the bucket, of letters, digits and - . _ ~ /; empty: the bucket itself
  std::map<std::string, std::string> query;  // unescaped
  // What a PUT sends: bytes that outlive the request, or so many from the beginning of a file.
  struct File {
    int descriptor = -1;
    std::uint64_t bytes = 0;
  };
  std::optional<std::string_view> body;
  std::optional<File> body_file = std::nullopt;
  std::uint64_t max_reply_bytes = 1 << 20;  // a longer body is cut there
  bool is_probe = false;                    // one short try, even when all else is refused
  // Given the length of a reply with 2xx before its first byte, says to which file they go, from
  // its beginning; nothing: they are refused. Not called for a reply without bytes. A reply that
  // does not tell its length is an error. One try. Null: `body` has the bytes.
  std::function<std::optional<int>(std::uint64_t bytes)> open_file = nullptr;
  // One try, which may take so long, and as much longer as the bytes sent and received take at
  // `bytes_per_millisecond` (0: no longer). 0: as long as the location and the sizes say.
  std::chrono::milliseconds within{0};
  std::uint64_t bytes_per_millisecond = 0;
  std::function<bool()> stop = nullptr;  // asked every 20 ms
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

}  // namespace geodesic::server
