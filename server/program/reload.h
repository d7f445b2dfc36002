// What SIGHUP does: reads the configuration again, from where it came at the start,
// and has the running process follow it as far as it can. All or nothing: unless
// everything can be read, everything stays as it is.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "server/base/current.h"
#include "server/compute/pool.h"
#include "server/config/config.h"
#include "server/edge/server.h"
#include "server/edge/tls.h"
#include "server/query/field_queries.h"
#include "server/query/mesh_catalog.h"
#include "server/routes/routes.h"

namespace geodesic::server {

// How many jobs may wait, by a configuration.
[[nodiscard]] ComputePool::QueueLimits queue_limits(const Config& config);
// What the catalogue may hold.
[[nodiscard]] CatalogLimits catalog_limits(const Config& config);
// How long clients have.
[[nodiscard]] HttpPatience http_patience(const Config& config);

class Reload {
 public:
  // The parts of the process that follow. They must outlive it.
  struct Parts {
    Routes& routes;
    MeshCatalog& catalog;
    FieldQueries& queries;
    ComputePool& pool;
    std::vector<HttpServer*> listeners;
    std::shared_ptr<TlsContext> tls;  // null: plain HTTP
  };
  using Read = std::function<Result<CommandLine>()>;

  // `started` is what the parts were made with. `read` reads all sources again.
  Reload(const Config& started, Read read, Environment environment, Parts parts);

  // What a reload has come to: names of options.
  struct Outcome {
    std::vector<std::string> changed;  // and in force
    std::vector<std::string> waiting;  // differ from what is in force until a restart
    std::vector<std::string> warnings;
  };
  // Fails with why it changed nothing. To be called by one thread at a time.
  [[nodiscard]] Result<Outcome> run();
  // The same, and tells the log.
  void run_and_log();

  // What is in force. Any thread.
  [[nodiscard]] std::shared_ptr<const Config> config() const { return config_.get(); }

 private:
  const std::uint64_t most_queued_;  // there are threads for no more
  const Read read_;
  const Environment environment_;
  const Parts parts_;
  Current<Config> config_;
};

}  // namespace geodesic::server
