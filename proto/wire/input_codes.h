// What may be wrong with the bytes of a request or of a file, besides what the engine says of a
// mesh (core/base/error.h).
#pragma once

#include "core/base/error.h"

namespace geodesic {

// NOLINTBEGIN(readability-identifier-naming): called as clients are told.
struct InputCode {
  // The request does not parse.
  static constexpr ErrorCode bad_syntax{"bad_syntax"};
  // A parameter that no such query has.
  static constexpr ErrorCode unknown_parameter{"unknown_parameter"};
  // No format that the client accepts.
  static constexpr ErrorCode not_acceptable{"not_acceptable"};
  // The bytes are of no format that we read.
  static constexpr ErrorCode format_unknown{"format_unknown"};
  // The file refers to another file.
  static constexpr ErrorCode external_uri{"external_uri"};
  // The file requires an extension that we lack.
  static constexpr ErrorCode extension_required{"extension_required"};
  // No geodesic method of that name.
  static constexpr ErrorCode method_unknown{"method_unknown"};
  // Stored bytes are not what was stored.
  static constexpr ErrorCode store_corrupt{"store_corrupt"};
};
// NOLINTEND(readability-identifier-naming)

}  // namespace geodesic
