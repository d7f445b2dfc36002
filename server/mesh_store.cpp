#include "server/mesh_store.h"

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <mutex>
#include <set>
#include <shared_mutex>
#include <system_error>
#include <utility>

#include "server/sha256.h"

namespace geodesic::server {

namespace fs = std::filesystem;

namespace {

// A file descriptor that closes itself.
class File {
 public:
  explicit File(int descriptor) : descriptor_(descriptor) {}
  File(File&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  File& operator=(File&&) = delete;
  ~File() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  [[nodiscard]] int get() const { return descriptor_; }
  explicit operator bool() const { return descriptor_ >= 0; }

 private:
  int descriptor_;
};

// Clients see what failed and errno's text; the log sees where.
tl::unexpected<Error> disk_error(std::string_view what, const fs::path& path, int error) {
  const std::string reason = std::generic_category().message(error);
  spdlog::error("store: {} {}: {}", what, path.string(), reason);
  return fail(ErrorCode::store_failed, fmt::format("the store failed to {}: {}", what, reason));
}

Result<void> sync_directory(const fs::path& directory) {
  const File file(::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!file) return disk_error("open a directory", directory, errno);
  if (::fsync(file.get()) != 0) return disk_error("sync a directory", directory, errno);
  return {};
}

// Creates a directory below an existing one, durably.
Result<void> make_directory(const fs::path& directory) {
  if (::mkdir(directory.c_str(), 0755) == 0) return sync_directory(directory.parent_path());
  if (errno != EEXIST) return disk_error("create a directory", directory, errno);
  return {};
}

Result<void> write_file(const fs::path& path, std::string_view bytes) {
  const File file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
  if (!file) return disk_error("create a file", path, errno);
  while (!bytes.empty()) {
    const ssize_t n = ::write(file.get(), bytes.data(), bytes.size());
    if (n < 0) {
      if (errno == EINTR) continue;
      return disk_error("write a file", path, errno);
    }
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
  if (::fsync(file.get()) != 0) return disk_error("sync a file", path, errno);
  return {};
}

// The bytes of a file; nothing if there is no such file.
Result<std::optional<std::string>> read_file(const fs::path& path) {
  const File file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file) {
    if (errno == ENOENT) return std::nullopt;
    return disk_error("open a file", path, errno);
  }
  const off_t size = ::lseek(file.get(), 0, SEEK_END);
  if (size < 0 || ::lseek(file.get(), 0, SEEK_SET) < 0)
    return disk_error("read a file", path, errno);
  std::string bytes(static_cast<std::size_t>(size), '\0');
  std::size_t got = 0;
  while (got < bytes.size()) {
    const ssize_t n = ::read(file.get(), bytes.data() + got, bytes.size() - got);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return disk_error("read a file", path, errno);
    if (n == 0) break;  // shorter than it was a moment ago
    got += static_cast<std::size_t>(n);
  }
  bytes.resize(got);
  return bytes;
}

// Whether there was such a file.
Result<bool> remove_file(const fs::path& path) {
  if (::unlink(path.c_str()) == 0) return true;
  if (errno == ENOENT) return false;
  return disk_error("remove a file", path, errno);
}

constexpr std::string_view hex_digits = "0123456789abcdef";

tl::unexpected<Error> unknown_mesh() {
  return fail(ErrorCode::mesh_unknown, "no mesh of that id is stored");
}

}  // namespace

bool is_mesh_id(std::string_view id) {
  return id.size() == 64 && id.find_first_not_of(hex_digits) == std::string_view::npos;
}

class MeshStore::Impl {
 public:
  Impl(fs::path directory, File lock) : root_(std::move(directory)), lock_(std::move(lock)) {}

  // Empties tmp/ and lists the objects.
  Result<void> scan() {
    for (const char* name : {"objects", "meta", "tmp", "quarantine"}) {
      if (auto made = make_directory(root_ / name); !made) return made;
    }
    std::error_code error;
    for (fs::directory_iterator it(root_ / "tmp", error), end; !error && it != end;
         it.increment(error)) {
      std::error_code stuck;
      fs::remove_all(it->path(), stuck);
      if (stuck) return disk_error("remove a temporary file", it->path(), stuck.value());
    }
    if (error) return disk_error("list its temporary files", root_ / "tmp", error.value());

    for (fs::directory_iterator it(root_ / "objects", error), end; !error && it != end;
         it.increment(error)) {
      if (auto scanned = scan_shard(it->path()); !scanned) return scanned;
    }
    if (error) return disk_error("list its objects", root_ / "objects", error.value());
    return {};
  }

  Result<void> put(std::string_view id, std::string_view bytes, std::string_view metadata) {
    const std::lock_guard lock(stripe(id));
    const bool known = contains(id);
    if (!known) {
      if (auto stored = place(object_path(id), bytes); !stored) {
        (void)remove_file(object_path(id));
        return stored;
      }
    }
    if (auto stored = place(meta_path(id), metadata); !stored) {
      // Nothing of a failed put may remain; what an earlier one stored stays.
      if (!known) {
        (void)remove_file(meta_path(id));
        (void)remove_file(object_path(id));
      }
      return stored;
    }
    const std::unique_lock index(index_mutex_);
    ids_.emplace(id);
    return {};
  }

  Result<void> put_metadata(std::string_view id, std::string_view metadata) {
    const std::lock_guard lock(stripe(id));
    if (!contains(id)) return unknown_mesh();
    return place(meta_path(id), metadata);
  }

  Result<std::string> get_source(std::string_view id) {
    Result<std::optional<std::string>> bytes = std::nullopt;
    {
      const std::lock_guard lock(stripe(id));
      if (!contains(id)) return unknown_mesh();
      bytes = read_file(object_path(id));
    }
    if (!bytes) return fail(std::move(bytes.error()));
    if (*bytes && sha256_hex(**bytes) == id) return std::move(**bytes);
    return quarantine(id);
  }

  Result<std::optional<std::string>> get_metadata(std::string_view id) {
    const std::lock_guard lock(stripe(id));
    if (!contains(id)) return unknown_mesh();
    return read_file(meta_path(id));
  }

  Result<bool> remove(std::string_view id) {
    const std::lock_guard lock(stripe(id));
    // On the way in the metadata comes second; so on the way out it goes first.
    const Result<bool> meta = remove_file(meta_path(id));
    if (!meta) return meta;
    const Result<bool> object = remove_file(object_path(id));
    if (!object) return object;
    if (*object) {
      if (auto synced = sync_directory(object_path(id).parent_path()); !synced) {
        return fail(std::move(synced.error()));
      }
    }
    const std::unique_lock index(index_mutex_);
    const auto found = ids_.find(id);
    const bool known = found != ids_.end();
    if (known) ids_.erase(found);
    return known;
  }

  bool contains(std::string_view id) const {
    const std::shared_lock index(index_mutex_);
    return ids_.find(id) != ids_.end();
  }

  std::vector<std::string> list(std::string_view after_id, std::size_t limit) const {
    const std::shared_lock index(index_mutex_);
    std::vector<std::string> page;
    for (auto it = ids_.upper_bound(after_id); it != ids_.end() && page.size() < limit; ++it) {
      page.push_back(*it);
    }
    return page;
  }

  std::size_t size() const {
    const std::shared_lock index(index_mutex_);
    return ids_.size();
  }

 private:
  Result<void> scan_shard(const fs::path& directory) {
    std::error_code error;
    for (fs::directory_iterator it(directory, error), end; !error && it != end;
         it.increment(error)) {
      std::string id = it->path().filename().string();
      if (is_mesh_id(id) && id.starts_with(directory.filename().string())) {
        ids_.insert(std::move(id));
      }
    }
    // A stray file among the directories is none of ours.
    if (error && error != std::errc::not_a_directory) {
      return disk_error("list its objects", directory, error.value());
    }
    return {};
  }

  fs::path object_path(std::string_view id) const {
    return root_ / "objects" / id.substr(0, 2) / id;
  }
  fs::path meta_path(std::string_view id) const {
    return root_ / "meta" / id.substr(0, 2) / (std::string(id) + ".json");
  }

  // Writes a file so that after a loss of power it is either there whole or not at all.
  Result<void> place(const fs::path& path, std::string_view bytes) {
    const fs::path temporary = root_ / "tmp" / std::to_string(++temporaries_);
    Result<void> done = make_directory(path.parent_path());
    if (!done) return done;
    done = write_file(temporary, bytes);
    if (done && ::rename(temporary.c_str(), path.c_str()) != 0) {
      done = disk_error("rename a file", path, errno);
    }
    if (!done) {
      ::unlink(temporary.c_str());
      return done;
    }
    done = sync_directory(path.parent_path());
    return done;
  }

  // Takes a damaged object out of service.
  tl::unexpected<Error> quarantine(std::string_view id) {
    const std::lock_guard lock(stripe(id));
    const fs::path from = object_path(id);
    // Between reading and now it may have been removed, or put again.
    if (!contains(id)) return unknown_mesh();
    Result<std::optional<std::string>> again = read_file(from);
    if (again && *again && sha256_hex(**again) == id) {
      return fail(ErrorCode::store_failed, "the mesh was replaced while it was read: try again");
    }
    spdlog::error("store: {} is missing or not what was stored; moved to quarantine",
                  from.string());
    if (::rename(from.c_str(), (root_ / "quarantine" / id).c_str()) != 0 && errno != ENOENT) {
      (void)disk_error("quarantine a file", from, errno);
    }
    (void)remove_file(meta_path(id));
    const std::unique_lock index(index_mutex_);
    if (const auto found = ids_.find(id); found != ids_.end()) ids_.erase(found);
    return fail(ErrorCode::store_corrupt, "the stored bytes are damaged; upload the mesh again");
  }

  // Changes to one id exclude each other; those to others mostly do not.
  std::mutex& stripe(std::string_view id) {
    return stripes_[hex_digits.find(id[0]) * 4 + hex_digits.find(id[1]) / 4];
  }

  const fs::path root_;
  const File lock_;  // holds the flock
  std::atomic<std::uint64_t> temporaries_{0};
  std::array<std::mutex, 64> stripes_;
  mutable std::shared_mutex index_mutex_;
  std::set<std::string, std::less<>> ids_;
};

MeshStore::MeshStore(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
MeshStore::~MeshStore() = default;

Result<std::unique_ptr<MeshStore>> MeshStore::open(const fs::path& directory) {
  // This error is for the operator, who needs to know where.
  const auto cannot = [&](const std::string& reason) {
    return fail(ErrorCode::store_failed,
                fmt::format("cannot use {} as the store: {}", directory.string(), reason));
  };
  std::error_code error;
  fs::create_directories(directory, error);
  if (error) return cannot(error.message());
  File lock(::open((directory / "lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
  if (!lock) return cannot(std::generic_category().message(errno));
  if (::flock(lock.get(), LOCK_EX | LOCK_NB) != 0) {
    return cannot(errno == EWOULDBLOCK ? "another process uses it"
                                       : std::generic_category().message(errno));
  }
  auto impl = std::make_unique<Impl>(directory, std::move(lock));
  if (auto scanned = impl->scan(); !scanned) return cannot(scanned.error().detail);
  return std::unique_ptr<MeshStore>(new MeshStore(std::move(impl)));
}

Result<void> MeshStore::put(std::string_view id, std::string_view bytes,
                            std::string_view metadata) {
  if (!is_mesh_id(id)) return unknown_mesh();
  if (sha256_hex(bytes) != id) {
    return fail(ErrorCode::digest_mismatch, "the bytes do not have the given SHA-256");
  }
  return impl_->put(id, bytes, metadata);
}

Result<void> MeshStore::put_metadata(std::string_view id, std::string_view metadata) {
  if (!is_mesh_id(id)) return unknown_mesh();
  return impl_->put_metadata(id, metadata);
}

Result<std::string> MeshStore::get_source(std::string_view id) {
  if (!is_mesh_id(id)) return unknown_mesh();
  return impl_->get_source(id);
}

Result<std::optional<std::string>> MeshStore::get_metadata(std::string_view id) {
  if (!is_mesh_id(id)) return unknown_mesh();
  return impl_->get_metadata(id);
}

bool MeshStore::contains(std::string_view id) const {
  return is_mesh_id(id) && impl_->contains(id);
}

Result<bool> MeshStore::remove(std::string_view id) {
  if (!is_mesh_id(id)) return false;
  return impl_->remove(id);
}

std::vector<std::string> MeshStore::list(std::string_view after_id, std::size_t limit) const {
  return impl_->list(after_id, limit);
}

std::size_t MeshStore::size() const { return impl_->size(); }

}  // namespace geodesic::server
