// Uploaded files in a local directory, addressed by the SHA-256 of their bytes.
//
//   DIR/lock                 held (flock) by the one process that uses DIR
//   DIR/objects/ab/<id>      the bytes as uploaded, "ab" being the id's first two digits
//   DIR/meta/ab/<id>.json    the metadata, opaque here
//   DIR/tmp/                 files being written; emptied at the start
//   DIR/quarantine/<id>      bytes found not to be what was stored
//
// Durability: a file is written under a temporary name, synced, renamed, and its
// directory synced; first the object, then the metadata. `put` returns only when
// both are down, so what was acknowledged survives a loss of power, and what was
// not acknowledged leaves nothing or an object without metadata, which is listed
// and can be completed by another `put`.
//
// All methods may be called from any thread. No error names a path: they are
// shown to clients; paths go to the log.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"

namespace geodesic::server {

class MeshStore {
 public:
  // Opens or creates the store in `directory`. Reads names only, no file.
  // `store_failed` if it cannot be created or read or another process uses it;
  // this error, meant for the operator, names the directory.
  [[nodiscard]] static Result<std::unique_ptr<MeshStore>> open(
      const std::filesystem::path& directory);
  ~MeshStore();
  MeshStore(const MeshStore&) = delete;
  MeshStore& operator=(const MeshStore&) = delete;

  // Stores `bytes` and `metadata` under `id`, which must be the SHA-256 of the
  // bytes (`digest_mismatch` otherwise; `mesh_unknown` if it is not 64 lower-case
  // hexadecimal digits). Already stored: the bytes are kept, the metadata is
  // replaced. `store_failed` when the disk is full, read-only and so on; then
  // nothing of this put remains.
  [[nodiscard]] Result<void> put(std::string_view id, std::string_view bytes,
                                 std::string_view metadata);

  // Replaces the metadata of a stored mesh; `mesh_unknown`, `store_failed`.
  [[nodiscard]] Result<void> put_metadata(std::string_view id, std::string_view metadata);

  // The bytes as uploaded, their digest checked anew. `mesh_unknown`;
  // `store_failed`; `store_corrupt` when the bytes are not those that were
  // stored: the file is then moved to quarantine/ and the mesh is unknown.
  [[nodiscard]] Result<std::string> get_source(std::string_view id);

  // The metadata, or nothing if there is none; `mesh_unknown`, `store_failed`.
  [[nodiscard]] Result<std::optional<std::string>> get_metadata(std::string_view id);

  // Whether the mesh is known; from memory, no disk.
  [[nodiscard]] bool contains(std::string_view id) const;

  // Forgets the mesh; metadata first, then the object. Idempotent: tells
  // whether it was there. `store_failed`.
  [[nodiscard]] Result<bool> remove(std::string_view id);

  // Up to `limit` ids in ascending order, all greater than `after_id` (empty:
  // from the first); from memory, no disk.
  [[nodiscard]] std::vector<std::string> list(std::string_view after_id, std::size_t limit) const;

  [[nodiscard]] std::size_t size() const;

 private:
  class Impl;
  explicit MeshStore(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// Whether `id` is 64 lower-case hexadecimal digits.
[[nodiscard]] bool is_mesh_id(std::string_view id);

}  // namespace geodesic::server
