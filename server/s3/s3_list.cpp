#include "server/s3/s3_list.h"

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <pugixml.hpp>
#include <utility>

#include "server/base/service_codes.h"

namespace geodesic::server {

namespace {

constexpr std::uint64_t kMostListBytes = 4 << 20;  // 1,000 keys take half a megabyte

// "2026-01-31T12:34:56.789Z" in seconds since 1970; 0 if it is none.
std::int64_t seconds_of(const char* text) {
  std::tm time{};
  if (::strptime(text, "%Y-%m-%dT%H:%M:%S", &time) == nullptr) return 0;
  return static_cast<std::int64_t>(::timegm(&time));
}

}  // namespace

tl::unexpected<Error> no_bucket() {
  return fail(ServiceCode::store_failed, "the bucket of the object store is not there");
}

Result<ListedPage> list_page(S3Client& client, const char* folder, std::string_view beginning,
                             std::string_view after, const std::string& token, std::size_t most,
                             std::chrono::milliseconds within) {
  const std::string full = client.location().prefix + folder;
  S3Request request;
  request.query = {{"list-type", "2"},
                   {"prefix", full + std::string(beginning)},
                   {"max-keys", std::to_string(std::min(most, kMostListed))}};
  if (!after.empty()) request.query.emplace("start-after", full + std::string(after));
  if (!token.empty()) request.query.emplace("continuation-token", token);
  request.max_reply_bytes = kMostListBytes;
  request.within = within;
  const auto reply = client.send(request);
  if (!reply) return fail(reply.error());
  if (reply->status == 404) return no_bucket();
  pugi::xml_document document;
  const pugi::xml_node list = document.load_buffer(reply->body.data(), reply->body.size())
                                  ? document.child("ListBucketResult")
                                  : pugi::xml_node();
  if (!list) return fail(ServiceCode::store_failed, "the object store's list cannot be read");
  ListedPage page;
  for (const pugi::xml_node item : list.children("Contents")) {
    std::string key = item.child_value("Key");
    if (!key.starts_with(full)) continue;
    key.erase(0, full.size());
    page.objects.push_back({std::move(key), std::strtoull(item.child_value("Size"), nullptr, 10),
                            seconds_of(item.child_value("LastModified")),
                            strong_tag(item.child_value("ETag"))});
  }
  if (std::string_view(list.child_value("IsTruncated")) == "true") {
    page.next = list.child_value("NextContinuationToken");
    if (page.next.empty() || page.next == token) {
      return fail(ServiceCode::store_failed, "the object store's list does not go on");
    }
  }
  return page;
}

}  // namespace geodesic::server
