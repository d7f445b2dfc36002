// A store in a directory, and what is in that directory.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include "server/config/config.h"
#include "server/store/mesh_store.h"
#include "server/store/open_store.h"

namespace geodesic::server::test {

inline std::unique_ptr<MeshStore> opened(const std::filesystem::path& path,
                                         const StoreBudget& budget = {}) {
  auto store = open_store(path.string(), budget, process_environment());
  REQUIRE(store);
  return std::move(*store);
}

// Where a mesh's bytes are.
inline std::filesystem::path object_of(const std::filesystem::path& root, const std::string& id) {
  return root / "objects" / id.substr(0, 2) / id;
}

inline std::size_t files_below(const std::filesystem::path& path) {
  namespace fs = std::filesystem;
  return static_cast<std::size_t>(
      std::count_if(fs::recursive_directory_iterator(path), fs::recursive_directory_iterator(),
                    [](const fs::directory_entry& entry) { return entry.is_regular_file(); }));
}

}  // namespace geodesic::server::test
