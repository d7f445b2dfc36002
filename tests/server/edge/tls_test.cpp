// TLS in front of the HTTP edge, with certificates that the test makes itself.
#include "server/edge/tls.h"

#include <doctest/doctest.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>
#include <stdlib.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <future>
#include <memory>
#include <vector>

#include "tests/fixtures/wait_until.h"
#include "tests/server/edge/fixture.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using geodesic::fixtures::wait_until;

namespace {

class Folder {
 public:
  Folder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "tls_XXXXXX").string();
    REQUIRE(::mkdtemp(pattern.data()) != nullptr);
    path_ = pattern;
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] std::string file(const char* name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

template <class T>
using Owned = std::unique_ptr<T, void (*)(T*)>;

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, FileCloser>;

// A key and a certificate that it signs itself, for `name`, as PEM files.
void make_certificate(const Folder& folder, const char* name) {
  const Owned<EVP_PKEY> key(EVP_EC_gen("P-256"), EVP_PKEY_free);
  const Owned<X509> certificate(X509_new(), X509_free);
  REQUIRE(key);
  ASN1_INTEGER_set(X509_get_serialNumber(certificate.get()), 1);
  X509_gmtime_adj(X509_getm_notBefore(certificate.get()), -60);
  X509_gmtime_adj(X509_getm_notAfter(certificate.get()), 3600);
  X509_set_pubkey(certificate.get(), key.get());
  X509_NAME* const subject = X509_get_subject_name(certificate.get());
  X509_NAME_add_entry_by_txt(subject, "CN", MBSTRING_ASC,
                             reinterpret_cast<const unsigned char*>(name), -1, -1, 0);
  X509_set_issuer_name(certificate.get(), subject);
  REQUIRE(X509_sign(certificate.get(), key.get(), EVP_sha256()) > 0);
  const File key_file(std::fopen(folder.file("key.pem").c_str(), "w"));
  const File certificate_file(std::fopen(folder.file("certificate.pem").c_str(), "w"));
  REQUIRE(PEM_write_PrivateKey(key_file.get(), key.get(), nullptr, nullptr, 0, nullptr, nullptr) ==
          1);
  REQUIRE(PEM_write_X509(certificate_file.get(), certificate.get()) == 1);
}

std::shared_ptr<TlsContext> loaded(const Folder& folder) {
  auto context = TlsContext::load({folder.file("certificate.pem"), folder.file("key.pem"), {}});
  REQUIRE(context);
  return *context;
}

// A TLS client on a raw one's socket.
class TlsClient {
 public:
  explicit TlsClient(int port, int newest = TLS1_3_VERSION, const char* protocols = nullptr)
      : tcp_(port),
        context_(SSL_CTX_new(TLS_client_method()), SSL_CTX_free),
        tls_(nullptr, SSL_free) {
    // As old as the library still speaks, so that it is the server that refuses.
    SSL_CTX_set_cipher_list(context_.get(), "ALL:@SECLEVEL=0");
    SSL_CTX_set_min_proto_version(context_.get(), TLS1_VERSION);
    SSL_CTX_set_max_proto_version(context_.get(), newest);
    tls_.reset(SSL_new(context_.get()));
    if (protocols != nullptr) {
      SSL_set_alpn_protos(tls_.get(), reinterpret_cast<const unsigned char*>(protocols),
                          static_cast<unsigned>(std::string_view(protocols).size()));
    }
    SSL_set_fd(tls_.get(), tcp_.socket());
    connected_ = SSL_connect(tls_.get()) == 1;
    ERR_clear_error();
  }
  [[nodiscard]] bool connected() const { return connected_; }
  [[nodiscard]] std::string version() const { return SSL_get_version(tls_.get()); }
  [[nodiscard]] std::string cipher() const { return SSL_get_cipher_name(tls_.get()); }
  [[nodiscard]] std::string server_name() const {
    const Owned<X509> certificate(SSL_get1_peer_certificate(tls_.get()), X509_free);
    char name[100] = {};
    X509_NAME_get_text_by_NID(X509_get_subject_name(certificate.get()), NID_commonName, name,
                              sizeof name);
    return name;
  }
  void send(std::string_view bytes) {
    while (!bytes.empty()) {
      const int n = SSL_write(tls_.get(), bytes.data(), static_cast<int>(bytes.size()));
      REQUIRE(n > 0);
      bytes.remove_prefix(static_cast<std::size_t>(n));
    }
  }
  // All up to `size` bytes, or to the end.
  std::string read(std::size_t size) {
    std::string bytes(size, '\0');
    std::size_t have = 0;
    while (have < size) {
      const int n = SSL_read(tls_.get(), bytes.data() + have, static_cast<int>(size - have));
      if (n <= 0) break;
      have += static_cast<std::size_t>(n);
    }
    bytes.resize(have);
    return bytes;
  }
  // The next reply's body.
  std::string receive() {
    std::string head;
    while (head.find("\r\n\r\n") == std::string::npos) {
      const std::string byte = read(1);
      if (byte.empty()) return "";
      head += byte;
    }
    const std::size_t at = head.find("Content-Length: ");
    REQUIRE(at != std::string::npos);
    return read(std::stoull(head.substr(at + 16)));
  }
  // The server has said goodbye, as against a connection that somebody has cut.
  bool ends() {
    char byte;
    return SSL_read(tls_.get(), &byte, 1) == 0 &&
           SSL_get_error(tls_.get(), 0) == SSL_ERROR_ZERO_RETURN;
  }

 private:
  RawClient tcp_;
  Owned<SSL_CTX> context_;
  Owned<SSL> tls_;
  bool connected_ = false;
};

HttpOptions with_tls(const Folder& folder) {
  HttpOptions options = Edge::patient();
  options.tls = loaded(folder);
  return options;
}

}  // namespace

TEST_CASE("requests are answered over TLS, on one connection and pipelined") {
  const Folder folder;
  make_certificate(folder, "edge");
  Edge edge(with_tls(folder));
  TlsClient client(edge.port);
  REQUIRE(client.connected());
  CHECK(client.version() == "TLSv1.3");
  CHECK(client.server_name() == "edge");
  client.send(get("/one"));
  CHECK(json::parse(client.receive())["path"] == "/one");
  client.send(get("/two") + get("/three") + post("/echo", "Content-Length: 3\r\n", "abc"));
  CHECK(json::parse(client.receive())["path"] == "/two");
  CHECK(json::parse(client.receive())["path"] == "/three");
  CHECK(client.receive() == "abc");
  client.send(get("/last", "Connection: close\r\n"));
  CHECK(json::parse(client.receive())["path"] == "/last");
  CHECK(client.ends());
}

TEST_CASE("large bodies pass through TLS both ways, and slow readers hold no thread") {
  const Folder folder;
  make_certificate(folder, "edge");
  HttpOptions options = with_tls(folder);
  options.io_threads = options.max_io_threads = 1;
  Edge edge(std::move(options));
  TlsClient slow(edge.port);
  slow.send(get("/big"));  // and does not read
  std::string body(2'000'000, '\0');
  std::uint32_t state = 1;
  for (char& c : body) c = static_cast<char>((state = state * 1664525u + 1013904223u) >> 24);
  TlsClient client(edge.port);
  client.send(post("/echo", with_length(body), body));
  CHECK(client.receive() == body);
  CHECK(slow.receive() == std::string(20'000'000, 'x'));
}

TEST_CASE("TLS 1.2 is spoken with forward secrecy, and nothing older") {
  const Folder folder;
  make_certificate(folder, "edge");
  Edge edge(with_tls(folder));
  TlsClient client(edge.port, TLS1_2_VERSION);
  REQUIRE(client.connected());
  CHECK(client.version() == "TLSv1.2");
  CHECK(client.cipher().starts_with("ECDHE-"));
  CHECK_FALSE(TlsClient(edge.port, TLS1_1_VERSION).connected());
  CHECK_FALSE(TlsClient(edge.port, TLS1_VERSION).connected());
}

TEST_CASE("of the protocols a client offers, HTTP/1.1 is chosen") {
  const Folder folder;
  make_certificate(folder, "edge");
  Edge edge(with_tls(folder));
  CHECK(TlsClient(edge.port, TLS1_3_VERSION, "\x02h2\x08http/1.1").connected());
  CHECK_FALSE(TlsClient(edge.port, TLS1_3_VERSION, "\x02h2").connected());
}

TEST_CASE("who says nothing, or no TLS, holds no thread and is cut") {
  const Folder folder;
  make_certificate(folder, "edge");
  HttpOptions options = with_tls(folder);
  options.io_threads = options.max_io_threads = 1;
  options.head_timeout = 2s;
  Edge edge(std::move(options));
  std::vector<std::unique_ptr<RawClient>> silent;
  for (int i = 0; i < 20; ++i) {
    silent.push_back(std::make_unique<RawClient>(edge.port));
    // Half of them begin a handshake: a record that promises more than comes.
    if (i % 2 == 1) silent.back()->send(std::string_view("\x16\x03\x01\x02\x00\x01\x00", 7));
  }
  TlsClient client(edge.port);
  REQUIRE(client.connected());
  client.send(get("/served"));
  CHECK(json::parse(client.receive())["path"] == "/served");
  for (auto& one : silent) CHECK(one->receive().status == 0);
  RawClient plain(edge.port);
  plain.send(get("/plain"));
  CHECK(plain.receive().status == 0);
  CHECK(edge.server.stats().threads == 1);
}

TEST_CASE("a new certificate is for new connections, and a bad one changes nothing") {
  const Folder folder;
  make_certificate(folder, "before");
  const auto context = loaded(folder);
  HttpOptions options = Edge::patient();
  options.tls = context;
  Edge edge(std::move(options));
  TlsClient old(edge.port);
  make_certificate(folder, "after");
  REQUIRE(context->reload());
  CHECK(TlsClient(edge.port).server_name() == "after");
  CHECK(old.server_name() == "before");
  old.send(get("/x"));
  CHECK(json::parse(old.receive())["path"] == "/x");

  std::ofstream(folder.file("certificate.pem")) << "no certificate";
  CHECK_FALSE(context->reload());
  CHECK(TlsClient(edge.port).server_name() == "after");
}

TEST_CASE("files that are no certificate and key are errors that name them") {
  const Folder folder;
  make_certificate(folder, "edge");
  const std::string certificate = folder.file("certificate.pem");
  const std::string key = folder.file("key.pem");
  const auto missing = TlsContext::load({folder.file("none.pem"), key, {}});
  REQUIRE_FALSE(missing);
  CHECK(missing.error().detail.find("none.pem") != std::string::npos);
  CHECK_FALSE(TlsContext::load({certificate, certificate, {}}));
  CHECK_FALSE(TlsContext::load({key, key, {}}));
  const Folder other;
  make_certificate(other, "other");
  CHECK_FALSE(TlsContext::load({certificate, other.file("key.pem"), {}}));
}

TEST_CASE("a body in many small records is read whole, however late the server is") {
  constexpr auto kTimeout = 4s;  // no machine stands still for so long before the thread is taken
  const Folder folder;
  make_certificate(folder, "edge");
  HttpOptions options = with_tls(folder);
  options.io_threads = options.max_io_threads = 1;
  options.body_timeout = kTimeout;
  Edge edge(std::move(options));
  const std::string body(1000, 'x');
  TlsClient client(edge.port);
  REQUIRE(client.connected());
  client.send(post("/echo", with_length(body), body.substr(0, 1)));
  wait_until([&] { return edge.server.stats().body_bytes > 0; });
  {
    TlsClient busy(edge.port);
    REQUIRE(busy.connected());
    busy.send(get("/gone"));  // has the only thread until it leaves
    wait_until([&] { return edge.server.stats().running > 0; });
    for (std::size_t i = 1; i < body.size(); ++i) client.send(body.substr(i, 1));
    std::this_thread::sleep_for(kTimeout + 200ms);
  }
  CHECK(client.receive() == body);
}
