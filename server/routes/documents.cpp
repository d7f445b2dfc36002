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
};

constexpr std::string_view kScript = "text/javascript; charset=utf-8";

constexpr std::string_view kYaml = "application/yaml";

constexpr Document kDocuments[] = {
    {"/openapi.yaml", kYaml, openapi_yaml},
    {"/openapi.json", "application/json", openapi_json},
    {"/docs/api/", "text/html; charset=utf-8", docs_page},
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
  HttpResponse response;
  std::string type(found->type);
  if (type == kYaml) {
    const std::string* const accept = request.header("Accept");
    if (accept != nullptr && accept->find("text/html") != std::string::npos) {
      type = "text/plain; charset=utf-8";
    }
    response.set_header("Vary", "Accept");
  }
  response.set_body(std::string(found->text()), std::move(type));
  response.set_header("X-Content-Type-Options", "nosniff");
  if (found->type.starts_with("text/html")) {
    response.set_header("Content-Security-Policy", kPolicy);
    response.set_header("Referrer-Policy", "no-referrer");
  }
  return response;
}

}  // namespace geodesic::server
