// Files that survive a crash: POSIX calls as values, each with the error's number.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/error.h"

namespace geodesic::server {

// A file descriptor that closes itself.
class File {
 public:
  explicit File(int descriptor) : descriptor_(descriptor) {}
  File(File&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  File& operator=(File&&) = delete;
  ~File();
  [[nodiscard]] int get() const { return descriptor_; }
  explicit operator bool() const { return descriptor_ >= 0; }

 private:
  int descriptor_;
};

// What a client may see of an errno: no path. `store_full` when there is no space
// left (no blocks, no quota, over a limit on file sizes), `store_failed` otherwise.
[[nodiscard]] tl::unexpected<Error> disk_failure(std::string_view what, int error);

// The same, after the log was told where.
[[nodiscard]] tl::unexpected<Error> disk_error(std::string_view what,
                                               const std::filesystem::path& path, int error);

// Makes the names in a directory survive a loss of power.
[[nodiscard]] Result<void> sync_directory(const std::filesystem::path& directory);

// Creates a directory below an existing one, durably. One that is there is made durable
// as well: who created it may have ended before that.
[[nodiscard]] Result<void> make_directory(const std::filesystem::path& directory);

// The same with all directories above it. Of those that are there and that this process may
// not read, it is taken that they will stay.
[[nodiscard]] Result<void> make_directories(const std::filesystem::path& directory);

// Creates a file, which must not be there, and makes its bytes survive a loss of
// power; not its name.
[[nodiscard]] Result<void> write_file(const std::filesystem::path& path, std::string_view bytes);

// The bytes of a file; nothing if there is no such file.
[[nodiscard]] Result<std::optional<std::string>> read_file(const std::filesystem::path& path);

// Whether there was such a file.
[[nodiscard]] Result<bool> remove_file(const std::filesystem::path& path);

}  // namespace geodesic::server
