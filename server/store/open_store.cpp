#include "server/store/open_store.h"

#include <utility>

#include "server/s3/s3_location.h"
#include "server/store/directory_storage.h"
#include "server/store/s3_storage.h"

namespace geodesic::server {

Result<std::unique_ptr<MeshStore>> open_store(const std::string& name, const StoreBudget& budget,
                                              const Environment& environment) {
  if (!is_s3_url(name)) {
    auto directory = DirectoryStorage::open(name);
    if (!directory) return fail(std::move(directory.error()));
    return MeshStore::open(std::move(*directory), budget);
  }
  auto location = parse_s3_url(name, environment);
  if (!location) return fail(std::move(location.error()));
  return MeshStore::open(std::make_unique<S3Storage>(std::move(*location)), budget);
}

}  // namespace geodesic::server
