// Bearer tokens: who may do what, read from a file of hashes. A line is one token:
//
//   NAME SCOPES SHA256 [expires=WHEN]        # a comment
//
//   NAME     1 to 64 letters, digits and . _ - : for the log, and its turn in queues
//   SCOPES   read, upload and admin, separated by commas
//   SHA256   of the whole token, in lower-case hexadecimal
//   WHEN     2026-12-31T23:59:59Z (RFC 3339), or 2026-12-31: when that day begins in
//            UTC; from then on the token is refused
//
// The hash is a plain one, with no salt and no cost: right for tokens of 256 random
// bits, as `make_token` makes them, and for nothing that a person has thought up.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"

namespace geodesic::server {

enum class Scope : std::uint8_t { read = 1, upload = 2, admin = 4 };

// A set of scopes. `upload` does not imply `read`; `admin` implies all.
class Scopes {
 public:
  constexpr Scopes() = default;
  // NOLINTNEXTLINE(google-explicit-constructor): a scope is a set of one
  constexpr Scopes(Scope scope) : bits_(static_cast<std::uint8_t>(scope)) {}

  [[nodiscard]] constexpr bool empty() const { return bits_ == 0; }
  // Whether a holder of these may do what any one of `needed` allows.
  [[nodiscard]] constexpr bool satisfy(Scopes needed) const {
    return needed.empty() || ((needed.bits_ | Scopes(Scope::admin).bits_) & bits_) != 0;
  }
  friend constexpr Scopes operator|(Scopes a, Scopes b) {
    a.bits_ |= b.bits_;
    return a;
  }
  friend constexpr bool operator==(Scopes, Scopes) = default;

 private:
  std::uint8_t bits_ = 0;
};
constexpr Scopes operator|(Scope a, Scope b) { return Scopes(a) | Scopes(b); }

// "read,upload". Fails with `bad_syntax` without repeating the text.
[[nodiscard]] Result<Scopes> parse_scopes(std::string_view text);
// In the order read, upload, admin; "" for none.
[[nodiscard]] std::string format_scopes(Scopes scopes);

using Moment = std::chrono::sys_seconds;
// What `expires` takes; `bad_syntax`.
[[nodiscard]] Result<Moment> parse_moment(std::string_view text);

struct Token {
  std::string name;
  Scopes scopes;
  std::string sha256;  // 64 lower-case hexadecimal digits
  std::optional<Moment> expires;
};

class Tokens {
 public:
  static constexpr std::size_t kMost = 4096;  // each request is compared with all of them

  // `file` is named by errors: "FILE:3: the third field is not …". They never
  // repeat what the line holds: that may be a hash, or a token by mistake.
  [[nodiscard]] static Result<Tokens> parse(std::string_view text, const std::string& file);
  // Reads a file; `bad_syntax` if it cannot be read or does not parse.
  [[nodiscard]] static Result<Tokens> load(const std::string& file);

  // The token whose secret this is; null if there is none. Takes the same time
  // wherever in the file it stands and whether it is there at all. It may have expired.
  [[nodiscard]] const Token* find(std::string_view secret) const;

  [[nodiscard]] std::size_t size() const { return tokens_.size(); }
  // What an operator should know of the file, a sentence each.
  [[nodiscard]] const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  std::vector<Token> tokens_;
  std::vector<std::string> warnings_;
};

struct FreshToken {
  std::string secret;  // geo_ and 43 characters of base64url: 256 random bits
  std::string line;    // for the file
};
// `bad_syntax` for a name that is none, or no scopes.
[[nodiscard]] Result<FreshToken> make_token(std::string_view name, Scopes scopes,
                                            std::optional<Moment> expires = {});

}  // namespace geodesic::server
