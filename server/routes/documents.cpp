#include "server/routes/documents.h"

#include <algorithm>
#include <iterator>
#include <string>
#include <utility>

#include "server/routes/embedded_text.h"
#include "server/routes/static_files.h"

namespace geodesic::server {
namespace {

struct Document {
  std::string_view path;
  std::string_view type;
  std::string_view (*text)();
  bool is_contract = false;
};

constexpr std::string_view kScript = "text/javascript; charset=utf-8";
constexpr std::string_view kHtml = "text/html; charset=utf-8";
constexpr std::string_view kYaml = "application/yaml";

constexpr Document kDocuments[] = {
    {"/openapi.yaml", kYaml, openapi_yaml, true},
    {"/openapi.json", "application/json", openapi_json, true},
    {"/docs/api/", kHtml, docs_page},
    {"/docs/api/style.css", "text/css; charset=utf-8", docs_style},
    {"/docs/api/page.js", kScript, docs_page_script},
    {"/docs/api/examples.js", kScript, docs_examples_script},
    {"/docs/api/place.js", kScript, docs_place_script},
    {"/docs/api/request.js", kScript, docs_request_script},
    {"/docs/api/schema.js", kScript, docs_schema_script},
    {"/docs/api/tabs.js", kScript, docs_tabs_script},
    {"/docs/api/text.js", kScript, docs_text_script},
};

// Scripts and styles are files of this server; pictures are replies that the page shows.
constexpr const char* kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    "img-src 'self' blob: data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

bool is_for_a_browser(const HttpRequest& request) {
  const std::string* const accept = request.header("Accept");
  return accept != nullptr && accept->find("text/html") != std::string::npos;
}

HttpResponse page(std::string text) {
  HttpResponse response;
  response.set_body(std::move(text), std::string(kHtml));
  response.set_header("X-Content-Type-Options", "nosniff");
  response.set_header("Content-Security-Policy", kPolicy);
  response.set_header("Referrer-Policy", "no-referrer");
  return response;
}

// The contract as it holds behind a proxy that publishes the server below a path.
std::string at_base_path(std::string_view contract, const std::string& base_path) {
  std::string text(contract);
  if (base_path.empty()) return text;
  for (const std::string_view server : {"- url: /", "\"servers\":[{\"url\":\"/"}) {
    const std::size_t found = text.find(server);
    if (found != std::string::npos) text.replace(found + server.size() - 1, 1, base_path);
  }
  return text;
}

}  // namespace

std::optional<HttpResponse> find_document(const HttpRequest& request) {
  const std::string& path = request.path;
  // Each stands at one address, with a slash or without.
  if (path == "/docs") return redirect(308, "docs/");
  if (path == "/docs/api") return redirect(308, "api/");
  const Document* const found =
      std::find_if(std::begin(kDocuments), std::end(kDocuments),
                   [&](const Document& document) { return document.path == path; });
  if (found == std::end(kDocuments)) return std::nullopt;
  if (found->type == kHtml) return page(std::string(found->text()));
  HttpResponse response;
  std::string type(found->type);
  if (type == kYaml) {
    if (is_for_a_browser(request)) type = "text/plain; charset=utf-8";
    response.set_header("Vary", "Accept");
  }
  response.set_body(found->is_contract ? at_base_path(found->text(), request.base_path)
                                       : std::string(found->text()),
                    std::move(type));
  response.set_header("X-Content-Type-Options", "nosniff");
  return response;
}

std::optional<HttpResponse> missing_document(const HttpRequest& request) {
  constexpr std::string_view kDocs = "/docs/";
  constexpr std::string_view kPlace = "{docs}";
  if (!request.path.starts_with(kDocs) || !is_for_a_browser(request)) return std::nullopt;
  if (request.method != "GET" && request.method != "HEAD") return std::nullopt;
  std::string to_docs;
  for (std::size_t i = kDocs.size(); i < request.path.size(); ++i) {
    if (request.path[i] == '/') to_docs += "../";
  }
  if (to_docs.empty()) to_docs = "./";
  std::string text(missing_page());
  for (std::size_t at = 0; (at = text.find(kPlace, at)) != std::string::npos;) {
    text.replace(at, kPlace.size(), to_docs);
  }
  HttpResponse response = page(std::move(text));
  response.status = 404;
  response.set_header("Vary", "Accept");
  return response;
}

}  // namespace geodesic::server
