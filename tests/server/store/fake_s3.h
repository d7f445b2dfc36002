// An S3 server in memory whose misbehaviour is scripted: enough of PUT, GET, HEAD,
// DELETE and ListObjectsV2 for a store, on a port of its own. It checks no signatures.
// tests/s3 runs the store against a real server.
#pragma once

#include <arpa/inet.h>
#include <doctest/doctest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "server/base/sha256.h"
#include "server/config/config.h"
#include "server/store/mesh_store.h"
#include "server/store/open_store.h"

namespace geodesic::server::test {

class FakeS3 {
 public:
  struct Call {
    std::string method;
    std::string key;    // in the bucket; empty: the bucket itself
    std::string query;  // undecoded
    std::string body;
  };
  // What to do with a call: serve it; answer 403 and do nothing; do it and answer 403; answer 503
  // and do nothing; do it and send half of the answer.
  enum class Act : std::uint8_t { serve, refuse, serve_and_refuse, later, break_off };

  FakeS3() : listener_(::socket(AF_INET, SOCK_STREAM, 0)) {
    ::setenv("no_proxy", "*", 1);  // libcurl's, which might have one to go through
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    REQUIRE(::bind(listener_, reinterpret_cast<sockaddr*>(&address), size) == 0);
    REQUIRE(::listen(listener_, 64) == 0);
    REQUIRE(::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) == 0);
    port_ = ntohs(address.sin_port);
    acceptor_ = std::thread([this] { accept_until_stopped(); });
  }
  ~FakeS3() {
    stopping_ = true;
    acceptor_.join();
    join_those_done(true);
    ::close(listener_);
  }
  FakeS3(const FakeS3&) = delete;
  FakeS3& operator=(const FakeS3&) = delete;

  // A store of its own process, as it were, in the bucket.
  std::unique_ptr<MeshStore> open() const {
    auto store = try_open({});
    REQUIRE_MESSAGE(store, (store ? "" : store.error().detail));
    return std::move(*store);
  }
  Result<std::unique_ptr<MeshStore>> try_open(const StoreBudget& budget) const {
    return open_store(url(), budget, environment);
  }
  std::string url() const {
    return "s3://bucket?timeout=60&endpoint=http://127.0.0.1:" + std::to_string(port_);
  }
  static std::optional<std::string> environment(const std::string& name) {
    if (name.starts_with("AWS_") && name != "AWS_SESSION_TOKEN") return "key";
    return std::nullopt;
  }

  std::optional<std::string> object(const std::string& key) const {
    const std::lock_guard lock(mutex_);
    const auto found = objects_.find(key);
    return found == objects_.end() ? std::nullopt : std::optional(found->second);
  }
  std::vector<std::string> keys() const {
    const std::lock_guard lock(mutex_);
    std::vector<std::string> keys;
    for (const auto& [key, bytes] : objects_) keys.push_back(key);
    return keys;
  }
  void put(const std::string& key, std::string bytes) {
    const std::lock_guard lock(mutex_);
    objects_[key] = std::move(bytes);
  }
  void erase(const std::string& key) {
    const std::lock_guard lock(mutex_);
    objects_.erase(key);
  }

  // Both are called on a thread of the server's, without a lock.
  struct Script {
    std::function<Act(const Call&)> before = nullptr;  // what to do
    std::function<void(const Call&)> after = nullptr;  // it is done, and not yet answered
  };
  // While nobody calls.
  void follow(Script script) {
    settle();
    script_ = std::move(script);
    settle();
  }
  // What one thread has written before it calls this, another sees that calls it later.
  // Every call does so at its beginning and at its end.
  void settle() { const std::lock_guard lock(settling_); }

  std::atomic<bool> tells_length_of_head{true};
  std::atomic<bool> tells_length_of_get{true};  // else the end of the connection is the end
  std::atomic<bool> tells_tags{true};

 private:
  void accept_until_stopped() {
    while (!stopping_) {
      pollfd waiting{listener_, POLLIN, 0};
      if (::poll(&waiting, 1, 20) <= 0) continue;
      const int socket = ::accept(listener_, nullptr, nullptr);
      if (socket < 0) continue;
      join_those_done(false);
      auto is_done = std::make_shared<std::atomic<bool>>(false);
      std::thread thread([this, socket, is_done] {
        if (const auto call = receive(socket)) send(socket, answer(*call));
        ::shutdown(socket, SHUT_WR);
        ::close(socket);
        *is_done = true;
      });
      answering_.emplace_back(std::move(thread), std::move(is_done));
    }
  }

  void join_those_done(bool all) {
    std::erase_if(answering_, [all](auto& each) {
      if (!all && !*each.second) return false;
      each.first.join();
      return true;
    });
  }

  // One request; every connection ends after it.
  static std::optional<Call> receive(int socket) {
    std::string bytes;
    const auto more = [&] {
      char part[16384];
      const ssize_t n = ::recv(socket, part, sizeof part, 0);
      if (n > 0) bytes.append(part, static_cast<std::size_t>(n));
      return n > 0;
    };
    std::size_t head;
    while ((head = bytes.find("\r\n\r\n")) == std::string::npos) {
      if (!more()) return std::nullopt;
    }
    const std::string_view fields = std::string_view(bytes).substr(0, head);
    std::size_t length = 0;
    if (const auto at = fields.find("Content-Length: "); at != std::string_view::npos) {
      length = std::stoull(std::string(fields.substr(at + 16, 20)));
    }
    if (fields.find("100-continue") != std::string_view::npos) {
      send(socket, "HTTP/1.1 100 Continue\r\n\r\n");
    }
    const std::string line(fields.substr(0, fields.find("\r\n")));
    while (bytes.size() < head + 4 + length) {
      if (!more()) return std::nullopt;
    }
    Call call;
    call.method = line.substr(0, line.find(' '));
    std::string target = line.substr(call.method.size() + 1);
    target.resize(target.find(' '));
    const std::size_t mark = target.find('?');
    if (mark != std::string::npos) call.query = target.substr(mark + 1);
    target.resize(std::min(mark, target.size()));
    constexpr std::string_view bucket = "/bucket/";
    if (target.starts_with(bucket)) call.key = target.substr(bucket.size());
    call.body = bytes.substr(head + 4);
    return call;
  }

  std::string answer(const Call& call) {
    settle();
    const Act act = script_.before ? script_.before(call) : Act::serve;
    const bool is_done = act != Act::refuse && act != Act::later;
    std::string reply = is_done ? serve(call) : std::string();
    if (is_done && script_.after) script_.after(call);
    settle();
    switch (act) {
      case Act::serve:
        break;
      case Act::break_off:
        reply.erase(reply.size() - reply.size() / 4);  // GCC 14 warns of resize() here
        break;
      case Act::later:
        return bare("503 Slow Down");
      case Act::refuse:
      case Act::serve_and_refuse:
        return bare("403 Forbidden");
    }
    return reply;
  }

  static std::string bare(const std::string& status) {
    return "HTTP/1.1 " + status + "\r\nContent-Length: 0\r\nConnection: close\r\n\r\n";
  }

  std::string serve(const Call& call) {
    const std::lock_guard lock(mutex_);
    if (call.key.empty()) return reply_of(200, list(call.query), true, {});
    const auto found = objects_.find(call.key);
    if (call.method == "PUT") {
      objects_[call.key] = call.body;
      return reply_of(200, {}, true, tag_of(call.body));
    }
    if (call.method == "DELETE") {
      objects_.erase(call.key);
      return reply_of(204, {}, true, {});
    }
    if (found == objects_.end()) return reply_of(404, {}, true, {});
    const std::string& bytes = found->second;
    if (call.method == "HEAD") {
      std::string reply = "HTTP/1.1 200 OK\r\nConnection: close\r\n";
      if (tells_length_of_head) reply += "Content-Length: " + std::to_string(bytes.size()) + "\r\n";
      if (tells_tags) reply += "ETag: \"" + tag_of(bytes) + "\"\r\n";
      return reply + "\r\n";
    }
    return reply_of(200, bytes, tells_length_of_get, tag_of(bytes));
  }

  std::string reply_of(int status, const std::string& body, bool has_length,
                       const std::string& tag) const {
    std::string reply = "HTTP/1.1 " + std::to_string(status) + " Said\r\nConnection: close\r\n";
    if (has_length) reply += "Content-Length: " + std::to_string(body.size()) + "\r\n";
    if (tells_tags && !tag.empty()) reply += "ETag: \"" + tag + "\"\r\n";
    return reply + "\r\n" + body;
  }

  static std::string parameter(const std::string& query, const std::string& name) {
    const auto at = ("&" + query).find("&" + name + "=");
    if (at == std::string::npos) return {};
    const auto begin = at + name.size() + 1;
    std::string value = query.substr(begin, query.find('&', begin) - begin);
    for (std::size_t i; (i = value.find("%2F")) != std::string::npos;) value.replace(i, 3, "/");
    for (std::size_t i; (i = value.find("%7E")) != std::string::npos;) value.replace(i, 3, "~");
    return value;
  }

  // In one page, however many keys there are, unless fewer are asked for.
  std::string list(const std::string& query) const {
    const std::string prefix = parameter(query, "prefix");
    const std::string after =
        std::max(parameter(query, "start-after"), parameter(query, "continuation-token"));
    const std::string most = parameter(query, "max-keys");
    std::size_t room = most.empty() ? 1000 : std::stoull(most);
    std::string last;
    bool is_cut = false;
    std::string xml = "<ListBucketResult>";
    for (const auto& [key, bytes] : objects_) {
      if (!key.starts_with(prefix) || key <= after) continue;
      if (room == 0) {
        is_cut = true;
        break;
      }
      --room;
      last = key;
      xml += "<Contents><Key>" + key + "</Key><Size>" + std::to_string(bytes.size()) + "</Size>";
      xml += "<LastModified>2026-01-31T12:34:56.789Z</LastModified>";
      if (tells_tags) xml += "<ETag>&quot;" + tag_of(bytes) + "&quot;</ETag>";
      xml += "</Contents>";
    }
    xml += is_cut ? "<IsTruncated>true</IsTruncated><NextContinuationToken>" + last +
                        "</NextContinuationToken>"
                  : "<IsTruncated>false</IsTruncated>";
    return xml + "</ListBucketResult>";
  }

  static std::string tag_of(const std::string& bytes) { return sha256_hex(bytes).substr(0, 32); }

  static void send(int socket, std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t n = ::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
      if (n <= 0) return;
      bytes.remove_prefix(static_cast<std::size_t>(n));
    }
  }

  int listener_;
  int port_ = 0;
  std::atomic<bool> stopping_{false};
  Script script_;
  std::mutex settling_;
  mutable std::mutex mutex_;
  std::map<std::string, std::string> objects_;
  std::thread acceptor_;
  // The acceptor's, until it has ended; with whether each is done.
  std::vector<std::pair<std::thread, std::shared_ptr<std::atomic<bool>>>> answering_;
};

}  // namespace geodesic::server::test
