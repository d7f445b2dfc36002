#include "server/store/directory_storage.h"

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <string>
#include <system_error>
#include <unordered_map>
#include <utility>

#include "server/base/service_codes.h"
#include "server/store/mesh_store.h"

namespace geodesic::server {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kMetadataSuffix = ".json";
constexpr std::size_t kMostErased = 1000;  // of old jobs at once

// Calls `visit(path)` for everything in a directory.
template <class Visit>
Result<void> for_each_in(const fs::path& directory, Visit&& visit) {
  std::error_code error;
  for (fs::directory_iterator it(directory, error), end; !error && it != end; it.increment(error)) {
    if (Result<void> done = visit(it->path()); !done) return done;
  }
  if (error) return disk_error("list a directory", directory, error.value());
  return {};
}

struct Found {
  std::string id;
  std::uint64_t bytes;
  std::int64_t changed;
};

// The files of one kind, all shards: by name and size, not by content. What is in
// the wrong shard or has another name is none of ours.
Result<std::vector<Found>> files_below(const fs::path& folder, std::string_view suffix) {
  std::vector<Found> files;
  auto listed = for_each_in(folder, [&](const fs::path& shard) -> Result<void> {
    struct stat status {};
    if (::stat(shard.c_str(), &status) != 0 || !S_ISDIR(status.st_mode)) return {};
    const std::string digits = shard.filename().string();
    return for_each_in(shard, [&](const fs::path& path) -> Result<void> {
      std::string name = path.filename().string();
      if (!name.ends_with(suffix)) return {};
      name.resize(name.size() - suffix.size());
      if (!is_mesh_id(name) || !name.starts_with(digits)) return {};
      struct stat file {};
      if (::stat(path.c_str(), &file) != 0) return disk_error("look at a file", path, errno);
      if (!S_ISREG(file.st_mode)) return {};
      files.push_back({std::move(name), static_cast<std::uint64_t>(file.st_size),
                       static_cast<std::int64_t>(file.st_mtime)});
      return {};
    });
  });
  if (!listed) return fail(std::move(listed.error()));
  return files;
}

// Whether it is there, and no larger.
Result<bool> is_file_of_at_most(std::uint64_t bytes, const fs::path& path) {
  struct stat file {};
  if (::stat(path.c_str(), &file) != 0) {
    if (errno == ENOENT) return false;
    return disk_error("look at a file", path, errno);
  }
  if (S_ISREG(file.st_mode) && static_cast<std::uint64_t>(file.st_size) <= bytes) return true;
  spdlog::warn("store: {} is not read: it is no file, or larger than {} bytes", path.string(),
               bytes);
  return false;
}

}  // namespace

Result<std::unique_ptr<ObjectStorage>> DirectoryStorage::open(const fs::path& directory) {
  // This error is for the operator, who needs to know where.
  const auto cannot = [&](const std::string& reason) {
    return fail(ServiceCode::store_failed,
                fmt::format("cannot use {} as the store: {}", directory.string(), reason));
  };
  std::error_code error;
  const fs::path absolute = fs::absolute(directory, error);
  if (error) return cannot(error.message());
  if (auto made = make_directories(absolute); !made) return cannot(made.error().detail);
  File lock(::open((directory / "lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
  if (!lock) return cannot(std::generic_category().message(errno));
  if (::flock(lock.get(), LOCK_EX | LOCK_NB) != 0) {
    return cannot(errno == EWOULDBLOCK ? "another process uses it"
                                       : std::generic_category().message(errno));
  }
  std::unique_ptr<DirectoryStorage> storage(new DirectoryStorage(directory, std::move(lock)));
  if (auto prepared = storage->prepare(); !prepared) return cannot(prepared.error().detail);
  return storage;
}

Result<void> DirectoryStorage::prepare() {
  for (const char* name : {"objects", "meta", "jobs", "tmp", "quarantine"}) {
    if (auto made = make_directory(root_ / name); !made) return made;
  }
  return for_each_in(root_ / "tmp", [](const fs::path& path) -> Result<void> {
    std::error_code stuck;
    fs::remove_all(path, stuck);
    if (stuck) return disk_error("remove a temporary file", path, stuck.value());
    return {};
  });
}

Result<std::vector<StoredMesh>> DirectoryStorage::list(std::string_view after, std::size_t most) {
  auto sources = files_below(root_ / "objects", "");
  if (!sources) return fail(std::move(sources.error()));
  auto metadata = files_below(root_ / "meta", kMetadataSuffix);
  if (!metadata) return fail(std::move(metadata.error()));
  std::unordered_map<std::string, std::uint64_t> bytes_of_metadata;
  for (Found& file : *metadata) bytes_of_metadata.emplace(std::move(file.id), file.bytes);

  std::vector<StoredMesh> meshes;
  meshes.reserve(sources->size());
  for (Found& file : *sources) {
    const auto described = bytes_of_metadata.find(file.id);
    const std::uint64_t more = described == bytes_of_metadata.end() ? 0 : described->second;
    if (described != bytes_of_metadata.end()) bytes_of_metadata.erase(described);
    if (file.id <= after) continue;
    meshes.push_back({std::move(file.id), file.bytes + more, file.changed});
  }
  std::sort(meshes.begin(), meshes.end(),
            [](const StoredMesh& a, const StoredMesh& b) { return a.id < b.id; });
  if (meshes.size() > most) meshes.resize(most);
  // Nobody asks for metadata of which the source is gone.
  for (const auto& [id, bytes] : bytes_of_metadata) {
    (void)remove_file(path_of(ObjectKind::metadata, id));
  }
  return meshes;
}

Result<std::optional<StoredMesh>> DirectoryStorage::find(std::string_view id) {
  struct stat source {};
  const fs::path path = path_of(ObjectKind::source, id);
  if (::stat(path.c_str(), &source) != 0) {
    if (errno == ENOENT) return std::nullopt;
    return disk_error("look at a file", path, errno);
  }
  struct stat metadata {};
  if (::stat(path_of(ObjectKind::metadata, id).c_str(), &metadata) != 0) metadata.st_size = 0;
  return StoredMesh{std::string(id), static_cast<std::uint64_t>(source.st_size + metadata.st_size),
                    static_cast<std::int64_t>(source.st_mtime)};
}

// Nobody else writes, so nobody asks.
Result<std::optional<std::string>> DirectoryStorage::metadata_version(std::string_view /*id*/) {
  return std::string();
}

Result<std::string> DirectoryStorage::write(ObjectKind kind, std::string_view id,
                                            std::string_view bytes) {
  const fs::path path = path_of(kind, id);
  const fs::path temporary = temporary_path();
  Result<void> done;
  {
    // One at a time: who finds the directory there must find it synced as well.
    const std::lock_guard lock(directories_);
    const fs::path directory = path.parent_path();
    if (!durable_.contains(directory)) {
      done = make_directory(directory);
      if (done) durable_.insert(directory);
    } else if (::mkdir(directory.c_str(), 0755) == 0) {  // somebody has removed it
      done = sync_directory(directory.parent_path());
    }
  }
  if (!done) return fail(std::move(done.error()));
  done = write_file(temporary, bytes);
  if (done && ::rename(temporary.c_str(), path.c_str()) != 0) {
    done = disk_error("rename a file", path, errno);
  }
  if (!done) {
    ::unlink(temporary.c_str());
    return fail(std::move(done.error()));
  }
  done = sync_directory(path.parent_path());
  if (!done) return fail(std::move(done.error()));
  return std::string();
}

Result<std::optional<StoredObject>> DirectoryStorage::read(ObjectKind kind, std::string_view id,
                                                           std::uint64_t expected_bytes) {
  const fs::path path = path_of(kind, id);
  if (is_of_job(kind)) {
    const auto may_be_read = is_file_of_at_most(expected_bytes, path);
    if (!may_be_read) return fail(may_be_read.error());
    if (!*may_be_read) return std::nullopt;
  }
  auto bytes = read_file(path);
  if (!bytes) return fail(std::move(bytes.error()));
  if (!*bytes) return std::nullopt;
  return StoredObject{std::move(**bytes), {}};
}

Result<std::optional<ObjectFile>> DirectoryStorage::open_source(std::string_view id) {
  const fs::path path = path_of(ObjectKind::source, id);
  File file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat about {};
  if (!file || ::fstat(file.get(), &about) != 0) {
    if (errno == ENOENT) return std::nullopt;
    return disk_error("open a file", path, errno);
  }
  const auto moment = [](const timespec& time) {
    return fmt::format("{}.{}", static_cast<std::int64_t>(time.tv_sec), time.tv_nsec);
  };
  std::string state = fmt::format("{}:{}:{}:{}", about.st_ino, about.st_size, moment(about.st_mtim),
                                  moment(about.st_ctim));
  return ObjectFile{std::move(file), static_cast<std::uint64_t>(about.st_size), std::move(state)};
}

Result<void> DirectoryStorage::erase(std::string_view id) {
  const Result<bool> metadata = remove_file(path_of(ObjectKind::metadata, id));
  if (!metadata) return fail(metadata.error());
  const fs::path path = path_of(ObjectKind::source, id);
  const Result<bool> source = remove_file(path);
  if (!source) return fail(source.error());
  // Even if it was gone: who removed it may have ended before the directory was synced.
  if (*source || fs::is_directory(path.parent_path())) return sync_directory(path.parent_path());
  return {};
}

Result<void> DirectoryStorage::quarantine(std::string_view id, std::string_view /*damaged*/) {
  const fs::path from = path_of(ObjectKind::source, id);
  const fs::path to = root_ / "quarantine" / id;
  if (::rename(from.c_str(), to.c_str()) != 0 && errno != ENOENT) {
    return disk_error("quarantine a file", from, errno);
  }
  const Result<bool> metadata = remove_file(path_of(ObjectKind::metadata, id));
  if (!metadata) return fail(metadata.error());
  return {};
}

Result<void> DirectoryStorage::erase_job(std::string_view id, std::span<const ObjectKind> kinds) {
  for (const ObjectKind kind : kinds) {
    if (auto removed = remove_file(path_of(kind, id)); !removed) return fail(removed.error());
  }
  return {};
}

Result<void> DirectoryStorage::erase_old_jobs(std::chrono::seconds age) {
  const std::time_t newest = std::time(nullptr) - static_cast<std::time_t>(age.count());
  std::size_t erased = 0;
  return for_each_in(root_ / "jobs", [&](const fs::path& path) -> Result<void> {
    if (!is_job_object(path.filename().string())) return {};
    struct stat file {};
    if (erased >= kMostErased || ::stat(path.c_str(), &file) != 0) return {};
    if (!S_ISREG(file.st_mode) || file.st_mtime > newest) return {};
    ++erased;
    auto removed = remove_file(path);
    if (!removed) return fail(std::move(removed.error()));
    return {};
  });
}

void DirectoryStorage::note_use(std::string_view id) {
  // Now, for both times. A store that cannot be written to still answers.
  (void)::utimensat(AT_FDCWD, path_of(ObjectKind::source, id).c_str(), nullptr, 0);
}

Result<void> DirectoryStorage::check() {
  // A block, so that a full disk shows; not synced, for a probe must not be slow.
  const std::string block(4096, 'x');
  const fs::path path = temporary_path();
  const File file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
  if (!file) return disk_failure("create a file", errno);
  const ssize_t written = ::write(file.get(), block.data(), block.size());
  const int error = written < 0 ? errno : ENOSPC;
  ::unlink(path.c_str());
  if (written != static_cast<ssize_t>(block.size())) return disk_failure("write a file", error);
  return {};
}

fs::path DirectoryStorage::path_of(ObjectKind kind, std::string_view id) const {
  const std::string_view digits = id.substr(0, 2);
  if (kind == ObjectKind::source) return root_ / "objects" / digits / id;
  if (kind != ObjectKind::metadata) return root_ / "jobs" / name_of_job_object(kind, id);
  return root_ / "meta" / digits / (std::string(id) + std::string(kMetadataSuffix));
}

fs::path DirectoryStorage::temporary_path() {
  return root_ / "tmp" / std::to_string(++temporaries_);
}

}  // namespace geodesic::server
