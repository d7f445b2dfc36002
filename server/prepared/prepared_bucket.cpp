#include "server/prepared/prepared_bucket.h"

#include <chrono>

#include "server/base/service_codes.h"
#include "server/s3/s3_list.h"

namespace geodesic::server {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr const char* kFolder = "prepared/";
// What S3 takes in one PUT.
constexpr std::uint64_t kMostObjectBytes = std::uint64_t{5} << 30;
// Preparing anew makes some 270 bytes in a microsecond (tests/cluster/warm_start.py).
constexpr std::uint64_t kSlowestReading = 100'000;  // bytes in a millisecond
constexpr milliseconds kFirstByte(1000);
// Nobody waits for an upload, but others are behind it.
constexpr std::uint64_t kSlowestWriting = 20'000;
constexpr milliseconds kBeforeWriting(10'000);
constexpr milliseconds kShort(2000);  // of a request without a body
constexpr milliseconds kErasing(10'000);

}  // namespace

std::string PreparedBucket::key_of(const std::string& name) const {
  return client_.location().prefix + kFolder + name;
}

Result<bool> PreparedBucket::read(const std::string& name,
                                  const std::function<std::optional<int>(std::uint64_t)>& open_file,
                                  const std::function<bool()>& stop) {
  S3Request request;
  request.key = key_of(name);
  request.open_file = [&](std::uint64_t bytes) {
    return bytes <= kMostObjectBytes ? open_file(bytes) : std::nullopt;
  };
  request.within = kFirstByte;
  request.bytes_per_millisecond = kSlowestReading;
  request.stop = stop;
  const auto reply = client_.send(request);
  if (!reply) return fail(reply.error());
  return reply->status != 404;
}

Result<bool> PreparedBucket::has(const std::string& name, std::uint64_t bytes,
                                 const std::function<bool()>& stop) {
  S3Request request;
  request.method = "HEAD";
  request.key = key_of(name);
  request.within = kShort;
  request.stop = stop;
  const auto reply = client_.send(request);
  if (!reply) {
    const ErrorCode code = reply.error().code;
    if (code == ServiceCode::store_unavailable || code == ErrorCode::cancelled) {
      return fail(reply.error());
    }
    return false;  // some let nobody ask, but write
  }
  return reply->status != 404 && reply->content_length.value_or(bytes) == bytes;
}

Result<void> PreparedBucket::write(const std::string& name, int file, std::uint64_t bytes,
                                   const std::function<bool()>& stop) {
  if (bytes > kMostObjectBytes) {
    return fail(ServiceCode::store_full, "a prepared mesh is too large for the bucket");
  }
  S3Request request;
  request.method = "PUT";
  request.key = key_of(name);
  request.body_file = S3Request::File{file, bytes};
  request.within = kBeforeWriting;
  request.bytes_per_millisecond = kSlowestWriting;
  request.stop = stop;
  const auto reply = client_.send(request);
  if (!reply) return fail(reply.error());
  if (reply->status == 404) return no_bucket();
  return {};
}

Result<void> PreparedBucket::erase(const std::string& name) {
  S3Request request;
  request.method = "DELETE";
  request.key = key_of(name);
  request.within = kShort;
  const auto reply = client_.send(request);
  if (!reply) return fail(reply.error());
  return {};
}

Result<void> PreparedBucket::erase_all(const std::string& beginning) {
  const auto end = Clock::now() + kErasing - 2 * kShort;  // the list and the last one
  // One mesh has as many as there are builds: one page.
  const auto page = list_page(client_, kFolder, beginning, "", "", kMostListed, kShort);
  if (!page) return fail(page.error());
  for (const ListedObject& object : page->objects) {
    if (Clock::now() > end) {
      return fail(ServiceCode::store_unavailable, "the object store is too slow");
    }
    if (auto done = erase(object.name); !done) return done;
  }
  return {};
}

}  // namespace geodesic::server
