// Headers that a client has forged at random: the client is whom a second reader of them finds, by
// regular expressions of the grammar, and never one whom a trusted proxy did not name.
#include <arpa/inet.h>
#include <doctest/doctest.h>

#include <array>
#include <optional>
#include <random>
#include <regex>
#include <string>
#include <vector>

#include "server/proxies/forwarded.h"
#include "tests/fixtures/test_seed.h"

using namespace geodesic;
using namespace geodesic::server;

namespace {

const std::string kPeer = "10.0.0.1";
constexpr int kDraws = 4000;

const AddressRanges& trusted() {
  static const AddressRanges ranges = *AddressRanges::parse("10.0.0.0/8,fd00::/8");
  return ranges;
}

std::string found(ForwardedHeader written, const std::vector<std::string>& lines) {
  HttpHead head;
  for (const std::string& line : lines) {
    head.headers.emplace_back(
        written == ForwardedHeader::forwarded ? "Forwarded" : "X-Forwarded-For", line);
  }
  return forwarded_for(trusted(), written, head, kPeer);
}

// --- the second reader: an address or nothing for each proxy of the chain

using Chain = std::vector<std::optional<std::string>>;

bool is_ip(int family, const std::string& text) {
  std::array<unsigned char, 16> bytes{};
  return ::inet_pton(family, text.c_str(), bytes.data()) == 1;
}

const std::string kToken = "[!#$%&'*+.^_`|~0-9A-Za-z-]+";
const std::string kQuoted =
    R"re("(?:[^"\\\x01-\x08\x0a-\x1f\x7f]|\\[^\x01-\x08\x0a-\x1f\x7f])*")re";
const std::string kValue = "(?:" + kToken + "|" + kQuoted + ")";

std::optional<std::string> address_of_node(const std::string& node) {
  static const std::regex kNode(
      R"re((?:([0-9.]+)|\[([0-9A-Fa-f:.]+)\])(?::(?:[0-9]{1,5}|_[A-Za-z0-9._-]+))?)re");
  std::smatch part;
  if (!std::regex_match(node, part, kNode)) return std::nullopt;
  const std::string address = part[1].matched ? part[1] : part[2];
  if (!is_ip(part[1].matched ? AF_INET : AF_INET6, address)) return std::nullopt;
  return address;
}

Chain chain_of_elements(const std::string& line) {
  const std::string pair = kToken + "=" + kValue;
  const std::string element = "(?:" + pair + ")?(?:[ \t]*;[ \t]*(?:" + pair + ")?)*";
  static const std::regex kLine("[ \t]*" + element + "(?:[ \t]*,[ \t]*" + element + ")*[ \t]*");
  if (!std::regex_match(line, kLine)) return {std::nullopt};
  Chain chain;
  static const std::regex kPart("(" + kToken + ")=(" + kValue + ")|[,;]");
  static const std::regex kFor("for", std::regex::icase);
  static const std::regex kEscape(R"re(\\([^]))re");
  bool says_something = false;
  std::optional<std::string> node;
  const auto end_element = [&] {
    if (says_something) chain.push_back(node ? address_of_node(*node) : std::nullopt);
    says_something = false;
    node.reset();
  };
  for (std::sregex_iterator part(line.begin(), line.end(), kPart), end; part != end; ++part) {
    if (part->str() == ",") {
      end_element();
      continue;
    }
    says_something = true;
    if (!std::regex_match((*part)[1].str(), kFor)) continue;
    if (node) return {std::nullopt};
    node = (*part)[2].str();
    if (node->front() == '"') {
      node = std::regex_replace(node->substr(1, node->size() - 2), kEscape, "$1");
    }
  }
  end_element();
  return chain;
}

Chain chain_of_list(const std::string& line) {
  Chain chain;
  static const std::regex kItem("[ \t]*([^,]*?)[ \t]*(?:,|$)");
  static const std::regex kBrackets(R"re(\[([^\]]*)\].*)re");
  static const std::regex kWithPort("([^:]*):[^:]*");
  for (std::size_t at = 0; at <= line.size();) {
    std::smatch item;
    const std::string rest = line.substr(at);
    REQUIRE(std::regex_search(rest, item, kItem, std::regex_constants::match_continuous));
    std::string address = item[1];
    std::smatch inner;
    if (std::regex_match(address, inner, kBrackets) ||
        (address.rfind('[', 0) != 0 && std::regex_match(address, inner, kWithPort))) {
      address = inner[1].str();
    }
    const bool is_address = is_ip(AF_INET, address) || is_ip(AF_INET6, address);
    chain.push_back(is_address ? std::optional(address) : std::nullopt);
    at += item.length() == 0 ? 1 : static_cast<std::size_t>(item.length());
    if (item.str().empty() || item.str().back() != ',') break;
  }
  return chain;
}

std::string expected(ForwardedHeader written, const std::vector<std::string>& lines) {
  Chain chain;
  for (const std::string& line : lines) {
    const Chain part =
        written == ForwardedHeader::forwarded ? chain_of_elements(line) : chain_of_list(line);
    chain.insert(chain.end(), part.begin(), part.end());
  }
  std::string client = kPeer;
  while (!chain.empty() && chain.back() && trusted().contains(client)) {
    client = *chain.back();
    chain.pop_back();
  }
  return client;
}

// --- what a client may write

class Forger {
 public:
  explicit Forger(std::uint32_t seed) : random_(seed) {}

  std::string line() {
    static const std::vector<std::string> kPieces{"for=",
                                                  "For=",
                                                  "by=",
                                                  "host=",
                                                  "proto=https",
                                                  "x=",
                                                  ";",
                                                  ";",
                                                  ",",
                                                  ",",
                                                  ", ",
                                                  " ",
                                                  "\t",
                                                  "\"",
                                                  "\"",
                                                  "\\",
                                                  "\\\"",
                                                  "=",
                                                  "_hidden",
                                                  "unknown",
                                                  ":80",
                                                  ":_p",
                                                  "[",
                                                  "]",
                                                  "6.6.6.6",
                                                  "10.0.0.2",
                                                  "10.9.9.9",
                                                  "for=10.0.0.3",
                                                  "for=6.6.6.6",
                                                  "for=\"[fd00::2]:1\"",
                                                  "for=\"6.6.6.6:7\"",
                                                  "[fd00::3]",
                                                  "2001:db8::6",
                                                  "[2001:db8::6]:9",
                                                  "fd00::4",
                                                  "\x80",
                                                  "a"};
    std::string line;
    for (std::size_t count = below(9); count > 0; --count) line += kPieces[below(kPieces.size())];
    return line;
  }
  std::vector<std::string> lines() {
    std::vector<std::string> all(1 + below(3));
    for (std::string& one : all) one = line();
    return all;
  }
  std::size_t below(std::size_t count) {
    return std::uniform_int_distribution<std::size_t>(0, count - 1)(random_);
  }

 private:
  std::mt19937 random_;
};

}  // namespace

TEST_CASE("of random headers, both readers find the same client") {
  Forger forger(fixtures::test_seed());
  int others = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    for (const auto written : {ForwardedHeader::forwarded, ForwardedHeader::x_forwarded_for}) {
      const std::vector<std::string> lines = forger.lines();
      const std::string client = found(written, lines);
      std::string shown;
      for (const std::string& line : lines) shown += "<" + line + ">";
      CAPTURE(shown);
      CHECK(client == expected(written, lines));
      others += static_cast<int>(client != kPeer);
    }
  }
  CHECK(others > kDraws / 20);  // that they are not all nonsense
}

TEST_CASE("whatever a client writes, it is whom the trusted proxies saw, or the proxy itself") {
  Forger forger(fixtures::test_seed() + 1);
  static const std::array<std::string, 4> kSeen{
      "for=198.51.100.7", "for=\"198.51.100.7:4711\";proto=https",
      "proto=https;for=\"198.51.100.7\"", "by=_us;for=\"198.51.100.7:_p\";host=\"example.org\""};
  int hidden = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    std::vector<std::string> lines = forger.lines();
    const std::string seen = kSeen[forger.below(kSeen.size())];
    const std::vector<std::string> forged = lines;
    CAPTURE(forged.back());
    CAPTURE(seen);
    lines.push_back(seen);  // a line of its own, as HAProxy adds it
    CHECK(found(ForwardedHeader::forwarded, lines) == "198.51.100.7");
    lines.push_back("for=10.0.0.9");  // and a second proxy
    CHECK(found(ForwardedHeader::forwarded, lines) == "198.51.100.7");
    lines = forged;
    lines.back() += ", " + seen;  // in the same line, whatever was there
    const std::string client = found(ForwardedHeader::forwarded, lines);
    hidden += static_cast<int>(client == kPeer);
    CHECK((client == "198.51.100.7" || client == kPeer));
    lines = forged;
    lines.back() += ", 198.51.100.7";
    CHECK(found(ForwardedHeader::x_forwarded_for, lines) == "198.51.100.7");
  }
  CHECK(hidden > 0);
  CHECK(hidden < kDraws);
}
