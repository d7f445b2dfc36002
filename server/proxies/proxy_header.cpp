#include "server/proxies/proxy_header.h"

#include <arpa/inet.h>

#include <algorithm>

namespace geodesic::server {

namespace {

constexpr std::string_view kSignature("\r\n\r\n\0\r\nQUIT\n", 12);
constexpr std::string_view kTextSignature = "PROXY ";  // of version 1

// Byte 12 is the version and the command, byte 13 the family and the protocol.
constexpr std::size_t kCommandAt = 12;
constexpr std::size_t kFamilyAt = 13;
constexpr std::size_t kLengthAt = 14;
constexpr unsigned kLocal = 0x20;
constexpr unsigned kProxy = 0x21;

// Families that come in connections; the others are datagrams', or nobody's yet.
constexpr unsigned kUnspecified = 0x00;
constexpr unsigned kIpv4 = 0x11;
constexpr unsigned kIpv6 = 0x21;
constexpr unsigned kUnixSocket = 0x31;

// The bytes of a family's two addresses.
constexpr std::size_t bytes_of_family(unsigned family) {
  switch (family) {
    case kIpv4:
      return 12;
    case kIpv6:
      return 36;
    case kUnixSocket:
      return 216;
    default:
      return 0;
  }
}

}  // namespace

auto ProxyHeader::refuse(std::string_view fault) -> State {
  fault_ = fault;
  return State::refused;
}

// Of the bytes that are there: whoever sends something else may never send as many.
auto ProxyHeader::judge_signature() -> State {
  const std::string_view begin(kept_.data(), std::min(taken_, kSignature.size()));
  if (kSignature.starts_with(begin)) return State::complete;
  if (begin.starts_with(kTextSignature)) {
    return refuse("its PROXY header is of version 1: let the proxy send version 2 (send-proxy-v2)");
  }
  if (kTextSignature.starts_with(begin)) return State::more;
  return refuse("it does not begin with a PROXY header (send-proxy-v2)");
}

auto ProxyHeader::judge_fixed() -> State {
  const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(kept_[at]); };
  const unsigned command = byte(kCommandAt);
  if (command != kLocal && command != kProxy) {
    return refuse("its PROXY header has an unknown version or command");
  }
  const std::size_t length = byte(kLengthAt) * std::size_t{256} + byte(kLengthAt + 1);
  size_ = kFixedBytes + length;
  if (command == kLocal) return State::complete;
  const unsigned family = byte(kFamilyAt);
  if (family != kUnspecified && bytes_of_family(family) == 0) {
    return refuse("its PROXY header is about no stream of IPv4, IPv6 or a local socket");
  }
  if (length < bytes_of_family(family)) {
    return refuse("its PROXY header is too short for its addresses");
  }
  return State::complete;
}

void ProxyHeader::read_source() {
  if (static_cast<unsigned char>(kept_[kCommandAt]) != kProxy) return;
  const unsigned family = static_cast<unsigned char>(kept_[kFamilyAt]);
  if (family != kIpv4 && family != kIpv6) return;
  std::array<char, INET6_ADDRSTRLEN> text{};
  source_ = ::inet_ntop(family == kIpv4 ? AF_INET : AF_INET6, kept_.data() + kFixedBytes,
                        text.data(), text.size());
}

auto ProxyHeader::take(std::string_view bytes) -> State {
  bytes = bytes.substr(0, missing());
  if (taken_ < kept_.size()) bytes.copy(kept_.data() + taken_, kept_.size() - taken_);
  const bool had_fixed = taken_ >= kFixedBytes;
  taken_ += bytes.size();
  if (!had_fixed) {
    if (const State state = judge_signature(); state != State::complete) return state;
    if (taken_ < kFixedBytes) return State::more;
    if (const State state = judge_fixed(); state != State::complete) return state;
  }
  if (missing() > 0) return State::more;
  read_source();
  return State::complete;
}

}  // namespace geodesic::server
