// TLS for a listener: a certificate with its key, the keys of tickets, and one session a
// connection. OpenSSL does the work. TLS 1.2 and 1.3, forward secrecy and authenticated encryption
// only; no renegotiation, no compression. Nothing here waits: a handshake that does not go on is
// the caller's to give up.
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <string>

#include "core/base/error.h"
#include "server/edge/progress.h"

struct ssl_ctx_st;
struct ssl_st;

namespace geodesic::server {

class TlsSession {
 public:
  explicit TlsSession(ssl_st* session) : session_(session) {}  // takes it over
  ~TlsSession();
  TlsSession(const TlsSession&) = delete;
  TlsSession& operator=(const TlsSession&) = delete;

  [[nodiscard]] Progress handshake();
  // At least one byte when done; `count` says how many.
  [[nodiscard]] Progress read(char* out, std::size_t size, std::size_t& count);
  [[nodiscard]] Progress write(const char* data, std::size_t size, std::size_t& count);
  // Tells the peer that this was all, so that nobody can cut a reply short unseen.
  void say_goodbye();

 private:
  Progress progress_of(int result);
  ssl_st* const session_;
  bool broken_ = false;
};

// Thread-safe.
class TlsContext {
 public:
  struct Files {
    std::string certificate;  // PEM; may hold the chain that leads to a root
    std::string key;          // PEM
    std::string ticket_keys;  // ticket_keys.h; empty: keys of this context's own
  };
  // Fails with `bad_syntax` and a sentence for the operator (unreadable, no match,
  // a key that wants a passphrase).
  [[nodiscard]] static Result<std::shared_ptr<TlsContext>> load(Files files);
  // Reads the files again, for connections to come; those that are open keep what
  // they have. On failure nothing changes.
  [[nodiscard]] Result<void> reload();

  // For an accepted socket, which stays the caller's; null without memory.
  [[nodiscard]] std::unique_ptr<TlsSession> open(int socket) const;

 private:
  explicit TlsContext(Files files) : files_(std::move(files)) {}

  const Files files_;
  mutable std::mutex mutex_;
  std::shared_ptr<ssl_ctx_st> context_;
};

}  // namespace geodesic::server
