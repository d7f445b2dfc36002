// What a store knows without asking its storage: ids, sizes, the order of use, and
// how much room is left. Of a storage that others use, too, it knows only what it was
// told when it asked, and when that was.
//
// Invariants: `order_` holds each known id once, the most recently used first;
// `bytes_` is the sum of the entries' bytes. An upload reserves its room before it
// writes, so that two at once cannot both take the last of it.
//
// All methods may be called from any thread. Uses are in seconds since 1970; when the storage was
// asked, in seconds of any clock.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "server/store/budget.h"
#include "server/store/object_storage.h"

namespace geodesic::server {

class StoreIndex {
 public:
  // `most`: how many meshes it knows at once; 0 for all of them.
  explicit StoreIndex(const StoreBudget& budget, std::size_t most = 0)
      : budget_(budget), most_(most) {}

  [[nodiscard]] bool contains(std::string_view id) const;
  // The bytes of a known mesh.
  [[nodiscard]] std::optional<std::uint64_t> bytes_of(std::string_view id) const;
  // Up to `limit` ids in ascending order, all greater than `after`.
  [[nodiscard]] std::vector<std::string> list(std::string_view after, std::size_t limit) const;
  [[nodiscard]] std::size_t size() const;

  enum class Use : std::uint8_t { unknown, known, worth_noting };
  // Makes a mesh the most recently used one. `worth_noting` at most once a minute
  // for each mesh: then the storage should remember it.
  Use use(std::string_view id, std::int64_t now);

  // Adds a mesh or changes its size, as the storage has it `now`; a new one is the most recently
  // used. Returns the id of the mesh that is not known any more since there were too many.
  std::optional<std::string> insert(const StoredMesh& mesh, std::int64_t now = 0);

  // Up to `most` meshes that were used since the storage was asked about them, which is `age`
  // seconds ago or longer.
  [[nodiscard]] std::vector<std::string> unconfirmed(std::int64_t now, std::int64_t age,
                                                     std::size_t most) const;
  // Whether it was known.
  bool erase(std::string_view id);

  // Takes `bytes` of the budget for an upload. Nothing to return: taken; give it
  // back with `release`. Otherwise the ids of the meshes to evict before another
  // try. `store_full` when the policy is to refuse or evicting cannot help.
  [[nodiscard]] Result<std::vector<std::string>> reserve(std::uint64_t bytes);
  void release(std::uint64_t bytes);

  // The meshes, bytes and budget; the counts of events are the store's.
  [[nodiscard]] StoreStats stats() const;

 private:
  struct Entry {
    std::uint64_t bytes;
    std::int64_t noted;      // the use that the storage knows of
    std::int64_t confirmed;  // when the storage was last asked
    bool is_used;            // since then
    std::list<const std::string*>::iterator place;
  };
  using Entries = std::map<std::string, Entry, std::less<>>;

  void erase_locked(Entries::iterator entry);

  const StoreBudget budget_;
  const std::size_t most_;
  mutable std::mutex mutex_;
  Entries entries_;
  std::list<const std::string*> order_;  // points to the keys of `entries_`
  std::uint64_t bytes_ = 0;
  std::uint64_t reserved_ = 0;
};

}  // namespace geodesic::server
