// geodesicd: geodesic distances and shortest paths on triangle meshes, over HTTP.
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/wire/mesh_name.h"
#include "server/base/memory_trimmer.h"
#include "server/compute/pool.h"
#include "server/config/config.h"
#include "server/config/tokens.h"
#include "server/decoder/process.h"
#include "server/decoder/processes.h"
#include "server/edge/server.h"
#include "server/edge/tls.h"
#include "server/metrics/metrics.h"
#include "server/prepared/prepared_files.h"
#include "server/program/check_config.h"
#include "server/program/memory_limits.h"
#include "server/program/reload.h"
#include "server/query/field_queries.h"
#include "server/query/mesh_catalog.h"
#include "server/routes/engine_digest.h"
#include "server/routes/routes.h"
#include "server/routes/static_files.h"
#include "server/s3/s3_location.h"
#include "server/store/job_records.h"
#include "server/store/mesh_store.h"
#include "server/store/monitor.h"
#include "server/store/open_store.h"

using namespace geodesic;
using namespace geodesic::server;

namespace {

// Allows as many open files as the system lets us. Returns for how many connections
// that is enough.
std::uint64_t allow_connections(std::uint64_t wanted) {
  constexpr rlim_t kOtherFiles = 256;
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return wanted;
  const rlim_t needed = std::max<rlim_t>(wanted + kOtherFiles, limit.rlim_cur);
  limit.rlim_cur = std::min(limit.rlim_max, needed);
  ::setrlimit(RLIMIT_NOFILE, &limit);
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur >= wanted + kOtherFiles) {
    return wanted;
  }
  const rlim_t possible =
      limit.rlim_cur > 2 * kOtherFiles ? limit.rlim_cur - kOtherFiles : limit.rlim_cur / 2;
  spdlog::warn("the limit of open files allows {} connections only", possible);
  return possible;
}

HttpOptions http_options(const Config& config, const Address& address, const Routes& routes,
                         std::uint64_t slots, std::uint64_t connections) {
  HttpOptions options;
  options.host = address.host;
  options.port = address.port;
  options.base_path = config.base_path;
  // What the configuration holds was read as such.
  options.trusted_proxies = AddressRanges::parse(config.trusted_proxies).value_or(AddressRanges());
  options.forwarded_header = config.forwarded_header == "forwarded"
                                 ? ForwardedHeader::forwarded
                                 : ForwardedHeader::x_forwarded_for;
  options.expects_proxy_header = config.proxy_protocol == "v2";
  options.io_threads = config.io_threads;
  // Each computation that runs or waits holds a thread: there must be others, which
  // tell the next client that the queue is full.
  options.max_io_threads = config.io_threads + config.queue + slots + 64;
  options.max_connections = connections;
  options.keep_alive = std::chrono::seconds(config.keep_alive_seconds);
  options.body_timeout = std::chrono::seconds(config.body_timeout_seconds);
  options.min_receive_rate = config.min_upload_rate;
  // One body as large as may be must have room.
  options.max_bodies_in_flight = std::max(options.max_bodies_in_flight, config.max_body_bytes);
  options.max_replies_in_flight = config.reply_memory_bytes;
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
    constexpr std::array kExtensions{".glb", ".gltf", ".drc", ".obj", ".ply", ".stl"};
    if (std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end()) {
      files.push_back(entry.path());
    }
  }
  if (error) spdlog::error("samples: {}: {}", folder, error.message());
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    std::ifstream in(file, std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(in)), {});
    const std::string name = file.filename().string();
    const auto upload =
        catalog.add(std::move(bytes), {}, {}, proto::is_mesh_name(name) ? name : std::string());
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

// The same, but gives up after `patience`; SIGHUP does not end it.
void wait_to_be_stopped(sigset_t signals, std::chrono::seconds patience) {
  sigdelset(&signals, SIGHUP);
  timespec timeout{};
  timeout.tv_sec = static_cast<std::time_t>(patience.count());
  sigtimedwait(&signals, nullptr, &timeout);
}

// The files of a folder; none if no folder is named. Nothing, and a line of the log, where that
// fails.
std::optional<StaticFiles> files_of(const std::string& folder, const StaticFiles::Place& place) {
  if (folder.empty()) return StaticFiles();
  auto loaded = StaticFiles::load(folder, place);
  if (!loaded) {
    spdlog::critical("{}", loaded.error().detail);
    return std::nullopt;
  }
  return std::move(*loaded);
}

// Null if there is no directory for them.
Result<std::unique_ptr<PreparedFiles>> open_prepared_files(const Config& config) {
  if (config.prepared.empty()) return nullptr;
  std::unique_ptr<PreparedBucket> bucket;
  if (!config.prepared_bucket.empty()) {
    auto location = parse_s3_url(config.prepared_bucket, process_environment());
    if (!location) return fail(std::move(location.error()));
    if (location->is_exposed()) {
      spdlog::warn(
          "prepared-bucket: what it sends is used as it is, and passes unencrypted: whoever can "
          "change it takes over this server. Name an https:// endpoint.");
    }
    bucket = std::make_unique<PreparedBucket>(std::move(*location));
  }
  return PreparedFiles::open(config.prepared,
                             {config.prepared_max_bytes, config.prepared_min_faces},
                             std::string(engine_digest()), std::move(bucket));
}

// `read` reads the configuration anew.
int serve(const Config& config, const Reload::Read& read, const sigset_t& stop_signals) {
  StoreBudget budget;
  budget.max_bytes = config.store_max_bytes;
  budget.when_full = config.store_when_full == "evict" ? WhenFull::evict : WhenFull::refuse;
  auto store = open_store(config.store, budget, process_environment());
  if (!store) {
    spdlog::critical("{}", store.error().detail);
    return 1;
  }
  const MemoryTrimmer trimmer(std::chrono::seconds(10));
  JobRecords job_records((*store)->storage(), {.bytes = config.job_result_bytes,
                                               .keep = std::chrono::seconds(config.job_seconds)});
  const StoreMonitor monitor(**store, std::chrono::seconds(5), [&] { job_records.tidy(); });
  std::shared_ptr<TlsContext> tls;
  if (!config.tls_cert.empty()) {
    auto loaded = TlsContext::load({config.tls_cert, config.tls_key, config.tls_ticket_keys});
    if (!loaded) {
      spdlog::critical("{}", loaded.error().detail);
      return 1;
    }
    tls = std::move(*loaded);
  }
  std::optional<Tokens> tokens;
  if (!config.tokens.empty()) {
    auto loaded = Tokens::load(config.tokens);
    if (!loaded) {
      spdlog::critical("tokens: {}", loaded.error().detail);
      return 1;
    }
    for (const std::string& warning : loaded->warnings()) spdlog::warn("tokens: {}", warning);
    tokens = std::move(*loaded);
  }
  auto viewer = files_of(config.viewer, StaticFiles::kViewer);
  auto docs = files_of(config.docs, StaticFiles::kDocs);
  if (!viewer || !docs) return 1;
  auto prepared_files = open_prepared_files(config);
  if (!prepared_files) {
    spdlog::critical("{}", prepared_files.error().detail);
    return 1;
  }
  std::unique_ptr<DecoderProcesses> decoders;
  if (config.decoder == "process") {
    auto started = DecoderProcesses::start("/proc/self/exe", catalog_limits(config).decoder);
    if (!started) {
      spdlog::critical("{}", started.error().detail);
      return 1;
    }
    decoders = std::move(*started);
  }
  Metrics metrics(GEODESIC_VERSION);
  ComputePool pool(config.compute_threads, queue_limits(config));
  pool.set_memory_limits(memory_limits(config));
  pool.observe_waits([&](StageTimes::Duration waited) { metrics.queued(waited.count()); });
  MeshCatalog catalog(**store, pool, catalog_limits(config), metrics, decoders.get());
  if (*prepared_files) catalog.keep_prepared_in(**prepared_files);
  FieldQueries queries(catalog, pool, config.field_cache_bytes, metrics);
  Routes routes(config, catalog, queries, pool, metrics);
  routes.access().set_tokens(std::move(tokens));
  routes.keep_jobs_in(job_records);
  routes.set_viewer(std::move(*viewer));
  routes.set_docs(std::move(*docs));
  if (!config.samples.empty()) add_samples(config.samples, catalog);

  const std::uint64_t connections = allow_connections(config.max_connections);
  HttpOptions api_options = http_options(config, config.listen, routes, pool.slots(), connections);
  api_options.tls = tls;
  api_options.wants_body = [&](HttpRequest& request) { return routes.wants_body(request); };
  api_options.finished = [&](const HttpFinished& end) {
    metrics.request(end.method, end.route, end.status, end.seconds, end.bytes_in, end.bytes_out);
  };
  // A listener of its own has threads and places of its own: probes are answered
  // however busy the API is.
  HttpOptions admin_options = http_options(config, config.admin_listen, routes, 0, 64);
  admin_options.expects_proxy_header = false;  // who probes it is no client behind a proxy
  admin_options.io_threads = 2;
  admin_options.max_io_threads = 16;
  // A process that serves nobody had better end, so that somebody starts another.
  std::atomic<bool> has_failed{false};
  api_options.failed = admin_options.failed = [&](const std::string&) {
    has_failed = true;
    ::kill(::getpid(), SIGTERM);
  };
  HttpServer api(std::move(api_options),
                 [&](HttpRequest& request) { return routes.answer(request); });
  HttpServer admin(std::move(admin_options),
                   [&](HttpRequest& request) { return routes.answer_admin(request); });
  routes.watch_listener([&] {
    const HttpServer::Stats stats = api.stats();
    return Routes::Listener{stats.connections, stats.accept_failures, stats.is_accepting};
  });
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
  std::printf("listening on %s://%s:%d\n", tls ? "https" : "http", config.listen.host.c_str(),
              *port);
  std::fflush(stdout);

  Reload reload(config, read, process_environment(),
                {routes, catalog, queries, pool, {&api, &admin}, tls});
  int signal;
  while ((signal = wait_for_signal(stop_signals)) == SIGHUP) reload.run_and_log();
  if (has_failed) {
    spdlog::critical("the server ends: nobody can reach it any more");
  } else {
    spdlog::info("signal {}: draining", signal);
  }
  api.close_after_replies();
  routes.start_draining();
  // Whoever asks a second time does not want to wait.
  const std::chrono::seconds delay(reload.config()->drain_delay_seconds);
  if (!has_failed && delay.count() > 0) {
    spdlog::info("for {} s /readyz says so, and connections end with their replies", delay.count());
    wait_to_be_stopped(stop_signals, delay);
  }
  const bool complete = api.stop(std::chrono::seconds(reload.config()->drain_seconds));
  admin.stop(std::chrono::seconds(1));
  routes.end_jobs();
  spdlog::info("{}", complete ? "stopped" : "stopped; some requests were cut off");
  return has_failed ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (is_decoder_process(argc, argv)) return run_decoder_process();
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  try {
    const Reload::Read read = [arguments = std::vector<std::string>(argv + 1, argv + argc)] {
      return read_config(arguments, process_environment());
    };
    const auto command = read();
    if (!command) {
      std::fprintf(stderr, "geodesicd: %s\n", command.error().detail.c_str());
      return 2;
    }
    if (command->check) {
      const std::string problems = check_config(*command, process_environment());
      std::fputs(problems.c_str(), stderr);
      if (problems.empty()) std::puts("configuration is valid");
      return problems.empty() ? 0 : 2;
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
    sigaddset(&stop_signals, SIGHUP);
    pthread_sigmask(SIG_BLOCK, &stop_signals, nullptr);
    // A file over a limit on sizes is an error of that write, not the end of the process.
    std::signal(SIGXFSZ, SIG_IGN);
    return serve(command->config, read, stop_signals);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "geodesicd: %s\n", error.what());
    return 1;
  }
}
