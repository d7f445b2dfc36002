// Parameters of a header, and the one by which an upload names its file.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace geodesic::server {

// The parameter of that name behind a header's value: `; name=value` or `; name="value"` (RFC 9110,
// section 5.6.6). A backslash before other than a quote or a backslash is one: browsers have sent
// whole paths of Windows. Nothing where it is absent, or where its quotes do not close.
[[nodiscard]] std::optional<std::string> header_parameter(std::string_view header,
                                                          std::string_view name);

// The file name in a Content-Disposition header (RFC 6266), without the folders before it:
// `filename*` where that can be read as UTF-8, else `filename`. Nothing where there is none.
[[nodiscard]] std::optional<std::string> file_name_in_disposition(std::string_view header);

// What is behind the last slash or backslash. Empty where that is a folder: `.` or `..`.
[[nodiscard]] std::string without_folders(std::string path);

}  // namespace geodesic::server
