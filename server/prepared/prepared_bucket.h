// Prepared meshes in a bucket of object storage, behind the directories of many machines: what one
// server has prepared, another one of the same build fetches. Objects are the files, under their
// names:
//
//   PREFIXprepared/<name>
//
// Each request is tried once and has a time of its own. After one that fails, none is sent for some
// seconds. All methods may be called from any thread. Errors are those of `S3Client::send`.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "server/s3/s3_client.h"
#include "server/s3/s3_location.h"

namespace geodesic::server {

class PreparedBucket {
 public:
  explicit PreparedBucket(S3Location location)
      : client_(std::move(location), "bucket of prepared meshes") {}

  // Writes an object to the file that `open_file` names, given how long it is. Says whether there
  // is one. Gives up after one second, and one more for each 100 MB. `open_file`, `stop`: as
  // `S3Request` has them. Further errors: store_full if the file was refused; store_failed if the
  // disk fails.
  [[nodiscard]] Result<bool> read(const std::string& name,
                                  const std::function<std::optional<int>(std::uint64_t)>& open_file,
                                  const std::function<bool()>& stop);
  // Whether an object is there that has so many bytes, as far as the bucket tells.
  [[nodiscard]] Result<bool> has(const std::string& name, std::uint64_t bytes,
                                 const std::function<bool()>& stop);
  // Writes one from an open file. Gives up after ten seconds, and one more for each 20 MB.
  [[nodiscard]] Result<void> write(const std::string& name, int file, std::uint64_t bytes,
                                   const std::function<bool()>& stop);
  // Two seconds at the most.
  [[nodiscard]] Result<void> erase(const std::string& name);
  // Erases the objects whose names begin so. Ten seconds at the most.
  [[nodiscard]] Result<void> erase_all(const std::string& beginning);

 private:
  [[nodiscard]] std::string key_of(const std::string& name) const;

  S3Client client_;  // not the store's: its rests and its waiting are its own
};

}  // namespace geodesic::server
