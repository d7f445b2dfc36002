// A store's objects in a local directory.
//
//   DIR/lock                 held (flock) by the one process that uses DIR
//   DIR/objects/ab/<id>      the bytes as uploaded, "ab" being the id's first two digits
//   DIR/meta/ab/<id>.json    the metadata, opaque here
//   DIR/jobs/<id>.job, …     what is kept of jobs, in up to four files each
//   DIR/tmp/                 files being written; emptied at the start
//   DIR/quarantine/<id>      bytes found not to be what was stored
//
// A file is written under a temporary name, synced, renamed, and its directory
// synced; so is each directory into the one above it, the store's own included. The time of its
// last change says when a mesh was last used.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <set>

#include "server/base/durable_file.h"
#include "server/store/object_storage.h"

namespace geodesic::server {

class DirectoryStorage final : public ObjectStorage {
 public:
  // Opens the directory, or creates it. `store_failed` if that cannot be done or
  // another process uses it; this error, for the operator, names the directory.
  [[nodiscard]] static Result<std::unique_ptr<ObjectStorage>> open(
      const std::filesystem::path& directory);

  [[nodiscard]] std::string name() const override { return root_.string(); }
  [[nodiscard]] bool is_shared() const override { return false; }
  [[nodiscard]] Result<std::vector<StoredMesh>> list(std::string_view after,
                                                     std::size_t most) override;
  [[nodiscard]] Result<std::optional<StoredMesh>> find(std::string_view id) override;
  [[nodiscard]] Result<std::optional<std::string>> metadata_version(std::string_view id) override;
  [[nodiscard]] Result<std::string> write(ObjectKind kind, std::string_view id,
                                          std::string_view bytes) override;
  [[nodiscard]] Result<std::optional<StoredObject>> read(ObjectKind kind, std::string_view id,
                                                         std::uint64_t expected_bytes) override;
  [[nodiscard]] Result<std::optional<ObjectFile>> open_source(std::string_view id) override;
  [[nodiscard]] Result<void> erase(std::string_view id) override;
  [[nodiscard]] Result<void> quarantine(std::string_view id, std::string_view damaged) override;
  [[nodiscard]] Result<void> erase_job(std::string_view id,
                                       std::span<const ObjectKind> kinds) override;
  [[nodiscard]] Result<void> erase_old_jobs(std::chrono::seconds age) override;
  void note_use(std::string_view id) override;
  [[nodiscard]] Result<void> check() override;

 private:
  DirectoryStorage(std::filesystem::path directory, File lock)
      : root_(std::move(directory)), lock_(std::move(lock)) {}

  // Creates the folders and empties tmp/.
  [[nodiscard]] Result<void> prepare();
  [[nodiscard]] std::filesystem::path path_of(ObjectKind kind, std::string_view id) const;
  [[nodiscard]] std::filesystem::path temporary_path();

  const std::filesystem::path root_;
  const File lock_;  // holds the flock
  std::mutex directories_;
  std::set<std::filesystem::path> durable_;  // those known to be synced into their parents
  std::atomic<std::uint64_t> temporaries_{0};
};

}  // namespace geodesic::server
