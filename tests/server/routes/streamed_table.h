// What a client has of a table whose rows are streamed, and how it asks for one.
#pragma once

#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/http/message.h"
#include "tests/server/routes/plane_service.h"

namespace geodesic::server::test {

// Where there is no way.
inline constexpr double kNowhere = std::numeric_limits<double>::infinity();

// All that a stream sends; no error: to its end.
inline std::pair<std::string, std::optional<Error>> received(const HttpResponse& response) {
  REQUIRE(response.status == 200);
  REQUIRE(response.stream);
  std::string all;
  std::string chunk;
  while (response.stream(chunk)) {
    CHECK_FALSE(chunk.empty());  // it would be taken for the end
    all += chunk;
    chunk.clear();
  }
  return {all, response.broken ? *response.broken : std::nullopt};
}

// The same of one that comes to its end.
inline std::string whole_stream(const HttpResponse& response) {
  auto [bytes, error] = received(response);
  REQUIRE_FALSE(error);
  return bytes;
}

template <class Number>
std::vector<Number> numbers_in(std::string_view bytes) {
  REQUIRE(bytes.size() % sizeof(Number) == 0);
  std::vector<Number> numbers(bytes.size() / sizeof(Number));
  if (!numbers.empty()) std::memcpy(numbers.data(), bytes.data(), bytes.size());
  return numbers;
}

inline std::vector<json> lines_in(const std::string& text) {
  std::vector<json> lines;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = text.find('\n', at);
    REQUIRE(end != std::string::npos);
    lines.push_back(json::parse(text.substr(at, end - at)));
    at = end + 1;
  }
  return lines;
}

// Points at vertices, as JSON has them.
inline json points_at(const std::vector<std::uint32_t>& vertices) {
  json points = json::array();
  for (const std::uint32_t v : vertices) points.push_back("v:" + std::to_string(v));
  return points;
}

struct TableService : PlaneService {
  using PlaneService::PlaneService;
  HttpResponse post(const std::string& at, const std::string& query, const json& body) {
    return service.ask("POST", at + "/" + query, body.dump());
  }
  [[nodiscard]] bool is_idle() {
    const auto stats = service.pool.stats();
    return stats.running == 0 && stats.queued == 0;
  }
};

inline json with(json body, const json& more) {
  body.update(more);
  return body;
}

// A table asked for by somebody who may leave.
inline HttpRequest table_request(const std::string& at, const json& asked) {
  HttpRequest request;
  request.method = "POST";
  request.target = request.path = at + "/table";
  request.id = "test";
  request.body = asked.dump();
  return request;
}

// Every eleventh vertex, so many.
inline json far_apart(std::size_t count) {
  std::vector<std::uint32_t> vertices(count);
  for (std::size_t i = 0; i < count; ++i) vertices[i] = static_cast<std::uint32_t>(i * 11);
  return points_at(vertices);
}

}  // namespace geodesic::server::test
