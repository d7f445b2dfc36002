// Uploaded files, addressed by the SHA-256 of their bytes, with a description each.
// What one file gives when it is read with other options than the defaults is another
// mesh: its id has the options' digest behind that of the bytes, and its own copy.
//
// What is kept where is the storage's business (object_storage.h); here is what
// holds for any: bytes are checked against their digest whenever they are read, a
// damaged mesh goes to quarantine and is never served, and a budget is kept.
//
// A put writes the source, then the metadata, and returns only when both will
// survive a crash. So what was acknowledged is there whole afterwards, and what
// was not acknowledged leaves nothing or a whole source without metadata, which
// is listed and can be completed by another `put` or by `put_metadata`.
//
// Several processes may share a storage. Then a process deletes a mesh only because it
// was asked to: never because a write of its own failed, or because it has read damaged
// bytes, for another one may have stored the same mesh meanwhile and said so. A removal takes the
// metadata first and the source last, the reverse of a put. So a source that is there after both
// has its metadata, whatever the order in which their requests arrived. What is there already is
// taken to be what is being put only if this process has written or read that very version of it;
// else it is written again.
//
// Of a shared storage a process knows the meshes that it was asked about. It believes what it
// knows for half a minute, and what it uses longer than that it asks about again, beside the
// queries. So a mesh that another process has removed or renamed is seen so within 40 seconds, if
// no more than some 6,000 meshes are in use. As long as the storage does not answer, what is known
// goes on being served. Lists are those of the storage, at every question. Nobody has a budget
// there, for nobody can count for all.
//
// All methods may be called from any thread. No error names a path or a host:
// they are shown to clients; the log has them. Any method that reaches the storage
// may fail with its errors: `store_failed`, `store_full`, `store_unavailable`.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "server/base/lru_cache.h"
#include "server/base/reply_file.h"
#include "server/base/service_codes.h"
#include "server/store/budget.h"
#include "server/store/index.h"
#include "server/store/mesh_id.h"
#include "server/store/object_storage.h"
#include "server/store/verified_files.h"

namespace geodesic::server {

// The error that names no mesh: nothing of that id is stored.
[[nodiscard]] inline tl::unexpected<Error> unknown_mesh() {
  return fail(ServiceCode::mesh_unknown, "no mesh of this id is stored");
}

class MeshStore {
 public:
  // Takes over a storage: lists what is in it, or where others use it only asks whether it works.
  // `bad_syntax` where a storage that others use is given a budget.
  [[nodiscard]] static Result<std::unique_ptr<MeshStore>> open(
      std::unique_ptr<ObjectStorage> storage, const StoreBudget& budget);

  // Stores `bytes` and `metadata` under `id`, which must begin with the SHA-256 of
  // the bytes (`digest_mismatch` otherwise; `mesh_unknown` if it is no id). Already stored: the
  // bytes are kept if they are known to be whole, the metadata is replaced. May evict other
  // meshes. `store_full` over the budget. After an error nothing of this put remains, as far
  // as the storage can be reached; in a shared storage, what was written before the error stays.
  [[nodiscard]] Result<void> put(std::string_view id, std::string_view bytes,
                                 std::string_view metadata);

  // Replaces the metadata of a stored mesh; `mesh_unknown`.
  [[nodiscard]] Result<void> put_metadata(std::string_view id, std::string_view metadata);

  // The bytes as uploaded, their digest checked anew. `mesh_unknown`;
  // `store_corrupt` when the bytes are not those that were stored: they are then
  // in quarantine and the mesh is unknown. `stop`: asked every few milliseconds while the digest is
  // computed; `cancelled`.
  [[nodiscard]] Result<std::string> get_source(
      std::string_view id, const std::function<bool()>& stop = [] { return false; });

  // The same as a file to be sent as it is read; null where the storage has no files, or the
  // bytes are to be had by `get_source` only, which also says what is wrong with them. Their digest
  // is checked the first time, and again once the file has been touched. `stop`: asked
  // every few milliseconds meanwhile; `cancelled`.
  [[nodiscard]] Result<std::shared_ptr<const ReplyFile>> open_source(
      std::string_view id, const std::function<bool()>& stop);

  // The metadata, or nothing if there is none; `mesh_unknown`. Kept in memory, a
  // limited amount of it.
  [[nodiscard]] Result<std::optional<std::string>> get_metadata(std::string_view id);

  // The same, but where other processes use the storage it is always read: they may have written
  // another one a moment ago.
  [[nodiscard]] Result<std::optional<std::string>> get_metadata_afresh(std::string_view id);

  // Whether the mesh is known; from memory.
  [[nodiscard]] bool contains(std::string_view id) const;

  // Whether the mesh is known, and that it is used now, which keeps it from being
  // evicted. From memory, unless it is not there and other processes use the same
  // storage: then that is asked.
  [[nodiscard]] Result<bool> use(std::string_view id);

  // The same, but where other processes use the storage it is always asked.
  [[nodiscard]] Result<bool> is_stored(std::string_view id);

  // Whether the bytes of a mesh that `is_stored` has just found are surely those that it
  // was stored with. If not, putting them again is the way to be sure.
  [[nodiscard]] bool is_surely_whole(std::string_view id) const;

  // Whether the mesh was found damaged, and neither put again nor removed since.
  // Who still has it in memory may go on with that.
  [[nodiscard]] bool is_damaged(std::string_view id) const;

  // Forgets the mesh. Idempotent: tells whether it was there.
  [[nodiscard]] Result<bool> remove(std::string_view id);

  // Up to `limit` ids in ascending order, all greater than `after_id` (empty:
  // from the first); from memory, unless other processes use the storage.
  [[nodiscard]] Result<std::vector<std::string>> list(std::string_view after_id, std::size_t limit);

  // Of a shared storage: the meshes that this process knows.
  [[nodiscard]] std::size_t size() const { return index_.size(); }
  [[nodiscard]] StoreStats stats() const;
  // For what is kept there besides meshes.
  [[nodiscard]] ObjectStorage& storage() { return *storage_; }

  // Asks a shared storage about the meshes that were used since it was last asked, if that is
  // `age` ago or longer, those used last first, and no more than 1,000 of them: what other
  // processes have done to them shows. The last error, if there was one: other meshes than that one
  // are asked about all the same, unless it is `store_unavailable`.
  Result<void> confirm_used(std::chrono::seconds age);

  // Tries the storage, and confirms what was used.
  // Returns, and remembers for `health`, whether it works; `store_unavailable`.
  Result<void> check();
  // The last check's outcome; from memory. Before the first: well.
  [[nodiscard]] Result<void> health() const;

 private:
  class Room;

  MeshStore(std::unique_ptr<ObjectStorage> storage, const StoreBudget& budget);
  [[nodiscard]] Result<Room> make_room(std::uint64_t bytes);
  [[nodiscard]] Result<void> write_both(std::string_view id, std::string_view bytes,
                                        std::string_view metadata);
  [[nodiscard]] Result<std::string> read_again_or_quarantine(std::string_view id);
  [[nodiscard]] Result<bool> ask_storage(std::string_view id);
  // Remembers that the source of that version has the right bytes.
  void note_whole(std::string_view id, std::string version);
  // Whether a mesh is what was found damaged, unchanged since.
  [[nodiscard]] bool is_what_was_damaged(const StoredMesh& mesh) const;
  // Remembers what the storage has.
  void learn(const StoredMesh& mesh);
  Result<void> confirm(const std::string& id);
  Result<bool> erase(std::string_view id);
  // Forgets a mesh that is not in the storage.
  void forget(std::string_view id);
  [[nodiscard]] std::mutex& stripe(std::string_view id);
  // Counts what the storage failed to do.
  template <class T>
  Result<T> counted(Result<T> result);

  const std::unique_ptr<ObjectStorage> storage_;
  StoreIndex index_;
  LruCache<StoredObject> metadata_;
  // Changes to one mesh exclude each other; those to others mostly do not.
  std::array<std::mutex, 64> stripes_;
  VerifiedFiles verified_;
  mutable std::mutex state_mutex_;  // of the next three
  Result<void> health_;
  using Versions = std::map<std::string, std::string, std::less<>>;  // by id
  Versions damaged_;
  Versions whole_;  // of known meshes in a shared storage
  std::atomic<std::uint64_t> removals_{0};
  std::atomic<std::uint64_t> evictions_{0};
  std::atomic<std::uint64_t> refusals_{0};
  std::atomic<std::uint64_t> corrupt_{0};
  std::atomic<std::uint64_t> failures_{0};
};

}  // namespace geodesic::server
