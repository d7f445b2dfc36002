#include "server/edge/tls.h"

#include <openssl/err.h>
#include <openssl/ssl.h>
#include <spdlog/fmt/fmt.h>

#include <array>
#include <utility>

#include "proto/wire/input_codes.h"
#include "server/edge/ticket_keys.h"

namespace geodesic::server {

namespace {

// TLS 1.3 has only suites of this kind.
constexpr const char* kCiphersOfTls12 = "ECDHE+AESGCM:ECDHE+CHACHA20";

// A question for a passphrase would wait at a terminal that nobody sees.
int no_passphrase(char*, int, int, void*) { return 0; }

// Clients that offer other protocols only (h2) learn at once that this is HTTP/1.1.
int choose_protocol(SSL*, const unsigned char** chosen, unsigned char* chosen_size,
                    const unsigned char* offered, unsigned offered_size, void*) {
  static constexpr std::array<unsigned char, 9> kOurs{8, 'h', 't', 't', 'p', '/', '1', '.', '1'};
  unsigned char* selected = nullptr;
  if (SSL_select_next_proto(&selected, chosen_size, kOurs.data(), kOurs.size(), offered,
                            offered_size) != OPENSSL_NPN_NEGOTIATED) {
    return SSL_TLSEXT_ERR_ALERT_FATAL;
  }
  *chosen = selected;
  return SSL_TLSEXT_ERR_OK;
}

tl::unexpected<Error> refuse(const std::string& what) {
  std::array<char, 256> reason{};
  ERR_error_string_n(ERR_peek_last_error(), reason.data(), reason.size());
  ERR_clear_error();
  return fail(InputCode::bad_syntax, fmt::format("TLS: {}: {}", what, reason.data()));
}

Result<std::shared_ptr<SSL_CTX>> make_context(const TlsContext::Files& files) {
  ERR_clear_error();
  const std::shared_ptr<SSL_CTX> context(SSL_CTX_new(TLS_server_method()), SSL_CTX_free);
  if (!context) return refuse("no memory");
  SSL_CTX* const raw = context.get();
  if (SSL_CTX_set_min_proto_version(raw, TLS1_2_VERSION) != 1 ||
      SSL_CTX_set_cipher_list(raw, kCiphersOfTls12) != 1) {
    return refuse("the library lacks a cipher");
  }
  SSL_CTX_set_options(
      raw, SSL_OP_NO_RENEGOTIATION | SSL_OP_NO_COMPRESSION | SSL_OP_CIPHER_SERVER_PREFERENCE);
  // Idle connections give their buffers back; a write takes what the socket takes.
  SSL_CTX_set_mode(raw, SSL_MODE_RELEASE_BUFFERS | SSL_MODE_ENABLE_PARTIAL_WRITE |
                            SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
  SSL_CTX_set_alpn_select_cb(raw, choose_protocol, nullptr);
  SSL_CTX_set_default_passwd_cb(raw, no_passphrase);
  if (SSL_CTX_use_certificate_chain_file(raw, files.certificate.c_str()) != 1) {
    return refuse(files.certificate);
  }
  if (SSL_CTX_use_PrivateKey_file(raw, files.key.c_str(), SSL_FILETYPE_PEM) != 1) {
    return refuse(files.key);
  }
  if (SSL_CTX_check_private_key(raw) != 1) return refuse(files.certificate + ", " + files.key);
  if (!files.ticket_keys.empty()) {
    auto keys = TicketKeys::load(files.ticket_keys);
    if (!keys) return fail(std::move(keys.error()));
    if (!TicketKeys::give(raw, std::move(*keys))) return refuse("tickets need memory");
  }
  return context;
}

}  // namespace

TlsSession::~TlsSession() { SSL_free(session_); }

Progress TlsSession::progress_of(int result) {
  switch (SSL_get_error(session_, result)) {
    case SSL_ERROR_NONE:
      return Progress::done;
    case SSL_ERROR_WANT_READ:
      return Progress::wants_read;
    case SSL_ERROR_WANT_WRITE:
      return Progress::wants_write;
    case SSL_ERROR_ZERO_RETURN:
      return Progress::closed;
    default:
      broken_ = true;
      return Progress::closed;
  }
}

// OpenSSL's queue of errors is the thread's: what another connection left there
// must not be taken for this one's.

Progress TlsSession::handshake() {
  ERR_clear_error();
  return progress_of(SSL_accept(session_));
}

Progress TlsSession::read(char* out, std::size_t size, std::size_t& count) {
  ERR_clear_error();
  return progress_of(SSL_read_ex(session_, out, size, &count));
}

Progress TlsSession::write(const char* data, std::size_t size, std::size_t& count) {
  ERR_clear_error();
  return progress_of(SSL_write_ex(session_, data, size, &count));
}

void TlsSession::say_goodbye() {
  if (broken_ || SSL_is_init_finished(session_) != 1) return;
  ERR_clear_error();
  SSL_shutdown(session_);
}

Result<std::shared_ptr<TlsContext>> TlsContext::load(Files files) {
  std::shared_ptr<TlsContext> context(new TlsContext(std::move(files)));
  if (auto loaded = context->reload(); !loaded) return fail(std::move(loaded.error()));
  return context;
}

Result<void> TlsContext::reload() {
  auto fresh = make_context(files_);
  if (!fresh) return fail(std::move(fresh.error()));
  const std::lock_guard lock(mutex_);
  context_ = std::move(*fresh);
  return {};
}

std::unique_ptr<TlsSession> TlsContext::open(int socket) const {
  std::shared_ptr<SSL_CTX> context;
  {
    const std::lock_guard lock(mutex_);
    context = context_;
  }
  SSL* const session = SSL_new(context.get());
  if (session == nullptr) return nullptr;
  auto owner = std::make_unique<TlsSession>(session);
  if (SSL_set_fd(session, socket) != 1) return nullptr;
  SSL_set_accept_state(session);
  return owner;
}

}  // namespace geodesic::server
