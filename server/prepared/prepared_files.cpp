#include "server/prepared/prepared_files.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <exception>
#include <utility>
#include <vector>

#include "server/base/service_codes.h"
#include "server/prepared/format.h"
#include "server/prepared/mapped_file.h"

namespace geodesic::server {
namespace {

constexpr std::size_t kMostWanted = 64;
constexpr std::size_t kMostUploads = kMostWanted / 2;  // of files that were here
constexpr std::size_t kMostKnown = 10'000;             // names in the bucket
constexpr std::chrono::hours kBetweenTidying{1};

// For what is done beside the queries: want of memory there is no reason to end.
template <class Do>
auto without_throwing(const Do& what) -> decltype(what()) {
  try {
    return what();
  } catch (const std::exception& error) {
    return fail(ServiceCode::store_failed, error.what());
  }
}

}  // namespace

Result<std::unique_ptr<PreparedFiles>> PreparedFiles::open(const std::filesystem::path& directory,
                                                           const Limits& limits, std::string engine,
                                                           std::unique_ptr<PreparedBucket> bucket) {
  auto folder = PreparedFolder::open(directory, limits.bytes);
  if (!folder) return fail(std::move(folder.error()));
  return std::unique_ptr<PreparedFiles>(
      new PreparedFiles(std::move(*folder), limits, std::move(engine), std::move(bucket)));
}

PreparedFiles::PreparedFiles(std::unique_ptr<PreparedFolder> folder, const Limits& limits,
                             std::string engine, std::unique_ptr<PreparedBucket> bucket)
    : folder_(std::move(folder)),
      limits_(limits),
      engine_(std::move(engine)),
      bucket_(std::move(bucket)),
      writer_([this] { write_files(); }) {}

PreparedFiles::~PreparedFiles() {
  {
    const std::lock_guard lock(mutex_);
    is_stopping_ = true;
  }
  changed_.notify_all();
  writer_.join();
}

std::string PreparedFiles::name_of(const std::string& id) const {
  return PreparedFolder::name_of(id, engine_);
}

Result<std::shared_ptr<const Adjacency>> PreparedFiles::find(const std::string& id,
                                                             const std::function<bool()>& stop) {
  auto found = find_here(id, stop);
  if (!found) return fail(std::move(found.error()));
  auto adjacency = std::move(found->adjacency);
  const bool is_here = adjacency != nullptr;
  if (!is_here && bucket_ != nullptr) {
    auto fetched = find_in_bucket(id, stop);
    if (!fetched) return fetched;
    adjacency = std::move(*fetched);
  }
  const auto known = is_sound_in_bucket(name_of(id));
  const std::lock_guard lock(mutex_);
  ++(adjacency ? stats_.found : stats_.missing);
  if (found->is_damaged) ++stats_.damaged;
  if (!adjacency) return nullptr;
  used_[id] = adjacency;
  // It may have been written while the bucket was away, or before there was one.
  if (is_here && bucket_ != nullptr && !known.value_or(false) && wanted_.size() < kMostUploads) {
    wanted_.push_back({id, adjacency, /*is_here=*/true});
    changed_.notify_all();
  }
  return adjacency;
}

Result<PreparedFiles::Found> PreparedFiles::find_here(const std::string& id,
                                                      const std::function<bool()>& stop) {
  Caller waiting(stop);
  waiting.is_patient = true;
  const auto turn = readers_.take(waiting);
  if (!turn) return fail(turn.error());
  const std::string name = name_of(id);
  PreparedChecksum checksum;
  const auto mapped = MappedFile::open(
      folder_->descriptor(), name.c_str(),
      [&](std::uint64_t offset, std::span<const std::byte> piece) { checksum.add(offset, piece); },
      stop);
  if (!mapped) return fail(mapped.error());
  if (!*mapped) return Found{};
  auto adjacency = read_prepared((*mapped)->bytes(), *mapped, {id, engine_}, checksum);
  if (adjacency) return Found{std::move(adjacency), false};
  spdlog::warn("the prepared mesh {} is damaged: it is prepared anew", id);
  remove(name);
  return Found{nullptr, true};
}

Result<std::shared_ptr<const Adjacency>> PreparedFiles::find_in_bucket(
    const std::string& id, const std::function<bool()>& stop) {
  const std::string name = name_of(id);
  std::unique_lock lock(mutex_);
  const auto fetching = fetching_.insert(fetching_.end(), Fetching{id});
  lock.unlock();
  const auto is_fetched = without_throwing([&] { return fetch(name, stop); });
  Result<Found> found = Found{};
  if (is_fetched && *is_fetched) {
    found = without_throwing([&] { return find_here(id, stop); });
  }
  lock.lock();
  const bool is_unwanted = fetching->is_unwanted;
  fetching_.erase(fetching);
  lock.unlock();
  if (is_unwanted) {
    remove(name);
    return nullptr;
  }
  if (!is_fetched) return fail(is_fetched.error());
  if (!found) return fail(std::move(found.error()));
  if (!*is_fetched) return nullptr;
  const bool is_sound = !found->is_damaged;
  if (found->adjacency || !is_sound) learn(name, is_sound);
  lock.lock();
  ++stats_.fetched;
  if (!is_sound) ++stats_.bucket_damaged;
  return std::move(found->adjacency);
}

Result<bool> PreparedFiles::fetch(const std::string& name, const std::function<bool()>& stop) {
  // Waiting for others may take longer than preparing.
  const auto turn = fetchers_.take_now();
  if (turn == nullptr) return false;
  const auto done = without_throwing([&] { return fetch_file(name, stop); });
  if (done) return done;
  if (stop()) return fail(ErrorCode::cancelled, "stopped");
  count_failure(done.error());
  return false;
}

Result<bool> PreparedFiles::fetch_file(const std::string& name, const std::function<bool()>& stop) {
  std::optional<PartFile> part;
  std::optional<Error> refused;
  const auto open_file = [&](std::uint64_t bytes) -> std::optional<int> {
    touch_what_is_used();
    auto created = folder_->create(name, bytes);
    if (!created) {
      refused = std::move(created.error());
      return std::nullopt;
    }
    part.emplace(std::move(*created));
    return part->descriptor();
  };
  const auto is_there = bucket_->read(name, open_file, stop);
  if (refused) {
    count_not_written(*refused);
    return false;
  }
  if (!is_there) return fail(is_there.error());
  if (!*is_there) return false;
  if (!part) {
    learn(name, false);
    return fail(ServiceCode::store_failed, "a prepared mesh of no bytes");
  }
  if (auto done = part->finish(); !done) return fail(std::move(done.error()));
  return true;
}

void PreparedFiles::upload(const std::string& name) {
  const auto done = without_throwing([&] { return upload_file(name); });
  if (!done) return count_failure(done.error());
  const std::lock_guard lock(mutex_);
  bucket_reported_.clear();
  if (*done) ++stats_.uploaded;
}

Result<bool> PreparedFiles::upload_file(const std::string& name) {
  const ReadableFile file = open_to_read(folder_->descriptor(), name.c_str());
  if (!file.descriptor) return false;  // it has left the directory again
  const auto stop = [&] { return is_stopping_ || is_unwanted_; };
  if (is_sound_in_bucket(name).value_or(true)) {
    const auto is_there = bucket_->has(name, file.bytes, stop);  // another server's
    if (!is_there) return fail(is_there.error());
    if (*is_there) {
      learn(name, true);
      return false;
    }
  }
  auto done = bucket_->write(name, file.descriptor.get(), file.bytes, stop);
  if (!done) return fail(std::move(done.error()));
  learn(name, true);
  return true;
}

void PreparedFiles::erase_in_bucket(const std::string& name) {
  const auto done = without_throwing([&] { return bucket_->erase(name); });
  learn(name, std::nullopt);
  if (!done) count_failure(done.error());
}

std::optional<bool> PreparedFiles::is_sound_in_bucket(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  const auto found = in_bucket_.find(name);
  return found == in_bucket_.end() ? std::nullopt : std::optional(found->second);
}

void PreparedFiles::learn(const std::string& name, std::optional<bool> is_sound) {
  const std::lock_guard lock(mutex_);
  if (!is_sound) {
    in_bucket_.erase(name);
    return;
  }
  if (in_bucket_.size() >= kMostKnown) in_bucket_.clear();  // it is asked again
  in_bucket_[name] = *is_sound;
}

void PreparedFiles::count_failure(const Error& error) {
  if (error.code == ErrorCode::cancelled) return;
  report(bucket_reported_, "the bucket: " + error.detail);
  const std::lock_guard lock(mutex_);
  ++stats_.bucket_failed;
}

void PreparedFiles::count_not_written(const Error& error) {
  if (error.code == ErrorCode::cancelled) return;
  report(reported_, error.detail);
  const std::lock_guard lock(mutex_);
  ++stats_.not_written;
}

void PreparedFiles::keep(const std::string& id, const std::shared_ptr<const Adjacency>& adjacency) {
  if (adjacency->mesh().face_count() < limits_.fewest_faces) return;
  {
    const std::lock_guard lock(mutex_);
    if (wanted_.size() >= kMostWanted) {
      ++stats_.not_written;
      return;
    }
    wanted_.push_back({id, adjacency, /*is_here=*/false});
  }
  changed_.notify_all();
}

void PreparedFiles::forget(const std::string& id) {
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(wanted_, [&](const Wanted& wanted) { return wanted.id == id; });
    is_unwanted_ = is_unwanted_ || writing_ == id;
    for (Fetching& fetching : fetching_) fetching.is_unwanted |= fetching.id == id;
    used_.erase(id);
    in_bucket_.erase(name_of(id));
  }
  changed_.notify_all();
  remove(name_of(id));
}

void PreparedFiles::erase(const std::string& id) {
  forget(id);
  const auto names = folder_->names();
  if (!names) report(reported_, names.error().detail);
  if (names) {
    for (const std::string& name : *names) {
      if (name.starts_with(id + ".")) remove(name);
    }
  }
  if (bucket_ == nullptr) return;
  if (auto done = bucket_->erase_all(id + "."); !done) {
    spdlog::warn("prepared meshes: {} may be in the bucket still: {}", id, done.error().detail);
    count_failure(done.error());
  }
}

PreparedFiles::Stats PreparedFiles::stats() const {
  const std::lock_guard lock(mutex_);
  Stats stats = stats_;
  stats.bytes = folder_->bytes();
  return stats;
}

void PreparedFiles::wait() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return wanted_.empty() && writing_.empty(); });
}

void PreparedFiles::write_files() {
  using Clock = std::chrono::steady_clock;
  auto next_tidying = Clock::now();
  std::unique_lock lock(mutex_);
  while (!is_stopping_) {
    if (Clock::now() >= next_tidying) {
      next_tidying = Clock::now() + kBetweenTidying;
      lock.unlock();
      tidy();
      lock.lock();
      continue;
    }
    if (wanted_.empty()) {
      changed_.wait_until(lock, next_tidying, [&] { return is_stopping_ || !wanted_.empty(); });
      continue;
    }
    const Wanted wanted = std::move(wanted_.front());
    wanted_.pop_front();
    writing_ = wanted.id;
    is_unwanted_ = false;
    lock.unlock();
    const std::string name = name_of(wanted.id);
    const bool is_here = wanted.is_here || write(wanted);
    if (is_here && bucket_ != nullptr && !is_unwanted_) upload(name);
    if (is_unwanted_) {
      remove(name);
      if (bucket_ != nullptr) erase_in_bucket(name);
    }
    lock.lock();
    writing_.clear();
    changed_.notify_all();
  }
}

bool PreparedFiles::write(const Wanted& wanted) {
  const auto adjacency = wanted.adjacency.lock();
  if (!adjacency) return false;
  const auto done = without_throwing([&] { return write_file(wanted.id, *adjacency); });
  if (!done) {
    count_not_written(done.error());
    return false;
  }
  const std::lock_guard lock(mutex_);
  if (is_unwanted_) return true;
  ++stats_.written;
  used_[wanted.id] = adjacency;
  reported_.clear();
  return true;
}

Result<void> PreparedFiles::write_file(const std::string& id, const Adjacency& adjacency) {
  touch_what_is_used();
  auto part = folder_->create(name_of(id), prepared_bytes(adjacency));
  if (!part) return fail(std::move(part.error()));
  const auto stop = [&] { return is_stopping_ || is_unwanted_; };
  if (auto done = write_prepared(part->descriptor(), {id, engine_}, adjacency, stop); !done) {
    return done;
  }
  return part->finish();
}

void PreparedFiles::tidy() {
  const auto done = without_throwing([&] {
    touch_what_is_used();
    return folder_->tidy();
  });
  if (!done) report(reported_, done.error().detail);
}

// A mesh in memory is in use, though nobody reads its file.
void PreparedFiles::touch_what_is_used() {
  std::vector<std::string> names;
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(used_, [](const auto& used) { return used.second.expired(); });
    for (const auto& [id, held] : used_) names.push_back(name_of(id));
  }
  for (const std::string& name : names) folder_->touch(name);
}

void PreparedFiles::remove(const std::string& name) {
  if (const auto done = folder_->remove(name); !done) report(reported_, done.error().detail);
}

// Once, until something else goes wrong or something went well: it is tried for each mesh.
void PreparedFiles::report(std::string& last, const std::string& what) {
  {
    const std::lock_guard lock(mutex_);
    if (last == what) return;
    last = what;
  }
  spdlog::warn("prepared meshes: {}", what);
}

}  // namespace geodesic::server
