#include "server/program/check_config.h"

#include <filesystem>
#include <system_error>

#include "server/config/tokens.h"
#include "server/edge/ticket_keys.h"
#include "server/edge/tls.h"
#include "server/routes/static_files.h"
#include "server/s3/s3_location.h"

namespace geodesic::server {

std::vector<std::string> problems_of(const Config& config, const Environment& environment) {
  std::vector<std::string> problems;
  if (!config.tokens.empty()) {
    if (const auto tokens = Tokens::load(config.tokens); !tokens) {
      problems.push_back("tokens: " + tokens.error().detail);
    }
  }
  if (!config.tls_cert.empty() && !config.tls_key.empty()) {
    if (const auto pair = TlsContext::load({config.tls_cert, config.tls_key, {}}); !pair) {
      problems.push_back("tls-cert, tls-key: " + pair.error().detail);
    }
  }
  if (!config.tls_ticket_keys.empty()) {
    if (const auto keys = TicketKeys::load(config.tls_ticket_keys); !keys) {
      problems.push_back("tls-ticket-keys: " + keys.error().detail);
    }
  }
  const auto check_files = [&](const std::string& folder, const StaticFiles::Place& place) {
    if (folder.empty()) return;
    if (const auto files = StaticFiles::load(folder, place); !files) {
      problems.push_back(files.error().detail);
    }
  };
  check_files(config.viewer, StaticFiles::kViewer);
  check_files(config.docs, StaticFiles::kDocs);
  if (config.store.empty()) {
    problems.emplace_back("store: a place is required");
  } else if (is_s3_url(config.store)) {
    if (const auto location = parse_s3_url(config.store, environment); !location) {
      problems.push_back("store: " + location.error().detail);
    }
  }
  if (!config.prepared_bucket.empty()) {
    if (const auto location = parse_s3_url(config.prepared_bucket, environment); !location) {
      problems.push_back("prepared-bucket: " + location.error().detail);
    }
  }
  return problems;
}

std::string check_config(const CommandLine& command, const Environment& environment) {
  std::string out;
  for (const Error& problem : command.problems) out += problem.detail + "\n";
  for (const std::string& problem : problems_of(command.config, environment)) out += problem + "\n";
  // Read at the start only, so a reload does not need them.
  if (const std::string& samples = command.config.samples; !samples.empty()) {
    std::error_code error;
    const std::filesystem::directory_iterator files(samples, error);
    if (error) out += "samples: " + samples + ": " + error.message() + "\n";
  }
  return out;
}

}  // namespace geodesic::server
