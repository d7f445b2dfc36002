// A request as handlers see it and the reply they give: plain values, free of
// sockets and of the library underneath.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "server/base/caller.h"

namespace geodesic::server {

class ReplyFile;

using NameValue = std::pair<std::string, std::string>;

struct HttpRequest {
  std::string method;              // as sent, such as "GET"; may be one that nobody knows
  std::string path;                // percent-decoded, without the query; starts with '/', or is "*"
  std::string target;              // raw, as sent
  std::string base_path;           // what links in a reply begin with; empty, or such as "/geo"
  std::string authority;           // the host, perhaps with a port, that it is for; "": not said
  std::vector<NameValue> query;    // percent-decoded ('+' is a space), in order
  std::vector<NameValue> headers;  // raw values, names as sent, in order
  std::string body;                // raw
  std::string remote;  // the client's address, maybe as a trusted proxy says it; no port
  std::string id;      // X-Request-Id if it was sane ([A-Za-z0-9._-]{1,64}), else one of ours
  // Whose turn in queues it is, and whether the peer has hung up or closed its sending half (or
  // the server stops without further grace): a system call that never blocks, may be asked by any
  // thread, also after the reply (then it answers true once the connection is closed). The edge
  // sets no deadline; whoever reads one in the request may.
  Caller caller;

  // Links to this server begin with it from now on, and it is no part of `path` where that begins
  // with it: a proxy may take it off or leave it on.
  void set_base_path(std::string base);

  // The first header of that name, whatever its case; null if there is none.
  [[nodiscard]] const std::string* header(std::string_view name) const;
  // The first query parameter of that name (case matters); null if there is none.
  [[nodiscard]] const std::string* parameter(std::string_view name) const;
};

struct HttpResponse {
  int status = 200;
  std::string content_type;  // may be empty if there is no body
  // Control characters in names or values are removed before sending.
  // Content-Length, Connection and X-Request-Id are the edge's to set.
  std::vector<NameValue> headers;
  std::shared_ptr<const std::string> body;  // null: empty. Never copied: may be a cache's.
  // If set, `body` is ignored, and this is sent as it is read.
  std::shared_ptr<const ReplyFile> file;
  // What its bytes have reserved of a memory (reply_budget.h), let go once they are sent; null:
  // the edge counts them.
  std::shared_ptr<const void> reserved;
  // If set, `body` is ignored and the reply is chunked: called for one chunk
  // after the other until it returns false (that last chunk is not sent).
  // May block, but not for longer than a client should wait for a sign of life.
  std::function<bool(std::string& chunk)> stream;
  // The stream has at least so many bytes. Who has to keep it can refuse before it is computed.
  std::uint64_t stream_bytes = 0;
  // If it names an error once `stream` has returned false, that was not the reply's end: the
  // connection is closed without one, so that the client can tell. May be null.
  std::shared_ptr<const std::optional<Error>> broken;
  // What the log line names instead of the raw target, such as
  // "/v1/meshes/{id}/distance"; empty: the target.
  std::string route;

  void set_header(std::string name, std::string value);  // replaces one of that name
  void set_body(std::string bytes, std::string type);

  // The problem+json reply for an error (see problem.h). `status` 0: the code's own.
  [[nodiscard]] static HttpResponse problem(const Error& error, const HttpRequest& request,
                                            int status = 0);
};

}  // namespace geodesic::server
