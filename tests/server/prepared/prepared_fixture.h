// What the tests of prepared meshes share.
#pragma once

#include <doctest/doctest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "server/prepared/prepared_files.h"
#include "tests/fixtures/same_adjacency.h"
#include "tests/fixtures/surface.h"
#include "tests/server/routes/service_fixture.h"

namespace geodesic::server::test {

inline const std::string kId(64, 'a');
inline const auto kNeverStop = [] { return false; };

inline std::shared_ptr<const Adjacency> prepared(const TriangleSoup& soup) {
  return fixtures::Surface(soup).shared();
}

inline std::unique_ptr<PreparedFiles> opened(const TemporaryFolder& folder,
                                             const PreparedFiles::Limits& limits = {},
                                             const std::string& engine = std::string(32, '1'),
                                             std::unique_ptr<PreparedBucket> bucket = nullptr) {
  auto files = PreparedFiles::open(folder.path(), limits, engine, std::move(bucket));
  REQUIRE(files);
  return std::move(*files);
}

inline std::filesystem::path only_file(const TemporaryFolder& folder) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry :
       std::filesystem::directory_iterator(folder.path() / "geodesicd-prepared")) {
    files.push_back(entry.path());
  }
  REQUIRE(files.size() == 1);
  return files.front();
}

inline std::size_t count_files(const TemporaryFolder& folder) { return folder.files().size(); }

inline std::string bytes_of_file(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {(std::istreambuf_iterator<char>(in)), {}};
}

inline void set_contents(const std::filesystem::path& path, const std::string& bytes) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  REQUIRE(::chmod(path.c_str(), 0600) == 0);
}

}  // namespace geodesic::server::test
