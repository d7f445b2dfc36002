#include "server/base/sha256.h"

#include <openssl/evp.h>

#include <array>
#include <cstddef>
#include <memory>
#include <stdexcept>

namespace geodesic::server {

namespace {

constexpr std::size_t kAtOnce = std::size_t{4} << 20;

void require(bool fine) {
  // Only an OpenSSL without SHA-256 or out of memory fails.
  if (!fine) throw std::runtime_error("SHA-256 is not available");
}

}  // namespace

std::string sha256_hex(std::string_view bytes) {
  return *sha256_hex(bytes, [] { return false; });
}

std::optional<std::string> sha256_hex(std::string_view bytes, const std::function<bool()>& stop) {
  Sha256 digest;
  while (!bytes.empty()) {
    const std::string_view piece = bytes.substr(0, kAtOnce);
    digest.add(piece);
    bytes.remove_prefix(piece.size());
    if (!bytes.empty() && stop()) return std::nullopt;
  }
  return digest.hex();
}

struct Sha256::Context {
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> md{EVP_MD_CTX_new(), &EVP_MD_CTX_free};
};

Sha256::Sha256() : context_(std::make_unique<Context>()) {
  require(context_->md && EVP_DigestInit_ex(context_->md.get(), EVP_sha256(), nullptr) == 1);
}

Sha256::~Sha256() = default;

void Sha256::add(std::string_view bytes) {
  require(EVP_DigestUpdate(context_->md.get(), bytes.data(), bytes.size()) == 1);
}

std::string Sha256::hex() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int length = 0;
  require(EVP_DigestFinal_ex(context_->md.get(), digest.data(), &length) == 1);
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string hex;
  hex.reserve(2 * length);
  for (unsigned int i = 0; i < length; ++i) {
    hex += kDigits[digest[i] >> 4];
    hex += kDigits[digest[i] & 15];
  }
  return hex;
}

}  // namespace geodesic::server
