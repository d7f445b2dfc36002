#include "server/program/reload.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include "proto/wire/input_codes.h"
#include "server/config/tokens.h"
#include "server/program/check_config.h"
#include "server/program/memory_limits.h"

namespace geodesic::server {

ComputePool::QueueLimits queue_limits(const Config& config) {
  return {config.queue, config.queue_per_client, std::chrono::seconds(config.queue_seconds)};
}

CatalogLimits catalog_limits(const Config& config) {
  CatalogLimits limits;
  limits.decode.max_vertices = config.max_vertices;
  limits.decode.max_faces = config.max_faces;
  limits.mesh_cache_bytes = config.mesh_cache_bytes;
  limits.adjacency_cache_bytes = config.adjacency_cache_bytes;
  limits.decoder = {config.decoder_memory_bytes, std::chrono::seconds(config.decoder_seconds)};
  return limits;
}

HttpPatience http_patience(const Config& config) {
  return {std::chrono::seconds(config.keep_alive_seconds),
          std::chrono::seconds(config.body_timeout_seconds), config.min_upload_rate};
}

Reload::Reload(const Config& started, Read read, Environment environment, Parts parts)
    : most_queued_(started.queue),
      read_(std::move(read)),
      environment_(std::move(environment)),
      parts_(std::move(parts)),
      config_(started) {}

auto Reload::run() -> Result<Outcome> {
  // What can fail comes first, so that a failure changes nothing.
  const auto command = read_();
  if (!command) return fail(command.error());
  const Config& fresh = command->config;
  if (const auto problems = problems_of(fresh, environment_); !problems.empty()) {
    return fail(InputCode::bad_syntax, fmt::format("{}", fmt::join(problems, "; ")));
  }
  std::optional<Tokens> tokens;
  if (!fresh.tokens.empty()) {
    auto loaded = Tokens::load(fresh.tokens);
    if (!loaded) return fail(std::move(loaded.error()));
    tokens = std::move(*loaded);
  }
  if (parts_.tls) {
    if (auto loaded = parts_.tls->reload(); !loaded) return fail(std::move(loaded.error()));
  }

  // Then what cannot.
  Outcome outcome;
  Config config = *config_.get();
  follow(fresh, config, outcome.changed, outcome.waiting);
  if (config.queue > most_queued_) {
    // What waits holds a thread, and others must be left to say that the queue is full.
    config.queue = most_queued_;
    outcome.waiting.emplace_back("queue");
    if (config.queue == config_->queue) std::erase(outcome.changed, "queue");
  }
  if (tokens) outcome.warnings = tokens->warnings();
  if (parts_.routes.access().is_on() && !tokens) {
    outcome.warnings.emplace_back("no token is asked for any more");
  }
  parts_.routes.access().set_tokens(std::move(tokens));
  parts_.routes.set_config(config);
  parts_.pool.set_limits(queue_limits(config));
  parts_.pool.set_memory_limits(memory_limits(config));
  parts_.catalog.set_limits(catalog_limits(config));
  parts_.queries.set_cache_budget(config.field_cache_bytes);
  for (HttpServer* const listener : parts_.listeners) {
    listener->set_patience(http_patience(config));
    listener->set_max_replies_in_flight(config.reply_memory_bytes);
  }
  spdlog::set_level(spdlog::level::from_str(config.log_level));
  config_.set(std::move(config));
  return outcome;
}

void Reload::run_and_log() {
  const spdlog::level::level_enum before = spdlog::get_level();
  const auto outcome = run();
  if (!outcome) {
    spdlog::error("reload: nothing was changed: {}", outcome.error().detail);
    return;
  }
  // A level that was just switched off must not swallow what came of it.
  const spdlog::level::level_enum after = spdlog::get_level();
  spdlog::set_level(std::min(before, after));
  const auto list = [](const std::vector<std::string>& names) {
    return names.empty() ? std::string("nothing") : fmt::format("{}", fmt::join(names, ", "));
  };
  spdlog::info("reload: changed: {}", list(outcome->changed));
  if (!outcome->waiting.empty()) {
    spdlog::warn("reload: waiting for a restart: {}", list(outcome->waiting));
  }
  for (const std::string& warning : outcome->warnings) spdlog::warn("reload: {}", warning);
  spdlog::info("reload: done{}", parts_.tls ? "; the files of TLS were read again" : "");
  spdlog::set_level(after);
}

}  // namespace geodesic::server
