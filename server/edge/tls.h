// TLS for a listener: a certificate with its key, and one session a connection.
// OpenSSL does the work. TLS 1.2 and 1.3, forward secrecy and authenticated
// encryption only; no renegotiation, no compression. Nothing here waits: a
// handshake that does not go on is the caller's to give up.
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
  // Both files are PEM; the certificate's may hold the chain that leads to a root.
  // Fails with `bad_syntax` and a sentence for the operator (unreadable, no match,
  // a key that wants a passphrase).
  [[nodiscard]] static Result<std::shared_ptr<TlsContext>> load(std::string certificate_file,
                                                                std::string key_file);
  // Reads the files again, for connections to come; those that are open keep what
  // they have. On failure nothing changes.
  [[nodiscard]] Result<void> reload();

  // For an accepted socket, which stays the caller's; null without memory.
  [[nodiscard]] std::unique_ptr<TlsSession> open(int socket) const;

 private:
  TlsContext(std::string certificate_file, std::string key_file)
      : certificate_file_(std::move(certificate_file)), key_file_(std::move(key_file)) {}

  const std::string certificate_file_;
  const std::string key_file_;
  mutable std::mutex mutex_;
  std::shared_ptr<ssl_ctx_st> context_;
};

}  // namespace geodesic::server
