#include "server/prepared/mapped_file.h"

#include <fcntl.h>
#include <spdlog/spdlog.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <system_error>
#include <utility>
#include <vector>

namespace geodesic::server {
namespace {

constexpr std::size_t kAtOnce = std::size_t{1} << 20;  // bytes between two calls of `stop`

enum class Outcome : std::uint8_t { done, failed, cancelled };

Outcome read_all(int file, std::uint64_t size, const MappedFile::Visit& visit,
                 const std::function<bool()>& stop) {
  std::vector<std::byte> piece(std::min<std::uint64_t>(size, kAtOnce));
  for (std::uint64_t offset = 0; offset < size;) {
    if (stop()) return Outcome::cancelled;
    const ssize_t count = ::pread(file, piece.data(), piece.size(), static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      spdlog::warn("a prepared mesh cannot be read: {}",
                   count < 0 ? std::generic_category().message(errno) : "it was cut short");
      return Outcome::failed;
    }
    visit(offset, std::span(piece).first(static_cast<std::size_t>(count)));
    offset += static_cast<std::uint64_t>(count);
  }
  return Outcome::done;
}

}  // namespace

ReadableFile open_to_read(const UniqueFd& directory, const char* name) {
  UniqueFd file(::openat(directory.get(), name, O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  struct stat about {};
  if (!file || ::fstat(file.get(), &about) != 0) return {};
  const bool is_ours =
      S_ISREG(about.st_mode) && about.st_uid == ::geteuid() && (about.st_mode & 0022U) == 0;
  if (!is_ours) return {};
  return {std::move(file), static_cast<std::uint64_t>(about.st_size)};
}

Result<std::shared_ptr<const MappedFile>> MappedFile::open(const UniqueFd& directory,
                                                           const char* name, const Visit& visit,
                                                           const std::function<bool()>& stop) {
  const ReadableFile opened = open_to_read(directory, name);
  const UniqueFd& file = opened.descriptor;
  const auto size = static_cast<std::size_t>(opened.bytes);
  if (!file || size == 0) return nullptr;
  (void)::posix_fadvise(file.get(), 0, 0, POSIX_FADV_SEQUENTIAL);
  const Outcome outcome = read_all(file.get(), size, visit, stop);
  if (outcome == Outcome::cancelled) return fail(ErrorCode::cancelled, "stopped");
  if (outcome == Outcome::failed) return nullptr;
  void* const at = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, file.get(), 0);
  if (at == MAP_FAILED) return nullptr;
  const timespec now[2] = {{0, UTIME_NOW}, {0, UTIME_NOW}};
  (void)::futimens(file.get(), now);
  return std::shared_ptr<const MappedFile>(
      new MappedFile({static_cast<const std::byte*>(at), size}));
}

MappedFile::~MappedFile() { ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size()); }

}  // namespace geodesic::server
