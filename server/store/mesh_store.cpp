#include "server/store/mesh_store.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <ctime>
#include <future>
#include <limits>
#include <system_error>
#include <tuple>
#include <utility>

#include "proto/wire/input_codes.h"
#include "server/base/service_codes.h"
#include "server/base/sha256.h"

namespace geodesic::server {

namespace {

constexpr std::uint64_t kMetadataCacheBytes = std::uint64_t{32} << 20;
// Descriptions have no budget of their own; this is far above any real one.
constexpr std::uint64_t kExpectedMetadataBytes = std::uint64_t{64} << 20;
// How long what a shared storage said is believed.
constexpr std::chrono::seconds kBelieved(30);
// Of a shared storage: how many meshes are known at once, and how many are asked about again at a
// time, by how many requests at once.
constexpr std::size_t kMostKnown = 100'000;
constexpr std::size_t kMostConfirmed = 1000;
constexpr std::size_t kConfirmedAtOnce = 8;

std::int64_t seconds_now() { return static_cast<std::int64_t>(std::time(nullptr)); }

// By a clock that nobody sets: for how long something has been believed.
std::int64_t steady_seconds() {
  using namespace std::chrono;
  return duration_cast<seconds>(steady_clock::now().time_since_epoch()).count();
}

}  // namespace

// Room reserved for an upload under way; given back at the end, when what was
// written counts by itself.
class MeshStore::Room {
 public:
  Room(StoreIndex& index, std::uint64_t bytes) : index_(&index), bytes_(bytes) {}
  Room(Room&& other) noexcept
      : index_(std::exchange(other.index_, nullptr)), bytes_(other.bytes_) {}
  Room& operator=(Room&&) = delete;
  ~Room() {
    if (index_ != nullptr) index_->release(bytes_);
  }

 private:
  StoreIndex* index_;
  std::uint64_t bytes_;
};

MeshStore::MeshStore(std::unique_ptr<ObjectStorage> storage, const StoreBudget& budget)
    : storage_(std::move(storage)),
      index_(budget, storage_->is_shared() ? kMostKnown : 0),
      metadata_(kMetadataCacheBytes,
                [](const StoredObject& kept) { return kept.bytes.size() + 256; }) {}

Result<std::unique_ptr<MeshStore>> MeshStore::open(std::unique_ptr<ObjectStorage> storage,
                                                   const StoreBudget& budget) {
  std::unique_ptr<MeshStore> store(new MeshStore(std::move(storage), budget));
  // For the operator, who needs to know which.
  const auto cannot = [&](ErrorCode code, std::string_view why) {
    return fail(code, fmt::format("cannot use {} as the store: {}", store->storage_->name(), why));
  };
  if (store->storage_->is_shared()) {
    if (budget.max_bytes != 0) {
      return cannot(InputCode::bad_syntax,
                    "--store-max-bytes is for a directory, which one server uses alone; "
                    "give the bucket a quota instead");
    }
    const auto works = store->storage_->check();
    if (!works) return cannot(works.error().code, works.error().detail);
    return store;
  }
  auto found = store->storage_->list("", std::numeric_limits<std::size_t>::max());
  if (!found) return cannot(found.error().code, found.error().detail);
  // Those used longest ago first: each one added becomes the most recently used.
  std::sort(found->begin(), found->end(), [](const StoredMesh& a, const StoredMesh& b) {
    return std::tie(a.used, a.id) < std::tie(b.used, b.id);
  });
  for (const StoredMesh& mesh : *found) store->learn(mesh);
  return store;
}

void MeshStore::learn(const StoredMesh& mesh) {
  const auto dropped = index_.insert(mesh, steady_seconds());
  if (dropped) forget(*dropped);
}

template <class T>
Result<T> MeshStore::counted(Result<T> result) {
  if (!result) ++failures_;
  return result;
}

Result<void> MeshStore::put(std::string_view id, std::string_view bytes,
                            std::string_view metadata) {
  if (!is_mesh_id(id)) return unknown_mesh();
  if (sha256_hex(bytes) != source_digest(id)) {
    return fail(ServiceCode::digest_mismatch, "the bytes do not have the given SHA-256");
  }
  auto stored = is_stored(id);
  if (!stored) return fail(std::move(stored.error()));
  if (*stored && is_surely_whole(id)) {
    auto replaced = put_metadata(id, metadata);
    // Somebody may have removed it meanwhile: then it is put anew.
    if (replaced || replaced.error().code != ServiceCode::mesh_unknown) return replaced;
    stored = false;
  }
  std::optional<Room> room;  // what is there has its own
  if (!*stored) {
    auto made = make_room(bytes.size() + metadata.size());
    if (!made) return fail(std::move(made.error()));
    room.emplace(std::move(*made));
  }
  const std::lock_guard lock(stripe(id));
  // Somebody else may have put it meanwhile: then the same once more, in its place.
  const bool is_new = !index_.contains(id);
  if (auto written = write_both(id, bytes, metadata); !written) {
    // Nothing of a failed put may remain; what an earlier one stored stays, and so does
    // what another process may have stored.
    if (is_new && !storage_->is_shared()) (void)storage_->erase(id);
    return written;
  }
  learn({std::string(id), bytes.size() + metadata.size(), seconds_now()});
  metadata_.erase(std::string(id));
  const std::lock_guard state(state_mutex_);
  damaged_.erase(std::string(id));
  return {};
}

Result<void> MeshStore::write_both(std::string_view id, std::string_view bytes,
                                   std::string_view metadata) {
  auto source = counted(storage_->write(ObjectKind::source, id, bytes));
  if (!source) return fail(std::move(source.error()));
  note_whole(id, std::move(*source));
  auto description = counted(storage_->write(ObjectKind::metadata, id, metadata));
  if (!description) return fail(std::move(description.error()));
  return {};
}

Result<MeshStore::Room> MeshStore::make_room(std::uint64_t bytes) {
  while (true) {
    auto victims = index_.reserve(bytes);
    if (!victims) {
      ++refusals_;
      return fail(std::move(victims.error()));
    }
    if (victims->empty()) return Room(index_, bytes);
    for (const std::string& victim : *victims) {
      const auto erased = erase(victim);
      if (!erased) return fail(erased.error());
      if (!*erased) continue;  // another upload has evicted it
      ++evictions_;
      spdlog::info("store: {} was evicted to make room", victim);
    }
  }
}

Result<void> MeshStore::put_metadata(std::string_view id, std::string_view metadata) {
  if (!is_mesh_id(id)) return unknown_mesh();
  const std::lock_guard lock(stripe(id));
  if (!index_.contains(id)) return unknown_mesh();
  auto written = counted(storage_->write(ObjectKind::metadata, id, metadata));
  if (!written) return fail(std::move(written.error()));
  metadata_.erase(std::string(id));
  const auto now = storage_->find(id);
  if (now && !*now) {  // another process has removed it since
    forget(id);
    return unknown_mesh();
  }
  if (now) learn(**now);
  return {};
}

Result<std::string> MeshStore::get_source(std::string_view id, const std::function<bool()>& stop) {
  const auto known = use(id);
  if (!known) return fail(known.error());
  if (!*known) return unknown_mesh();
  auto bytes = counted(storage_->read(ObjectKind::source, id, index_.bytes_of(id).value_or(0)));
  if (!bytes) return fail(std::move(bytes.error()));
  if (*bytes) {
    const auto digest = sha256_hex((*bytes)->bytes, stop);
    if (!digest) return fail(ErrorCode::cancelled, "the client is gone");
    if (*digest == source_digest(id)) {
      note_whole(id, std::move((*bytes)->version));
      return std::move((*bytes)->bytes);
    }
  }
  return read_again_or_quarantine(id);
}

Result<std::shared_ptr<const ReplyFile>> MeshStore::open_source(std::string_view id,
                                                                const std::function<bool()>& stop) {
  const auto known = use(id);
  if (!known) return fail(known.error());
  if (!*known) return unknown_mesh();
  auto opened = counted(storage_->open_source(id));
  if (!opened || !*opened) return nullptr;
  const std::string state = std::move((*opened)->state);
  const auto file = std::make_shared<const ReplyFile>(std::move((*opened)->file), (*opened)->bytes);
  const auto is_whole = verified_.is_whole(*file, id, state, stop);
  if (!is_whole) return fail(is_whole.error());
  return *is_whole ? file : nullptr;
}

// Once more, alone with the mesh: it may have been removed or put since, or the
// bytes may have been damaged on their way here.
Result<std::string> MeshStore::read_again_or_quarantine(std::string_view id) {
  const std::lock_guard lock(stripe(id));
  if (!index_.contains(id)) return unknown_mesh();
  auto bytes = counted(storage_->read(ObjectKind::source, id, index_.bytes_of(id).value_or(0)));
  if (!bytes) return fail(std::move(bytes.error()));
  if (*bytes && sha256_hex((*bytes)->bytes) == source_digest(id)) {
    note_whole(id, std::move((*bytes)->version));
    return std::move((*bytes)->bytes);
  }
  if (!*bytes && storage_->is_shared()) {  // another process has removed it
    forget(id);
    return unknown_mesh();
  }
  const StoredObject damaged = *bytes ? std::move(**bytes) : StoredObject{};
  // Out of the index whatever happens, so that it is not served and is logged once.
  forget(id);
  ++corrupt_;
  {
    const std::lock_guard state(state_mutex_);
    damaged_.insert_or_assign(std::string(id), damaged.version);
  }
  const bool moved = static_cast<bool>(counted(storage_->quarantine(id, damaged.bytes)));
  spdlog::error("store: {} is {}; {}", id, *bytes ? "not what was stored" : "missing",
                moved ? "it is in quarantine now" : "it could not be put into quarantine");
  return fail(InputCode::store_corrupt, "the stored bytes are damaged; upload the mesh again");
}

Result<std::optional<std::string>> MeshStore::get_metadata(std::string_view id) {
  const auto known = use(id);
  if (!known) return fail(known.error());
  if (!*known) return unknown_mesh();
  // What is not there is not kept: it may come.
  const auto metadata = metadata_.get_or_create(
      std::string(id), [&]() -> Result<std::shared_ptr<const StoredObject>> {
        auto read = counted(storage_->read(ObjectKind::metadata, id, kExpectedMetadataBytes));
        if (!read) return fail(std::move(read.error()));
        if (!*read) return unknown_mesh();
        return std::make_shared<const StoredObject>(std::move(**read));
      });
  if (metadata) return metadata->value->bytes;
  if (metadata.error().code == ServiceCode::mesh_unknown) return std::nullopt;
  return fail(metadata.error());
}

Result<std::optional<std::string>> MeshStore::get_metadata_afresh(std::string_view id) {
  if (storage_->is_shared()) metadata_.erase(std::string(id));
  return get_metadata(id);
}

bool MeshStore::contains(std::string_view id) const { return index_.contains(id); }

Result<bool> MeshStore::use(std::string_view id) {
  if (!is_mesh_id(id)) return false;
  switch (index_.use(id, seconds_now())) {
    case StoreIndex::Use::worth_noting:
      storage_->note_use(id);
      return true;
    case StoreIndex::Use::known:
      return true;
    case StoreIndex::Use::unknown:
      break;
  }
  return storage_->is_shared() ? ask_storage(id) : false;
}

Result<bool> MeshStore::is_stored(std::string_view id) {
  if (!storage_->is_shared() || !is_mesh_id(id)) return use(id);
  return ask_storage(id);
}

Result<bool> MeshStore::ask_storage(std::string_view id) {
  const std::lock_guard lock(stripe(id));
  auto found = counted(storage_->find(id));
  if (!found) return fail(std::move(found.error()));
  if (!*found || is_what_was_damaged(**found)) {
    forget(id);
    return false;
  }
  learn(**found);
  const std::lock_guard lock_state(state_mutex_);
  damaged_.erase(std::string(id));
  const auto whole = whole_.find(id);
  if (whole != whole_.end() && whole->second != (*found)->version) whole_.erase(whole);
  return true;
}

void MeshStore::note_whole(std::string_view id, std::string version) {
  if (version.empty()) return;
  const std::lock_guard lock(state_mutex_);
  whole_.insert_or_assign(std::string(id), std::move(version));
}

bool MeshStore::is_surely_whole(std::string_view id) const {
  // In a storage of its own, damage shows when the mesh is read.
  if (!storage_->is_shared()) return true;
  const std::lock_guard lock(state_mutex_);
  return whole_.contains(id);
}

bool MeshStore::is_what_was_damaged(const StoredMesh& mesh) const {
  if (mesh.version.empty()) return false;
  const std::lock_guard lock(state_mutex_);
  const auto found = damaged_.find(mesh.id);
  return found != damaged_.end() && found->second == mesh.version;
}

bool MeshStore::is_damaged(std::string_view id) const {
  const std::lock_guard lock(state_mutex_);
  return damaged_.contains(id);
}

Result<bool> MeshStore::remove(std::string_view id) {
  if (!is_mesh_id(id)) return false;
  if (const auto known = use(id); !known) return known;
  return erase(id);
}

Result<bool> MeshStore::erase(std::string_view id) {
  const std::lock_guard lock(stripe(id));
  ++removals_;
  if (auto erased = counted(storage_->erase(id)); !erased) return fail(std::move(erased.error()));
  const bool known = index_.erase(id);
  forget(id);
  const std::lock_guard state(state_mutex_);
  damaged_.erase(std::string(id));
  return known;
}

void MeshStore::forget(std::string_view id) {
  index_.erase(id);
  metadata_.erase(std::string(id));
  const std::lock_guard lock(state_mutex_);
  whole_.erase(std::string(id));
}

Result<std::vector<std::string>> MeshStore::list(std::string_view after_id, std::size_t limit) {
  if (!storage_->is_shared()) return index_.list(after_id, limit);
  const std::uint64_t removals = removals_;
  auto found = counted(storage_->list(after_id, limit));
  if (!found) return fail(std::move(found.error()));
  std::vector<std::string> ids;
  for (const StoredMesh& mesh : *found) {
    if (is_what_was_damaged(mesh)) continue;
    ids.push_back(mesh.id);
    // Whoever lists goes on to describe, and what is known need not be asked for each by itself.
    // But what this process has removed meanwhile, or is about to, must not be known again.
    const std::unique_lock lock(stripe(mesh.id), std::try_to_lock);
    if (lock && !index_.contains(mesh.id) && removals_ == removals) learn(mesh);
  }
  return ids;
}

StoreStats MeshStore::stats() const {
  StoreStats stats = index_.stats();
  stats.evictions = evictions_;
  stats.refusals = refusals_;
  stats.corrupt = corrupt_;
  stats.failures = failures_;
  return stats;
}

// What the storage has of a mesh: whether it is there, and whether its description is the one that
// is kept.
Result<void> MeshStore::confirm(const std::string& id) {
  const auto known = ask_storage(id);
  if (!known) return fail(known.error());
  const auto kept = *known ? metadata_.find(id) : nullptr;
  if (!kept) return {};
  const auto version = counted(storage_->metadata_version(id));
  if (!version) return fail(version.error());
  if (!*version || (*version)->empty() || **version != kept->version) metadata_.erase(id);
  return {};
}

Result<void> MeshStore::confirm_used(std::chrono::seconds age) {
  if (!storage_->is_shared()) return {};
  const auto ids = index_.unconfirmed(steady_seconds(), age.count(), kMostConfirmed);
  std::atomic<std::size_t> next = 0;
  std::atomic<bool> is_gone = false;  // the storage
  const auto confirm_some = [&]() -> Result<void> {
    Result<void> outcome;
    for (std::size_t i = next++; i < ids.size() && !is_gone; i = next++) {
      auto done = confirm(ids[i]);
      if (done) continue;
      // It would fail for the others, too, and each takes its time.
      is_gone = is_gone || done.error().code == ServiceCode::store_unavailable;
      outcome = std::move(done);
    }
    return outcome;
  };
  std::vector<std::future<Result<void>>> crew;
  try {
    for (std::size_t i = 1; i < std::min(ids.size(), kConfirmedAtOnce); ++i) {
      crew.push_back(std::async(std::launch::async, confirm_some));
    }
  } catch (const std::system_error&) {
    // No more threads can be started. Those that were, and this one, do it all.
  }
  Result<void> all = confirm_some();
  for (auto& part : crew) {
    if (auto done = part.get(); !done) all = std::move(done);
  }
  return all;
}

Result<void> MeshStore::check() {
  Result<void> well = storage_->check();
  if (well) (void)confirm_used(kBelieved);  // if the storage is gone since, the next check tells
  // Whatever the cause: not now, and perhaps later.
  if (!well) well.error().code = ServiceCode::store_unavailable;
  const std::lock_guard lock(state_mutex_);
  if (health_ && !well) spdlog::error("store: not ready: {}", well.error().detail);
  if (!health_ && well) spdlog::info("store: ready again");
  health_ = well;
  return well;
}

Result<void> MeshStore::health() const {
  const std::lock_guard lock(state_mutex_);
  return health_;
}

// By the first six bits of the digest.
std::mutex& MeshStore::stripe(std::string_view id) {
  constexpr std::string_view kHexDigits = "0123456789abcdef";
  return stripes_[kHexDigits.find(id[0]) * 4 + kHexDigits.find(id[1]) / 4];
}

}  // namespace geodesic::server
