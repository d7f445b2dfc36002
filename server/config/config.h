// The process's settings: a flag beats an environment variable (GEODESICD_…)
// beats the JSON file (--config FILE) beats the default. One table holds every
// option's name, default and help; flags, variables, file keys, `--help`,
// `--print-config` and the README's table all come from it.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "server/config/values.h"

namespace geodesic::server {

struct Config {
  Address listen{"127.0.0.1", 8080};
  Address admin_listen;         // host empty: admin routes stay on the API's listener
  std::string base_path;        // such as /geo; empty: none
  std::string trusted_proxies;  // addresses and ranges; empty: none
  std::string forwarded_header = "x-forwarded-for";            // or forwarded
  std::string proxy_protocol = "off";                          // or v2
  std::string store = "./geodesicd-store";                     // or s3://…
  std::uint64_t store_max_bytes = 0;                           // 0: no limit
  std::string store_when_full = "refuse";                      // or evict
  std::string prepared;                                        // directory; empty: none
  std::uint64_t prepared_max_bytes = std::uint64_t{10} << 30;  // 0: no limit
  std::uint64_t prepared_min_faces = 20'000;
  std::string prepared_bucket;  // s3://…; empty: none
  std::string samples;          // empty: none
  std::string viewer;           // empty: a plain page instead
  std::string docs;             // empty: the API's page alone

  std::string tls_cert;  // empty: plain HTTP
  std::string tls_key;
  std::string tls_ticket_keys;  // empty: each process has its own
  std::string tokens;           // empty: everybody may do everything
  std::string cors_origins = "*";
  std::string cors_write_origins;  // empty: only our own

  std::uint64_t io_threads = 64;
  std::uint64_t max_connections = 10'000;
  std::uint64_t compute_threads = 0;  // 0: one a core, fewer by a control group's quota
  std::uint64_t queue = 256;
  std::uint64_t queue_per_client = 0;  // 0: no bound
  std::uint64_t queue_seconds = 10;    // 0: no bound

  std::uint64_t query_memory_bytes = std::uint64_t{1} << 30;
  std::uint64_t compute_memory_bytes = 0;  // 0: what there is (memory_limits.h)

  std::uint64_t max_body_bytes = std::uint64_t{256} << 20;
  std::uint64_t max_json_bytes = std::uint64_t{8} << 20;
  std::uint64_t max_vertices = 20'000'000;
  std::uint64_t max_faces = 40'000'000;

  std::string decoder = "process";  // or in-process
  std::uint64_t decoder_memory_bytes = std::uint64_t{2} << 30;
  std::uint64_t decoder_seconds = 60;

  std::uint64_t mesh_cache_bytes = std::uint64_t{512} << 20;
  std::uint64_t adjacency_cache_bytes = std::uint64_t{1536} << 20;
  std::uint64_t field_cache_bytes = std::uint64_t{768} << 20;
  std::uint64_t reply_cache_bytes = std::uint64_t{256} << 20;
  std::uint64_t reply_memory_bytes = std::uint64_t{1} << 30;

  std::uint64_t body_timeout_seconds = 300;
  std::uint64_t min_upload_rate = std::uint64_t{1} << 10;  // bytes a second; 0: any
  std::uint64_t keep_alive_seconds = 75;
  std::uint64_t drain_delay_seconds = 0;
  std::uint64_t drain_seconds = 20;

  std::uint64_t max_jobs = 64;
  std::uint64_t job_result_bytes = std::uint64_t{256} << 20;
  std::uint64_t job_seconds = 600;
  std::uint64_t job_lease_seconds = 120;

  std::string log_level = "info";
};

// What the command line asks for.
struct CommandLine {
  Config config;
  // Set by --help, --version, --print-config, --print-config-table and --make-token:
  // write this to the standard output and exit with 0.
  std::optional<std::string> print;
  // --check-config: say what is wrong (check_config.h) and exit. `problems` are those
  // of the values, and `config` is what could be read.
  bool check = false;
  std::vector<Error> problems;
};

// Looks a variable up; empty optional: not set.
using Environment = std::function<std::optional<std::string>(const std::string& name)>;
[[nodiscard]] Environment process_environment();

// Merges all sources. `arguments` without the program's name. Fails with the first
// problem, unless all are asked for (--check-config): `bad_syntax` (`unknown_parameter`
// for a flag or key that does not exist) and a sentence that names the source, such as
// "GEODESICD_QUEUE: 'many' is not a whole number".
[[nodiscard]] Result<CommandLine> read_config(const std::vector<std::string>& arguments,
                                              const Environment& environment);

// Has a running process's configuration follow a fresh one: what can change while it
// runs is taken over into `running` and named in `changed`; what else differs is
// named in `waiting`.
void follow(const Config& fresh, Config& running, std::vector<std::string>& changed,
            std::vector<std::string>& waiting);

// The options as a Markdown table, for the README.
[[nodiscard]] std::string config_table();

}  // namespace geodesic::server
