#include "server/config.h"

#include <spdlog/fmt/fmt.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <variant>

namespace geodesic::server {

namespace {

enum class Kind { text, whole_number, bytes, address, level, when_full };

using Member = std::variant<std::string Config::*, std::uint64_t Config::*, Address Config::*>;

struct Option {
  std::string_view name;  // of the flag, without dashes; file keys are the same
  Kind kind;
  Member member;
  std::string_view value_hint;
  std::string_view help;
  std::uint64_t least = 0;
  std::uint64_t most = std::numeric_limits<std::uint64_t>::max();
};

constexpr std::uint64_t max_threads = 4096;
constexpr std::uint64_t max_seconds = 86400;
constexpr std::uint64_t max_queue = 4096;         // each holds a thread
constexpr std::uint64_t max_index = 0xffff'fffe;  // vertices and faces are 32-bit indices

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
      Option{"store", Kind::text, &Config::store, "PLACE",
             "Directory of the uploaded meshes, or s3://BUCKET/PREFIX?endpoint=URL&region=NAME"},
      Option{"store-max-bytes", Kind::bytes, &Config::store_max_bytes, "BYTES",
             "Most bytes in the store; 0: no limit"},
      Option{"store-when-full", Kind::when_full, &Config::store_when_full, "POLICY",
             "refuse: an upload over that is answered 507; evict: meshes used longest ago go"},
      Option{"samples", Kind::text, &Config::samples, "DIR",
             "Directory of mesh files uploaded at the start; empty: none"},
      Option{"io-threads", Kind::whole_number, &Config::io_threads, "N",
             "Threads for requests, started at once; more come as requests wait", 1, max_threads},
      Option{"max-connections", Kind::whole_number, &Config::max_connections, "N",
             "Connections at once; more push out who idles longest", 1, 1'000'000},
      Option{"compute-threads", Kind::whole_number, &Config::compute_threads, "N",
             "Computations that run at once; 0: one a core", 0, max_threads},
      Option{"queue", Kind::whole_number, &Config::queue, "N",
             "Computations that may wait; more are answered 503", 0, max_queue},
      Option{
          "queue-per-client", Kind::whole_number, &Config::queue_per_client, "N",
          "Computations of one client that may wait; more are answered 429; 0: as many as of all",
          0, max_queue},
      Option{"queue-seconds", Kind::whole_number, &Config::queue_seconds, "SECONDS",
             "Longest wait for a compute slot; longer is answered 503; 0: any", 0, max_seconds},
      Option{"max-body-bytes", Kind::bytes, &Config::max_body_bytes, "BYTES",
             "Most bytes of an uploaded mesh", 1},
      Option{"max-json-bytes", Kind::bytes, &Config::max_json_bytes, "BYTES",
             "Most bytes of a query's body", 1},
      Option{"max-vertices", Kind::whole_number, &Config::max_vertices, "N",
             "Most vertices of a mesh", 1, max_index},
      Option{"max-faces", Kind::whole_number, &Config::max_faces, "N", "Most faces of a mesh", 1,
             max_index},
      Option{"mesh-cache-bytes", Kind::bytes, &Config::mesh_cache_bytes, "BYTES",
             "Memory for decoded meshes"},
      Option{"adjacency-cache-bytes", Kind::bytes, &Config::adjacency_cache_bytes, "BYTES",
             "Memory for prepared adjacencies"},
      Option{"field-cache-bytes", Kind::bytes, &Config::field_cache_bytes, "BYTES",
             "Memory for distance fields"},
      Option{"body-timeout-seconds", Kind::whole_number, &Config::body_timeout_seconds, "SECONDS",
             "Time for a request's body to arrive", 1, max_seconds},
      Option{"min-upload-rate", Kind::bytes, &Config::min_upload_rate, "BYTES",
             "Bytes a second that a body must bring on average; slower is answered 408; 0: any"},
      Option{"keep-alive-seconds", Kind::whole_number, &Config::keep_alive_seconds, "SECONDS",
             "Time a connection may idle between requests", 1, max_seconds},
      Option{"drain-seconds", Kind::whole_number, &Config::drain_seconds, "SECONDS",
             "Time for running requests to finish after SIGTERM", 0, max_seconds},
      Option{"log-level", Kind::level, &Config::log_level, "LEVEL",
             "trace, debug, info, warn, error, critical or off"},
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
  return fail(ErrorCode::bad_syntax, std::move(detail));
}

Result<std::uint64_t> parse_whole_number(std::string_view text) {
  std::uint64_t value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end) {
    return bad(fmt::format("'{}' is not a whole number", text));
  }
  return value;
}

std::string format_bytes(std::uint64_t bytes) {
  constexpr std::array<std::string_view, 3> suffixes{"KiB", "MiB", "GiB"};
  for (int i = 2; i >= 0; --i) {
    const std::uint64_t unit = std::uint64_t{1} << (10 * (i + 1));
    if (bytes != 0 && bytes % unit == 0) {
      return fmt::format("{}{}", bytes / unit, suffixes[static_cast<std::size_t>(i)]);
    }
  }
  return std::to_string(bytes);
}

std::string format_address(const Address& address) {
  if (address.host.empty()) return "";
  const bool is_ipv6 = address.host.find(':') != std::string::npos;
  return fmt::format("{}{}{}:{}", is_ipv6 ? "[" : "", address.host, is_ipv6 ? "]" : "",
                     address.port);
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
    return fail(Error{ErrorCode::bad_syntax,
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

Result<void> read_file(const std::string& path, Config& config, Origins& origins) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return bad(fmt::format("{}: cannot be read", path));
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const nlohmann::json json = nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false,
                                                    /*ignore_comments=*/true);
  if (!json.is_object()) return bad(fmt::format("{}: is not a JSON object", path));
  for (const auto& item : json.items()) {
    const std::string& key = item.key();
    const nlohmann::json& value = item.value();
    const std::string source = fmt::format("{}: {}", path, key);
    const auto known = std::find_if(options().begin(), options().end(),
                                    [&](const Option& option) { return option.name == key; });
    if (known == options().end()) {
      return fail(ErrorCode::unknown_parameter, fmt::format("{}: no such option", source), key);
    }
    if (!value.is_string() && !value.is_number_unsigned()) {
      return bad(fmt::format("{}: must be a string or a whole number", source));
    }
    const std::string written = value.is_string() ? value.get<std::string>() : value.dump();
    if (auto set = set_option(*known, written, source, config); !set) return set;
    origins[static_cast<std::size_t>(known - options().begin())] = path;
  }
  return {};
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
  app.set_version_flag("--version", "geodesicd " GEODESIC_VERSION);

  CommandLine result;
  try {
    // CLI11 wants the last argument first.
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));
  } catch (const CLI::CallForHelp&) {
    result.print = app.help();
    return result;
  } catch (const CLI::CallForVersion& version) {
    result.print = std::string(version.what()) + "\n";
    return result;
  } catch (const CLI::ExtrasError& error) {
    return fail(ErrorCode::unknown_parameter, error.what());
  } catch (const CLI::ParseError& error) {
    return bad(error.what());
  }
  if (table) {
    result.print = config_table();
    return result;
  }

  Origins origins(options().size(), "default");
  if (file.empty()) file = environment("GEODESICD_CONFIG").value_or("");
  if (!file.empty()) {
    if (auto read = read_file(file, result.config, origins); !read) {
      return fail(std::move(read.error()));
    }
  }
  for (std::size_t i = 0; i < options().size(); ++i) {
    const Option& option = options()[i];
    const std::string variable = variable_name(option.name);
    if (const auto value = environment(variable)) {
      if (auto set = set_option(option, *value, variable, result.config); !set) {
        return fail(std::move(set.error()));
      }
      origins[i] = variable;
    }
    if (parsed[i]->count() > 0) {
      const std::string flag = "--" + std::string(option.name);
      if (auto set = set_option(option, flags[i], flag, result.config); !set) {
        return fail(std::move(set.error()));
      }
      origins[i] = flag;
    }
  }
  if (result.config.tls_cert.empty() != result.config.tls_key.empty()) {
    return bad("--tls-cert and --tls-key go together");
  }
  if (print) result.print = print_config(result.config, origins);
  return result;
}

std::string config_table() {
  const Config defaults;
  std::string out = "| flag | environment | default | meaning |\n|---|---|---|---|\n";
  for (const Option& option : options()) {
    const std::string value = format_value(option, defaults);
    out += fmt::format("| `--{} {}` | `{}` | {} | {} |\n", option.name, option.value_hint,
                       variable_name(option.name), value.empty() ? "" : "`" + value + "`",
                       option.help);
  }
  return out;
}

Result<std::uint64_t> parse_bytes(std::string_view text) {
  std::uint64_t unit = 1;
  std::string_view digits = text;
  for (const auto& [suffix, factor] :
       {std::pair{std::string_view("KiB"), std::uint64_t{1} << 10},
        std::pair{std::string_view("MiB"), std::uint64_t{1} << 20},
        std::pair{std::string_view("GiB"), std::uint64_t{1} << 30}}) {
    if (text.ends_with(suffix)) {
      unit = factor;
      digits.remove_suffix(suffix.size());
    }
  }
  const auto count = parse_whole_number(digits);
  if (!count || *count > std::numeric_limits<std::uint64_t>::max() / unit) {
    return bad(fmt::format("'{}' is not a number of bytes, such as 1048576, 512KiB or 2GiB", text));
  }
  return *count * unit;
}

Result<Address> parse_address(std::string_view text) {
  const auto refuse = [&] {
    return bad(fmt::format("'{}' is not HOST:PORT, such as 127.0.0.1:8080 or [::1]:0", text));
  };
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return refuse();
  std::string_view host = text.substr(0, colon);
  const auto port = parse_whole_number(text.substr(colon + 1));
  if (!port || *port > 65535) return refuse();
  if (host.starts_with('[') && host.ends_with(']')) {
    host = host.substr(1, host.size() - 2);
    if (host.empty()) return refuse();
  } else if (host.find(':') != std::string_view::npos) {
    return refuse();  // IPv6 needs its brackets, or the port is ambiguous
  }
  return Address{host.empty() ? "0.0.0.0" : std::string(host), static_cast<int>(*port)};
}

}  // namespace geodesic::server
