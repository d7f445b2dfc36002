// Prepared meshes in a bucket of object storage, behind the directories of many machines: what one
// server has prepared, another one of the same build fetches. Objects are the files, under their
// names:
//
//   PREFIXprepared/<name>
//
// All methods may be called from any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "core/base/error.h"
#include "server/s3/s3_client.h"
#include "server/s3/s3_location.h"

namespace geodesic::server {

class PreparedBucket {
 public:
  explicit PreparedBucket(S3Location location) : client_(std::move(location)) {}

  // How many bytes an object has; nothing if it is not there.
  [[nodiscard]] Result<std::optional<std::uint64_t>> find(const std::string& name);
  // Writes an object of so many bytes to an open file. Gives up after as long as preparing the mesh
  // anew may take, and then everybody does for some seconds. `stop`: as `S3Request` has it.
  // Errors: cancelled, and those of `S3Client::send`.
  [[nodiscard]] Result<void> read(const std::string& name, std::uint64_t bytes, int file,
                                  const std::function<bool()>& stop);
  [[nodiscard]] Result<void> write(const std::string& name, std::span<const std::byte> bytes,
                                   const std::function<bool()>& stop);
  [[nodiscard]] Result<void> erase(const std::string& name);
  // Erases the objects whose names begin so.
  [[nodiscard]] Result<void> erase_all(const std::string& beginning);

 private:
  [[nodiscard]] std::string key_of(const std::string& name) const;

  S3Client client_;  // not the store's: its rests and its waiting are its own
};

}  // namespace geodesic::server
