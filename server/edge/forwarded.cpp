#include "server/edge/forwarded.h"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>

#include "server/http/message.h"

namespace geodesic::server {

namespace {

// A numeric address without what some proxies add: brackets and a port. Empty if it is none.
std::string bare_address(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return {};
  text = text.substr(begin, text.find_last_not_of(" \t") - begin + 1);
  if (text.front() == '[') {
    const std::size_t end = text.find(']');
    text = end == std::string_view::npos ? std::string_view() : text.substr(1, end - 1);
  } else if (std::count(text.begin(), text.end(), ':') == 1) {
    text = text.substr(0, text.find(':'));
  }
  std::string address(text);
  std::array<unsigned char, sizeof(in6_addr)> bytes{};
  const bool is_address = ::inet_pton(AF_INET, address.c_str(), bytes.data()) == 1 ||
                          ::inet_pton(AF_INET6, address.c_str(), bytes.data()) == 1;
  return is_address ? address : std::string();
}

}  // namespace

std::string forwarded_for(const AddressRanges& trusted, const HttpHead& head,
                          const std::string& peer) {
  if (!trusted.contains(peer)) return peer;
  std::string client = peer;
  for (auto header = head.headers.rbegin(); header != head.headers.rend(); ++header) {
    if (!equals_ignoring_case(header->first, "X-Forwarded-For")) continue;
    for (std::string_view list = header->second;;) {
      const std::size_t comma = list.rfind(',');
      std::string address =
          bare_address(comma == std::string_view::npos ? list : list.substr(comma + 1));
      if (address.empty()) return client;
      client = std::move(address);
      if (!trusted.contains(client)) return client;
      if (comma == std::string_view::npos) break;
      list = list.substr(0, comma);
    }
  }
  return client;
}

}  // namespace geodesic::server
