#include "server/store/s3_storage.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <ctime>
#include <utility>

#include "server/base/service_codes.h"
#include "server/s3/s3_list.h"
#include "server/store/mesh_store.h"

namespace geodesic::server {

namespace {

constexpr const char* kObjects = "objects/";
constexpr const char* kJobs = "jobs/";
constexpr int kMostJobPages = 100;        // … that is looked through for old jobs
constexpr std::size_t kMostErased = 100;  // of those at once
constexpr int kMostPages = 1000;          // of one list
// What S3 takes in one PUT, so that nothing of ours is larger.
constexpr std::uint64_t kMostObjectBytes = std::uint64_t{5} << 30;

}  // namespace

std::string S3Storage::key_of(ObjectKind kind, std::string_view id) const {
  const std::string& prefix = client_.location().prefix;
  if (kind == ObjectKind::source) return prefix + kObjects + std::string(id);
  if (kind != ObjectKind::metadata) return prefix + kJobs + name_of_job_object(kind, id);
  return prefix + "meta/" + std::string(id) + ".json";
}

Result<std::vector<StoredMesh>> S3Storage::list(std::string_view after, std::size_t most) {
  std::vector<StoredMesh> meshes;
  std::string token;
  for (int pages = 0; pages < kMostPages && meshes.size() < most; ++pages) {
    auto page = list_page(client_, kObjects, "", after, token, most - meshes.size());
    if (!page) return fail(std::move(page.error()));
    for (ListedObject& object : page->objects) {
      // Keys that are none of ours are passed over.
      if (!is_mesh_id(object.name)) continue;
      meshes.push_back(
          {std::move(object.name), object.bytes, object.written, std::move(object.version)});
    }
    if (page->next.empty()) return meshes;
    token = std::move(page->next);
  }
  if (meshes.size() < most) {
    return fail(ServiceCode::store_failed, "the object store's list has no end");
  }
  return meshes;
}

Result<std::optional<StoredMesh>> S3Storage::find(std::string_view id) {
  S3Request request;
  request.method = "HEAD";
  request.key = key_of(ObjectKind::source, id);
  const auto reply = client_.send(request);
  if (!reply) return fail(reply.error());
  if (reply->status == 404) return std::nullopt;
  StoredMesh mesh{std::string(id), reply->content_length.value_or(0), reply->last_modified,
                  reply->entity_tag};
  if (reply->content_length) return mesh;
  // Some servers leave the length out of a HEAD's answer. Their lists have it.
  const auto page = list_page(client_, kObjects, mesh.id, "", "", 2);  // with options or without
  if (!page) return fail(page.error());
  for (const ListedObject& listed : page->objects) {
    if (listed.name == mesh.id) mesh.bytes = listed.bytes;
  }
  return mesh;
}

Result<std::optional<std::string>> S3Storage::metadata_version(std::string_view id) {
  S3Request request;
  request.method = "HEAD";
  request.key = key_of(ObjectKind::metadata, id);
  auto reply = client_.send(request);
  if (!reply) return fail(std::move(reply.error()));
  if (reply->status == 404) return std::nullopt;
  return std::move(reply->entity_tag);
}

Result<std::string> S3Storage::put_key(const std::string& key, std::string_view bytes) {
  S3Request request;
  request.method = "PUT";
  request.key = key;
  request.body = bytes;
  auto reply = client_.send(request);
  if (!reply) return fail(std::move(reply.error()));
  if (reply->status == 404) return no_bucket();
  return std::move(reply->entity_tag);
}

Result<std::string> S3Storage::write(ObjectKind kind, std::string_view id, std::string_view bytes) {
  return put_key(key_of(kind, id), bytes);
}

Result<std::optional<StoredObject>> S3Storage::read(ObjectKind kind, std::string_view id,
                                                    std::uint64_t expected_bytes) {
  S3Request request;
  request.key = key_of(kind, id);
  // Room for an error's XML.
  request.max_reply_bytes = std::max<std::uint64_t>(expected_bytes, 1 << 20);
  auto reply = client_.send(request);
  if (!reply) return fail(std::move(reply.error()));
  if (is_of_job(kind) && (reply->cut || reply->body.size() > expected_bytes)) {
    spdlog::warn("store: {} is not read: it is larger than {} bytes", request.key, expected_bytes);
    return std::nullopt;
  }
  if (reply->cut) {
    // The expectation was wrong. What was cut tells nothing about the object.
    request.max_reply_bytes = kMostObjectBytes;
    reply = client_.send(request);
    if (!reply) return fail(std::move(reply.error()));
    if (reply->cut) return fail(ServiceCode::store_failed, "an object of the store is too large");
  }
  if (reply->status == 404) return std::nullopt;
  // Without a length, a body that ended early looks whole: it must not stand for a version.
  if (!reply->content_length) reply->entity_tag.clear();
  return StoredObject{std::move(reply->body), std::move(reply->entity_tag)};
}

Result<void> S3Storage::erase_key(const std::string& key) {
  S3Request request;
  request.method = "DELETE";
  request.key = key;
  const auto reply = client_.send(request);
  if (!reply) return fail(reply.error());
  return {};
}

Result<void> S3Storage::erase(std::string_view id) {
  if (auto done = erase_key(key_of(ObjectKind::metadata, id)); !done) return done;
  return erase_key(key_of(ObjectKind::source, id));
}

Result<void> S3Storage::quarantine(std::string_view id, std::string_view damaged) {
  const auto kept = put_key(client_.location().prefix + "quarantine/" + std::string(id), damaged);
  if (!kept) return fail(kept.error());
  return {};
}

Result<void> S3Storage::erase_job(std::string_view id, std::span<const ObjectKind> kinds) {
  for (const ObjectKind kind : kinds) {
    if (auto done = erase_key(key_of(kind, id)); !done) return done;
  }
  return {};
}

Result<void> S3Storage::erase_old_jobs(std::chrono::seconds age) {
  const std::int64_t newest = std::time(nullptr) - age.count();
  std::string token;
  std::size_t erased = 0;
  for (int pages = 0; pages < kMostJobPages; ++pages) {
    const auto page = list_page(client_, kJobs, "", "", token, kMostListed);
    if (!page) return fail(page.error());
    for (const ListedObject& object : page->objects) {
      if (!is_job_object(object.name)) continue;
      if (object.written == 0 || object.written > newest) continue;
      if (++erased > kMostErased) return {};
      if (auto done = erase_key(client_.location().prefix + kJobs + object.name); !done) {
        return done;
      }
    }
    if (page->next.empty()) break;
    token = page->next;
  }
  return {};
}

Result<void> S3Storage::check() {
  S3Request request;
  request.query = {{"list-type", "2"}, {"max-keys", "1"}};
  request.is_probe = true;
  const auto reply = client_.send(request);
  if (!reply) return fail(reply.error());
  if (reply->status == 404) return no_bucket();
  return {};
}

}  // namespace geodesic::server
