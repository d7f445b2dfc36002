// What a proxy that passes connections on sends before everything else: whose connection it is.
// Version 2 of the PROXY protocol (HAProxy's doc/proxy-protocol.txt, section 2.2), as
// `send-proxy-v2` writes it. No library of Debian reads it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace geodesic::server {

// Takes a header in pieces, however it is cut, and keeps no more of it than two addresses: a header
// has at most 65,551 bytes. What stands behind the addresses (TLVs, the checksum among them) is
// skipped, and not looked at.
class ProxyHeader {
 public:
  enum class State : std::uint8_t { more, complete, refused };

  // So many bytes may be taken at most: those behind them need not be the header's. At least one
  // while there is more.
  [[nodiscard]] std::size_t missing() const { return size_ - taken_; }
  // To be called until it is complete or refused.
  [[nodiscard]] State take(std::string_view bytes);
  [[nodiscard]] bool has_begun() const { return taken_ != 0; }

  // Once complete, the client's numeric address. Empty where the proxy speaks for itself (LOCAL: a
  // probe) or names no address (UNSPEC, or a local socket): then the connection's own holds.
  [[nodiscard]] const std::string& source() const { return source_; }
  // Once refused: why, as the end of a sentence for the operator.
  [[nodiscard]] std::string_view fault() const { return fault_; }

 private:
  static constexpr std::size_t kFixedBytes = 16;        // signature, command, family, length
  static constexpr std::size_t kMostAddressBytes = 36;  // two of IPv6, and two ports

  State refuse(std::string_view fault);
  State judge_signature();
  State judge_fixed();
  void read_source();

  std::array<char, kFixedBytes + kMostAddressBytes> kept_{};
  std::size_t taken_ = 0;
  std::size_t size_ = kFixedBytes;  // of the header, once it has said more
  std::string source_;
  std::string_view fault_;
};

}  // namespace geodesic::server
