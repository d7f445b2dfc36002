// Bytes as they come over the network: heads of requests, bodies in chunks, and forms.
#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "proto/wire/input_codes.h"
#include "server/edge/body.h"
#include "server/http/head.h"
#include "server/http/multipart.h"
#include "tests/fuzz/targets.h"

namespace geodesic::fuzz {
namespace {

using namespace std::string_literals;
using server::HttpBody;
using server::HttpHead;

std::string_view text_of(Input input) {
  return {reinterpret_cast<const char*>(input.data()), input.size()};
}

void expect_clean(std::string_view text) {
  expect(std::none_of(text.begin(), text.end(),
                      [](char c) { return server::is_control(c) && c != '\t'; }),
         "what came in a line holds no control character");
}

constexpr std::size_t kMostBody = 1000;

struct Taken {
  HttpBody::State state = HttpBody::State::more;
  std::string body;
  std::string rest;
};

Taken take(std::string_view bytes, std::size_t piece) {
  HttpBody reader = HttpBody::chunked(kMostBody);
  Taken taken;
  while (taken.state == HttpBody::State::more && !bytes.empty()) {
    std::string_view part = bytes.substr(0, piece);
    bytes.remove_prefix(part.size());
    taken.state = reader.take(part, taken.body);
    expect(taken.state != HttpBody::State::more || part.empty(), "all that came is taken");
    taken.rest = std::string(part) + std::string(bytes);
    expect(taken.body.size() <= kMostBody, "a body keeps within its limit");
  }
  return taken;
}

// A line, which ends in CR LF and holds no control character.
std::optional<std::string_view> take_line(std::string_view& bytes) {
  const std::size_t end = bytes.find("\r\n");
  if (end == std::string_view::npos) return std::nullopt;
  const std::string_view line = bytes.substr(0, end);
  bytes.remove_prefix(end + 2);
  if (std::any_of(line.begin(), line.end(), server::is_control)) return std::nullopt;
  return line;
}

// All chunks at once, as RFC 9112, 7.1 has them.
std::optional<Taken> read_plainly(std::string_view bytes) {
  Taken taken;
  while (true) {
    const auto line = take_line(bytes);
    if (!line) return std::nullopt;
    const std::string digits(line->substr(0, line->find(';')));
    if (digits.empty() || digits.find_first_not_of("0123456789abcdefABCDEF") != digits.npos) {
      return std::nullopt;
    }
    const std::size_t size = std::stoull(digits, nullptr, 16);
    if (size == 0) break;
    if (bytes.size() < size + 2 || bytes.substr(size, 2) != "\r\n") return std::nullopt;
    taken.body += bytes.substr(0, size);
    bytes.remove_prefix(size + 2);
  }
  while (true) {
    const auto line = take_line(bytes);
    if (!line) return std::nullopt;
    if (line->empty()) break;
    const std::size_t colon = line->find(':');
    if (colon == line->npos || !server::is_token(line->substr(0, colon))) return std::nullopt;
  }
  taken.state = HttpBody::State::complete;
  taken.rest = bytes;
  return taken;
}

}  // namespace

void fuzz_head(Input input) {
  std::string_view text = text_of(input);
  const std::size_t end = text.find("\r\n\r\n");
  if (end == std::string_view::npos) return;
  text = text.substr(0, end + 4);
  HttpHead head;
  if (const auto error = server::parse_head(text, {1000, 20}, head)) {
    expect(error->error.code != ErrorCode::internal, "an error is the client's");
    expect(!error->error.detail.empty(), "an error says what is wrong");
    return;
  }
  expect(server::is_token(head.method), "a method is a token");
  expect(head.path == "*" || head.path.front() == '/', "a path begins with a slash");
  expect(head.path.find('\0') == std::string::npos, "a path holds no NUL");
  expect(head.authority.empty() ? head.http_1_0 : server::is_authority(head.authority),
         "a request is for a host");
  expect(!(head.chunked && head.body_bytes != 0), "a body is counted or in chunks");
  int hosts = 0;
  int lengths = 0;
  for (const auto& [name, value] : head.headers) {
    expect(server::is_token(name), "a header's name is a token");
    expect_clean(value);
    hosts += server::equals_ignoring_case(name, "Host");
    lengths += server::equals_ignoring_case(name, "Content-Length") ||
               server::equals_ignoring_case(name, "Transfer-Encoding");
  }
  expect(hosts <= 1 && lengths <= 1, "host and length are said once");
  // What was said comes out the same when it is said again in the plainest way.
  std::string again = head.method + " " + head.target + (head.http_1_0 ? " HTTP/1.0" : " HTTP/1.1");
  again += "\r\n";
  for (const auto& [name, value] : head.headers) again += name + ":" + value + "\r\n";
  HttpHead second;
  expect(!server::parse_head(again + "\r\n", {1000, 20}, second), "a head can be said again");
  expect(second.path == head.path && second.query == head.query && second.headers == head.headers &&
             second.body_bytes == head.body_bytes && second.chunked == head.chunked &&
             second.keep_alive == head.keep_alive && second.authority == head.authority,
         "a head said again is the same");
}

void fuzz_body(Input input) {
  if (input.empty()) return;
  const std::size_t piece = 1 + input.front() % 32U;
  const std::string_view text = text_of(input.subspan(1));
  const Taken whole = take(text, std::max<std::size_t>(text.size(), 1));
  const Taken cut = take(text, piece);
  expect(whole.state == cut.state, "it does not matter how a body is cut");
  if (whole.state != HttpBody::State::complete) return;
  expect(whole.body == cut.body && whole.rest == cut.rest, "nor where it ends");
  const auto read = read_plainly(text);
  expect(read && read->body == whole.body && read->rest == whole.rest,
         "chunks are what the plainest reader takes them for");
}

void fuzz_form(Input input) {
  const std::string_view text = text_of(input);
  const std::size_t line = text.find('\n');
  const std::string_view type = text.substr(0, line);
  const auto boundary = server::multipart_boundary(type);
  expect(!boundary || server::is_multipart(type), "a boundary is a form's");
  if (!boundary || line == std::string_view::npos) return;
  expect(!boundary->empty() && boundary->size() <= 70, "a boundary has 1 to 70 characters");
  const std::string_view body = text.substr(line + 1);
  const auto parts = server::read_multipart(body, *boundary);
  if (!parts) {
    expect(parts.error().code == InputCode::bad_syntax, "an error is the client's");
    return;
  }
  std::size_t bytes = 0;
  for (const server::Part& part : *parts) {
    expect(
        part.bytes.empty() || (part.bytes.data() >= body.data() &&
                               part.bytes.data() + part.bytes.size() <= body.data() + body.size()),
        "a part is part of the body");
    expect(part.bytes.find("\r\n--" + *boundary) == std::string_view::npos,
           "a part holds no boundary");
    bytes += part.bytes.size();
  }
  expect(bytes <= body.size(), "parts do not overlap");
}

std::vector<std::string> head_seeds() {
  return {"GET / HTTP/1.1\r\nHost: x\r\n\r\n",
          "POST /v1/meshes?units=mm HTTP/1.1\r\nHost: 127.0.0.1:8080\r\nContent-Length: 5\r\n"
          "Expect: 100-continue\r\nContent-Type: model/gltf-binary\r\n\r\n",
          "PUT /a%20b/%C3%A9?c=%2f&d=+ HTTP/1.1\r\nhost:[::1]:80\r\nTransfer-Encoding: chunked\r\n"
          "Connection: keep-alive, close\r\n\r\n",
          "GET http://example.org:80/path?x HTTP/1.1\r\nHost: example.org\r\n\r\n",
          "OPTIONS * HTTP/1.1\r\nHost: h.\r\nOrigin: null\r\n\r\n",
          "HEAD /x HTTP/1.0\r\nA: \t b c\t\r\n\r\n"};
}

std::vector<std::string> body_seeds() {
  return {
      "\x05"
      "5\r\nhello\r\n0\r\n\r\n"s,
      "\x01"
      "005;a=b;c=\"d\"\r\nhello\r\nA\r\n0123456789\r\n0;x\r\nT: u\r\nV: w\r\n\r\n"s,
      "\x02"
      "0\r\n\r\nGET /next HTTP/1.1\r\n\r\n"s,
      "\x07"
      "3e8\r\n"s,
      "\x03"
      "ffffffffffffffff\r\n"s};
}

std::vector<std::string> form_seeds() {
  const std::string type = "multipart/form-data; boundary=";
  return {type +
              "b\n--b\r\nContent-Disposition: form-data; name=\"f\"; filename=\"a.glb\"\r\n"
              "Content-Type: model/gltf-binary\r\n\r\nglTF\r\n--b--\r\n",
          type +
              "\"a b\"; charset=x\npreamble\r\n--a b\r\ncontent-disposition: form-data;"
              " name=n\r\n\r\n1\r\n--a b  \r\nContent-Disposition: form-data; filename=\"x;%22y\""
              "\r\n\r\n\r\n--a b--",
          "Multipart/Form-Data; Boundary=--\n----\r\nContent-Disposition: a\r\n\r\n\r\n------",
          "text/plain; boundary=b\n--b--"};
}

}  // namespace geodesic::fuzz
