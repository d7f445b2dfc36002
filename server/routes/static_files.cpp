#include "server/routes/static_files.h"

#include <spdlog/fmt/fmt.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

#include "server/http/entity_tag.h"
#include "server/http/finish_reply.h"
#include "server/http/gzip.h"

namespace geodesic::server {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMostBytes = std::uintmax_t{64} << 20;

struct Kind {
  std::string_view extension;
  std::string_view type;
  bool packs;
};

constexpr std::array<Kind, 13> kKinds{{{".html", "text/html; charset=utf-8", true},
                                       {".js", "text/javascript; charset=utf-8", true},
                                       {".css", "text/css; charset=utf-8", true},
                                       {".svg", "image/svg+xml", true},
                                       {".json", "application/json", true},
                                       {".webmanifest", "application/manifest+json", true},
                                       {".txt", "text/plain; charset=utf-8", true},
                                       {".csv", "text/csv; charset=utf-8", true},
                                       {".sh", "text/plain; charset=utf-8", true},
                                       {".png", "image/png", false},
                                       {".webp", "image/webp", false},
                                       {".ico", "image/x-icon", false},
                                       {".woff2", "font/woff2", false}}};

const Kind* kind_of(const fs::path& file) {
  for (const Kind& kind : kKinds) {
    if (file.extension() == kind.extension) return &kind;
  }
  return nullptr;
}

constexpr std::string_view kIndex = "index.html";

// Everything is a file of this server; pictures are replies that the page shows.
constexpr const char* kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    "img-src 'self' blob: data:; font-src 'self'; worker-src 'self'; manifest-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

}  // namespace

const StaticFiles::Place StaticFiles::kViewer{"viewer", "", "/assets/"};
const StaticFiles::Place StaticFiles::kDocs{"docs", "/docs", ""};

Result<StaticFiles> StaticFiles::load(const std::string& folder, const Place& place) {
  StaticFiles site;
  site.lasting_ = place.lasting;
  const auto unreadable = [&](const std::string& why) {
    return fail(ErrorCode::internal, fmt::format("{}: {}: {}", place.name, folder, why));
  };
  std::uintmax_t bytes = 0;
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end;
       it.increment(error)) {
    const fs::path& path = it->path();
    const Kind* const kind = kind_of(path);
    std::error_code ignored;
    if (kind == nullptr || !fs::is_regular_file(it->symlink_status(ignored))) continue;
    bytes += it->file_size(ignored);
    if (bytes > kMostBytes) return unreadable("more than 64 MiB cannot be served");
    std::ifstream stream(path, std::ios::binary);
    std::string content((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
    if (!stream) return unreadable(path.filename().string() + " cannot be read");
    File file;
    file.type = kind->type;
    file.tag = entity_tag(content);
    if (std::string packed = kind->packs ? gzip(content) : ""; kind->packs) {
      if (packed.size() < content.size()) {
        file.packed = std::make_shared<const std::string>(std::move(packed));
      }
    }
    file.bytes = std::make_shared<const std::string>(std::move(content));
    const fs::path name = path.lexically_relative(folder);
    std::string at = place.prefix + "/" + name.generic_string();
    if (name.filename() == "index.html") at.resize(at.size() - kIndex.size());
    site.files_.emplace(std::move(at), std::move(file));
  }
  if (error) return unreadable(error.message());
  if (!site.files_.contains(place.prefix + "/")) return unreadable("there is no index.html");
  return site;
}

std::optional<HttpResponse> StaticFiles::find(const HttpRequest& request) const {
  const auto found = files_.find(request.path);
  if (found == files_.end()) {
    if (request.path.ends_with('/') || !files_.contains(request.path + "/")) return std::nullopt;
    return redirect(308, request.path.substr(request.path.rfind('/') + 1) + "/");
  }
  const File& file = found->second;
  HttpResponse response;
  if (has_already(request, file.tag)) {
    response = not_modified(file.tag);
  } else {
    response.content_type = file.type;
    response.body = file.bytes;
    response.set_header("ETag", file.tag);
    if (file.packed && admits_gzip(request)) {
      response.body = file.packed;
      response.set_header("Content-Encoding", "gzip");
      response.set_header("ETag", packed_tag(file.tag));
    }
  }
  if (file.packed) response.set_header("Vary", "Accept-Encoding");
  const bool is_lasting = !lasting_.empty() && request.path.starts_with(lasting_);
  response.set_header("Cache-Control",
                      is_lasting ? "public, max-age=31536000, immutable" : "no-cache");
  if (file.type.starts_with("text/html")) {
    response.set_header("Content-Security-Policy", kPolicy);
    response.set_header("Referrer-Policy", "no-referrer");
  }
  return response;
}

HttpResponse redirect(int status, std::string to) {
  HttpResponse response;
  response.status = status;
  response.set_header("Location", std::move(to));
  return response;
}

}  // namespace geodesic::server
