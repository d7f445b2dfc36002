// The viewer's files (clients/web/viewer, built), read once at the start and then served
// from memory: what is asked for never becomes the name of a file to open.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "server/http/message.h"

namespace geodesic::server {

class ViewerFiles {
 public:
  // None: nothing is found.
  ViewerFiles() = default;

  // All files below a folder whose kind is known by their names; links are not followed.
  // Errors: internal, if the folder cannot be read, has no index.html, or holds more than
  // 64 MiB.
  [[nodiscard]] static Result<ViewerFiles> load(const std::string& folder);

  // The reply to the GET of a path, index.html being "/"; nothing where there is no file.
  // What lies under /assets/ has a digest in its name and may be kept for ever.
  [[nodiscard]] std::optional<HttpResponse> find(const HttpRequest& request) const;

 private:
  struct File {
    std::shared_ptr<const std::string> bytes;
    std::shared_ptr<const std::string> packed;  // by gzip; null where that is no gain
    std::string type;
    std::string tag;
  };
  std::map<std::string, File, std::less<>> files_;  // by path
};

}  // namespace geodesic::server
