#include "server/edge/ticket_keys.h"

#include <openssl/core_names.h>
#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/params.h>
#include <openssl/rand.h>
#include <openssl/ssl.h>
#include <spdlog/fmt/fmt.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <utility>

#include "proto/wire/input_codes.h"

namespace geodesic::server {

namespace {

constexpr std::size_t kKeyBytes = sizeof(TicketKeys::Key);
static_assert(kKeyBytes == 80, "the parts of a key stand in the file one behind the other");
constexpr std::size_t kLineBytes = (kKeyBytes + 2) / 3 * 4;  // in base64
constexpr std::size_t kMostFileBytes = 8192;

tl::unexpected<Error> bad_keys(std::string detail) {
  return fail(InputCode::bad_syntax, std::move(detail));
}

using SharedKeys = std::shared_ptr<const TicketKeys>;

// Called when a context goes, which its sessions may have kept longer than its owner.
void drop_keys(void*, void* keys, CRYPTO_EX_DATA*, int, long, void*) {
  delete static_cast<SharedKeys*>(keys);
}

int place_of_keys() {
  static const int place =
      CRYPTO_get_ex_new_index(CRYPTO_EX_INDEX_SSL_CTX, 0, nullptr, nullptr, nullptr, drop_keys);
  return place;
}

bool set_mac(EVP_MAC_CTX* mac, const TicketKeys::Key& key) {
  // OpenSSL does not write to either.
  auto* const bytes = const_cast<unsigned char*>(key.mac.data());
  auto* const digest = const_cast<char*>("SHA256");
  const std::array parameters{
      OSSL_PARAM_construct_octet_string(OSSL_MAC_PARAM_KEY, bytes, key.mac.size()),
      OSSL_PARAM_construct_utf8_string(OSSL_MAC_PARAM_DIGEST, digest, 0),
      OSSL_PARAM_construct_end()};
  return EVP_MAC_CTX_set_params(mac, parameters.data()) == 1;
}

// OpenSSL's question for a key; see SSL_CTX_set_tlsext_ticket_key_evp_cb(3) for the numbers.
int choose_key(SSL* session, unsigned char* name, unsigned char* iv, EVP_CIPHER_CTX* cipher,
               EVP_MAC_CTX* mac, int encrypts) {
  constexpr int kFailed = -1;
  constexpr int kNoSuchKey = 0;  // a full handshake
  constexpr int kTaken = 1;
  constexpr int kTakenAndReplaced = 2;
  const auto* const keys = static_cast<const SharedKeys*>(
      SSL_CTX_get_ex_data(SSL_get_SSL_CTX(session), place_of_keys()));
  if (keys == nullptr) return kFailed;
  if (encrypts == 1) {
    const TicketKeys::Key& key = (*keys)->encrypting();
    std::memcpy(name, key.name.data(), key.name.size());
    const bool is_ready =
        RAND_bytes(iv, EVP_CIPHER_get_iv_length(EVP_aes_256_cbc())) == 1 && set_mac(mac, key) &&
        EVP_EncryptInit_ex2(cipher, EVP_aes_256_cbc(), key.cipher.data(), iv, nullptr) == 1;
    return is_ready ? kTaken : kFailed;
  }
  const auto [key, is_old] = (*keys)->find(name);
  if (key == nullptr) return kNoSuchKey;
  const bool is_ready =
      set_mac(mac, *key) &&
      EVP_DecryptInit_ex2(cipher, EVP_aes_256_cbc(), key->cipher.data(), iv, nullptr) == 1;
  if (!is_ready) return kFailed;
  return is_old ? kTakenAndReplaced : kTaken;
}

}  // namespace

TicketKeys::~TicketKeys() { OPENSSL_cleanse(keys_.data(), keys_.size() * sizeof(Key)); }

auto TicketKeys::find(const unsigned char* name) const -> Found {
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    if (std::memcmp(keys_[i].name.data(), name, keys_[i].name.size()) == 0) {
      return {&keys_[i], i + 2 < keys_.size()};
    }
  }
  return {nullptr, false};
}

Result<void> TicketKeys::add(std::string_view line) {
  constexpr std::string_view kRecipe =
      "a key is 80 random bytes, as `openssl rand 80 | base64 -w0`";
  const bool is_long_enough =
      line.size() == kLineBytes && line.ends_with('=') && line[kLineBytes - 2] != '=';
  std::array<unsigned char, kLineBytes / 4 * 3> bytes{};
  const bool is_key =
      is_long_enough && line.find_first_of(" \t") == std::string_view::npos &&
      EVP_DecodeBlock(bytes.data(), reinterpret_cast<const unsigned char*>(line.data()),
                      static_cast<int>(line.size())) == static_cast<int>(bytes.size());
  const bool is_twice = is_key && find(bytes.data()).key != nullptr;
  if (!is_key || is_twice || keys_.size() == kMost) {
    OPENSSL_cleanse(bytes.data(), bytes.size());
    return bad_keys(!is_key    ? std::string(kRecipe)
                    : is_twice ? "the key stands in the file twice"
                               : fmt::format("more than {} keys", kMost));
  }
  Key key;
  std::memcpy(&key, bytes.data(), sizeof key);
  keys_.push_back(key);
  OPENSSL_cleanse(bytes.data(), bytes.size());
  OPENSSL_cleanse(&key, sizeof key);
  return {};
}

Result<std::shared_ptr<const TicketKeys>> TicketKeys::load(const std::string& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) {
    return bad_keys(file + ": is no file that can be read");
  }
  if ((status.st_mode & (S_IROTH | S_IWOTH)) != 0) {
    return bad_keys(file + ": everybody on this machine may read or write it (chmod o-rw)");
  }
  std::ifstream in(file, std::ios::binary);
  std::string text(kMostFileBytes + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!in.is_open() || in.bad()) return bad_keys(file + ": is no file that can be read");
  const auto size = static_cast<std::size_t>(in.gcount());
  if (size > kMostFileBytes) {
    OPENSSL_cleanse(text.data(), text.size());
    return bad_keys(fmt::format("{}: more than {} bytes", file, kMostFileBytes));
  }
  const std::shared_ptr<TicketKeys> keys(new TicketKeys);
  keys->keys_.reserve(kMost);  // no copy is left behind
  std::string_view rest(text.data(), size);
  Result<void> added;
  for (int number = 1; !rest.empty() && added; ++number) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    std::string_view line = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.empty()) continue;
    added = keys->add(line);
    if (!added) added = bad_keys(fmt::format("{}:{}: {}", file, number, added.error().detail));
  }
  OPENSSL_cleanse(text.data(), text.size());
  if (!added) return fail(std::move(added.error()));
  if (keys->keys_.size() < kLeast) {
    return bad_keys(
        fmt::format("{}: {} keys, and at least {} are needed: one that was, one that is "
                    "and one to come",
                    file, keys->keys_.size(), kLeast));
  }
  return keys;
}

bool TicketKeys::give(ssl_ctx_st* context, std::shared_ptr<const TicketKeys> keys) {
  auto owner = std::make_unique<SharedKeys>(std::move(keys));
  if (SSL_CTX_set_ex_data(context, place_of_keys(), owner.get()) != 1) return false;
  (void)owner.release();
  return SSL_CTX_set_tlsext_ticket_key_evp_cb(context, choose_key) == 1;
}

}  // namespace geodesic::server
