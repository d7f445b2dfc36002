#include "server/routes/documents.h"

#include <algorithm>
#include <iterator>
#include <string>

#include "server/routes/embedded_text.h"

namespace geodesic::server {
namespace {

struct Document {
  std::string_view path;
  std::string_view type;
  std::string_view (*text)();
};

constexpr std::string_view kScript = "text/javascript; charset=utf-8";

constexpr Document kDocuments[] = {
    {"/openapi.yaml", "application/yaml", openapi_yaml},
    {"/openapi.json", "application/json", openapi_json},
    {"/docs", "text/html; charset=utf-8", docs_page},
    {"/docs/style.css", "text/css; charset=utf-8", docs_style},
    {"/docs/page.js", kScript, docs_page_script},
    {"/docs/request.js", kScript, docs_request_script},
    {"/docs/schema.js", kScript, docs_schema_script},
    {"/docs/text.js", kScript, docs_text_script},
};

// Scripts and styles are files of this server; pictures are replies that the page shows.
constexpr const char* kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    "img-src 'self' blob: data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

}  // namespace

std::optional<HttpResponse> find_document(std::string_view path) {
  const Document* const found =
      std::find_if(std::begin(kDocuments), std::end(kDocuments),
                   [&](const Document& document) { return document.path == path; });
  if (found == std::end(kDocuments)) return std::nullopt;
  HttpResponse response;
  response.set_body(std::string(found->text()), std::string(found->type));
  response.set_header("X-Content-Type-Options", "nosniff");
  if (found->type.starts_with("text/html")) {
    response.set_header("Content-Security-Policy", kPolicy);
    response.set_header("Referrer-Policy", "no-referrer");
  }
  return response;
}

}  // namespace geodesic::server
