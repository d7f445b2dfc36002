#include "server/prepared/prepared_files.h"

#include <dirent.h>
#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <exception>
#include <optional>
#include <random>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "server/base/durable_file.h"
#include "server/base/service_codes.h"
#include "server/prepared/format.h"
#include "server/prepared/mapped_file.h"

namespace geodesic::server {
namespace {

constexpr std::size_t kMostWanted = 64;
constexpr std::chrono::hours kBetweenTidying{1};
constexpr std::time_t kLongestUnused = 7 * 24 * 3600;  // seconds
constexpr std::time_t kLongestWriting = 3600;          // then a .part file counts as abandoned
constexpr std::uint64_t kFreePart = 20;  // of the disk stays free: one part in so many
constexpr std::string_view kUnfinished = ".part";
constexpr std::size_t kIdDigits = 64;  // at the least
// Of the digest of a build, in a file's name: the file itself has it whole.
constexpr std::size_t kEngineDigits = 12;

bool is_hexadecimal(std::string_view text) {
  return text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

// ID.ENGINE, and while it is being written ID.ENGINE.DIGITS.part. Anything else is not ours.
bool is_ours(std::string_view name) {
  const std::size_t end = name.find('.');
  if (end == std::string_view::npos || end < kIdDigits) return false;
  if (!is_hexadecimal(name.substr(0, kIdDigits))) return false;
  std::string_view rest = name.substr(end + 1);
  if (rest.ends_with(kUnfinished)) {
    rest.remove_suffix(kUnfinished.size());
    const std::size_t dot = rest.find('.');
    if (dot == std::string_view::npos || !is_hexadecimal(rest.substr(dot + 1))) return false;
    rest = rest.substr(0, dot);
  }
  return rest.size() == kEngineDigits && is_hexadecimal(rest);
}

// The names of our files; nothing if they cannot be had.
std::optional<std::vector<std::string>> names_in(const UniqueFd& directory) {
  UniqueFd again(::openat(directory.get(), ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  DIR* const list = again ? ::fdopendir(again.get()) : nullptr;
  if (list == nullptr) return std::nullopt;
  (void)again.release();  // it is the list's now
  std::vector<std::string> names;
  while (const dirent* const entry = ::readdir(list)) {
    if (is_ours(entry->d_name)) names.emplace_back(entry->d_name);
  }
  ::closedir(list);
  return names;
}

struct FileOnDisk {
  std::string name;
  std::uint64_t bytes;
  std::time_t used;
};

// What was used longest ago comes first.
std::optional<std::vector<FileOnDisk>> files_in(const UniqueFd& directory) {
  auto names = names_in(directory);
  if (!names) return std::nullopt;
  std::vector<FileOnDisk> files;
  for (std::string& name : *names) {
    struct stat about {};
    if (::fstatat(directory.get(), name.c_str(), &about, AT_SYMLINK_NOFOLLOW) != 0) continue;
    const auto bytes = static_cast<std::uint64_t>(about.st_size);
    files.push_back({std::move(name), bytes, about.st_mtim.tv_sec});
  }
  std::sort(files.begin(), files.end(),
            [](const FileOnDisk& a, const FileOnDisk& b) { return a.used < b.used; });
  return files;
}

// Gives back what was acquired.
class Turn {
 public:
  explicit Turn(std::counting_semaphore<>& places) : places_(places) {}
  ~Turn() { places_.release(); }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;

 private:
  std::counting_semaphore<>& places_;
};

std::string random_digits() {
  std::random_device random;
  char digits[17];
  std::snprintf(digits, sizeof(digits), "%08x%08x", random(), random());
  return digits;
}

}  // namespace

Result<std::unique_ptr<PreparedFiles>> PreparedFiles::open(const std::filesystem::path& directory,
                                                           const Limits& limits, std::string engine,
                                                           std::unique_ptr<PreparedBucket> bucket) {
  const auto cannot = [&](const std::string& why) {
    return fail(ServiceCode::store_failed,
                "cannot keep prepared meshes in " + directory.string() + ": " + why);
  };
  const auto why = [] { return std::generic_category().message(errno); };
  std::error_code error;
  std::filesystem::create_directories(directory, error);
  if (error) return cannot(error.message());
  const std::filesystem::path own = directory / "geodesicd-prepared";
  if (::mkdir(own.c_str(), 0700) != 0 && errno != EEXIST) return cannot(why());
  UniqueFd opened(::open(own.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
  struct stat about {};
  if (!opened || ::fstat(opened.get(), &about) != 0) return cannot(why());
  // What is read is used as it is, so nobody else may write there.
  if (about.st_uid != ::geteuid()) return cannot("its folder geodesicd-prepared is another user's");
  if (::fchmod(opened.get(), 0700) != 0) return cannot(why());
  return std::unique_ptr<PreparedFiles>(
      new PreparedFiles(std::move(opened), limits, std::move(engine), std::move(bucket)));
}

PreparedFiles::PreparedFiles(UniqueFd directory, const Limits& limits, std::string engine,
                             std::unique_ptr<PreparedBucket> bucket)
    : directory_(std::move(directory)),
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
  return id + "." + engine_.substr(0, kEngineDigits);
}

Result<std::shared_ptr<const Adjacency>> PreparedFiles::find(const std::string& id,
                                                             const std::function<bool()>& stop) {
  const std::string name = name_of(id);
  auto found = find_here(id, name, stop);
  if (found && !found->adjacency && bucket_ != nullptr) {
    const auto is_fetched = fetch(name, stop);
    if (!is_fetched) return fail(is_fetched.error());
    if (*is_fetched) {
      found = find_here(id, name, stop);
      // Else every machine would fetch it.
      if (found && found->is_damaged) (void)bucket_->erase(name);
    }
  }
  if (!found) return fail(std::move(found.error()));
  const std::lock_guard lock(mutex_);
  if (found->adjacency) {
    ++stats_.found;
    used_[id] = found->adjacency;
  } else {
    ++(found->is_damaged ? stats_.damaged : stats_.missing);
  }
  return std::move(found->adjacency);
}

Result<PreparedFiles::Found> PreparedFiles::find_here(const std::string& id,
                                                      const std::string& name,
                                                      const std::function<bool()>& stop) {
  while (!readers_.try_acquire_for(std::chrono::milliseconds(5))) {
    if (stop()) return fail(ErrorCode::cancelled, "stopped");
  }
  const Turn turn(readers_);
  PreparedChecksum checksum;
  const auto mapped = MappedFile::open(
      directory_, name.c_str(),
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

Result<bool> PreparedFiles::fetch(const std::string& name, const std::function<bool()>& stop) {
  // Waiting for others may take longer than preparing.
  if (!fetchers_.try_acquire()) return false;
  const Turn turn(fetchers_);
  const auto failed = [&](const Error& error) -> Result<bool> {
    if (error.code == ErrorCode::cancelled) return fail(error);
    count_failure(error);
    return false;
  };
  const auto bytes = bucket_->find(name);
  if (!bytes) return failed(bytes.error());
  if (!*bytes) return false;
  if (!make_room(**bytes)) return false;
  const auto made =
      make_file(name, [&](int file) { return bucket_->read(name, **bytes, file, stop); });
  if (!made) return failed(made.error());
  const std::lock_guard lock(mutex_);
  ++stats_.fetched;
  return true;
}

void PreparedFiles::upload(const std::string& name) {
  const auto present = bucket_->find(name);  // another server's
  if (!present) return count_failure(present.error());
  if (*present) return;
  const auto stop = [&] { return is_stopping_.load(); };
  const auto mapped = MappedFile::open(
      directory_, name.c_str(), [](auto, auto) {}, stop);
  if (!mapped || !*mapped) return;  // it has left the directory again
  if (auto done = bucket_->write(name, (*mapped)->bytes(), stop); !done) {
    return count_failure(done.error());
  }
  const std::lock_guard lock(mutex_);
  ++stats_.uploaded;
}

void PreparedFiles::count_failure(const Error& error) {
  if (error.code == ErrorCode::cancelled) return;
  report("the bucket: " + error.detail);
  const std::lock_guard lock(mutex_);
  ++stats_.bucket_failed;
}

void PreparedFiles::keep(const std::string& id, const std::shared_ptr<const Adjacency>& adjacency) {
  if (adjacency->mesh().face_count() < limits_.fewest_faces) return;
  {
    const std::lock_guard lock(mutex_);
    if (wanted_.size() >= kMostWanted) {
      ++stats_.not_written;
      return;
    }
    wanted_.push_back({id, adjacency});
  }
  changed_.notify_all();
}

void PreparedFiles::forget(const std::string& id) {
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(wanted_, [&](const Wanted& wanted) { return wanted.id == id; });
    is_unwanted_ = is_unwanted_ || writing_ == id;
    used_.erase(id);
  }
  changed_.notify_all();
  remove(name_of(id));
}

void PreparedFiles::erase(const std::string& id) {
  forget(id);
  const auto names = names_in(directory_);
  if (!names) return report("the files of other builds cannot be listed");
  for (const std::string& name : *names) {
    if (name.starts_with(id + ".")) remove(name);
  }
  if (bucket_ == nullptr) return;
  if (auto done = bucket_->erase_all(id + "."); !done) count_failure(done.error());
}

PreparedFiles::Stats PreparedFiles::stats() const {
  const std::lock_guard lock(mutex_);
  return stats_;
}

void PreparedFiles::wait() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return wanted_.empty() && writing_.empty(); });
}

void PreparedFiles::write_files() {
  auto tidied = std::chrono::steady_clock::time_point::min();
  std::unique_lock lock(mutex_);
  while (!is_stopping_) {
    const auto now = std::chrono::steady_clock::now();
    if (tidied == std::chrono::steady_clock::time_point::min() || now > tidied + kBetweenTidying) {
      tidied = now;
      lock.unlock();
      try {
        tidy();
      } catch (const std::exception& error) {
        report(error.what());
      }
      lock.lock();
      continue;
    }
    if (wanted_.empty()) {
      changed_.wait_until(lock, tidied + kBetweenTidying + std::chrono::seconds(1),
                          [&] { return is_stopping_ || !wanted_.empty(); });
      continue;
    }
    const Wanted wanted = std::move(wanted_.front());
    wanted_.pop_front();
    writing_ = wanted.id;
    is_unwanted_ = false;
    lock.unlock();
    write(wanted);
    lock.lock();
    writing_.clear();
    changed_.notify_all();
  }
}

void PreparedFiles::write(const Wanted& wanted) {
  const auto adjacency = wanted.adjacency.lock();
  if (!adjacency) return;
  const std::string name = name_of(wanted.id);
  Result<void> done;
  try {
    done = write_file(wanted.id, name, *adjacency);
    if (done && bucket_ != nullptr) upload(name);
  } catch (const std::exception& error) {  // want of memory is no reason to end
    done = fail(ServiceCode::store_failed, error.what());
  }
  const bool is_cancelled = !done && done.error().code == ErrorCode::cancelled;
  if (!done && !is_cancelled) report(done.error().detail);
  bool is_unwanted = false;
  {
    const std::lock_guard lock(mutex_);
    is_unwanted = is_unwanted_;
    if (done && !is_unwanted) {
      ++stats_.written;
      used_[wanted.id] = adjacency;
      reported_.clear();
    }
    if (!done && !is_cancelled) ++stats_.not_written;
  }
  if (!done || !is_unwanted) return;
  remove(name);
  if (bucket_ != nullptr) (void)bucket_->erase(name);
}

Result<void> PreparedFiles::write_file(const std::string& id, const std::string& name,
                                       const Adjacency& adjacency) {
  if (!make_room(prepared_bytes(adjacency))) {
    return fail(ServiceCode::store_full, "a mesh has no room");
  }
  return make_file(name, [&](int file) {
    return write_prepared(file, {id, engine_}, adjacency, [&] { return is_stopping_.load(); });
  });
}

Result<void> PreparedFiles::make_file(const std::string& name,
                                      const std::function<Result<void>(int)>& fill) {
  const std::string part = name + "." + random_digits() + std::string(kUnfinished);
  const UniqueFd file(::openat(directory_.get(), part.c_str(),
                               O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600));
  if (!file) return disk_failure("create a prepared mesh's file", errno);
  Result<void> done = fill(file.get());
  if (done && ::renameat(directory_.get(), part.c_str(), directory_.get(), name.c_str()) != 0) {
    // Another process has removed it: the mesh is gone.
    done = errno == ENOENT ? fail(ErrorCode::cancelled, "removed")
                           : disk_failure("rename a prepared mesh's file", errno);
  }
  if (!done) (void)::unlinkat(directory_.get(), part.c_str(), 0);
  return done;
}

// A mesh in memory is in use, though nobody reads its file.
void PreparedFiles::touch_what_is_used() {
  std::vector<std::string> names;
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(used_, [](const auto& used) { return used.second.expired(); });
    for (const auto& [id, held] : used_) names.push_back(name_of(id));
  }
  const timespec now[2] = {{0, UTIME_NOW}, {0, UTIME_NOW}};
  for (const std::string& name : names) {
    (void)::utimensat(directory_.get(), name.c_str(), now, AT_SYMLINK_NOFOLLOW);
  }
}

bool PreparedFiles::make_room(std::uint64_t bytes) {
  touch_what_is_used();
  struct statvfs disk {};
  const auto files = files_in(directory_);
  if (!files || ::fstatvfs(directory_.get(), &disk) != 0) {
    report("the files cannot be listed");
    return false;
  }
  const std::uint64_t reserve = std::uint64_t{disk.f_blocks} * disk.f_frsize / kFreePart;
  std::uint64_t free = std::uint64_t{disk.f_bavail} * disk.f_frsize;
  std::uint64_t taken = 0;
  for (const FileOnDisk& file : *files) taken += file.bytes;
  const auto has_room = [&] {
    return (limits_.bytes == 0 || taken + bytes <= limits_.bytes) && free >= reserve + bytes;
  };
  // A file that could not fit even after removing all others makes none of them go.
  const bool is_possible =
      (limits_.bytes == 0 || bytes <= limits_.bytes) && free + taken >= reserve + bytes;
  const std::time_t now = std::time(nullptr);
  for (const FileOnDisk& file : *files) {
    const bool is_unfinished = file.name.ends_with(kUnfinished);
    const bool is_old = file.used < now - (is_unfinished ? kLongestWriting : kLongestUnused);
    const bool makes_room = !is_unfinished && !has_room() && (is_possible || bytes == 0);
    if (!is_old && !makes_room) continue;
    remove(file.name);
    taken -= file.bytes;
    free += file.bytes;
  }
  const std::lock_guard lock(mutex_);
  stats_.bytes = taken + (has_room() ? bytes : 0);
  return has_room();
}

void PreparedFiles::remove(const std::string& name) {
  if (::unlinkat(directory_.get(), name.c_str(), 0) == 0 || errno == ENOENT) return;
  report("a file cannot be removed: " + std::generic_category().message(errno));
}

// Once, until something else goes wrong or something went well: it is tried for each mesh.
void PreparedFiles::report(const std::string& what) {
  {
    const std::lock_guard lock(mutex_);
    if (reported_ == what) return;
    reported_ = what;
  }
  spdlog::warn("prepared meshes: {}", what);
}

}  // namespace geodesic::server
