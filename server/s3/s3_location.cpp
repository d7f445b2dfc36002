#include "server/s3/s3_location.h"

#include <curl/curl.h>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <charconv>
#include <memory>
#include <utility>

#include "proto/wire/input_codes.h"
#include "server/http/head.h"

namespace geodesic::server {

namespace {

struct FreeUrl {
  void operator()(CURLU* url) const { curl_url_cleanup(url); }
};
struct FreeText {
  void operator()(char* text) const { curl_free(text); }
};
using Url = std::unique_ptr<CURLU, FreeUrl>;
using Text = std::unique_ptr<char, FreeText>;

tl::unexpected<Error> bad(std::string_view url, std::string_view reason) {
  return fail(InputCode::bad_syntax, fmt::format("'{}': {}", url, reason));
}

// A part of a URL, empty if it has none.
std::string part(const Url& url, CURLUPart which, unsigned flags = 0) {
  char* text = nullptr;
  if (curl_url_get(url.get(), which, &text, flags) != CURLUE_OK) return {};
  return Text(text).get();
}

Url parsed(std::string_view text) {
  Url url(curl_url());
  if (url && curl_url_set(url.get(), CURLUPART_URL, std::string(text).c_str(),
                          CURLU_NON_SUPPORT_SCHEME) != CURLUE_OK) {
    url.reset();
  }
  return url;
}

// What needs no escaping: versions of libcurl differ in how they sign the rest.
bool is_plain(std::string_view text, std::string_view also) {
  return std::all_of(text.begin(), text.end(), [&](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           also.find(c) != std::string_view::npos;
  });
}

bool is_bucket(std::string_view name) {
  return name.size() >= 3 && name.size() <= 63 && is_plain(name, "-.") && name.front() != '.' &&
         name.front() != '-';
}

// Returns the path with one slash at its end and none at its start: "a/b/" for "/a/b". Empty if
// there is no prefix.
Result<std::string> prefix_of(std::string_view url, std::string_view path) {
  while (path.starts_with('/')) path.remove_prefix(1);
  while (path.ends_with('/')) path.remove_suffix(1);
  if (path.empty()) return std::string();
  const std::string slashed = fmt::format("/{}/", path);
  for (const std::string_view odd : {"//", "/./", "/../"}) {
    if (slashed.find(odd) != std::string::npos) return bad(url, "the prefix has an odd segment");
  }
  if (!is_plain(path, "-._~/") || path.size() > 512) {
    return bad(url, "a prefix has letters, digits and - . _ ~ / only, 512 of them at most");
  }
  return slashed.substr(1);
}

struct Parameters {
  std::string endpoint;
  std::string region = "us-east-1";
  std::string style;
  std::string timeout = "10";
};

Result<Parameters> parameters_of(std::string_view url, std::string_view query) {
  Parameters parameters;
  auto items = parse_query(query);
  if (!items) return bad(url, items.error().detail);
  for (auto& [name, value] : *items) {
    if (name == "endpoint") {
      parameters.endpoint = std::move(value);
    } else if (name == "region") {
      parameters.region = std::move(value);
    } else if (name == "style") {
      parameters.style = std::move(value);
    } else if (name == "timeout") {
      parameters.timeout = std::move(value);
    } else {
      return fail(
          InputCode::unknown_parameter,
          fmt::format("'{}': '{}' is none of endpoint, region, style and timeout", url, name));
    }
  }
  return parameters;
}

// The bucket's URL; `location` has the bucket and the region.
Result<std::string> bucket_url(std::string_view text, const Parameters& parameters,
                               const S3Location& location) {
  const bool is_amazon = parameters.endpoint.empty();
  const std::string endpoint =
      is_amazon ? fmt::format("https://s3.{}.amazonaws.com", location.region) : parameters.endpoint;
  const Url url = parsed(endpoint);
  if (!url) return bad(text, "the endpoint is no URL");
  const std::string scheme = part(url, CURLUPART_SCHEME);
  if (scheme != "http" && scheme != "https") return bad(text, "the endpoint is not http or https");
  if (!part(url, CURLUPART_USER).empty() || !part(url, CURLUPART_PASSWORD).empty()) {
    return bad(scheme + "://…", "credentials are given in the environment, not in the URL");
  }
  const std::string path = part(url, CURLUPART_PATH);
  if ((!path.empty() && path != "/") || !part(url, CURLUPART_QUERY).empty()) {
    return bad(text, "the endpoint has a path or a query");
  }
  const std::string host = part(url, CURLUPART_HOST);
  const std::string port = part(url, CURLUPART_PORT);
  const std::string authority = port.empty() ? host : host + ":" + port;
  // A certificate for *.s3.… does not cover a name with more dots.
  const bool virtual_by_default = is_amazon && location.bucket.find('.') == std::string::npos;
  const std::string style =
      parameters.style.empty() ? (virtual_by_default ? "virtual" : "path") : parameters.style;
  if (style == "path") return fmt::format("{}://{}/{}", scheme, authority, location.bucket);
  if (style == "virtual") return fmt::format("{}://{}.{}", scheme, location.bucket, authority);
  return bad(text, "style is path or virtual");
}

}  // namespace

std::string S3Location::name() const { return "s3://" + bucket + "/" + prefix; }

bool S3Location::is_exposed() const {
  const Url parts = parsed(url);
  if (!parts || part(parts, CURLUPART_SCHEME) != "http") return false;
  const std::string host = part(parts, CURLUPART_HOST);
  return host != "localhost" && host != "[::1]" && !host.starts_with("127.");
}

bool is_s3_url(std::string_view text) { return text.starts_with("s3://"); }

Result<S3Location> parse_s3_url(std::string_view text, const Environment& environment) {
  const Url url = parsed(text);
  if (!url || !is_s3_url(text)) return bad(text, "this is no s3:// URL");
  if (!part(url, CURLUPART_USER).empty() || !part(url, CURLUPART_PASSWORD).empty()) {
    return bad("s3://…", "credentials are given in the environment, not in the URL");
  }
  S3Location location;
  location.bucket = part(url, CURLUPART_HOST);
  if (!is_bucket(location.bucket) || !part(url, CURLUPART_PORT).empty()) {
    return bad(text, "this is no name of a bucket");
  }
  auto prefix = prefix_of(text, part(url, CURLUPART_PATH));
  if (!prefix) return fail(std::move(prefix.error()));
  location.prefix = std::move(*prefix);
  auto parameters = parameters_of(text, part(url, CURLUPART_QUERY));
  if (!parameters) return fail(std::move(parameters.error()));
  if (parameters->region.empty() || !is_plain(parameters->region, "-_")) {
    return bad(text, "this is no name of a region");
  }
  location.region = parameters->region;
  long seconds = 0;
  const std::string& timeout = parameters->timeout;
  const auto [stop, error] =
      std::from_chars(timeout.data(), timeout.data() + timeout.size(), seconds);
  if (error != std::errc() || stop != timeout.data() + timeout.size() || seconds < 1 ||
      seconds > 3600) {
    return bad(text, "timeout is a whole number of seconds, 1 to 3600");
  }
  location.timeout = std::chrono::seconds(seconds);
  auto bucket = bucket_url(text, *parameters, location);
  if (!bucket) return fail(std::move(bucket.error()));
  location.url = std::move(*bucket);

  location.access_key = environment("AWS_ACCESS_KEY_ID").value_or("");
  location.secret_key = environment("AWS_SECRET_ACCESS_KEY").value_or("");
  location.session_token = environment("AWS_SESSION_TOKEN").value_or("");
  if (location.access_key.empty() || location.secret_key.empty()) {
    return bad(text, "AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY are not set");
  }
  return location;
}

}  // namespace geodesic::server
