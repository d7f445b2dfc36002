#include "server/config/config.h"

#include <spdlog/fmt/fmt.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <system_error>
#include <variant>

#include "proto/wire/input_codes.h"
#include "proto/wire/json_outline.h"
#include "server/config/tokens.h"

namespace geodesic::server {

namespace {

enum class Kind { text, whole_number, bytes, address, level, when_full, decoder };

using Member = std::variant<std::string Config::*, std::uint64_t Config::*, Address Config::*>;

struct Option {
  std::string_view name;  // of the flag, without dashes; file keys are the same
  Kind kind;
  Member member;
  std::string_view value_hint;
  std::string_view help;
  std::uint64_t least = 0;
  std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
  bool follows = false;  // a running process takes a new value over when it reloads
};
constexpr bool follows = true;

constexpr std::uint64_t max_threads = 4096;
constexpr std::uint64_t max_seconds = 86400;
constexpr std::uint64_t max_queue = 4096;         // each holds a thread
constexpr std::uint64_t max_index = 0xffff'fffe;  // vertices and faces are 32-bit indices
constexpr std::uint64_t no_bound = std::numeric_limits<std::uint64_t>::max();

// The one table. Defaults are those of `Config`.
std::span<const Option> options() {
  static const std::array table{
      Option{"listen", Kind::address, &Config::listen, "HOST:PORT",
             "Where the API listens; port 0 takes any free one, printed at the start"},
      Option{"admin-listen", Kind::address, &Config::admin_listen, "HOST:PORT",
             "Where probes and metrics listen; empty: on the API's listener"},
      Option{"tls-cert", Kind::text, &Config::tls_cert, "FILE",
             "PEM certificate (with its chain) of the API's listener; empty: plain HTTP"},
      Option{"tls-key", Kind::text, &Config::tls_key, "FILE", "PEM key of that certificate"},
      Option{"tokens", Kind::text, &Config::tokens, "FILE",
             "Tokens that clients need, a line each: NAME SCOPES SHA256; empty: none is asked for",
             0, no_bound, follows},
      Option{"cors-origins", Kind::text, &Config::cors_origins, "ORIGINS",
             "Origins whose pages may call the API, with commas between them; *: any; empty: none"},
      Option{"cors-write-origins", Kind::text, &Config::cors_write_origins, "ORIGINS",
             "Of these, whose pages may also upload and delete, beside the server's own; *: any"},
      Option{"store", Kind::text, &Config::store, "PLACE",
             "Directory of the uploaded meshes, or s3://BUCKET/PREFIX?endpoint=URL&region=NAME"},
      Option{"store-max-bytes", Kind::bytes, &Config::store_max_bytes, "BYTES",
             "Most bytes in the store; 0: no limit"},
      Option{"store-when-full", Kind::when_full, &Config::store_when_full, "POLICY",
             "refuse: an upload over that is answered 507; evict: meshes used longest ago go"},
      Option{"samples", Kind::text, &Config::samples, "DIR",
             "Directory of mesh files uploaded at the start; empty: none"},
      Option{"viewer", Kind::text, &Config::viewer, "DIR",
             "Directory of the built viewer, served at /; empty: a plain page"},
      Option{"io-threads", Kind::whole_number, &Config::io_threads, "N",
             "Threads for requests, started at once; more come as requests wait", 1, max_threads},
      Option{"max-connections", Kind::whole_number, &Config::max_connections, "N",
             "Connections at once; more push out who idles longest", 1, 1'000'000},
      Option{"compute-threads", Kind::whole_number, &Config::compute_threads, "N",
             "Computations that run at once; 0: one a core", 0, max_threads},
      Option{"queue", Kind::whole_number, &Config::queue, "N",
             "Computations that may wait; more are answered 503", 0, max_queue, follows},
      Option{
          "queue-per-client", Kind::whole_number, &Config::queue_per_client, "N",
          "Computations of one client that may wait; more are answered 429; 0: as many as of all",
          0, max_queue, follows},
      Option{"queue-seconds", Kind::whole_number, &Config::queue_seconds, "SECONDS",
             "Longest wait for a compute slot; longer is answered 503; 0: any", 0, max_seconds,
             follows},
      Option{"query-memory-bytes", Kind::bytes, &Config::query_memory_bytes, "BYTES",
             "Memory that one query may take; more is answered 422; 0: as for all", 0, no_bound,
             follows},
      Option{"compute-memory-bytes", Kind::bytes, &Config::compute_memory_bytes, "BYTES",
             "Memory of all computations together, with preparing meshes; 0: what the machine or "
             "container has, less 1GiB, the caches, the replies and a decoder",
             0, no_bound, follows},
      Option{"max-body-bytes", Kind::bytes, &Config::max_body_bytes, "BYTES",
             "Most bytes of an uploaded mesh", 1, no_bound, follows},
      Option{"max-json-bytes", Kind::bytes, &Config::max_json_bytes, "BYTES",
             "Most bytes of a query's body", 1, no_bound, follows},
      Option{"max-vertices", Kind::whole_number, &Config::max_vertices, "N",
             "Most vertices of a mesh", 1, max_index, follows},
      Option{"max-faces", Kind::whole_number, &Config::max_faces, "N", "Most faces of a mesh", 1,
             max_index, follows},
      Option{"decoder", Kind::decoder, &Config::decoder, "WHERE",
             "process: files are decoded in confined processes of their own; in-process: not"},
      Option{"decoder-memory-bytes", Kind::bytes, &Config::decoder_memory_bytes, "BYTES",
             "Memory for decoding one file; a small file gets less: 512MiB and 256 times its size",
             std::uint64_t{64} << 20, no_bound, follows},
      Option{"decoder-seconds", Kind::whole_number, &Config::decoder_seconds, "SECONDS",
             "Time for decoding one file", 1, max_seconds, follows},
      Option{"mesh-cache-bytes", Kind::bytes, &Config::mesh_cache_bytes, "BYTES",
             "Memory for decoded meshes", 0, no_bound, follows},
      Option{"adjacency-cache-bytes", Kind::bytes, &Config::adjacency_cache_bytes, "BYTES",
             "Memory for prepared adjacencies", 0, no_bound, follows},
      Option{"field-cache-bytes", Kind::bytes, &Config::field_cache_bytes, "BYTES",
             "Memory for distance fields", 0, no_bound, follows},
      Option{"reply-cache-bytes", Kind::bytes, &Config::reply_cache_bytes, "BYTES",
             "Memory for encoded replies to GET", 0, no_bound, follows},
      Option{"reply-memory-bytes", Kind::bytes, &Config::reply_memory_bytes, "BYTES",
             "Memory for replies being made or sent; more are answered 503, larger ones 422",
             std::uint64_t{16} << 20, no_bound, follows},
      Option{"body-timeout-seconds", Kind::whole_number, &Config::body_timeout_seconds, "SECONDS",
             "Time for a request's body to arrive", 1, max_seconds, follows},
      Option{"min-upload-rate", Kind::bytes, &Config::min_upload_rate, "BYTES",
             "Bytes a second that a body must bring on average; slower is answered 408; 0: any", 0,
             no_bound, follows},
      Option{"keep-alive-seconds", Kind::whole_number, &Config::keep_alive_seconds, "SECONDS",
             "Time a connection may idle between requests", 1, max_seconds, follows},
      Option{"drain-seconds", Kind::whole_number, &Config::drain_seconds, "SECONDS",
             "Time for running requests to finish after SIGTERM", 0, max_seconds, follows},
      Option{"max-jobs", Kind::whole_number, &Config::max_jobs, "N",
             "Jobs (Prefer: respond-async) that may wait and run; more are answered 503", 0,
             max_queue},
      Option{"job-result-bytes", Kind::bytes, &Config::job_result_bytes, "BYTES",
             "Memory for the bodies of jobs' requests and replies"},
      Option{"job-seconds", Kind::whole_number, &Config::job_seconds, "SECONDS",
             "Time for which a job is kept after its end", 1, max_seconds},
      Option{"log-level", Kind::level, &Config::log_level, "LEVEL",
             "trace, debug, info, warn, error, critical or off", 0, no_bound, follows},
  };
  return table;
}

std::string variable_name(std::string_view option) {
  std::string name = "GEODESICD_";
  for (const char c : option) {
    name += c == '-' ? '_' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  }
  return name;
}

tl::unexpected<Error> bad(std::string detail) {
  return fail(InputCode::bad_syntax, std::move(detail));
}

std::string format_value(const Option& option, const Config& config) {
  if (const auto* text = std::get_if<std::string Config::*>(&option.member)) return config.**text;
  if (const auto* address = std::get_if<Address Config::*>(&option.member)) {
    return format_address(config.**address);
  }
  const std::uint64_t number = config.*std::get<std::uint64_t Config::*>(option.member);
  return option.kind == Kind::bytes ? format_bytes(number) : std::to_string(number);
}

// Sets one option; `source` opens the error's sentence.
Result<void> set_option(const Option& option, std::string_view text, std::string_view source,
                        Config& config) {
  const auto refuse = [&](std::string_view reason) {
    return fail(Error{InputCode::bad_syntax,
                      fmt::format("{}: {}", source, reason),
                      std::string(option.name),
                      {},
                      {}});
  };
  switch (option.kind) {
    case Kind::when_full:
      if (text != "refuse" && text != "evict") {
        return refuse(fmt::format("'{}' is neither refuse nor evict", text));
      }
      config.*std::get<std::string Config::*>(option.member) = text;
      return {};
    case Kind::decoder:
      if (text != "process" && text != "in-process") {
        return refuse(fmt::format("'{}' is neither process nor in-process", text));
      }
      config.*std::get<std::string Config::*>(option.member) = text;
      return {};
    case Kind::level: {
      constexpr std::array<std::string_view, 7> levels{"trace", "debug",    "info", "warn",
                                                       "error", "critical", "off"};
      if (std::find(levels.begin(), levels.end(), text) == levels.end()) {
        return refuse(fmt::format("'{}' is none of {}", text, fmt::join(levels, ", ")));
      }
      [[fallthrough]];
    }
    case Kind::text:
      config.*std::get<std::string Config::*>(option.member) = text;
      return {};
    case Kind::address: {
      Result<Address> address = text.empty() ? Result<Address>(Address{}) : parse_address(text);
      if (!address) return refuse(address.error().detail);
      if (address->host.empty() && option.name == "listen") return refuse("an address is required");
      config.*std::get<Address Config::*>(option.member) = std::move(*address);
      return {};
    }
    case Kind::whole_number:
    case Kind::bytes: {
      const auto number = option.kind == Kind::bytes ? parse_bytes(text) : parse_whole_number(text);
      if (!number) return refuse(number.error().detail);
      if (*number < option.least) return refuse(fmt::format("at least {}", option.least));
      if (*number > option.most) return refuse(fmt::format("at most {}", option.most));
      config.*std::get<std::uint64_t Config::*>(option.member) = *number;
      return {};
    }
  }
  return {};
}

// Where each option's value came from, in the order of the table.
using Origins = std::vector<std::string>;

using Problems = std::vector<Error>;

void read_file(const std::string& path, Config& config, Origins& origins, Problems& problems) {
  const auto refuse = [&](std::string detail) {
    problems.push_back({InputCode::bad_syntax, std::move(detail), {}, {}, {}});
  };
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) return refuse(path + ": is a folder");
  std::ifstream file(path, std::ios::binary);
  if (!file) return refuse(fmt::format("{}: cannot be read", path));
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  using nlohmann::json;
  const json options_given = json::parse(text, nullptr, /*allow_exceptions=*/false,
                                         /*ignore_comments=*/true);
  if (!options_given.is_object()) return refuse(fmt::format("{}: is not a JSON object", path));
  constexpr std::size_t kMostLevels = 64;
  const auto repeated =
      proto::outline_of_json(text, kMostLevels, /*ignore_comments=*/true).repeated_name;
  if (repeated) {
    problems.push_back({InputCode::bad_syntax,
                        fmt::format("{}: {}: comes twice", path, *repeated),
                        *repeated,
                        {},
                        {}});
  }
  for (const auto& item : options_given.items()) {
    const std::string& key = item.key();
    const json& value = item.value();
    const std::string source = fmt::format("{}: {}", path, key);
    const auto known = std::find_if(options().begin(), options().end(),
                                    [&](const Option& option) { return option.name == key; });
    if (known == options().end()) {
      problems.push_back({InputCode::unknown_parameter, source + ": no such option", key, {}, {}});
      continue;
    }
    if (!value.is_string() && !value.is_number_unsigned()) {
      refuse(fmt::format("{}: must be a string or a whole number", source));
      continue;
    }
    const std::string written = value.is_string() ? value.get<std::string>() : value.dump();
    if (auto set = set_option(*known, written, source, config); !set) {
      problems.push_back(std::move(set.error()));
      continue;
    }
    origins[static_cast<std::size_t>(known - options().begin())] = path;
  }
}

std::string print_config(const Config& config, const Origins& origins) {
  std::string out;
  for (std::size_t i = 0; i < origins.size(); ++i) {
    const Option& option = options()[i];
    out += fmt::format("{:<22} {:<24} {}\n", option.name,
                       fmt::format("\"{}\"", format_value(option, config)), origins[i]);
  }
  return out;
}

// What --make-token is given.
struct TokenRequest {
  std::string name;
  std::string scopes;
  std::string expires;
};

Result<std::string> print_token(const TokenRequest& request) {
  const auto scopes = parse_scopes(request.scopes);
  if (!scopes) return bad("--scopes: " + scopes.error().detail);
  std::optional<Moment> expires;
  if (!request.expires.empty()) {
    const auto moment = parse_moment(request.expires);
    if (!moment) return bad("--expires: " + moment.error().detail);
    expires = *moment;
  }
  const auto fresh = make_token(request.name, *scopes, expires);
  if (!fresh) return bad("--make-token: " + fresh.error().detail);
  return fresh->secret + "\n" + fresh->line + "\n";
}

}  // namespace

Environment process_environment() {
  return [](const std::string& name) -> std::optional<std::string> {
    const char* const value = std::getenv(name.c_str());
    return value == nullptr ? std::nullopt : std::optional<std::string>(value);
  };
}

Result<CommandLine> read_config(const std::vector<std::string>& arguments,
                                const Environment& environment) {
  CLI::App app("Geodesic distances and shortest paths on triangle meshes, over HTTP", "geodesicd");
  const Config defaults;
  std::vector<std::string> flags(options().size());
  std::vector<CLI::Option*> parsed;
  for (std::size_t i = 0; i < flags.size(); ++i) {
    const Option& option = options()[i];
    parsed.push_back(
        app.add_option("--" + std::string(option.name), flags[i],
                       fmt::format("{} [{}, default \"{}\"]", option.help,
                                   variable_name(option.name), format_value(option, defaults)))
            ->type_name(std::string(option.value_hint)));
  }
  std::string file;
  app.add_option("--config", file, "JSON file of these options [GEODESICD_CONFIG]")
      ->type_name("FILE");
  bool print = false;
  bool table = false;
  app.add_flag("--print-config", print, "Print every option's value and origin");
  app.add_flag("--print-config-table", table, "Print the options as Markdown");
  CommandLine result;
  app.add_flag("--check-config", result.check,
               "Read all settings and the files that they name, and say what is wrong");
  TokenRequest token;
  CLI::Option* const make =
      app.add_option("--make-token", token.name,
                     "Print a fresh token, and the line for the file of --tokens")
          ->type_name("NAME");
  app.add_option("--scopes", token.scopes, "What --make-token allows: read,upload,admin")
      ->needs(make)
      ->type_name("SCOPES");
  app.add_option("--expires", token.expires,
                 "When what --make-token makes ends, such as 2030-01-31")
      ->needs(make)
      ->type_name("WHEN");
  app.allow_extras();  // to be told of all of them
  app.set_version_flag("--version", "geodesicd " GEODESIC_VERSION);

  try {
    // CLI11 wants the last argument first.
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::CallForHelp&) {
    result.print = app.help();
    return result;
  } catch (const CLI::CallForVersion& version) {
    result.print = std::string(version.what()) + "\n";
    return result;
  } catch (const CLI::ParseError& error) {
    return bad(error.what());
  }
  for (const std::string& extra : app.remaining()) {
    result.problems.push_back(
        {InputCode::unknown_parameter, fmt::format("'{}' is not known here", extra), {}, {}, {}});
  }
  if (result.problems.empty() && (table || make->count() > 0)) {
    auto text = table ? Result<std::string>(config_table()) : print_token(token);
    if (!text) return fail(std::move(text.error()));
    result.print = std::move(*text);
    return result;
  }

  Origins origins(options().size(), "default");
  const auto set = [&](std::size_t i, std::string_view text, std::string source) {
    if (auto done = set_option(options()[i], text, source, result.config); !done) {
      result.problems.push_back(std::move(done.error()));
    }
    origins[i] = std::move(source);
  };
  if (file.empty()) file = environment("GEODESICD_CONFIG").value_or("");
  if (!file.empty()) read_file(file, result.config, origins, result.problems);
  for (std::size_t i = 0; i < options().size(); ++i) {
    const std::string variable = variable_name(options()[i].name);
    if (const auto value = environment(variable)) set(i, *value, variable);
    if (parsed[i]->count() > 0) set(i, flags[i], "--" + std::string(options()[i].name));
  }
  if (result.config.tls_cert.empty() != result.config.tls_key.empty()) {
    result.problems.push_back(
        {InputCode::bad_syntax, "--tls-cert and --tls-key go together", {}, {}, {}});
  }
  if (!result.check && !result.problems.empty()) return fail(result.problems.front());
  if (print && !result.check) result.print = print_config(result.config, origins);
  return result;
}

void follow(const Config& fresh, Config& running, std::vector<std::string>& changed,
            std::vector<std::string>& waiting) {
  for (const Option& option : options()) {
    if (format_value(option, fresh) == format_value(option, running)) continue;
    (option.follows ? changed : waiting).emplace_back(option.name);
    if (!option.follows) continue;
    std::visit([&](auto member) { running.*member = fresh.*member; }, option.member);
  }
}

std::string config_table() {
  const Config defaults;
  std::string out = "| flag | environment | default | meaning | SIGHUP |\n|---|---|---|---|---|\n";
  for (const Option& option : options()) {
    const std::string value = format_value(option, defaults);
    out += fmt::format("| `--{} {}` | `{}` | {} | {} | {} |\n", option.name, option.value_hint,
                       variable_name(option.name), value.empty() ? "" : "`" + value + "`",
                       option.help, option.follows ? "yes" : "");
  }
  return out;
}

}  // namespace geodesic::server
