// Which pages of other origins may call the API from a browser (CORS, the Fetch
// standard), and what they may read of its replies. No cookies are involved, so any
// origin may be allowed without danger: what needs a token needs it from everywhere.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "server/http_message.h"

namespace geodesic::server {

class CrossOrigin {
 public:
  // "*": any origin; empty: none; else origins such as "https://example.org",
  // separated by commas.
  explicit CrossOrigin(std::string_view origins);

  // A browser's question before the request itself. It is answered for any path: what
  // is wrong with the request, the request will be told.
  [[nodiscard]] static bool is_preflight(const HttpRequest& request);
  [[nodiscard]] HttpResponse answer_preflight(const HttpRequest& request) const;

  // Lets the page read the reply.
  void allow(const HttpRequest& request, HttpResponse& response) const;

 private:
  // The value of Access-Control-Allow-Origin; empty: not allowed.
  [[nodiscard]] std::string_view allowed(const HttpRequest& request) const;

  bool any_ = false;
  std::vector<std::string> origins_;
};

// Adds a name to a list header such as Vary, once.
void add_to_list(HttpResponse& response, const std::string& header, std::string_view name);

}  // namespace geodesic::server
