#include "server/store/index.h"

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
  entry.is_used = true;
  if (now - entry.noted < kSecondsBetweenNotes) return Use::known;
  entry.noted = now;
  return Use::worth_noting;
}

std::optional<std::string> StoreIndex::insert(const StoredMesh& mesh, std::int64_t now) {
  const std::lock_guard lock(mutex_);
  const auto [it, is_new] = entries_.try_emplace(mesh.id);
  Entry& entry = it->second;
  if (is_new) {
    entry.place = order_.insert(order_.begin(), &it->first);
    entry.noted = mesh.used;
  } else {
    bytes_ -= entry.bytes;
  }
  entry.bytes = mesh.bytes;
  entry.confirmed = now;
  entry.is_used = false;
  bytes_ += mesh.bytes;
  if (most_ == 0 || entries_.size() <= most_) return std::nullopt;
  std::string forgotten = *order_.back();
  erase_locked(entries_.find(forgotten));
  return forgotten;
}

std::vector<std::string> StoreIndex::unconfirmed(std::int64_t now, std::int64_t age,
                                                 std::size_t most) const {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> ids;
  for (const std::string* const id : order_) {
    if (ids.size() == most) break;
    const Entry& entry = entries_.find(*id)->second;
    if (entry.is_used && now - entry.confirmed >= age) ids.push_back(*id);
  }
  return ids;
}

bool StoreIndex::erase(std::string_view id) {
  const std::lock_guard lock(mutex_);
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

StoreStats StoreIndex::stats() const {
  const std::lock_guard lock(mutex_);
  StoreStats stats;
  stats.meshes = entries_.size();
  stats.bytes = bytes_;
  stats.max_bytes = budget_.max_bytes;
  return stats;
}

}  // namespace geodesic::server
