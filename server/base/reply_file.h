// A reply's body in a file. It is read while it is sent. So it is never in memory as a whole,
// however large it is and however many clients take it at once.
#pragma once

#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "server/base/durable_file.h"

namespace geodesic::server {

class ReplyFile {
 public:
  // Takes over the file, which must not change any more.
  ReplyFile(File file, std::uint64_t size) : file_(std::move(file)), size_(size) {}

  [[nodiscard]] std::uint64_t size() const { return size_; }

  // Reads up to `size` bytes from `offset`. Returns how many it read: 0 at the end or on an error.
  // Any number of threads may read at once.
  [[nodiscard]] std::size_t read(std::uint64_t offset, char* out, std::size_t size) const {
    ssize_t count;
    do {
      count = ::pread(file_.get(), out, size, static_cast<off_t>(offset));
    } while (count < 0 && errno == EINTR);
    return count > 0 ? static_cast<std::size_t>(count) : 0;
  }

 private:
  const File file_;
  const std::uint64_t size_;
};

}  // namespace geodesic::server
