#include "server/store/mesh_id.h"

#include <cstddef>

#include "server/base/sha256.h"

namespace geodesic::server {
namespace {

constexpr std::string_view kHexDigits = "0123456789abcdef";
constexpr std::size_t kDigestSize = 64;
constexpr std::size_t kOptionsDigestSize = 32;
constexpr std::size_t kOldOptionsDigestSize = 12;
constexpr char kOptionsMark = '~';

}  // namespace

bool is_mesh_id(std::string_view id) {
  const auto is_hex = [](std::string_view digits) {
    return digits.find_first_not_of(kHexDigits) == std::string_view::npos;
  };
  if (id.size() == kDigestSize) return is_hex(id);
  const bool has_size = id.size() == kDigestSize + 1 + kOptionsDigestSize ||
                        id.size() == kDigestSize + 1 + kOldOptionsDigestSize;
  return has_size && id[kDigestSize] == kOptionsMark && is_hex(source_digest(id)) &&
         is_hex(id.substr(kDigestSize + 1));
}

std::string mesh_id(std::string_view sha256, std::string_view options) {
  std::string id(sha256);
  if (!options.empty())
    id.append(1, kOptionsMark).append(sha256_hex(options), 0, kOptionsDigestSize);
  return id;
}

bool is_of_options(std::string_view id, std::string_view options) {
  if (options.empty() || !has_options(id)) return options.empty() && !has_options(id);
  return sha256_hex(options).starts_with(id.substr(kDigestSize + 1));
}

std::string_view source_digest(std::string_view id) { return id.substr(0, kDigestSize); }

bool has_options(std::string_view id) { return id.size() > kDigestSize; }

}  // namespace geodesic::server
