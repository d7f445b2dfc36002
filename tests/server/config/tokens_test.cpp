#include "server/config/tokens.h"

#include <doctest/doctest.h>
#include <sys/stat.h>

#include <fstream>
#include <set>
#include <string>
#include <string_view>

#include "proto/wire/input_codes.h"
#include "server/base/sha256.h"
#include "tests/server/routes/service_fixture.h"

using namespace geodesic;
using namespace geodesic::server;

namespace {

// A line for a secret.
std::string line(std::string_view name, std::string_view scopes, std::string_view secret,
                 std::string_view rest = "") {
  return std::string(name) + " " + std::string(scopes) + " " + sha256_hex(secret) +
         std::string(rest) + "\n";
}

Tokens parsed(const std::string& text) {
  auto tokens = Tokens::parse(text, "file");
  REQUIRE(tokens);
  return std::move(*tokens);
}

std::string refusal(const std::string& text) {
  const auto tokens = Tokens::parse(text, "folder/file");
  REQUIRE_FALSE(tokens);
  CHECK(tokens.error().code == InputCode::bad_syntax);
  return tokens.error().detail;
}

}  // namespace

TEST_CASE("a file of tokens: names, scopes, comments and ends") {
  const Tokens tokens = parsed("# who may do what\n\n" + line("ann", "read", "geo_a") + "\t" +
                               line("bob.2_x-y", "upload,read", "geo_b", "  # for the scans") +
                               line("cy", "admin", "geo_c", " expires=2030-01-31\r") + "dee read " +
                               sha256_hex("geo_d"));  // no newline at the end
  CHECK(tokens.size() == 4);
  CHECK(tokens.warnings().empty());
  const Token* const ann = tokens.find("geo_a");
  REQUIRE(ann != nullptr);
  CHECK(ann->name == "ann");
  CHECK(ann->scopes == Scopes(Scope::read));
  CHECK_FALSE(ann->expires);
  const Token* const bob = tokens.find("geo_b");
  REQUIRE(bob != nullptr);
  CHECK(bob->name == "bob.2_x-y");
  CHECK(bob->scopes == (Scope::read | Scope::upload));
  const Token* const cy = tokens.find("geo_c");
  REQUIRE(cy != nullptr);
  CHECK(cy->expires == *parse_moment("2030-01-31T00:00:00Z"));
  REQUIRE(tokens.find("geo_d") != nullptr);
  for (const std::string_view unknown : {"", "geo_", "geo_A", "geo_a ", "ann"}) {
    CAPTURE(unknown);
    CHECK(tokens.find(unknown) == nullptr);
  }
  CHECK(tokens.find(sha256_hex("geo_a")) == nullptr);  // the file's hash is no token
}

TEST_CASE("a token is found wherever it stands among many") {
  std::string text;
  const auto name_of = [](std::size_t i) { return "n" + std::to_string(i); };
  for (std::size_t i = 0; i < Tokens::kMost; ++i) text += line(name_of(i), "read", name_of(i));
  const Tokens tokens = parsed(text);
  for (const std::size_t i :
       {std::size_t{0}, std::size_t{1}, std::size_t{255}, std::size_t{2048}, Tokens::kMost - 1}) {
    const Token* const found = tokens.find(name_of(i));
    REQUIRE(found != nullptr);
    CHECK(found->name == name_of(i));
  }
  CHECK(tokens.find(name_of(Tokens::kMost)) == nullptr);
  CHECK(refusal(text + line("more", "read", "more")) == "folder/file:4097: more than 4096 tokens");
}

TEST_CASE("admin implies every scope, upload does not imply reading") {
  const Scopes read = Scope::read;
  const Scopes upload = Scope::upload;
  const Scopes admin = Scope::admin;
  for (const Scopes needed : {read, upload, admin, read | upload, Scopes()}) {
    CHECK(admin.satisfy(needed));
  }
  CHECK(read.satisfy(read));
  CHECK_FALSE(read.satisfy(upload));
  CHECK_FALSE(read.satisfy(admin));
  CHECK_FALSE(upload.satisfy(read));
  CHECK(upload.satisfy(read | upload));
  CHECK(upload.satisfy(Scopes()));
  CHECK(Scopes().satisfy(Scopes()));
  CHECK_FALSE(Scopes().satisfy(read));
  CHECK(format_scopes(*parse_scopes("admin,read")) == "read,admin");
  CHECK(format_scopes(*parse_scopes("upload")) == "upload");
  for (const char* bad :
       {"", ",", "read,", ",read", "Read", "read upload", "write", "read,,admin"}) {
    CAPTURE(bad);
    CHECK_FALSE(parse_scopes(bad));
  }
}

TEST_CASE("a malformed line is refused with its place and nothing of what it holds") {
  const std::string hash = sha256_hex("geo_secret");
  const std::string secret = "geo_AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA";
  const auto check = [&](const std::string& bad, std::string_view reason) {
    CAPTURE(bad);
    const std::string detail = refusal("# first\n" + line("ok", "read", "x") + bad + "\n");
    CHECK(detail.starts_with("folder/file:3: "));
    CHECK(detail.find(reason) != std::string::npos);
    CHECK(detail.find(hash) == std::string::npos);
    CHECK(detail.find(hash.substr(0, 12)) == std::string::npos);
    CHECK(detail.find(secret) == std::string::npos);
  };
  check("name read", "has 2 fields");
  check(hash, "has 1 fields");
  check("name read " + hash + " expires=2030-01-01 x", "has 5 fields");
  check("na/me read " + hash, "the first field");
  check(std::string(65, 'a') + " read " + hash, "the first field");
  check("name write " + hash, "the second field");
  check("name " + hash + " read", "the second field");
  check(hash + "= read " + hash, "the first field");
  check("name read " + hash.substr(1), "the third field");
  check("name read " + hash.substr(1) + "G", "the third field");
  check("name read " + secret, "a token itself");
  check("name read " + hash + " " + hash, "the fourth field");
  check("name read " + hash + " expires=tomorrow", "the fourth field");
  check("ok read " + hash, "line 2 has this name too");
  check("name read " + sha256_hex("x"), "line 2 has this hash too");
}

TEST_CASE("moments are those of RFC 3339, or days") {
  const auto at = [](std::string_view text) {
    const auto moment = parse_moment(text);
    CAPTURE(text);
    REQUIRE(moment);
    return moment->time_since_epoch().count();
  };
  CHECK(at("1970-01-01") == 0);
  CHECK(at("1970-01-02T00:00:01Z") == 86401);
  CHECK(at("1970-01-01t02:00:00z") == 7200);
  CHECK(at("1970-01-01T02:00:00+02:00") == 0);
  CHECK(at("1970-01-01T00:00:00-05:30") == 19800);
  CHECK(at("1970-01-01T00:00:05.123456Z") == 5);
  CHECK(at("2000-02-29") == 951782400);
  for (const char* bad : {"",
                          "2030",
                          "2030-1-1",
                          "2030-13-01",
                          "2030-02-30",
                          "2029-02-29",
                          "2030/01/01",
                          "2030-01-01Z",
                          "2030-01-01T",
                          "2030-01-01T10:00Z",
                          "2030-01-01T10:00:00",
                          "2030-01-01T24:00:00Z",
                          "2030-01-01T10:60:00Z",
                          "2030-01-01 10:00:00Z",
                          "2030-01-01T10:00:00.Z",
                          "2030-01-01T10:00:00.5",
                          "2030-01-01T10:00:00+0100",
                          "2030-01-01T10:00:00*01:00",
                          "2030-01-01T10:00:00Zx",
                          "-030-01-01",
                          "2030-01-01T-1:00:00Z"}) {
    CAPTURE(bad);
    CHECK_FALSE(parse_moment(bad));
  }
}

TEST_CASE("a fresh token is random, and its line is found by it") {
  std::set<std::string> secrets;
  for (int i = 0; i < 100; ++i) {
    const auto fresh = make_token("ann", Scope::read | Scope::upload);
    REQUIRE(fresh);
    CHECK(fresh->secret.size() == 47);  // 43 digits of 6 bits hold 256
    CHECK(fresh->secret.starts_with("geo_"));
    CHECK(fresh->secret.find_first_not_of(
              "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789"
              "-_") == std::string::npos);
    CHECK(fresh->line.starts_with("ann read,upload "));
    CHECK(fresh->line.find(fresh->secret) == std::string::npos);
    const Tokens tokens = parsed(fresh->line);
    REQUIRE(tokens.find(fresh->secret) != nullptr);
    CHECK(tokens.find(fresh->secret)->scopes == (Scope::read | Scope::upload));
    secrets.insert(fresh->secret);
  }
  CHECK(secrets.size() == 100);
  const auto ending = make_token("bob", Scope::admin, parse_moment("2030-06-01T12:34:56Z").value());
  REQUIRE(ending);
  CHECK(ending->line.ends_with(" expires=2030-06-01T12:34:56Z"));
  CHECK(parsed(ending->line).find(ending->secret)->expires ==
        *parse_moment("2030-06-01T12:34:56Z"));
  CHECK_FALSE(make_token("two words", Scope::read));
  CHECK_FALSE(make_token("", Scope::read));
  CHECK_FALSE(make_token("ann", Scopes()));
}

TEST_CASE("a file that others may read, or that lets nobody in, is a warning") {
  const test::TemporaryFolder folder;
  const std::string file = (folder.path() / "tokens").string();
  std::ofstream(file) << line("ann", "read", "geo_a");
  REQUIRE(::chmod(file.c_str(), 0640) == 0);
  auto tokens = Tokens::load(file);
  REQUIRE(tokens);
  CHECK(tokens->size() == 1);
  CHECK(tokens->warnings().empty());
  REQUIRE(::chmod(file.c_str(), 0644) == 0);
  tokens = Tokens::load(file);
  REQUIRE(tokens);
  REQUIRE(tokens->warnings().size() == 1);
  CHECK(tokens->warnings().front().find(file) != std::string::npos);
  CHECK(parsed("# nobody\n").warnings().size() == 1);
  const auto absent = Tokens::load(file + ".none");
  REQUIRE_FALSE(absent);
  CHECK(absent.error().detail == file + ".none: cannot be read");
  CHECK_FALSE(Tokens::load(folder.path().string()));  // a folder is no file
}
