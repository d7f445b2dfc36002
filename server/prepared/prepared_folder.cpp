#include "server/prepared/prepared_folder.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <ctime>
#include <random>
#include <system_error>

#include "server/base/durable_file.h"
#include "server/base/service_codes.h"

namespace geodesic::server {
namespace {

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

std::string random_digits() {
  std::random_device random;
  char digits[17];
  std::snprintf(digits, sizeof digits, "%08x%08x", random(), random());
  return digits;
}

struct FileOnDisk {
  std::string name;
  std::uint64_t bytes;
  std::time_t used;
  [[nodiscard]] bool is_unfinished() const { return name.ends_with(kUnfinished); }
};

// Takes the room of a file's bytes before they are written. Some file systems cannot: there only
// the budget knows of it. Returns an errno.
int reserve(int file, std::uint64_t bytes) {
  const auto size = static_cast<off_t>(bytes);
  if (bytes == 0 || ::fallocate(file, 0, 0, size) == 0) return 0;
  if (errno != EOPNOTSUPP && errno != ENOSYS) return errno;
  return ::ftruncate(file, size) == 0 ? 0 : errno;
}

}  // namespace

PartFile::~PartFile() {
  if (file_ && !part_.empty()) (void)::unlinkat(folder_, part_.c_str(), 0);
}

Result<void> PartFile::finish() {
  if (::renameat(folder_, part_.c_str(), folder_, name_.c_str()) != 0) {
    if (errno != ENOENT) return disk_failure("rename a prepared mesh's file", errno);
    return fail(ErrorCode::cancelled, "the mesh was removed");
  }
  part_.clear();
  return {};
}

Result<std::unique_ptr<PreparedFolder>> PreparedFolder::open(const std::filesystem::path& directory,
                                                             std::uint64_t max_bytes) {
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
  return std::unique_ptr<PreparedFolder>(new PreparedFolder(std::move(opened), max_bytes));
}

std::string PreparedFolder::name_of(std::string_view mesh, std::string_view engine) {
  return std::string(mesh) + "." + std::string(engine.substr(0, kEngineDigits));
}

Result<std::vector<std::string>> PreparedFolder::names() const {
  UniqueFd again(::openat(folder_.get(), ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  DIR* const list = again ? ::fdopendir(again.get()) : nullptr;
  if (list == nullptr) return disk_failure("list the prepared meshes", errno);
  (void)again.release();  // it is the list's now
  std::vector<std::string> names;
  while (const dirent* const entry = ::readdir(list)) {
    if (is_ours(entry->d_name)) names.emplace_back(entry->d_name);
  }
  ::closedir(list);
  return names;
}

Result<void> PreparedFolder::remove(const std::string& name) const {
  if (::unlinkat(folder_.get(), name.c_str(), 0) == 0 || errno == ENOENT) return {};
  return disk_failure("remove a prepared mesh's file", errno);
}

void PreparedFolder::touch(const std::string& name) const {
  const timespec now[2] = {{0, UTIME_NOW}, {0, UTIME_NOW}};
  (void)::utimensat(folder_.get(), name.c_str(), now, AT_SYMLINK_NOFOLLOW);
}

Result<PartFile> PreparedFolder::create(const std::string& name, std::uint64_t bytes) {
  const std::lock_guard lock(making_room_);
  const auto has_room = make_room(bytes);
  if (!has_room) return fail(has_room.error());
  if (!*has_room) return fail(ServiceCode::store_full, "a mesh has no room");
  std::string part = name + "." + random_digits() + std::string(kUnfinished);
  UniqueFd file(::openat(folder_.get(), part.c_str(),
                         O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600));
  if (!file) return disk_failure("create a prepared mesh's file", errno);
  PartFile made(folder_.get(), std::move(file), std::move(part), name);
  if (const int error = reserve(made.descriptor(), bytes); error != 0) {
    return disk_failure("take the room of a prepared mesh's file", error);
  }
  return made;
}

Result<void> PreparedFolder::tidy() {
  const std::lock_guard lock(making_room_);
  const auto done = make_room(0);
  if (!done) return fail(done.error());
  return {};
}

Result<bool> PreparedFolder::make_room(std::uint64_t bytes) {
  auto found = names();
  if (!found) return fail(std::move(found.error()));
  std::vector<FileOnDisk> files;
  for (std::string& name : *found) {
    struct stat about {};
    if (::fstatat(folder_.get(), name.c_str(), &about, AT_SYMLINK_NOFOLLOW) != 0) continue;
    const auto size = static_cast<std::uint64_t>(about.st_size);
    files.push_back({std::move(name), size, about.st_mtim.tv_sec});
  }
  std::sort(files.begin(), files.end(),
            [](const FileOnDisk& a, const FileOnDisk& b) { return a.used < b.used; });
  struct statvfs disk {};
  if (::fstatvfs(folder_.get(), &disk) != 0) return disk_failure("ask for the disk's room", errno);
  const std::uint64_t kept_free = std::uint64_t{disk.f_blocks} * disk.f_frsize / kFreePart;
  std::uint64_t free = std::uint64_t{disk.f_bavail} * disk.f_frsize;
  std::uint64_t taken = 0;
  std::uint64_t unfinished = 0;
  for (const FileOnDisk& file : files) {
    taken += file.bytes;
    if (file.is_unfinished()) unfinished += file.bytes;
  }
  const auto fits = [&](std::uint64_t others, std::uint64_t still_free) {
    return (max_bytes_ == 0 || others + bytes <= max_bytes_) && still_free >= kept_free + bytes;
  };
  // A file that could not fit even after removing all others makes none of them go.
  const bool is_possible = fits(unfinished, free + taken - unfinished);
  const std::time_t now = std::time(nullptr);
  for (const FileOnDisk& file : files) {
    const bool is_old = file.used < now - (file.is_unfinished() ? kLongestWriting : kLongestUnused);
    const bool makes_room =
        !file.is_unfinished() && !fits(taken, free) && (is_possible || bytes == 0);
    if (!is_old && !makes_room) continue;
    if (!remove(file.name)) continue;
    taken -= file.bytes;
    free += file.bytes;
  }
  const bool has_room = fits(taken, free);
  bytes_ = taken + (has_room ? bytes : 0);
  return has_room;
}

}  // namespace geodesic::server
