// Bodies of several parts, as forms send files (RFC 7578, multipart/form-data).
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"

namespace geodesic::server {

// Views into the body.
struct Part {
  std::string name;      // of the form's field
  std::string filename;  // empty: a field without a file
  std::string_view bytes;
};

// The boundary, if the content type is multipart/form-data with one that may be.
[[nodiscard]] std::optional<std::string> multipart_boundary(std::string_view content_type);

// Whether the content type is multipart/form-data, with a boundary or not.
[[nodiscard]] bool is_multipart(std::string_view content_type);

// Errors: bad_syntax (parameter `body`): what is not of this form, or of more than
// 1000 parts.
[[nodiscard]] Result<std::vector<Part>> read_multipart(std::string_view body,
                                                       std::string_view boundary);

}  // namespace geodesic::server
