#include "server/config/options.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

#include "proto/wire/input_codes.h"
#include "server/base/address_ranges.h"

namespace geodesic::server {
namespace {

using Kind = Option::Kind;

constexpr bool kFollows = true;

constexpr std::uint64_t kMaxThreads = 4096;
constexpr std::uint64_t kMaxSeconds = 86400;
constexpr std::uint64_t kMaxQueue = 4096;         // each holds a thread
constexpr std::uint64_t kMaxIndex = 0xffff'fffe;  // vertices and faces are 32-bit indices
constexpr std::uint64_t kNoBound = std::numeric_limits<std::uint64_t>::max();

// Empty, or segments of letters, digits and -._~ that each begin with a slash. The first is none of
// the server's own: behind a proxy that takes the path off, nobody could tell the two apart.
bool is_base_path(std::string_view path) {
  constexpr std::size_t kMostBytes = 200;
  if (path.empty()) return true;
  if (path.size() > kMostBytes || path.front() != '/') return false;
  constexpr std::array<std::string_view, 9> kOwn{"v1",           "docs",         "assets",
                                                 "openapi.json", "openapi.yaml", "livez",
                                                 "readyz",       "metrics",      "debug"};
  const std::string_view first = path.substr(1, path.substr(1).find('/'));
  if (std::find(kOwn.begin(), kOwn.end(), first) != kOwn.end()) return false;
  while (!path.empty()) {
    path.remove_prefix(1);  // the slash
    const std::string_view segment = path.substr(0, path.find('/'));
    const auto is_plain = [](unsigned char c) {
      return std::isalnum(c) != 0 || std::string_view("-._~").find(c) != std::string_view::npos;
    };
    if (segment.empty() || segment == "." || segment == "..") return false;
    if (!std::all_of(segment.begin(), segment.end(), is_plain)) return false;
    path.remove_prefix(segment.size());
  }
  return true;
}

}  // namespace

std::span<const Option> options() {
  static const std::array table{
      Option{"listen", Kind::address, &Config::listen, "HOST:PORT",
             "Where the API listens; port 0 takes any free one, printed at the start"},
      Option{"admin-listen", Kind::address, &Config::admin_listen, "HOST:PORT",
             "Where probes and metrics listen; empty: on the API's listener"},
      Option{"base-path", Kind::base_path, &Config::base_path, "PATH",
             "Path that a proxy has for the server, such as /geo: links in replies begin with it"},
      Option{"trusted-proxies", Kind::addresses, &Config::trusted_proxies, "ADDRESSES",
             "Addresses and ranges of proxies, with commas between them, that are believed who the "
             "client is"},
      Option{"forwarded-header", Kind::forwarded_header, &Config::forwarded_header, "HEADER",
             "Header in which they say so, x-forwarded-for or forwarded (RFC 7239); the other one "
             "is not read"},
      Option{"proxy-protocol", Kind::proxy_protocol, &Config::proxy_protocol, "VERSION",
             "v2: connections to the API's listener come from these proxies alone, and each begins "
             "with a PROXY header of version 2; off: none does"},
      Option{"tls-cert", Kind::text, &Config::tls_cert, "FILE",
             "PEM certificate (with its chain) of the API's listener; empty: plain HTTP"},
      Option{"tls-key", Kind::text, &Config::tls_key, "FILE", "PEM key of that certificate"},
      Option{"tls-ticket-keys", Kind::text, &Config::tls_ticket_keys, "FILE",
             "Keys of TLS session tickets, shared by several servers, a line each: 80 bytes in "
             "base64; the last but one encrypts, all decrypt; empty: each process has its own"},
      Option{"tokens", Kind::text, &Config::tokens, "FILE",
             "Tokens that clients need, a line each: NAME SCOPES SHA256; empty: none is asked for",
             0, kNoBound, kFollows},
      Option{"cors-origins", Kind::text, &Config::cors_origins, "ORIGINS",
             "Origins whose pages may call the API, with commas between them; *: any; empty: none"},
      Option{"cors-write-origins", Kind::text, &Config::cors_write_origins, "ORIGINS",
             "Of these, whose pages may also upload and delete, beside the server's own; *: any"},
      Option{"store", Kind::text, &Config::store, "PLACE",
             "Directory of the uploaded meshes, or s3://BUCKET/PREFIX?endpoint=URL&region=NAME"},
      Option{"store-max-bytes", Kind::bytes, &Config::store_max_bytes, "BYTES",
             "Most bytes in the store, if it is a directory; 0: no limit"},
      Option{"store-when-full", Kind::when_full, &Config::store_when_full, "POLICY",
             "refuse: an upload over that is answered 507; evict: meshes used longest ago go"},
      Option{"prepared", Kind::text, &Config::prepared, "DIR",
             "Directory of this machine for prepared meshes, so that a restart need not prepare "
             "them again; empty: none is kept"},
      Option{"prepared-max-bytes", Kind::bytes, &Config::prepared_max_bytes, "BYTES",
             "Most bytes in it; what was used longest ago goes; 0: no limit"},
      Option{"prepared-min-faces", Kind::whole_number, &Config::prepared_min_faces, "N",
             "Faces of the smallest mesh that is kept there; smaller ones are prepared in no time",
             0, kMaxIndex},
      Option{
          "prepared-bucket", Kind::text, &Config::prepared_bucket, "URL",
          "Bucket behind it, as --store names one, where several machines' servers share prepared "
          "meshes; empty: none"},
      Option{"samples", Kind::text, &Config::samples, "DIR",
             "Directory of mesh files uploaded at the start; empty: none"},
      Option{"viewer", Kind::text, &Config::viewer, "DIR",
             "Directory of the built viewer, served at /; empty: a plain page"},
      Option{"docs", Kind::text, &Config::docs, "DIR",
             "Directory of the built documentation, served at /docs/; empty: the API's page alone"},
      Option{"io-threads", Kind::whole_number, &Config::io_threads, "N",
             "Threads for requests, started at once; more come as requests wait", 1, kMaxThreads},
      Option{"max-connections", Kind::whole_number, &Config::max_connections, "N",
             "Connections at once; more push out who idles longest", 1, 1'000'000},
      Option{"compute-threads", Kind::whole_number, &Config::compute_threads, "N",
             "Computations that run at once; 0: one a core, fewer by a control group's quota", 0,
             kMaxThreads},
      Option{"queue", Kind::whole_number, &Config::queue, "N",
             "Computations that may wait; more are answered 503", 0, kMaxQueue, kFollows},
      Option{
          "queue-per-client", Kind::whole_number, &Config::queue_per_client, "N",
          "Computations of one client that may wait; more are answered 429; 0: as many as of all",
          0, kMaxQueue, kFollows},
      Option{"queue-seconds", Kind::whole_number, &Config::queue_seconds, "SECONDS",
             "Longest wait for a compute slot; longer is answered 503; 0: any", 0, kMaxSeconds,
             kFollows},
      Option{"query-memory-bytes", Kind::bytes, &Config::query_memory_bytes, "BYTES",
             "Memory that one query may take; more is answered 422; 0: as for all", 0, kNoBound,
             kFollows},
      Option{"compute-memory-bytes", Kind::bytes, &Config::compute_memory_bytes, "BYTES",
             "Memory of all computations together, with preparing meshes; 0: what the machine or "
             "container has, less 1GiB, the caches, the replies and a decoder",
             0, kNoBound, kFollows},
      Option{"max-body-bytes", Kind::bytes, &Config::max_body_bytes, "BYTES",
             "Most bytes of an uploaded mesh", 1, kNoBound, kFollows},
      Option{"max-json-bytes", Kind::bytes, &Config::max_json_bytes, "BYTES",
             "Most bytes of a query's body", 1, kNoBound, kFollows},
      Option{"max-vertices", Kind::whole_number, &Config::max_vertices, "N",
             "Most vertices of a mesh", 1, kMaxIndex, kFollows},
      Option{"max-faces", Kind::whole_number, &Config::max_faces, "N", "Most faces of a mesh", 1,
             kMaxIndex, kFollows},
      Option{"decoder", Kind::decoder, &Config::decoder, "WHERE",
             "process: files are decoded in confined processes of their own; in-process: not"},
      Option{"decoder-memory-bytes", Kind::bytes, &Config::decoder_memory_bytes, "BYTES",
             "Memory for decoding one file; a small file gets less: 512MiB and 256 times its size",
             std::uint64_t{64} << 20, kNoBound, kFollows},
      Option{"decoder-seconds", Kind::whole_number, &Config::decoder_seconds, "SECONDS",
             "Time for decoding one file", 1, kMaxSeconds, kFollows},
      Option{"mesh-cache-bytes", Kind::bytes, &Config::mesh_cache_bytes, "BYTES",
             "Memory for decoded meshes", 0, kNoBound, kFollows},
      Option{"adjacency-cache-bytes", Kind::bytes, &Config::adjacency_cache_bytes, "BYTES",
             "Memory for prepared adjacencies", 0, kNoBound, kFollows},
      Option{"field-cache-bytes", Kind::bytes, &Config::field_cache_bytes, "BYTES",
             "Memory for distance fields", 0, kNoBound, kFollows},
      Option{"reply-cache-bytes", Kind::bytes, &Config::reply_cache_bytes, "BYTES",
             "Memory for encoded replies to GET", 0, kNoBound, kFollows},
      Option{"reply-memory-bytes", Kind::bytes, &Config::reply_memory_bytes, "BYTES",
             "Memory for replies being made or sent; more are answered 503, larger ones 422",
             std::uint64_t{16} << 20, kNoBound, kFollows},
      Option{"body-timeout-seconds", Kind::whole_number, &Config::body_timeout_seconds, "SECONDS",
             "Time for a request's body to arrive", 1, kMaxSeconds, kFollows},
      Option{"min-upload-rate", Kind::bytes, &Config::min_upload_rate, "BYTES",
             "Bytes a second that a body must bring on average; slower is answered 408; 0: any", 0,
             kNoBound, kFollows},
      Option{"keep-alive-seconds", Kind::whole_number, &Config::keep_alive_seconds, "SECONDS",
             "Time a connection may idle between requests", 1, kMaxSeconds, kFollows},
      Option{"drain-delay-seconds", Kind::whole_number, &Config::drain_delay_seconds, "SECONDS",
             "Time after SIGTERM in which /readyz is 503, jobs end, kept connections end with a "
             "reply, and all else goes on, for balancers to see",
             0, kMaxSeconds, kFollows},
      Option{"drain-seconds", Kind::whole_number, &Config::drain_seconds, "SECONDS",
             "Time for running requests to finish after SIGTERM and that delay", 0, kMaxSeconds,
             kFollows},
      Option{
          "max-jobs", Kind::whole_number, &Config::max_jobs, "N",
          "Jobs (Prefer: respond-async) that may wait and run, at most half of them one client's; "
          "more are answered 503, and 429 to that client",
          0, kMaxQueue},
      Option{"job-result-bytes", Kind::bytes, &Config::job_result_bytes, "BYTES",
             "Memory for the bodies of jobs' requests and replies"},
      Option{"job-seconds", Kind::whole_number, &Config::job_seconds, "SECONDS",
             "Time for which a job is kept after its end", 1, kMaxSeconds},
      Option{"job-lease-seconds", Kind::whole_number, &Config::job_lease_seconds, "SECONDS",
             "Time after which a job that nobody asks about is cancelled; 0: never", 0,
             kMaxSeconds},
      Option{"log-level", Kind::level, &Config::log_level, "LEVEL",
             "trace, debug, info, warn, error, critical or off", 0, kNoBound, kFollows},
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

std::string format_value(const Option& option, const Config& config) {
  if (const auto* text = std::get_if<std::string Config::*>(&option.member)) return config.**text;
  if (const auto* address = std::get_if<Address Config::*>(&option.member)) {
    return format_address(config.**address);
  }
  const std::uint64_t number = config.*std::get<std::uint64_t Config::*>(option.member);
  return option.kind == Kind::bytes ? format_bytes(number) : std::to_string(number);
}

Result<void> set_option(const Option& option, std::string_view text, std::string_view source,
                        Config& config) {
  const auto refuse = [&](std::string_view reason) {
    return fail(Error{InputCode::bad_syntax,
                      fmt::format("{}: {}", source, reason),
                      std::string(option.name),
                      {},
                      {}});
  };
  const auto set_text = [&](bool is_valid, std::string_view reason) -> Result<void> {
    if (!is_valid) return refuse(fmt::format("'{}' {}", text, reason));
    config.*std::get<std::string Config::*>(option.member) = text;
    return {};
  };
  switch (option.kind) {
    case Kind::when_full:
      return set_text(text == "refuse" || text == "evict", "is neither refuse nor evict");
    case Kind::base_path:
      return set_text(is_base_path(text),
                      "is no path such as /geo or /tools/geo, or begins as the server's own do "
                      "(/v1, /docs)");
    case Kind::addresses:
      return set_text(AddressRanges::parse(text).has_value(),
                      "is no list of addresses and ranges such as 127.0.0.1,10.0.0.0/8,fd00::/8 "
                      "(no bits after the prefix)");
    case Kind::forwarded_header:
      return set_text(text == "x-forwarded-for" || text == "forwarded",
                      "is neither x-forwarded-for nor forwarded");
    case Kind::proxy_protocol:
      return set_text(text == "off" || text == "v2",
                      "is neither off nor v2 (a proxy's version 1 is not read)");
    case Kind::decoder:
      return set_text(text == "process" || text == "in-process",
                      "is neither process nor in-process");
    case Kind::level: {
      constexpr std::array<std::string_view, 7> kLevels{"trace", "debug",    "info", "warn",
                                                        "error", "critical", "off"};
      return set_text(std::find(kLevels.begin(), kLevels.end(), text) != kLevels.end(),
                      fmt::format("is none of {}", fmt::join(kLevels, ", ")));
    }
    case Kind::text:
      return set_text(true, "");
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

}  // namespace geodesic::server
