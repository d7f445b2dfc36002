// A file mapped into memory, to be read. All processes that map it share its pages.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>

#include "core/base/error.h"
#include "server/base/unique_fd.h"

namespace geodesic::server {

// A file that is open to be read.
struct ReadableFile {
  UniqueFd descriptor;  // none: there is no such file, or somebody else could write to it
  std::uint64_t bytes = 0;
};
[[nodiscard]] ReadableFile open_to_read(const UniqueFd& directory, const char* name);

class MappedFile {
 public:
  // What is done with the file's bytes, piece by piece, before it is mapped. `offset`: of the
  // piece.
  using Visit = std::function<void(std::uint64_t offset, std::span<const std::byte> piece)>;

  // Reads the whole file, then maps it, and sets its time of use to now. The first read is by
  // pread, so that a fault of the disk is an error. A mapped page that the disk cannot deliver
  // later ends the process (SIGBUS), and so does cutting the file short. Removing or replacing it
  // is safe. Null: there is no such file, it cannot be read, or somebody else could write to it.
  // `stop` is called once for each MiB. Errors: cancelled.
  [[nodiscard]] static Result<std::shared_ptr<const MappedFile>> open(
      const UniqueFd& directory, const char* name, const Visit& visit,
      const std::function<bool()>& stop);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  // At the beginning of a page.
  [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }

 private:
  explicit MappedFile(std::span<const std::byte> bytes) : bytes_(bytes) {}

  const std::span<const std::byte> bytes_;
};

}  // namespace geodesic::server
