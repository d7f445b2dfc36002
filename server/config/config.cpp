#include "server/config/config.h"

#include <spdlog/fmt/fmt.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "proto/wire/input_codes.h"
#include "proto/wire/json_outline.h"
#include "server/config/options.h"
#include "server/config/tokens.h"

namespace geodesic::server {

namespace {

tl::unexpected<Error> bad(std::string detail) {
  return fail(InputCode::bad_syntax, std::move(detail));
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
  if (request.scopes.empty()) {
    return bad(
        "--make-token: --scopes says what it allows, such as --scopes read,upload, or admin");
  }
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
  if (result.config.tls_cert.empty() && !result.config.tls_ticket_keys.empty()) {
    result.problems.push_back(
        {InputCode::bad_syntax, "--tls-ticket-keys needs --tls-cert and --tls-key", {}, {}, {}});
  }
  if (result.config.prepared.empty() && !result.config.prepared_bucket.empty()) {
    result.problems.push_back(
        {InputCode::bad_syntax, "--prepared-bucket needs --prepared, a directory", {}, {}, {}});
  }
  if (result.config.proxy_protocol != "off" && result.config.trusted_proxies.empty()) {
    result.problems.push_back({InputCode::bad_syntax,
                               "--proxy-protocol needs --trusted-proxies, the addresses of the "
                               "proxies: without them nobody could connect",
                               {},
                               {},
                               {}});
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
