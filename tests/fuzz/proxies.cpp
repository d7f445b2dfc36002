// What proxies say of their clients: PROXY headers, and Forwarded.
#include <arpa/inet.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/proxies/forwarded.h"
#include "server/proxies/proxy_header.h"
#include "tests/fuzz/targets.h"

namespace geodesic::fuzz {
namespace {

using namespace std::string_literals;
using server::ForwardedHeader;
using server::ProxyHeader;

constexpr std::string_view kMagic("\r\n\r\n\0\r\nQUIT\n", 12);

struct Announced {
  ProxyHeader::State state = ProxyHeader::State::more;
  std::string source;
  std::size_t used = 0;
};

Announced announced_in(std::string_view bytes, std::size_t piece) {
  ProxyHeader header;
  Announced result;
  while (result.state == ProxyHeader::State::more && result.used < bytes.size()) {
    expect(header.missing() > 0, "a header that is not complete misses something");
    const auto part = bytes.substr(result.used, std::min(piece, header.missing()));
    result.used += part.size();
    result.state = header.take(part);
  }
  expect(result.state != ProxyHeader::State::refused || !header.fault().empty(),
         "a refusal says why");
  result.source = header.source();
  return result;
}

// All at once, as section 2.2 has it: the number of its bytes, and whom it names. Nothing for what
// is no header, or not all of one.
std::optional<std::pair<std::size_t, std::string>> read_plainly(std::string_view bytes) {
  if (bytes.size() < 16 || bytes.substr(0, 12) != kMagic) return std::nullopt;
  const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(bytes[at]); };
  const std::size_t end = 16 + 256U * byte(14) + byte(15);
  if (bytes.size() < end || byte(12) >> 4U != 2 || (byte(12) & 15U) > 1) return std::nullopt;
  const std::string_view rest = bytes.substr(16, end - 16);
  const bool is_local = (byte(12) & 15U) == 0;
  if (is_local || byte(13) == 0) return std::pair{end, ""s};
  const unsigned family = byte(13) >> 4U;
  if ((byte(13) & 15U) != 1 || family < 1 || family > 3) return std::nullopt;
  constexpr std::array<std::size_t, 4> kSizes{0, 12, 36, 216};
  if (rest.size() < kSizes[family]) return std::nullopt;
  if (family == 3) return std::pair{end, ""s};
  std::array<char, INET6_ADDRSTRLEN> text{};
  ::inet_ntop(family == 1 ? AF_INET : AF_INET6, rest.data(), text.data(), text.size());
  return std::pair{end, std::string(text.data())};
}

}  // namespace

void fuzz_proxy_header(Input input) {
  if (input.empty()) return;
  const std::string_view bytes(reinterpret_cast<const char*>(input.data()) + 1, input.size() - 1);
  const Announced whole = announced_in(bytes, std::max<std::size_t>(bytes.size(), 1));
  const Announced cut = announced_in(bytes, 1 + input.front() % 32U);
  expect(whole.state == cut.state && whole.source == cut.source,
         "it does not matter how a header is cut");
  const auto plain = read_plainly(bytes);
  expect(plain.has_value() == (whole.state == ProxyHeader::State::complete),
         "a header is what the plainest reader takes for one");
  if (!plain) return;
  expect(whole.used == plain->first && cut.used == plain->first, "and ends where it does there");
  expect(whole.source == plain->second, "and names who is named there");
}

void fuzz_forwarded(Input input) {
  const std::string line(reinterpret_cast<const char*>(input.data()), input.size());
  static const auto trusted = *server::AddressRanges::parse("10.0.0.0/8,fd00::/8");
  for (const auto written : {ForwardedHeader::forwarded, ForwardedHeader::x_forwarded_for}) {
    const bool is_standard = written == ForwardedHeader::forwarded;
    server::HttpHead head;
    head.headers.emplace_back(is_standard ? "Forwarded" : "X-Forwarded-For", line);
    const auto client = [&](const std::string& peer) {
      return server::forwarded_for(trusted, written, head, peer);
    };
    expect(client("203.0.113.5") == "203.0.113.5", "only trusted proxies are believed");
    std::array<unsigned char, sizeof(in6_addr)> bytes{};
    const std::string found = client("10.0.0.1");
    expect(::inet_pton(AF_INET, found.c_str(), bytes.data()) == 1 ||
               ::inet_pton(AF_INET6, found.c_str(), bytes.data()) == 1,
           "a client is an address");
    const std::string added = is_standard ? "for=\"[2001:db8::7]:80\"" : "2001:db8::7";
    head.headers.emplace_back(head.headers.front().first, added);
    expect(client("10.0.0.1") == "2001:db8::7", "whom a trusted proxy adds is believed");
    head.headers.pop_back();
    head.headers.back().second += "," + added;
    const std::string behind = client("10.0.0.1");
    expect(behind == "2001:db8::7" || (is_standard && behind == "10.0.0.1"),
           "or, behind a quote that does not end, the proxy itself");
  }
}

std::vector<std::string> proxy_header_seeds() {
  const std::string v4 = "\x21\x11\0\x0c\xc6\x33\x64\x07\xc0\x00\x02\x01\xd4\x31\x01\xbb"s;
  const std::string v6 = "\x21\x21\0\x2b"s + std::string(36, '\x20') + "\x03\0\x04\0\0\0\0"s;
  return {"\x1f" + std::string(kMagic) + v4 + "GET / HTTP/1.1\r\n",
          "\0"s + std::string(kMagic) + v6 + "\x16\x03\x01",
          "\x02" + std::string(kMagic) + "\x20\0\0\0"s + "GET",
          "\x03" + std::string(kMagic) + "\x21\x31\0\xd8"s + std::string(216, '/'),
          "\x04PROXY TCP4 198.51.100.7 192.0.2.1 54321 443\r\n"};
}

std::vector<std::string> forwarded_seeds() {
  return {"for=192.0.2.60;proto=http;by=203.0.113.43",
          "for=192.0.2.43, for=198.51.100.17",
          "For=\"[2001:db8:cafe::17]:4711\"",
          "for=_hidden, for=\"_SEVKISEK:_p\", for=unknown",
          "198.51.100.1:80, [fd00::1]:9, 10.0.0.3",
          "for=\"10.0.0.2\\\"\";host=\"a,b;c\" ,, ;for=10.0.0.2"};
}

}  // namespace geodesic::fuzz
