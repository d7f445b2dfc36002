// Where a store keeps its bytes: the small interface with two implementations, a
// local directory and S3-compatible object storage.
//
// An object is a mesh's source or its metadata, under the mesh's id, or a part of what is kept of a
// job, under the job's. A write is atomic and durable: once it has returned, the object is there
// whole, after a crash or a loss of power too; until then it is there whole or not at all.
//
// All methods may be called from any thread. Ids are valid ones. Errors:
// `store_full` when there is no room, `store_unavailable` when trying again later
// may help, `store_failed` otherwise. No error names a path or a host, for they
// are shown to clients: the log does.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "server/base/durable_file.h"

namespace geodesic::server {

enum class ObjectKind : std::uint8_t {
  source,
  metadata,
  job,        // its question, without a large body (job_records.h)
  job_body,   // of its request
  job_end,    // its reply, without a large body
  job_reply,  // the reply's body
};

inline constexpr std::array kJobObjects{ObjectKind::job, ObjectKind::job_body, ObjectKind::job_end,
                                        ObjectKind::job_reply};
[[nodiscard]] constexpr bool is_of_job(ObjectKind kind) {
  return kind != ObjectKind::source && kind != ObjectKind::metadata;
}
// No `job` and no `job_end` is larger.
inline constexpr std::uint64_t kMostJobBytes = std::uint64_t{256} << 10;

// What an object of a job is called among all of them.
[[nodiscard]] std::string name_of_job_object(ObjectKind kind, std::string_view id);
// Whether it may be called so. Others may keep things of their own beside ours.
[[nodiscard]] bool is_job_object(std::string_view name);

struct StoredMesh {
  std::string id;
  std::uint64_t bytes = 0;   // what its objects take, as far as a list sees
  std::int64_t used = 0;     // when it was last used, or written: seconds since 1970
  std::string version = {};  // of its source, as `StoredObject` has it
};

struct StoredObject {
  std::string bytes;
  // Changes whenever the object is written with other bytes. Empty where nobody else
  // writes, and where the storage does not tell.
  std::string version;
};

// An object as an open file, which stays whole when the object is removed or written anew.
struct ObjectFile {
  File file;
  std::uint64_t bytes = 0;
  std::string state;  // differs from before once anything has been done to the file
};

class ObjectStorage {
 public:
  ObjectStorage() = default;
  virtual ~ObjectStorage() = default;
  ObjectStorage(const ObjectStorage&) = delete;
  ObjectStorage& operator=(const ObjectStorage&) = delete;

  // For the operator: the directory or the URL, without secrets.
  [[nodiscard]] virtual std::string name() const = 0;

  // Whether other processes may change what is there.
  [[nodiscard]] virtual bool is_shared() const = 0;

  // The meshes whose source is there, up to `most` of them, in ascending order of their ids, which
  // are all greater than `after`; reads no contents.
  [[nodiscard]] virtual Result<std::vector<StoredMesh>> list(std::string_view after,
                                                             std::size_t most) = 0;

  // One mesh as a list would show it; nothing if it is not there.
  [[nodiscard]] virtual Result<std::optional<StoredMesh>> find(std::string_view id) = 0;

  // The version of a mesh's metadata, without its bytes; nothing if they are not there.
  [[nodiscard]] virtual Result<std::optional<std::string>> metadata_version(
      std::string_view id) = 0;

  // The version of what was written. After an error it may be there all the same.
  [[nodiscard]] virtual Result<std::string> write(ObjectKind kind, std::string_view id,
                                                  std::string_view bytes) = 0;

  // All of the bytes, unchecked; nothing if there is no such object. `expected_bytes`
  // is about how many there should be, 0 where that is not known. Of a job it is the most that
  // there may be: who else may write to the storage is not to fill the memory, so what is larger is
  // logged, and is as if it were not there.
  [[nodiscard]] virtual Result<std::optional<StoredObject>> read(ObjectKind kind,
                                                                 std::string_view id,
                                                                 std::uint64_t expected_bytes) = 0;

  // The same as a file, where the storage has files: to be read piece by piece. Nothing where it
  // has none, or there is no such object.
  [[nodiscard]] virtual Result<std::optional<ObjectFile>> open_source(std::string_view /*id*/) {
    return std::nullopt;
  }

  // Removes the metadata, then the source; durably. It may be gone already.
  [[nodiscard]] virtual Result<void> erase(std::string_view id) = 0;

  // Keeps the bytes of a damaged source, `damaged`, for the operator. A storage that no
  // other process uses moves them out of the way and removes their metadata. A shared one
  // removes nothing: another process may have put the mesh again meanwhile. The mesh may
  // be gone already.
  [[nodiscard]] virtual Result<void> quarantine(std::string_view id, std::string_view damaged) = 0;

  // Removes objects of a job. They may be gone already.
  [[nodiscard]] virtual Result<void> erase_job(std::string_view id,
                                               std::span<const ObjectKind> kinds) = 0;

  // Removes what is kept of jobs and was written so long ago; not more of it than takes some
  // seconds.
  [[nodiscard]] virtual Result<void> erase_old_jobs(std::chrono::seconds age) = 0;

  // Remembers, if it can, that the mesh was used now.
  virtual void note_use(std::string_view id) = 0;

  // Whether reading and writing would work now. Cheap; seconds at most.
  [[nodiscard]] virtual Result<void> check() = 0;
};

}  // namespace geodesic::server
