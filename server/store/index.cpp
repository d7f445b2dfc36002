#include "server/store/index.h"

#include <algorithm>
#include <iterator>
#include <tuple>
#include <utility>

#include "server/base/service_codes.h"

namespace geodesic::server {

namespace {
constexpr std::int64_t kSecondsBetweenNotes = 60;
}  // namespace

bool StoreIndex::contains(std::string_view id) const {
  const std::lock_guard lock(mutex_);
  return entries_.find(id) != entries_.end();
}

std::optional<std::uint64_t> StoreIndex::bytes_of(std::string_view id) const {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(id);
  if (found == entries_.end()) return std::nullopt;
  return found->second.bytes;
}

std::vector<std::string> StoreIndex::list(std::string_view after, std::size_t limit) const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> page;
  for (auto it = entries_.upper_bound(after); it != entries_.end() && page.size() < limit; ++it) {
    page.push_back(it->first);
  }
  return page;
}

std::size_t StoreIndex::size() const {
  const std::lock_guard lock(mutex_);
  return entries_.size();
}

StoreIndex::Use StoreIndex::use(std::string_view id, std::int64_t now) {
  const std::lock_guard lock(mutex_);
  const auto found = entries_.find(id);
  if (found == entries_.end()) return Use::unknown;
  Entry& entry = found->second;
  order_.splice(order_.begin(), order_, entry.place);
  if (now - entry.noted < kSecondsBetweenNotes) return Use::known;
  entry.noted = now;
  return Use::worth_noting;
}

void StoreIndex::insert(const StoredMesh& mesh) {
  const std::lock_guard lock(mutex_);
  insert_locked(mesh);
}

void StoreIndex::insert_locked(const StoredMesh& mesh) {
  const auto [it, is_new] = entries_.try_emplace(mesh.id);
  Entry& entry = it->second;
  if (is_new) {
    entry.place = order_.insert(order_.begin(), &it->first);
    entry.noted = mesh.used;
  } else {
    bytes_ -= entry.bytes;
  }
  entry.bytes = mesh.bytes;
  entry.generation = generation_;
  bytes_ += mesh.bytes;
  erased_.erase(mesh.id);
}

bool StoreIndex::erase(std::string_view id) {
  const std::lock_guard lock(mutex_);
  // Remembered even if it was not known: the scan under way may have seen it.
  if (scanning_) erased_.emplace(id);
  const auto found = entries_.find(id);
  if (found == entries_.end()) return false;
  erase_locked(found);
  return true;
}

void StoreIndex::erase_locked(Entries::iterator entry) {
  bytes_ -= entry->second.bytes;
  order_.erase(entry->second.place);
  entries_.erase(entry);
}

Result<std::vector<std::string>> StoreIndex::reserve(std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> victims;
  const std::uint64_t wanted = bytes_ + reserved_ + bytes;
  if (budget_.max_bytes == 0 || wanted <= budget_.max_bytes) {
    reserved_ += bytes;
    return victims;
  }
  if (budget_.when_full == WhenFull::evict && reserved_ + bytes <= budget_.max_bytes) {
    std::uint64_t left = wanted;
    for (auto it = order_.rbegin(); it != order_.rend() && left > budget_.max_bytes; ++it) {
      victims.push_back(**it);
      left -= entries_.find(**it)->second.bytes;
    }
    return victims;
  }
  return fail_limit(ServiceCode::store_full, "the store has no room for this mesh",
                    budget_.max_bytes, wanted);
}

void StoreIndex::release(std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  reserved_ -= bytes;
}

void StoreIndex::begin_scan() {
  const std::lock_guard lock(mutex_);
  ++generation_;
  scanning_ = true;
}

std::vector<std::string> StoreIndex::end_scan(std::optional<std::vector<StoredMesh>> found) {
  std::map<std::string_view, const StoredMesh*> by_id;
  if (found) {
    // Those used longest ago first: each one added becomes the most recently used.
    std::sort(found->begin(), found->end(), [](const StoredMesh& a, const StoredMesh& b) {
      return std::tie(a.used, a.id) < std::tie(b.used, b.id);
    });
    for (const StoredMesh& mesh : *found) by_id.emplace(mesh.id, &mesh);
  }

  const std::lock_guard lock(mutex_);
  std::vector<std::string> gone;
  if (found) {
    for (auto it = entries_.begin(); it != entries_.end();) {
      const auto next = std::next(it);
      if (it->second.generation < generation_ && !by_id.contains(it->first)) {
        gone.push_back(it->first);
        erase_locked(it);
      }
      it = next;
    }
    for (const StoredMesh& mesh : *found) {
      const bool settled = erased_.contains(mesh.id) || entries_.contains(mesh.id);
      if (!settled) insert_locked(mesh);
    }
  }
  erased_.clear();
  scanning_ = false;
  return gone;
}

StoreStats StoreIndex::stats() const {
  const std::lock_guard lock(mutex_);
  StoreStats stats;
  stats.meshes = entries_.size();
  stats.bytes = bytes_;
  stats.max_bytes = budget_.max_bytes;
  return stats;
}

}  // namespace geodesic::server
