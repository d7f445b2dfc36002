// The keys of TLS session tickets, read from a file that several servers share: a client that comes
// to another of them, or to one that was started anew, goes on with its session. Without such a
// file OpenSSL draws keys that nobody else has.
//
// The file is one that HAProxy takes for `tls-ticket-keys`: a key a line, at least three, each 80
// random bytes in base64. The last but one encrypts; all decrypt. So a fresh key goes to the end of
// the file, where every server knows it before any of them uses it.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"

struct ssl_ctx_st;

namespace geodesic::server {

class TicketKeys {
 public:
  static constexpr std::size_t kLeast = 3;
  static constexpr std::size_t kMost = 16;

  // Fails with `bad_syntax` and a sentence for the operator that holds no key: unreadable, readable
  // by everybody, a line that is no key, too few or too many of them.
  [[nodiscard]] static Result<std::shared_ptr<const TicketKeys>> load(const std::string& file);
  ~TicketKeys();  // leaves nothing in memory
  TicketKeys(const TicketKeys&) = delete;
  TicketKeys& operator=(const TicketKeys&) = delete;

  // Has a context's tickets made with these keys, which live as long as it does.
  [[nodiscard]] static bool give(ssl_ctx_st* context, std::shared_ptr<const TicketKeys> keys);

  struct Key {
    std::array<unsigned char, 16> name;    // in the ticket, in the clear
    std::array<unsigned char, 32> mac;     // HMAC with SHA-256
    std::array<unsigned char, 32> cipher;  // AES-256-CBC
  };
  [[nodiscard]] const Key& encrypting() const { return keys_[keys_.size() - 2]; }
  // The key of that name, and whether a ticket of it is to be replaced: its key will go first.
  struct Found {
    const Key* key;  // null: there is none
    bool is_old;
  };
  [[nodiscard]] Found find(const unsigned char* name) const;

 private:
  TicketKeys() = default;
  Result<void> add(std::string_view line);

  std::vector<Key> keys_;  // in the order of the file
};

}  // namespace geodesic::server
