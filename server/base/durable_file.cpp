#include "server/base/durable_file.h"

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "server/base/service_codes.h"

namespace geodesic::server {

namespace fs = std::filesystem;

File::~File() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

tl::unexpected<Error> disk_failure(std::string_view what, int error) {
  const bool full = error == ENOSPC || error == EDQUOT || error == EFBIG;
  return fail(
      full ? ServiceCode::store_full : ServiceCode::store_failed,
      fmt::format("the store failed to {}: {}", what, std::generic_category().message(error)));
}

tl::unexpected<Error> disk_error(std::string_view what, const fs::path& path, int error) {
  spdlog::error("store: cannot {} {}: {}", what, path.string(),
                std::generic_category().message(error));
  return disk_failure(what, error);
}

Result<void> sync_directory(const fs::path& directory) {
  const File file(::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!file) return disk_error("open a directory", directory, errno);
  if (::fsync(file.get()) != 0) return disk_error("sync a directory", directory, errno);
  return {};
}

Result<void> make_directory(const fs::path& directory) {
  if (::mkdir(directory.c_str(), 0755) != 0 && errno != EEXIST) {
    return disk_error("create a directory", directory, errno);
  }
  return sync_directory(directory.parent_path());
}

Result<void> make_directories(const fs::path& directory) {
  fs::path path;
  for (const fs::path& part : directory) {
    path /= part;
    if (!path.has_relative_path()) continue;  // the root
    struct stat status {};
    const bool is_there = ::stat(path.c_str(), &status) == 0;
    if (is_there && ::access(path.parent_path().c_str(), R_OK) != 0) continue;
    if (is_there && !S_ISDIR(status.st_mode)) {
      return disk_error("create a directory", path, ENOTDIR);
    }
    Result<void> made = is_there ? sync_directory(path.parent_path()) : make_directory(path);
    // What others have made farther up is synced as far as their file systems allow it.
    if (!made && (!is_there || path == directory)) return made;
  }
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

Result<std::optional<std::string>> read_file(const fs::path& path) {
  const File file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file) {
    if (errno == ENOENT) return std::nullopt;
    return disk_error("open a file", path, errno);
  }
  const off_t size = ::lseek(file.get(), 0, SEEK_END);
  if (size < 0 || ::lseek(file.get(), 0, SEEK_SET) < 0) {
    return disk_error("read a file", path, errno);
  }
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

Result<bool> remove_file(const fs::path& path) {
  if (::unlink(path.c_str()) == 0) return true;
  if (errno == ENOENT || errno == ENOTDIR) return false;
  return disk_error("remove a file", path, errno);
}

}  // namespace geodesic::server
