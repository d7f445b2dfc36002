#include "server/config/tokens.h"

#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/rand.h>
#include <spdlog/fmt/fmt.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <system_error>
#include <utility>

#include "proto/wire/input_codes.h"
#include "server/base/sha256.h"

namespace geodesic::server {

namespace {

constexpr std::string_view kPrefix = "geo_";
constexpr std::size_t kHexDigits = 64;
constexpr std::array<std::pair<std::string_view, Scope>, 3> kScopeNames{
    {{"read", Scope::read}, {"upload", Scope::upload}, {"admin", Scope::admin}}};

tl::unexpected<Error> bad(std::string detail) {
  return fail(InputCode::bad_syntax, std::move(detail));
}

bool is_name(std::string_view text) {
  return !text.empty() && text.size() <= 64 && std::all_of(text.begin(), text.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
  });
}

bool is_sha256(std::string_view text) {
  return text.size() == kHexDigits && std::all_of(text.begin(), text.end(), [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
         });
}

// Cut at the first of the separators, which goes too.
std::string_view next_part(std::string_view& text, std::string_view separators) {
  const std::size_t end = text.find_first_of(separators);
  const std::string_view part = text.substr(0, end);
  text = end == std::string_view::npos ? "" : text.substr(end + 1);
  return part;
}

std::vector<std::string_view> fields_of(std::string_view line) {
  line = line.substr(0, line.find('#'));
  std::vector<std::string_view> fields;
  while (!line.empty()) {
    const std::string_view field = next_part(line, " \t\r");
    if (!field.empty()) fields.push_back(field);
  }
  return fields;
}

// What is wrong with a line is said of its places, not of what is in them.
Result<Token> parse_line(const std::vector<std::string_view>& fields) {
  constexpr std::string_view kForm = "NAME SCOPES SHA256 [expires=WHEN]";
  if (fields.size() < 3 || fields.size() > 4) {
    return bad(fmt::format("has {} fields, not {}", fields.size(), kForm));
  }
  Token token;
  if (!is_name(fields[0])) {
    return bad("the first field, a name, has 1 to 64 letters, digits and . _ -");
  }
  token.name = fields[0];
  const auto scopes = parse_scopes(fields[1]);
  if (!scopes) return bad("the second field: " + scopes.error().detail);
  token.scopes = *scopes;
  if (fields[2].starts_with(kPrefix)) {
    return bad("the third field is a token itself; the file holds its SHA-256 only");
  }
  if (!is_sha256(fields[2])) {
    return bad("the third field is not a SHA-256: 64 lower-case hexadecimal digits");
  }
  token.sha256 = fields[2];
  if (fields.size() == 4) {
    constexpr std::string_view kKey = "expires=";
    if (!fields[3].starts_with(kKey)) return bad("the fourth field is not expires=WHEN");
    const auto moment = parse_moment(fields[3].substr(kKey.size()));
    if (!moment) return bad("the fourth field: " + moment.error().detail);
    token.expires = *moment;
  }
  return token;
}

// Digits, and nothing else, at a place; -1 if there is something else.
int number_at(std::string_view text, std::size_t at, std::size_t count) {
  int value = 0;
  for (std::size_t i = at; i < at + count; ++i) {
    if (i >= text.size() || text[i] < '0' || text[i] > '9') return -1;
    value = 10 * value + (text[i] - '0');
  }
  return value;
}

bool is_within(int value, int most) { return value >= 0 && value <= most; }

// "Z", "+01:00" or "-05:30": what to take off for UTC.
std::optional<std::chrono::minutes> offset_of(std::string_view text) {
  if (text == "Z" || text == "z") return std::chrono::minutes(0);
  const int hours = number_at(text, 1, 2);
  const int minutes = number_at(text, 4, 2);
  if (text.size() != 6 || text[3] != ':' || !is_within(hours, 23) || !is_within(minutes, 59)) {
    return {};
  }
  const std::chrono::minutes offset = std::chrono::hours(hours) + std::chrono::minutes(minutes);
  if (text[0] == '+') return offset;
  if (text[0] == '-') return -offset;
  return {};
}

std::string base64url(const std::array<unsigned char, 32>& bytes) {
  std::array<unsigned char, 45> text{};  // 44 characters and a NUL
  EVP_EncodeBlock(text.data(), bytes.data(), static_cast<int>(bytes.size()));
  std::string out(reinterpret_cast<const char*>(text.data()));
  std::replace(out.begin(), out.end(), '+', '-');
  std::replace(out.begin(), out.end(), '/', '_');
  while (out.ends_with('=')) out.pop_back();
  return out;
}

}  // namespace

Result<Scopes> parse_scopes(std::string_view text) {
  Scopes scopes;
  bool more = true;
  while (more) {
    more = text.find(',') != std::string_view::npos;
    const std::string_view name = next_part(text, ",");
    const auto* const known = std::find_if(kScopeNames.begin(), kScopeNames.end(),
                                           [&](const auto& row) { return row.first == name; });
    if (known == kScopeNames.end()) {
      return bad("scopes are read, upload and admin, separated by commas");
    }
    scopes = scopes | known->second;
  }
  return scopes;
}

std::string format_scopes(Scopes scopes) {
  std::string out;
  for (const auto& [name, scope] : kScopeNames) {
    if ((scopes | scope) != scopes) continue;
    if (!out.empty()) out += ',';
    out += name;
  }
  return out;
}

Result<Moment> parse_moment(std::string_view text) {
  const auto refuse = [] { return bad("a time is 2026-12-31 or 2026-12-31T23:59:59Z"); };
  const int year = number_at(text, 0, 4);
  const int month = number_at(text, 5, 2);
  const int day = number_at(text, 8, 2);
  if (year < 0 || month < 0 || day < 0 || text[4] != '-' || text[7] != '-') return refuse();
  const std::chrono::year_month_day date(std::chrono::year(year),
                                         std::chrono::month(static_cast<unsigned>(month)),
                                         std::chrono::day(static_cast<unsigned>(day)));
  if (!date.ok()) return refuse();
  Moment moment = std::chrono::sys_days(date);
  if (text.size() == 10) return moment;

  const int hours = number_at(text, 11, 2);
  const int minutes = number_at(text, 14, 2);
  const int seconds = number_at(text, 17, 2);
  if ((text[10] != 'T' && text[10] != 't') || !is_within(hours, 23) || !is_within(minutes, 59) ||
      !is_within(seconds, 60) || text[13] != ':' || text[16] != ':') {
    return refuse();
  }
  std::string_view rest = text.substr(19);
  if (rest.starts_with('.')) {  // a fraction of a second makes no difference here
    const std::size_t end = rest.find_first_not_of("0123456789", 1);
    if (end == 1 || end == std::string_view::npos) return refuse();
    rest.remove_prefix(end);
  }
  const auto offset = offset_of(rest);
  if (!offset) return refuse();
  moment += std::chrono::hours(hours) + std::chrono::minutes(minutes) +
            std::chrono::seconds(seconds) - *offset;
  return moment;
}

Result<Tokens> Tokens::parse(std::string_view text, const std::string& file) {
  Tokens tokens;
  std::map<std::string, int, std::less<>> lines_of_names;
  std::map<std::string, int, std::less<>> lines_of_hashes;
  for (int number = 1; !text.empty(); ++number) {
    const std::vector<std::string_view> fields = fields_of(next_part(text, "\n"));
    if (fields.empty()) continue;
    const auto refuse = [&](std::string_view reason) {
      return bad(fmt::format("{}:{}: {}", file, number, reason));
    };
    auto token = parse_line(fields);
    if (!token) return refuse(token.error().detail);
    const auto [name, is_new_name] = lines_of_names.emplace(token->name, number);
    if (!is_new_name) return refuse(fmt::format("line {} has this name too", name->second));
    const auto [hash, is_new_hash] = lines_of_hashes.emplace(token->sha256, number);
    if (!is_new_hash) return refuse(fmt::format("line {} has this hash too", hash->second));
    if (tokens.tokens_.size() == kMost) return refuse(fmt::format("more than {} tokens", kMost));
    tokens.tokens_.push_back(std::move(*token));
  }
  if (tokens.tokens_.empty()) {
    tokens.warnings_.push_back(file + ": holds no token, so that nobody is let in");
  }
  return tokens;
}

Result<Tokens> Tokens::load(const std::string& file) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored)) return bad(file + ": is a folder");
  std::ifstream in(file, std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (!in.is_open() || in.bad()) return bad(file + ": cannot be read");
  auto tokens = parse(text, file);
  struct stat status {};
  if (tokens && ::stat(file.c_str(), &status) == 0 && (status.st_mode & S_IROTH) != 0) {
    tokens->warnings_.push_back(file + ": everybody on this machine may read it (chmod o-r)");
  }
  return tokens;
}

const Token* Tokens::find(std::string_view secret) const {
  const std::string digest = sha256_hex(secret);
  // Neither an early exit nor a branch on what was compared: time tells nothing.
  std::size_t found = tokens_.size();
  for (std::size_t i = 0; i < tokens_.size(); ++i) {
    const auto differs =
        static_cast<unsigned>(CRYPTO_memcmp(digest.data(), tokens_[i].sha256.data(), kHexDigits));
    // All ones where nothing differs: CRYPTO_memcmp gives 0 to 255.
    const std::size_t mask = std::size_t{0} - static_cast<std::size_t>((differs - 1U) >> 31U);
    found = (found & ~mask) | (i & mask);
  }
  return found < tokens_.size() ? &tokens_[found] : nullptr;
}

Result<FreshToken> make_token(std::string_view name, Scopes scopes, std::optional<Moment> expires) {
  if (!is_name(name)) return bad("a token's name has 1 to 64 letters, digits and . _ -");
  if (scopes.empty()) return bad("a token needs a scope");
  std::array<unsigned char, 32> random{};
  if (RAND_bytes(random.data(), static_cast<int>(random.size())) != 1) {
    return fail(ErrorCode::internal, "the system gives no random numbers");
  }
  FreshToken fresh;
  fresh.secret = std::string(kPrefix) + base64url(random);
  fresh.line = fmt::format("{} {} {}", name, format_scopes(scopes), sha256_hex(fresh.secret));
  if (expires) {
    const auto day = std::chrono::floor<std::chrono::days>(*expires);
    const std::chrono::year_month_day date(day);
    const std::chrono::hh_mm_ss time(*expires - day);
    fresh.line +=
        fmt::format(" expires={:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z", static_cast<int>(date.year()),
                    static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()),
                    time.hours().count(), time.minutes().count(), time.seconds().count());
  }
  return fresh;
}

}  // namespace geodesic::server
