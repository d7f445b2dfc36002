#include "server/prepared/prepared_bucket.h"

#include <chrono>
#include <string_view>
#include <utility>

#include "server/base/service_codes.h"
#include "server/s3/s3_list.h"

namespace geodesic::server {
namespace {

constexpr const char* kFolder = "prepared/";
// What S3 takes in one PUT.
constexpr std::uint64_t kMostObjectBytes = std::uint64_t{5} << 30;
// Preparing anew makes some 270 bytes in a microsecond (tests/cluster/warm_start.py).
constexpr std::uint64_t kSlowestBytesPerMillisecond = 100'000;
constexpr std::chrono::milliseconds kFirstByte{1000};
constexpr std::chrono::milliseconds kShort{2000};  // of a request without a body

}  // namespace

std::string PreparedBucket::key_of(const std::string& name) const {
  return client_.location().prefix + kFolder + name;
}

Result<std::optional<std::uint64_t>> PreparedBucket::find(const std::string& name) {
  S3Request request;
  request.method = "HEAD";
  request.key = key_of(name);
  request.within = kShort;
  const auto reply = client_.send(request);
  if (!reply) return fail(reply.error());
  if (reply->status == 404) return std::nullopt;
  if (reply->content_length) return reply->content_length;
  return fail(ServiceCode::store_failed, "the object store does not tell how long an object is");
}

Result<void> PreparedBucket::read(const std::string& name, std::uint64_t bytes, int file,
                                  const std::function<bool()>& stop) {
  S3Request request;
  request.key = key_of(name);
  request.max_reply_bytes = bytes;
  request.file = file;
  request.within = kFirstByte + std::chrono::milliseconds(bytes / kSlowestBytesPerMillisecond);
  request.stop = stop;
  const auto reply = client_.send(request);
  if (!reply) return fail(reply.error());
  if (reply->cut) return fail(ServiceCode::store_failed, "a prepared mesh has grown in the bucket");
  if (reply->status == 404) {
    return fail(ServiceCode::store_failed, "a prepared mesh has left the bucket");
  }
  return {};
}

Result<void> PreparedBucket::write(const std::string& name, std::span<const std::byte> bytes,
                                   const std::function<bool()>& stop) {
  if (bytes.size() > kMostObjectBytes) {
    return fail(ServiceCode::store_full, "a prepared mesh is too large for the bucket");
  }
  S3Request request;
  request.method = "PUT";
  request.key = key_of(name);
  request.body = std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size());
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
  // One mesh has as many as there are builds: one page.
  const auto page = list_page(client_, kFolder, beginning, "", "", kMostListed);
  if (!page) return fail(page.error());
  for (const ListedObject& object : page->objects) {
    if (auto done = erase(object.name); !done) return done;
  }
  return {};
}

}  // namespace geodesic::server
