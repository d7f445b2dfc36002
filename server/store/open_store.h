// Opens the store that a name stands for: `s3://…` is object storage
// (s3_location.h), anything else a local directory.
#pragma once

#include <memory>
#include <string>

#include "core/base/error.h"
#include "server/config/config.h"
#include "server/store/mesh_store.h"

namespace geodesic::server {

// Errors are for the operator, and name the store.
[[nodiscard]] Result<std::unique_ptr<MeshStore>> open_store(const std::string& name,
                                                            const StoreBudget& budget,
                                                            const Environment& environment);

}  // namespace geodesic::server
