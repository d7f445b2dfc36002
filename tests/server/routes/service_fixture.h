// The whole service but its sockets, in a store of its own that is gone afterwards.
#pragma once

#include <doctest/doctest.h>
#include <stdlib.h>

#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/mesh/shapes.h"
#include "proto/encode/encode_mesh.h"
#include "server/base/reply_file.h"
#include "server/base/sha256.h"
#include "server/compute/pool.h"
#include "server/config/config.h"
#include "server/http/head.h"
#include "server/program/memory_limits.h"
#include "server/program/reload.h"
#include "server/query/field_queries.h"
#include "server/query/mesh_catalog.h"
#include "server/routes/routes.h"
#include "server/store/mesh_store.h"
#include "server/store/open_store.h"

namespace geodesic::server::test {

using nlohmann::json;

class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "service_XXXXXX").string();
    REQUIRE(::mkdtemp(pattern.data()) != nullptr);
    path_ = pattern;
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  // Every file below the folder, by name.
  [[nodiscard]] std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(path_)) {
      if (entry.is_regular_file()) names.push_back(entry.path().filename().string());
    }
    return names;
  }

 private:
  std::filesystem::path path_;
};

inline std::unique_ptr<MeshStore> opened_store(const std::filesystem::path& folder) {
  auto store = open_store(folder.string(), {}, process_environment());
  REQUIRE(store);
  return std::move(*store);
}

class Service {
 public:
  explicit Service(const std::filesystem::path& folder, const Config& config = {},
                   std::size_t slots = 2)
      : Service(opened_store(folder), config, slots) {}
  explicit Service(std::unique_ptr<MeshStore> of, const Config& config = {}, std::size_t slots = 2)
      : store(std::move(of)),
        pool(slots, 256),
        catalog(*store, pool, catalog_limits(config), metrics),
        queries(catalog, pool, config.field_cache_bytes, metrics),
        routes(config, catalog, queries, pool, metrics) {
    pool.set_memory_limits(memory_limits(config));
  }

  HttpResponse ask(std::string method, const std::string& target, std::string body = {},
                   std::vector<NameValue> headers = {}) {
    HttpRequest request;
    request.method = std::move(method);
    request.target = target;
    const std::size_t mark = target.find('?');
    request.path = target.substr(0, mark);
    if (mark != std::string::npos) {
      const auto query = parse_query(target.substr(mark + 1));
      REQUIRE(query);
      request.query = *query;
    }
    request.set_base_path(base_path);
    request.headers = std::move(headers);
    if (const std::string* host = request.header("Host")) request.authority = *host;
    request.body = std::move(body);
    request.id = "test";
    HttpResponse response = routes.answer(request);
    if (response.file) {  // what a client is sent
      std::string bytes(response.file->size(), '\0');
      REQUIRE(response.file->read(0, bytes.data(), bytes.size()) == bytes.size());
      response.body = std::make_shared<const std::string>(std::move(bytes));
    }
    return response;
  }
  HttpResponse get(const std::string& target) { return ask("GET", target); }

  // Uploads and returns the id.
  std::string upload(const std::string& bytes) {
    const HttpResponse response = ask("POST", "/v1/meshes", bytes);
    REQUIRE((response.status == 201 || response.status == 200));
    return json::parse(*response.body)["id"];
  }

  std::string base_path;  // of every request
  std::unique_ptr<MeshStore> store;
  Metrics metrics{"test"};
  ComputePool pool;
  MeshCatalog catalog;
  FieldQueries queries;
  Routes routes;
};

inline std::string glb_of(const TriangleSoup& soup) {
  const std::vector<std::byte> bytes = proto::encode_glb(soup, "test");
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

inline json body_of(const HttpResponse& response) {
  REQUIRE(response.body);
  return json::parse(*response.body);
}

inline std::string header_of(const HttpResponse& response, std::string_view name) {
  for (const auto& [key, value] : response.headers) {
    if (key == name) return value;
  }
  return {};
}

template <class Number>
std::vector<Number> numbers_of(const HttpResponse& response) {
  REQUIRE(response.body);
  std::vector<Number> numbers(response.body->size() / sizeof(Number));
  std::memcpy(numbers.data(), response.body->data(), numbers.size() * sizeof(Number));
  return numbers;
}

}  // namespace geodesic::server::test
