// A folder of files that browsers ask for (the built viewer, the documentation site), read once at
// the start and then served from memory: what is asked for never becomes the name of a file to
// open.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "server/http/message.h"

namespace geodesic::server {

class StaticFiles {
 public:
  // Where a folder's files stand among the server's paths.
  struct Place {
    std::string name;     // of the option, for messages
    std::string prefix;   // before each file's path, such as "/docs"; empty: the server's root
    std::string lasting;  // files whose paths begin so have a digest in their names; empty: none
  };
  static const Place kViewer;
  static const Place kDocs;

  // None: nothing is found.
  StaticFiles() = default;

  // All files below a folder whose kind is known by their names; links are not followed.
  // Errors: internal, if the folder cannot be read, has no index.html, or holds more than
  // 64 MiB.
  [[nodiscard]] static Result<StaticFiles> load(const std::string& folder, const Place& place);

  [[nodiscard]] bool empty() const { return files_.empty(); }

  // The reply to the GET of a path; nothing where there is no file. An index.html is its folder's
  // path with a slash at the end; without the slash, the reply is a 308 to it.
  // What is lasting may be kept for ever.
  [[nodiscard]] std::optional<HttpResponse> find(const HttpRequest& request) const;

 private:
  struct File {
    std::shared_ptr<const std::string> bytes;
    std::shared_ptr<const std::string> packed;  // by gzip; null where that is no gain
    std::string type;
    std::string tag;
  };
  std::map<std::string, File, std::less<>> files_;  // by path
  std::string lasting_;
};

// A reply that sends the client elsewhere. `to` is relative to the path asked for, so that it holds
// behind a proxy that takes a prefix off. `status`: 308 where that holds for ever, else 307.
[[nodiscard]] HttpResponse redirect(int status, std::string to);

}  // namespace geodesic::server
