// A store's objects in a bucket of S3-compatible object storage, which any number of
// processes may share.
//
//   PREFIXobjects/<id>      the bytes as uploaded
//   PREFIXmeta/<id>.json    the metadata, opaque here
//   PREFIXjobs/<id>.job, …  what is kept of jobs, in up to four objects each
//   PREFIXquarantine/<id>   a copy of bytes found not to be what was stored
//
// S3 writes an object whole or not at all. A version is the object's entity tag. When a
// mesh was last used is not kept there: after a restart, the time of the upload stands
// for it.
//
// Of meshes, nothing but `erase` deletes: few servers delete an object only if it is still the one
// that was looked at, so any other delete might take away what another process has just
// stored and acknowledged.
#pragma once

#include "server/s3/s3_client.h"
#include "server/s3/s3_location.h"
#include "server/store/object_storage.h"

namespace geodesic::server {

class S3Storage final : public ObjectStorage {
 public:
  explicit S3Storage(S3Location location) : client_(std::move(location)) {}

  [[nodiscard]] std::string name() const override { return client_.location().name(); }
  [[nodiscard]] bool is_shared() const override { return true; }
  [[nodiscard]] Result<std::vector<StoredMesh>> list(std::string_view after,
                                                     std::size_t most) override;
  [[nodiscard]] Result<std::optional<StoredMesh>> find(std::string_view id) override;
  [[nodiscard]] Result<std::optional<std::string>> metadata_version(std::string_view id) override;
  [[nodiscard]] Result<std::string> write(ObjectKind kind, std::string_view id,
                                          std::string_view bytes) override;
  [[nodiscard]] Result<std::optional<StoredObject>> read(ObjectKind kind, std::string_view id,
                                                         std::uint64_t expected_bytes) override;
  [[nodiscard]] Result<void> erase(std::string_view id) override;
  [[nodiscard]] Result<void> quarantine(std::string_view id, std::string_view damaged) override;
  [[nodiscard]] Result<void> erase_job(std::string_view id,
                                       std::span<const ObjectKind> kinds) override;
  [[nodiscard]] Result<void> erase_old_jobs(std::chrono::seconds age) override;
  void note_use(std::string_view /*id*/) override {}
  [[nodiscard]] Result<void> check() override;

 private:
  [[nodiscard]] std::string key_of(ObjectKind kind, std::string_view id) const;
  [[nodiscard]] Result<std::string> put_key(const std::string& key, std::string_view bytes);
  [[nodiscard]] Result<void> erase_key(const std::string& key);

  S3Client client_;
};

}  // namespace geodesic::server
