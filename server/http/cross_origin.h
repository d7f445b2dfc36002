// Which pages of other origins may call the API from a browser (CORS, the Fetch
// standard), what they may read of its replies, and which pages may change what is kept.
//
// No cookies are involved, but where the server stands can be as good as one: a page of
// anybody's, open in a browser, reaches a server on that browser's own machine. To read may
// be allowed to any page; to change meshes is for the server's own pages, for callers that
// are no pages, and for the origins named. This is judged here before anything happens and
// not left to browsers: they ask first (preflight) only about some requests, and a form sends
// a POST to anywhere.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/http/message.h"

namespace geodesic::server {

class CrossOrigin {
 public:
  // "*": any origin; empty: none; else origins such as "https://example.org",
  // separated by commas. `writers` are those that may change meshes, beside our own.
  explicit CrossOrigin(std::string_view origins, std::string_view writers = {});

  // Whether a request may change which meshes are kept: uploads, deletions, and methods
  // that nobody knows. Queries by POST read; a job is known to those only who began it.
  [[nodiscard]] static bool changes(std::string_view method, std::string_view path);
  // Nothing if the request may go on; else the reply, a 403. A page is known by Origin and
  // Sec-Fetch-Site, which browsers set and pages cannot. Our own is one of the host that the
  // request is for, by whatever scheme: a proxy may have added TLS; or what the browser
  // calls same-origin, as a proxy may have changed the host.
  [[nodiscard]] std::optional<HttpResponse> refuse(const HttpRequest& request) const;

  // A browser's question before the request itself. It is answered for any path: what
  // else is wrong with the request, the request will be told.
  [[nodiscard]] static bool is_preflight(const HttpRequest& request);
  [[nodiscard]] HttpResponse answer_preflight(const HttpRequest& request) const;

  // Lets the page read the reply.
  void allow(const HttpRequest& request, HttpResponse& response) const;

 private:
  struct Origins {
    explicit Origins(std::string_view list);
    [[nodiscard]] bool has(std::string_view origin) const;
    bool any = false;
    std::vector<std::string> named;
  };
  // The value of Access-Control-Allow-Origin; empty: not allowed.
  [[nodiscard]] std::string_view allowed(const HttpRequest& request) const;
  [[nodiscard]] bool may_change(const HttpRequest& request) const;
  [[nodiscard]] static HttpResponse refusal(const HttpRequest& request);

  const Origins readers_;
  const Origins writers_;
};

// Adds a name to a list header such as Vary, once.
void add_to_list(HttpResponse& response, const std::string& header, std::string_view name);

}  // namespace geodesic::server
