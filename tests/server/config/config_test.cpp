#include "server/config/config.h"

#include <doctest/doctest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "proto/wire/input_codes.h"
#include "server/config/tokens.h"
#include "server/program/check_config.h"

using namespace geodesic;
using namespace geodesic::server;

namespace {

using Variables = std::map<std::string, std::string>;

Environment in(Variables variables) {
  return [variables = std::move(variables)](const std::string& name) -> std::optional<std::string> {
    const auto found = variables.find(name);
    if (found == variables.end()) return std::nullopt;
    return found->second;
  };
}

struct ConfigFile {
  explicit ConfigFile(const std::string& text) {
    std::string pattern = (std::filesystem::temp_directory_path() / "config_XXXXXX").string();
    const int descriptor = ::mkstemp(pattern.data());
    REQUIRE(descriptor >= 0);
    ::close(descriptor);
    path = pattern;
    std::ofstream(path) << text;
  }
  ~ConfigFile() { std::filesystem::remove(path); }
  std::string path;
};

Error error_of(const std::vector<std::string>& arguments, Variables variables = {}) {
  const auto line = read_config(arguments, in(std::move(variables)));
  REQUIRE_FALSE(line);
  return line.error();
}

bool mentions(const Error& error, std::string_view text) {
  return error.detail.find(text) != std::string::npos;
}

}  // namespace

TEST_CASE("without any source the defaults hold") {
  const auto line = read_config({}, in({}));
  REQUIRE(line);
  CHECK_FALSE(line->print);
  CHECK(line->config.listen.host == "127.0.0.1");
  CHECK(line->config.listen.port == 8080);
  CHECK(line->config.admin_listen.host.empty());
  CHECK(line->config.max_body_bytes == 256u << 20);
  CHECK(line->config.field_cache_bytes == 768u << 20);
}

TEST_CASE("a flag beats a variable beats the file beats the default") {
  const ConfigFile file(
      R"({"queue": 1, "io-threads": 2, "store": "from-file", "max-json-bytes": "3KiB"})");
  const auto line = read_config({"--queue", "10", "--config", file.path, "--admin-listen=[::1]:0"},
                                in({{"GEODESICD_QUEUE", "20"}, {"GEODESICD_IO_THREADS", "30"}}));
  REQUIRE(line);
  CHECK(line->config.queue == 10);
  CHECK(line->config.io_threads == 30);
  CHECK(line->config.store == "from-file");
  CHECK(line->config.max_json_bytes == 3072);
  CHECK(line->config.keep_alive_seconds == 75);
  CHECK(line->config.admin_listen.host == "::1");

  const auto printed =
      read_config({"--queue=10", "--print-config"}, in({{"GEODESICD_QUEUE", "20"},
                                                        {"GEODESICD_CONFIG", file.path},
                                                        {"GEODESICD_LISTEN", "0.0.0.0:80"}}));
  REQUIRE(printed);
  REQUIRE(printed->print);
  const std::string& text = *printed->print;
  const auto line_of = [&](const std::string& name) {
    const std::size_t at = text.find("\n" + name + " ");
    return text.substr(at + 1, text.find('\n', at + 1) - at - 1);
  };
  CHECK(line_of("queue").find("\"10\"") != std::string::npos);
  CHECK(line_of("queue").ends_with("--queue"));
  CHECK(line_of("io-threads").ends_with(file.path));
  CHECK(line_of("max-body-bytes").find("\"256MiB\"") != std::string::npos);
  CHECK(line_of("max-body-bytes").ends_with("default"));
  CHECK(text.find("GEODESICD_LISTEN") != std::string::npos);
}

TEST_CASE("a bad value names its source") {
  CHECK(mentions(error_of({"--queue", "many"}), "--queue: 'many' is not a whole number"));
  CHECK(mentions(error_of({}, {{"GEODESICD_QUEUE", "-1"}}), "GEODESICD_QUEUE: '-1'"));
  CHECK(mentions(error_of({"--io-threads=0"}), "--io-threads: at least 1"));
  CHECK(mentions(error_of({"--max-vertices=4294967295"}), "--max-vertices: at most"));
  CHECK(mentions(error_of({}, {{"GEODESICD_LISTEN", ""}}),
                 "GEODESICD_LISTEN: an address is required"));
  CHECK(mentions(error_of({"--log-level=loud"}), "--log-level: 'loud' is none of trace"));
  CHECK(error_of({"--max-body-bytes=1TB"}).parameter == "max-body-bytes");
  const ConfigFile bad_value(R"({"queue": "x"})");
  CHECK(mentions(error_of({"--config", bad_value.path}), bad_value.path + ": queue: 'x'"));
  const ConfigFile negative(R"({"queue": -1})");
  CHECK(mentions(error_of({"--config", negative.path}), "queue: must be a string or a whole"));
}

TEST_CASE("what proxies write is one of two headers, and a PROXY header comes from trusted ones") {
  const auto line = read_config({"--forwarded-header", "forwarded", "--proxy-protocol", "v2",
                                 "--trusted-proxies", "10.0.0.1"},
                                in({}));
  REQUIRE(line);
  CHECK(line->config.forwarded_header == "forwarded");
  CHECK(line->config.proxy_protocol == "v2");
  CHECK(mentions(error_of({"--forwarded-header=both"}), "'both' is neither x-forwarded-for nor"));
  CHECK(mentions(error_of({"--proxy-protocol=v1"}), "'v1' is neither off nor v2"));
  CHECK(mentions(error_of({"--proxy-protocol=v2"}), "needs --trusted-proxies"));
}

TEST_CASE("keys of tickets are for a listener with TLS") {
  CHECK(mentions(error_of({"--tls-ticket-keys=keys"}), "needs --tls-cert and --tls-key"));
  CHECK(mentions(error_of({"--prepared-bucket=s3://meshes"}), "needs --prepared"));
}

TEST_CASE("trusted proxies are addresses and ranges") {
  const auto line = read_config({"--trusted-proxies", "127.0.0.1, fd00::/8"}, in({}));
  REQUIRE(line);
  CHECK(line->config.trusted_proxies == "127.0.0.1, fd00::/8");
  const Error error = error_of({}, {{"GEODESICD_TRUSTED_PROXIES", "10.0.0.1/8"}});
  CHECK(error.code == InputCode::bad_syntax);
  CHECK(mentions(error, "GEODESICD_TRUSTED_PROXIES: '10.0.0.1/8' is no list of addresses"));
}

TEST_CASE("unknown options and unreadable files are refused") {
  CHECK(error_of({"--quue=1"}).code == InputCode::unknown_parameter);
  CHECK(mentions(error_of({"--quue=1"}), "--quue"));
  CHECK(mentions(error_of({"stray"}), "stray"));
  CHECK(error_of({"--queue"}).code == InputCode::bad_syntax);
  const ConfigFile unknown(R"({"quue": 1})");
  CHECK(error_of({"--config", unknown.path}).code == InputCode::unknown_parameter);
  CHECK(mentions(error_of({"--config", unknown.path}), "quue: no such option"));
  const ConfigFile array("[1]");
  CHECK(mentions(error_of({"--config", array.path}), "is not a JSON object"));
  const ConfigFile broken("{");
  CHECK(mentions(error_of({"--config", broken.path}), "is not a JSON object"));
  CHECK(mentions(error_of({"--config", broken.path + ".none"}), "cannot be read"));
  CHECK(mentions(error_of({"--config", std::filesystem::temp_directory_path().string()}),
                 "is a folder"));
}

TEST_CASE("a name that comes twice in the file is refused, with the same value too") {
  for (const std::string text : {R"({"queue": 1, "queue": 2})", R"({"queue": 1, "queue": 1})",
                                 R"({"queue": 1, /* again */ "store": "a", "queue": 2})",
                                 R"({"store": "a", "que\u0075e": 1, "queue": 1, "store": "a"})"}) {
    CAPTURE(text);
    const ConfigFile file(text);
    const Error error = error_of({"--config", file.path});
    CHECK(error.code == InputCode::bad_syntax);
    CHECK(error.parameter == "queue");
    CHECK(mentions(error, file.path + ": queue: comes twice"));
  }
}

TEST_CASE("help, version and the table list what there is") {
  const auto help = read_config({"--help"}, in({}));
  REQUIRE(help);
  const auto version = read_config({"--version"}, in({}));
  REQUIRE(version);
  CHECK(version->print->starts_with("geodesicd "));
  const auto table = read_config({"--print-config-table"}, in({}));
  REQUIRE(table);
  CHECK(*table->print == config_table());
  for (const char* name : {"listen",
                           "admin-listen",
                           "store",
                           "samples",
                           "viewer",
                           "docs",
                           "io-threads",
                           "compute-threads",
                           "queue",
                           "max-body-bytes",
                           "max-json-bytes",
                           "max-vertices",
                           "max-faces",
                           "mesh-cache-bytes",
                           "adjacency-cache-bytes",
                           "field-cache-bytes",
                           "body-timeout-seconds",
                           "keep-alive-seconds",
                           "tls-cert",
                           "tls-key",
                           "tokens",
                           "max-connections",
                           "queue-per-client",
                           "queue-seconds",
                           "min-upload-rate",
                           "drain-seconds",
                           "log-level"}) {
    CAPTURE(name);
    CHECK(help->print->find("--" + std::string(name) + " ") != std::string::npos);
    CHECK(config_table().find("| `--" + std::string(name) + " ") != std::string::npos);
  }
  CHECK(config_table().find("| `--queue N` | `GEODESICD_QUEUE` | `256` |") != std::string::npos);
}

TEST_CASE("--check-config gathers every problem of every source") {
  const ConfigFile file(R"({"queue": "x", "quue": 1, "max-faces": 7, "store": -1})");
  const auto line = read_config({"--check-config", "--config", file.path, "--max-vertices=0",
                                 "--stray", "--tls-cert=cert.pem", "word"},
                                in({{"GEODESICD_LOG_LEVEL", "loud"}}));
  REQUIRE(line);
  CHECK(line->check);
  CHECK(line->config.max_faces == 7);  // what is right was read
  const std::string said = check_config(*line, in({}));
  CAPTURE(said);
  for (const std::string& part :
       {std::string("'--stray' is not known"), std::string("'word' is not known"),
        file.path + ": queue: 'x' is not a whole number", file.path + ": quue: no such option",
        file.path + ": store: must be", std::string("--max-vertices: at least 1"),
        std::string("GEODESICD_LOG_LEVEL: 'loud'"), std::string("--tls-key go together")}) {
    CAPTURE(part);
    CHECK(said.find(part) != std::string::npos);
  }
  CHECK(std::count(said.begin(), said.end(), '\n') == 8);
}

TEST_CASE("--check-config reads the files and places that are named, and touches no store") {
  const std::string store = (std::filesystem::temp_directory_path() / "never_made").string();
  const auto said = [&](std::vector<std::string> flags, Variables variables = {}) {
    flags.emplace_back("--check-config");
    const auto line = read_config(flags, in(variables));
    REQUIRE(line);
    return check_config(*line, in(variables));
  };
  CHECK(said({"--store", store}).empty());
  CHECK_FALSE(std::filesystem::exists(store));
  CHECK(said({"--store", ""}) == "store: a place is required\n");
  const Variables keys{{"AWS_ACCESS_KEY_ID", "a"}, {"AWS_SECRET_ACCESS_KEY", "b"}};
  CHECK(said({"--store", "s3://bucket/prefix"}, keys).empty());
  CHECK(said({"--store", "s3://bucket/prefix"}).find("AWS_ACCESS_KEY_ID") != std::string::npos);
  CHECK(said({"--store", "s3://bucket?colour=red"}, keys).starts_with("store: "));

  const std::string hash(64, 'a');
  const ConfigFile good("ann read " + hash + "\n");
  const ConfigFile bad("ann read\n");
  CHECK(said({"--tokens", good.path}).empty());
  const std::string several =
      said({"--tokens", bad.path, "--tls-cert", good.path, "--tls-key", good.path, "--store", ""});
  CAPTURE(several);
  CHECK(several.starts_with("tokens: " + bad.path + ":1: has 2 fields"));
  CHECK(several.find("\ntls-cert, tls-key: ") != std::string::npos);
  CHECK(several.find("\nstore: ") != std::string::npos);
  CHECK(several.find(hash) == std::string::npos);
}

TEST_CASE("--check-config tries each place that is to be read") {
  const std::string none = (std::filesystem::temp_directory_path() / "never_made").string();
  const ConfigFile file("");
  const std::string folder = std::filesystem::path(file.path).parent_path().string();
  const auto said = [](const std::string& option, const std::string& place) {
    const auto line = read_config({"--check-config", option, place}, in({}));
    REQUIRE(line);
    return check_config(*line, in({}));
  };
  CHECK(said("--samples", folder).empty());
  CHECK(said("--samples", "").empty());
  for (const std::string option : {"--samples", "--viewer", "--docs"}) {
    CAPTURE(option);
    for (const std::string& place : {none, file.path}) {
      CHECK_FALSE(said(option, place).empty());
      CHECK(said(option, place).find(option.substr(2)) != std::string::npos);
    }
  }
}

TEST_CASE("--make-token prints a token and the line that lets it in") {
  const auto made = [](const std::vector<std::string>& flags) {
    const auto line = read_config(flags, in({}));
    REQUIRE(line);
    REQUIRE(line->print);
    return *line->print;
  };
  const std::string text = made({"--make-token", "ann", "--scopes", "read,upload"});
  const std::string secret = text.substr(0, text.find('\n'));
  CHECK(secret.starts_with("geo_"));
  const auto tokens = Tokens::parse(text.substr(text.find('\n') + 1), "file");
  REQUIRE(tokens);
  REQUIRE(tokens->find(secret) != nullptr);
  CHECK(tokens->find(secret)->name == "ann");
  CHECK(made({"--make-token=x", "--scopes=admin", "--expires=2030-01-31"})
            .ends_with(" expires=2030-01-31T00:00:00Z\n"));

  CHECK(mentions(error_of({"--make-token", "ann"}), "--scopes read,upload"));
  CHECK(mentions(error_of({"--make-token", "ann", "--scopes", "all"}), "--scopes: "));
  CHECK(mentions(error_of({"--make-token", "", "--scopes", "read"}), "--make-token: "));
  CHECK(mentions(error_of({"--make-token", "a b", "--scopes", "read"}), "--make-token: "));
  CHECK(mentions(error_of({"--make-token=a", "--scopes=read", "--expires=soon"}), "--expires: "));
  CHECK(mentions(error_of({"--scopes", "read"}), "--make-token"));
  CHECK(mentions(error_of({"--make-token=a", "--scopes=read", "--quue=1"}), "--quue"));
}

TEST_CASE("byte sizes take binary suffixes and nothing else") {
  CHECK(parse_bytes("0") == 0u);
  CHECK(parse_bytes("123") == 123u);
  CHECK(parse_bytes("2KiB") == 2048u);
  CHECK(parse_bytes("256MiB") == 268435456u);
  CHECK(parse_bytes("3GiB") == std::uint64_t{3} << 30);
  CHECK(parse_bytes("17179869183GiB") == std::uint64_t{17179869183} << 30);
  for (const char* bad : {"", "KiB", "1 KiB", "1.5GiB", "-1", "+1", "1kb", "0x10", "17179869184GiB",
                          "18446744073709551616"}) {
    CAPTURE(bad);
    CHECK_FALSE(parse_bytes(bad));
  }
}

TEST_CASE("addresses are HOST:PORT with IPv6 in brackets") {
  const auto check = [](std::string_view text, std::string_view host, int port) {
    CAPTURE(text);
    const auto address = parse_address(text);
    REQUIRE(address);
    CHECK(address->host == host);
    CHECK(address->port == port);
  };
  check("127.0.0.1:8080", "127.0.0.1", 8080);
  check("localhost:0", "localhost", 0);
  check(":80", "0.0.0.0", 80);
  check("[::1]:65535", "::1", 65535);
  for (const char* bad :
       {"", "8080", "host", "host:", "host:x", "host:65536", "::1:80", "[]:80", "host:-1"}) {
    CAPTURE(bad);
    CHECK_FALSE(parse_address(bad));
  }
}
