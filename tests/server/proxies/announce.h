// PROXY headers of version 2 for tests, written as section 2.2 of its specification has them.
#pragma once

#include <arpa/inet.h>

#include <array>
#include <stdexcept>
#include <string>
#include <string_view>

namespace geodesic::server::test {

// Of a command, a family and what stands behind the length.
inline std::string header_of(unsigned command, unsigned family, const std::string& rest) {
  std::string header("\r\n\r\n\0\r\nQUIT\n", 12);
  header += static_cast<char>(command);
  header += static_cast<char>(family);
  header += static_cast<char>(rest.size() >> 8U);
  header += static_cast<char>(rest.size() & 0xffU);
  return header + rest;
}

// Of a client's connection to an address, both of one family.
inline std::string announce(const std::string& from, const std::string& to = "192.0.2.1") {
  const bool is_v6 = from.find(':') != std::string::npos;
  std::string rest;
  for (const std::string& address : {from, to}) {
    std::array<char, 16> bytes{};
    if (::inet_pton(is_v6 ? AF_INET6 : AF_INET, address.c_str(), bytes.data()) != 1) {
      throw std::runtime_error("no address: " + address);
    }
    rest.append(bytes.data(), is_v6 ? 16 : 4);
  }
  rest += std::string("\xd4\x31\x01\xbb", 4);
  return header_of(0x21, is_v6 ? 0x21 : 0x11, rest);
}

}  // namespace geodesic::server::test
