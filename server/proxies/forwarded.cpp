#include "server/proxies/forwarded.h"

#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstddef>
#include <deque>
#include <optional>
#include <string_view>
#include <utility>

namespace geodesic::server {

namespace {

// No chain of proxies is longer. Whoever writes more addresses has no more of them looked at.
constexpr std::size_t kMostProxies = 64;

// What the proxies say of who asked them, the last of them last.
using Hops = std::deque<std::string>;

void add_hop(Hops& hops, std::string_view text) {
  hops.emplace_back(text);
  if (hops.size() > kMostProxies) hops.pop_front();
}

bool is_address_of(int family, const std::string& text) {
  std::array<unsigned char, sizeof(in6_addr)> bytes{};
  return ::inet_pton(family, text.c_str(), bytes.data()) == 1;
}

// --- X-Forwarded-For, which no standard describes

Hops hops_of_list(std::string_view list) {
  Hops hops;
  for (bool more = true; more;) {
    const std::size_t comma = list.find(',');
    add_hop(hops, trimmed(list.substr(0, comma)));
    more = comma != std::string_view::npos;
    if (more) list.remove_prefix(comma + 1);
  }
  return hops;
}

// A numeric address without what some proxies add: brackets and a port. Empty if it is none.
std::string address_of_item(std::string_view text) {
  if (text.starts_with('[')) {
    const std::size_t end = text.find(']');
    text = end == std::string_view::npos ? std::string_view() : text.substr(1, end - 1);
  } else if (std::count(text.begin(), text.end(), ':') == 1) {
    text = text.substr(0, text.find(':'));
  }
  std::string address(text);
  const bool is_address = is_address_of(AF_INET, address) || is_address_of(AF_INET6, address);
  return is_address ? address : std::string();
}

// --- Forwarded, RFC 7239

// A token, or what a quoted string holds (RFC 9110, 5.6.4); nothing for other text.
std::optional<std::string> value_of_pair(std::string_view text) {
  if (!text.starts_with('"')) {
    return is_token(text) ? std::optional<std::string>(text) : std::nullopt;
  }
  std::string value;
  for (std::size_t i = 1; i < text.size(); ++i) {
    if (text[i] == '"') {
      return i + 1 == text.size() ? std::optional<std::string>(std::move(value)) : std::nullopt;
    }
    if (text[i] == '\\' && ++i == text.size()) return std::nullopt;
    if (is_control(text[i]) && text[i] != '\t') return std::nullopt;
    value += text[i];
  }
  return std::nullopt;
}

// The nodes of `for=`, empty where an element has none. Nothing if any part of the line is not as
// section 4 has it: by a quote that does not end, a client could swallow what a proxy adds.
std::optional<Hops> hops_of_elements(std::string_view line) {
  Hops hops;
  while (!line.empty()) {
    std::string_view element = trimmed(take_until(',', line));
    if (element.empty()) continue;  // RFC 9110, 5.6.1
    std::optional<std::string> node;
    while (!element.empty()) {
      const std::string_view pair = trimmed(take_until(';', element));
      if (pair.empty()) continue;
      const std::size_t equals = pair.find('=');
      const std::string_view name = pair.substr(0, equals);
      if (equals == std::string_view::npos || !is_token(name)) return std::nullopt;
      auto value = value_of_pair(pair.substr(equals + 1));
      if (!value) return std::nullopt;
      if (!equals_ignoring_case(name, "for")) continue;
      if (node) return std::nullopt;  // said twice
      node = std::move(value);
    }
    add_hop(hops, node.value_or(std::string()));
  }
  return hops;
}

// Digits, or a name that hides them (section 6.3).
bool is_node_port(std::string_view port) {
  constexpr std::size_t kMostDigits = 5;
  const auto is_digit = [](unsigned char c) { return std::isdigit(c) != 0; };
  const auto may_hide = [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '.' || c == '_' || c == '-';
  };
  if (port.starts_with('_')) {
    return port.size() > 1 && std::all_of(port.begin() + 1, port.end(), may_hide);
  }
  return !port.empty() && port.size() <= kMostDigits &&
         std::all_of(port.begin(), port.end(), is_digit);
}

// The numeric address of a node (section 6). Empty if it is `unknown`, hidden (`_name`) or
// anything else.
std::string address_of_node(std::string_view node) {
  std::string_view rest;
  std::string address;
  const bool in_brackets = node.starts_with('[');
  if (in_brackets) {
    const std::size_t end = node.find(']');
    if (end == std::string_view::npos) return {};
    address = node.substr(1, end - 1);
    rest = node.substr(end + 1);
  } else {
    const std::size_t end = std::min(node.find(':'), node.size());
    address = node.substr(0, end);
    rest = node.substr(end);
  }
  if (!is_address_of(in_brackets ? AF_INET6 : AF_INET, address)) return {};
  if (!rest.empty() && (rest.front() != ':' || !is_node_port(rest.substr(1)))) return {};
  return address;
}

}  // namespace

std::string forwarded_for(const AddressRanges& trusted, ForwardedHeader written,
                          const HttpHead& head, const std::string& peer) {
  if (!trusted.contains(peer)) return peer;
  const bool is_standard = written == ForwardedHeader::forwarded;
  const std::string_view name = is_standard ? "Forwarded" : "X-Forwarded-For";
  std::string client = peer;
  std::size_t looked_at = 0;
  for (auto header = head.headers.rbegin(); header != head.headers.rend(); ++header) {
    if (!equals_ignoring_case(header->first, name)) continue;
    const auto hops = is_standard ? hops_of_elements(header->second) : hops_of_list(header->second);
    if (!hops) return client;
    for (auto hop = hops->rbegin(); hop != hops->rend(); ++hop) {
      std::string address = is_standard ? address_of_node(*hop) : address_of_item(*hop);
      if (address.empty() || ++looked_at > kMostProxies) return client;
      client = std::move(address);
      if (!trusted.contains(client)) return client;
    }
  }
  return client;
}

}  // namespace geodesic::server
