#include "server/s3/s3_transfer.h"

#include <curl/curl.h>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <functional>
#include <new>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include "server/base/durable_file.h"
#include "server/base/service_codes.h"
#include "server/base/sha256.h"

namespace geodesic::server {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds kConnectTimeout(3);
constexpr std::chrono::seconds kProbeTimeout(2);
constexpr int kPollMilliseconds = 20;
constexpr std::uint64_t kSlowestBytesPerSecond = 64 * 1024;
constexpr std::uint64_t kMostErrorBytes = 1 << 20;
constexpr std::size_t kAtOnce = std::size_t{1} << 20;  // bytes between two calls of `stop`

struct FreeList {
  void operator()(curl_slist* list) const { curl_slist_free_all(list); }
};
using Headers = std::unique_ptr<curl_slist, FreeList>;

void add_header(Headers& headers, const std::string& line) {
  curl_slist* const longer = curl_slist_append(headers.get(), line.c_str());
  if (longer == nullptr) throw std::bad_alloc();
  (void)headers.release();
  headers.reset(longer);
}

// RFC 3986: everything but the unreserved characters, as %XX in capitals.
std::string escaped(std::string_view text) {
  constexpr std::string_view kUnreserved =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~";
  std::string out;
  for (const char c : text) {
    if (kUnreserved.find(c) != std::string_view::npos) {
      out += c;
    } else {
      out += fmt::format("%{:02X}", static_cast<unsigned char>(c));
    }
  }
  return out;
}

// What a PUT sends.
struct Upload {
  std::string_view bytes;
  std::optional<S3Request::File> file;
  std::uint64_t sent = 0;
  int disk_error = 0;  // an errno

  explicit Upload(const S3Request& request)
      : bytes(request.body.value_or(std::string_view())), file(request.body_file) {}
  [[nodiscard]] std::uint64_t size() const { return file ? file->bytes : bytes.size(); }
  // The bytes that come next, at most so many. Less than there are only if the disk fails.
  std::size_t read(char* to, std::size_t most) {
    most = static_cast<std::size_t>(std::min<std::uint64_t>(most, size() - sent));
    if (!file) {
      std::memcpy(to, bytes.data() + sent, most);
      sent += most;
      return most;
    }
    std::size_t done = 0;
    while (done < most) {
      const ssize_t count =
          ::pread(file->descriptor, to + done, most - done, static_cast<off_t>(sent));
      if (count < 0 && errno == EINTR) continue;
      if (count <= 0) {
        disk_error = count < 0 ? errno : EIO;  // it was cut short
        break;
      }
      done += static_cast<std::size_t>(count);
      sent += static_cast<std::uint64_t>(count);
    }
    return done;
  }
};

std::size_t read_upload(char* to, std::size_t size, std::size_t count, void* user) {
  auto& upload = *static_cast<Upload*>(user);
  const std::size_t n = upload.read(to, size * count);
  return upload.disk_error == 0 ? n : std::size_t{CURL_READFUNC_ABORT};
}

// libcurl starts again from the front when a kept connection turns out to be dead.
int seek_upload(void* user, curl_off_t offset, int origin) {
  auto& upload = *static_cast<Upload*>(user);
  if (origin != SEEK_SET || offset < 0 || static_cast<std::uint64_t>(offset) > upload.size()) {
    return CURL_SEEKFUNC_FAIL;
  }
  upload.sent = static_cast<std::uint64_t>(offset);
  return CURL_SEEKFUNC_OK;
}

struct Download {
  CURL* handle;
  const S3Request& request;
  S3Reply& reply;
  Clock::time_point& deadline;
  std::optional<int> file = std::nullopt;  // once it is open
  std::uint64_t length = 0;                // of the bytes that go there
  std::uint64_t written = 0;
  std::optional<Error> own_error = std::nullopt;
};

bool has_succeeded(CURL* handle) {
  long status = 0;
  curl_easy_getinfo(handle, CURLINFO_RESPONSE_CODE, &status);
  return status >= 200 && status < 300;
}

std::chrono::milliseconds time_for(std::uint64_t bytes, const S3Request& request) {
  const std::uint64_t rate = request.bytes_per_millisecond;
  return std::chrono::milliseconds(rate == 0 ? 0 : bytes / rate);
}

// Says whether there is a file to write to.
bool open_file(Download& download) {
  curl_off_t length = -1;
  curl_easy_getinfo(download.handle, CURLINFO_CONTENT_LENGTH_DOWNLOAD_T, &length);
  if (length < 0) {
    download.own_error =
        fail(ServiceCode::store_failed, "the object store does not tell how long an object is")
            .value();
    return false;
  }
  download.length = static_cast<std::uint64_t>(length);
  download.file = download.request.open_file(download.length);
  if (!download.file) {
    download.own_error = fail(ServiceCode::store_full, "an object has no room here").value();
    return false;
  }
  download.deadline += time_for(download.length, download.request);
  return true;
}

bool write_to_file(Download& download, std::string_view bytes) {
  if (!download.file && !open_file(download)) return false;
  if (bytes.size() > download.length - download.written) return false;
  while (!bytes.empty()) {
    const ssize_t count =
        ::pwrite(*download.file, bytes.data(), bytes.size(), static_cast<off_t>(download.written));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) {
      download.own_error = disk_failure("write what the object store sends", errno).value();
      return false;
    }
    bytes.remove_prefix(static_cast<std::size_t>(count));
    download.written += static_cast<std::uint64_t>(count);
  }
  return true;
}

bool take(Download& download, std::string_view bytes) {
  const bool is_good = has_succeeded(download.handle);
  if (download.request.open_file && is_good) return write_to_file(download, bytes);
  std::string& body = download.reply.body;
  const std::uint64_t limit = is_good ? download.request.max_reply_bytes
                                      : std::min(download.request.max_reply_bytes, kMostErrorBytes);
  const std::uint64_t room = limit - std::min<std::uint64_t>(limit, body.size());
  download.reply.cut = bytes.size() > room;
  body.append(
      bytes.substr(0, static_cast<std::size_t>(std::min<std::uint64_t>(room, bytes.size()))));
  return !download.reply.cut;
}

std::size_t write_download(const char* from, std::size_t size, std::size_t count, void* user) {
  auto& download = *static_cast<Download*>(user);
  const std::size_t n = size * count;
  try {
    return take(download, {from, n}) ? n : n + 1;  // "not all of it": libcurl stops
  } catch (const std::exception& error) {          // none may pass through C
    download.own_error = fail(ServiceCode::store_failed, error.what()).value();
    return n + 1;
  }
}

// As curl_easy_perform, but asks `stop` every few milliseconds, where libcurl's own callback may
// come but once a second.
CURLcode perform(CURLM* multi, CURL* handle, const std::function<bool()>& stop,
                 const Clock::time_point& deadline) {
  if (curl_multi_add_handle(multi, handle) != CURLM_OK) throw std::bad_alloc();
  CURLcode code = CURLE_ABORTED_BY_CALLBACK;
  for (int running = 1; running > 0 && !(stop && stop());) {
    if (Clock::now() > deadline) {
      code = CURLE_OPERATION_TIMEDOUT;
      break;
    }
    if (curl_multi_perform(multi, &running) != CURLM_OK) {
      code = CURLE_FAILED_INIT;
      break;
    }
    int left = 0;
    if (const CURLMsg* const said = curl_multi_info_read(multi, &left)) {
      code = said->data.result;
    } else if (curl_multi_poll(multi, nullptr, 0, kPollMilliseconds, nullptr) != CURLM_OK) {
      code = CURLE_FAILED_INIT;
      break;
    }
  }
  curl_multi_remove_handle(multi, handle);
  return code;
}

void read_reply(CURL* handle, S3Reply& reply) {
  long status = 0;
  curl_easy_getinfo(handle, CURLINFO_RESPONSE_CODE, &status);
  reply.status = static_cast<int>(status);
  curl_off_t length = -1;
  curl_easy_getinfo(handle, CURLINFO_CONTENT_LENGTH_DOWNLOAD_T, &length);
  if (length >= 0) reply.content_length = static_cast<std::uint64_t>(length);
  curl_header* tag = nullptr;
  if (curl_easy_header(handle, "ETag", 0, CURLH_HEADER, -1, &tag) == CURLHE_OK) {
    reply.entity_tag = strong_tag(tag->value);
  }
  curl_off_t changed = 0;
  curl_easy_getinfo(handle, CURLINFO_FILETIME_T, &changed);
  reply.last_modified = changed > 0 ? changed : 0;
}

}  // namespace

std::string strong_tag(std::string_view text) {
  if (text.starts_with("W/")) return {};
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"') {
    text.remove_prefix(1);
    text.remove_suffix(1);
  }
  return std::string(text);
}

Result<std::string> digest_of_body(const S3Request& request) {
  Upload upload(request);
  Sha256 digest;
  std::vector<char> piece(
      static_cast<std::size_t>(std::min<std::uint64_t>(upload.size(), kAtOnce)));
  while (upload.sent < upload.size()) {
    if (request.stop && request.stop()) return fail(ErrorCode::cancelled, "stopped");
    const std::size_t count = upload.read(piece.data(), piece.size());
    if (upload.disk_error != 0) return disk_failure("read a file", upload.disk_error);
    digest.add({piece.data(), count});
  }
  return digest.hex();
}

S3Transfer::S3Transfer() {
  static const CURLcode started = curl_global_init(CURL_GLOBAL_DEFAULT);
  if (started != CURLE_OK) throw std::runtime_error("libcurl does not start");
  easy_ = curl_easy_init();
  multi_ = curl_multi_init();
  if (easy_ != nullptr && multi_ != nullptr) return;
  curl_easy_cleanup(easy_);
  curl_multi_cleanup(multi_);
  throw std::bad_alloc();
}

S3Transfer::~S3Transfer() {
  curl_easy_cleanup(easy_);
  curl_multi_cleanup(multi_);
}

S3Transfer::Outcome S3Transfer::run(const S3Location& location, const S3Request& request,
                                    const std::string& digest) {
  Outcome outcome;
  std::string url = location.url + "/" + request.key;
  char separator = '?';
  for (const auto& [name, value] : request.query) {  // a map: sorted
    url += separator + escaped(name) + "=" + escaped(value);
    separator = '&';
  }

  Upload upload(request);
  Headers headers;
  // Signed with the rest, so that the server refuses bytes damaged on their way.
  add_header(headers, "x-amz-content-sha256: " + digest);
  if (!location.session_token.empty()) {
    add_header(headers, "x-amz-security-token: " + location.session_token);
  }

  curl_easy_reset(easy_);  // the connections stay: they are multi_'s
  const auto set = [&](CURLoption option, auto value) {
    const CURLcode code = curl_easy_setopt(easy_, option, value);
    if (code != CURLE_OK) throw std::runtime_error("libcurl lacks an option");
  };
  std::array<char, CURL_ERROR_SIZE> reason{};
  set(CURLOPT_ERRORBUFFER, reason.data());
  set(CURLOPT_NOSIGNAL, 1L);
  set(CURLOPT_PROTOCOLS_STR, "http,https");
  set(CURLOPT_URL, url.c_str());
  set(CURLOPT_USERAGENT, "geodesicd");
  set(CURLOPT_USERNAME, location.access_key.c_str());
  set(CURLOPT_PASSWORD, location.secret_key.c_str());
  const std::string signing = "aws:amz:" + location.region + ":s3";
  set(CURLOPT_AWS_SIGV4, signing.c_str());
  set(CURLOPT_HTTPHEADER, headers.get());
  set(CURLOPT_FILETIME, 1L);

  if (request.method == "HEAD") {
    set(CURLOPT_NOBODY, 1L);
  } else if (request.method == "PUT") {
    set(CURLOPT_UPLOAD, 1L);
    set(CURLOPT_INFILESIZE_LARGE, static_cast<curl_off_t>(upload.size()));
    set(CURLOPT_READFUNCTION, &read_upload);
    set(CURLOPT_READDATA, static_cast<void*>(&upload));
    set(CURLOPT_SEEKFUNCTION, &seek_upload);
    set(CURLOPT_SEEKDATA, static_cast<void*>(&upload));
  } else if (request.method != "GET") {
    set(CURLOPT_CUSTOMREQUEST, request.method.c_str());
  }
  // The wait for a name that is resolved ends with the request.
  set(CURLOPT_QUICK_EXIT, 1L);
  const bool is_bounded = request.within.count() > 0;
  auto deadline = is_bounded ? Clock::now() + request.within + time_for(upload.size(), request)
                             : Clock::time_point::max();
  Download download{easy_, request, outcome.reply, deadline};
  set(CURLOPT_WRITEFUNCTION, &write_download);
  set(CURLOPT_WRITEDATA, static_cast<void*>(&download));

  // Silence ends a request, slowness does not; and nothing lasts for ever.
  const auto silence =
      request.is_probe ? std::min(kProbeTimeout, location.timeout) : location.timeout;
  const auto connect = std::min(request.is_probe ? kProbeTimeout : kConnectTimeout, silence);
  const std::uint64_t bytes = std::max<std::uint64_t>(upload.size(), request.max_reply_bytes);
  const auto longest = request.is_probe
                           ? silence
                           : silence + std::chrono::seconds(bytes / kSlowestBytesPerSecond + 1);
  set(CURLOPT_CONNECTTIMEOUT, static_cast<long>(connect.count()));
  set(CURLOPT_LOW_SPEED_LIMIT, 1L);
  set(CURLOPT_LOW_SPEED_TIME, static_cast<long>(silence.count()));
  set(CURLOPT_TIMEOUT, static_cast<long>(std::min<std::int64_t>(longest.count(), 1 << 20)));
  CURLcode code = perform(multi_, easy_, request.stop, deadline);
  if (code == CURLE_WRITE_ERROR && outcome.reply.cut) code = CURLE_OK;
  if (code == CURLE_ABORTED_BY_CALLBACK && upload.disk_error != 0) {
    outcome.own_error = disk_failure("read a file", upload.disk_error).value();
  } else if (code == CURLE_ABORTED_BY_CALLBACK) {
    outcome.own_error = fail(ErrorCode::cancelled, "stopped").value();
  } else if (download.own_error) {
    outcome.own_error = std::move(download.own_error);
  }
  outcome.curl_code = code;
  outcome.reason = reason[0] != '\0' ? reason.data() : curl_easy_strerror(code);
  read_reply(easy_, outcome.reply);
  // They point to what is gone when this returns.
  curl_easy_reset(easy_);
  return outcome;
}

}  // namespace geodesic::server
