// What a store knows without asking its storage: ids, sizes, the order of use, and
// how much room is left.
//
// Invariants: `order_` holds each known id once, the most recently used first;
// `bytes_` is the sum of the entries' bytes. An upload reserves its room before it
// writes, so that two at once cannot both take the last of it.
//
// All methods may be called from any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "server/store/budget.h"
#include "server/store/object_storage.h"

namespace geodesic::server {

class StoreIndex {
 public:
  explicit StoreIndex(const StoreBudget& budget) : budget_(budget) {}

  [[nodiscard]] bool contains(std::string_view id) const;
  // The bytes of a known mesh.
  [[nodiscard]] std::optional<std::uint64_t> bytes_of(std::string_view id) const;
  // Up to `limit` ids in ascending order, all greater than `after`.
  [[nodiscard]] std::vector<std::string> list(std::string_view after, std::size_t limit) const;
  [[nodiscard]] std::size_t size() const;

  enum class Use : std::uint8_t { unknown, known, worth_noting };
  // Makes a mesh the most recently used one. `worth_noting` at most once a minute
  // for each mesh: then the storage should remember it. `now` in seconds since 1970.
  Use use(std::string_view id, std::int64_t now);

  // Adds a mesh or changes its size; a new one is the most recently used.
  void insert(const StoredMesh& mesh);
  // Whether it was known.
  bool erase(std::string_view id);

  // Takes `bytes` of the budget for an upload. Nothing to return: taken; give it
  // back with `release`. Otherwise the ids of the meshes to evict before another
  // try. `store_full` when the policy is to refuse or evicting cannot help.
  [[nodiscard]] Result<std::vector<std::string>> reserve(std::uint64_t bytes);
  void release(std::uint64_t bytes);

  // A scan of the storage, one at a time: `begin_scan`, then `end_scan` with what
  // was found, which keeps what changed meanwhile and returns the ids that are
  // gone; or with nothing, when the scan failed.
  void begin_scan();
  std::vector<std::string> end_scan(std::optional<std::vector<StoredMesh>> found);

  // The meshes, bytes and budget; the counts of events are the store's.
  [[nodiscard]] StoreStats stats() const;

 private:
  struct Entry {
    std::uint64_t bytes;
    std::int64_t noted;        // the use that the storage knows of
    std::uint64_t generation;  // in which it last changed
    std::list<const std::string*>::iterator place;
  };
  using Entries = std::map<std::string, Entry, std::less<>>;

  void insert_locked(const StoredMesh& mesh);
  void erase_locked(Entries::iterator entry);

  const StoreBudget budget_;
  mutable std::mutex mutex_;
  Entries entries_;
  std::list<const std::string*> order_;  // points to the keys of `entries_`
  std::uint64_t bytes_ = 0;
  std::uint64_t reserved_ = 0;
  std::uint64_t generation_ = 0;  // counts scans begun
  bool scanning_ = false;
  std::set<std::string, std::less<>> erased_;  // since the scan under way began
};

}  // namespace geodesic::server
