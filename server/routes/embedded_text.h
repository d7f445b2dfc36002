// Files that are part of the program.
#pragma once

#include <string_view>

namespace geodesic::server {

[[nodiscard]] std::string_view openapi_yaml();  // proto/openapi.yaml
[[nodiscard]] std::string_view openapi_json();  // the same as JSON

// The files of clients/web/docs.
[[nodiscard]] std::string_view docs_page();
[[nodiscard]] std::string_view docs_style();
[[nodiscard]] std::string_view docs_page_script();
[[nodiscard]] std::string_view docs_examples_script();
[[nodiscard]] std::string_view docs_place_script();
[[nodiscard]] std::string_view docs_request_script();
[[nodiscard]] std::string_view docs_schema_script();
[[nodiscard]] std::string_view docs_tabs_script();
[[nodiscard]] std::string_view docs_text_script();

[[nodiscard]] std::string_view start_page();  // clients/web/index.html

// clients/web/missing.html, where {docs} stands for the way from the address asked for to /docs/.
[[nodiscard]] std::string_view missing_page();

}  // namespace geodesic::server
