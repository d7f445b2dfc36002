// geodesicd: geodesic distances and shortest paths on triangle meshes, over HTTP.
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "server/compute_pool.h"
#include "server/config.h"
#include "server/field_queries.h"
#include "server/http_server.h"
#include "server/mesh_catalog.h"
#include "server/mesh_store.h"
#include "server/routes.h"

using namespace geodesic;
using namespace geodesic::server;

namespace {

HttpOptions http_options(const Config& config, const Address& address, const Routes& routes) {
  HttpOptions options;
  options.host = address.host;
  options.port = address.port;
  options.io_threads = config.io_threads;
  options.max_io_threads = 8 * config.io_threads;
  options.keep_alive = std::chrono::seconds(config.keep_alive_seconds);
  options.body_timeout = std::chrono::seconds(config.body_timeout_seconds);
  options.max_body = [&routes](std::string_view method, std::string_view path) {
    return routes.max_body(method, path);
  };
  return options;
}

// Every mesh file of a folder, as if it had been uploaded.
void add_samples(const std::string& folder, MeshCatalog& catalog) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const auto extension = entry.path().extension();
    if (extension == ".glb" || extension == ".gltf" || extension == ".drc") {
      files.push_back(entry.path());
    }
  }
  if (error) spdlog::error("samples: {}: {}", folder, error.message());
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    std::ifstream in(file, std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(in)), {});
    const auto upload = catalog.add(std::move(bytes), {});
    if (upload) {
      spdlog::info("sample {}: {}", file.filename().string(), upload->id);
    } else {
      spdlog::error("sample {}: {}", file.filename().string(), upload.error().detail);
    }
  }
}

// Blocks until the process is asked to stop. The signals were blocked before any
// thread was made, so only this one sees them.
int wait_for_signal(const sigset_t& signals) {
  int signal = 0;
  sigwait(&signals, &signal);
  return signal;
}

int serve(const Config& config, const sigset_t& stop_signals) {
  auto store = MeshStore::open(config.store);
  if (!store) {
    spdlog::critical("{}", store.error().detail);
    return 1;
  }
  ComputePool pool(config.compute_threads, config.queue);
  CatalogLimits limits;
  limits.decode.max_vertices = config.max_vertices;
  limits.decode.max_faces = config.max_faces;
  limits.mesh_cache_bytes = config.mesh_cache_bytes;
  limits.adjacency_cache_bytes = config.adjacency_cache_bytes;
  MeshCatalog catalog(**store, pool, limits);
  FieldQueries queries(catalog, pool, config.field_cache_bytes);
  Routes routes(config, catalog, queries, pool);
  if (!config.samples.empty()) add_samples(config.samples, catalog);

  HttpServer api(http_options(config, config.listen, routes),
                 [&](HttpRequest& request) { return routes.answer(request); });
  HttpServer admin(http_options(config, config.admin_listen, routes),
                   [&](HttpRequest& request) { return routes.answer_admin(request); });
  if (!config.admin_listen.host.empty()) {
    const auto port = admin.start();
    if (!port) {
      spdlog::critical("admin: {}", port.error().detail);
      return 1;
    }
    std::printf("admin listening on http://%s:%d\n", config.admin_listen.host.c_str(), *port);
  }
  const auto port = api.start();
  if (!port) {
    spdlog::critical("{}", port.error().detail);
    return 1;
  }
  // Scripts wait for this line.
  std::printf("listening on http://%s:%d\n", config.listen.host.c_str(), *port);
  std::fflush(stdout);

  const int signal = wait_for_signal(stop_signals);
  spdlog::info("signal {}: draining", signal);
  routes.start_draining();
  const bool complete = api.stop(std::chrono::seconds(config.drain_seconds));
  admin.stop(std::chrono::seconds(1));
  spdlog::info("{}", complete ? "stopped" : "stopped; some requests were cut off");
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  try {
    const auto command =
        read_config(std::vector<std::string>(argv + 1, argv + argc), process_environment());
    if (!command) {
      std::fprintf(stderr, "geodesicd: %s\n", command.error().detail.c_str());
      return 2;
    }
    if (command->print) {
      std::fputs(command->print->c_str(), stdout);
      return 0;
    }
    spdlog::set_level(spdlog::level::from_str(command->config.log_level));
    sigset_t stop_signals;
    sigemptyset(&stop_signals);
    sigaddset(&stop_signals, SIGTERM);
    sigaddset(&stop_signals, SIGINT);
    pthread_sigmask(SIG_BLOCK, &stop_signals, nullptr);
    return serve(command->config, stop_signals);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "geodesicd: %s\n", error.what());
    return 1;
  }
}
