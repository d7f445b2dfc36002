#include "server/s3/s3_client.h"

#include <curl/curl.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <new>
#include <pugixml.hpp>
#include <random>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

#include "server/base/service_codes.h"
#include "server/base/sha256.h"

namespace geodesic::server {

namespace {

constexpr int kMostRunning = 32;
constexpr int kMostWaiting = 32;
constexpr int kMostTries = 3;
constexpr std::chrono::seconds kRest(6);
constexpr std::chrono::seconds kConnectTimeout(3);
constexpr std::chrono::seconds kProbeTimeout(2);
constexpr int kPoll = 20;  // milliseconds
constexpr std::uint64_t kSlowestBytesPerSecond = 64 * 1024;

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

struct Upload {
  std::string_view bytes;
  std::size_t sent = 0;
};

std::size_t read_upload(char* to, std::size_t size, std::size_t count, void* user) {
  auto& upload = *static_cast<Upload*>(user);
  const std::size_t n = std::min(size * count, upload.bytes.size() - upload.sent);
  std::memcpy(to, upload.bytes.data() + upload.sent, n);
  upload.sent += n;
  return n;
}

// libcurl starts again from the front when a kept connection turns out to be dead.
int seek_upload(void* user, curl_off_t offset, int origin) {
  auto& upload = *static_cast<Upload*>(user);
  if (origin != SEEK_SET || offset < 0 ||
      static_cast<std::uint64_t>(offset) > upload.bytes.size()) {
    return CURL_SEEKFUNC_FAIL;
  }
  upload.sent = static_cast<std::size_t>(offset);
  return CURL_SEEKFUNC_OK;
}

struct Download {
  CURL* handle;
  S3Reply& reply;
  std::uint64_t limit;
  std::optional<int> file;  // for the body of a reply with 2xx
  std::uint64_t written = 0;
};

bool has_succeeded(CURL* handle) {
  long status = 0;
  curl_easy_getinfo(handle, CURLINFO_RESPONSE_CODE, &status);
  return status >= 200 && status < 300;
}

// Returns how much was written.
std::size_t write_to_file(Download& download, std::string_view bytes) {
  if (bytes.size() > download.limit - download.written) {
    download.reply.cut = true;
    return 0;
  }
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t count = ::pwrite(*download.file, bytes.data() + done, bytes.size() - done,
                                   static_cast<off_t>(download.written));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return 0;
    done += static_cast<std::size_t>(count);
    download.written += static_cast<std::uint64_t>(count);
  }
  return bytes.size();
}

std::size_t write_download(const char* from, std::size_t size, std::size_t count, void* user) {
  auto& download = *static_cast<Download*>(user);
  std::string& body = download.reply.body;
  const std::size_t n = size * count;
  if (download.file && has_succeeded(download.handle)) {
    const std::size_t written = write_to_file(download, {from, n});
    return written == n ? n : n + 1;  // "not all of it": libcurl stops
  }
  if (n > download.limit - body.size()) {
    body.append(from, static_cast<std::size_t>(download.limit - body.size()));
    download.reply.cut = true;
    return n + 1;
  }
  body.append(from, n);
  return n;
}

// As curl_easy_perform, but asks `stop` every few milliseconds: libcurl's own callback may come but
// once a second. The connection is not kept.
CURLcode perform_until(CURL* handle, const std::function<bool()>& stop) {
  const std::unique_ptr<CURLM, CURLMcode (*)(CURLM*)> multi(curl_multi_init(), curl_multi_cleanup);
  if (!multi || curl_multi_add_handle(multi.get(), handle) != CURLM_OK) throw std::bad_alloc();
  CURLcode code = CURLE_ABORTED_BY_CALLBACK;
  for (int running = 1; running > 0 && !stop();) {
    if (curl_multi_perform(multi.get(), &running) != CURLM_OK) {
      code = CURLE_FAILED_INIT;
      break;
    }
    int left = 0;
    if (const CURLMsg* const said = curl_multi_info_read(multi.get(), &left)) {
      code = said->data.result;
    } else if (curl_multi_poll(multi.get(), nullptr, 0, kPoll, nullptr) != CURLM_OK) {
      code = CURLE_FAILED_INIT;
      break;
    }
  }
  curl_multi_remove_handle(multi.get(), handle);
  return code;
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

namespace {

bool is_later(int status) {
  return status == 429 || status == 500 || status == 502 || status == 503 || status == 504;
}

// The "AccessDenied" of <Error><Code>AccessDenied</Code>…; its message may quote the
// request, so it is left where it is.
std::string s3_code(const std::string& body) {
  pugi::xml_document document;
  if (!document.load_buffer(body.data(), body.size())) return {};
  std::string code = document.child("Error").child_value("Code");
  const bool is_word = std::all_of(code.begin(), code.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '.' || c == '_';
  });
  return is_word && code.size() <= 64 ? code : std::string();
}

void pause_before(int attempt) {
  thread_local std::minstd_rand random(std::random_device{}());
  // 0.1 s, then 0.4 s, up to as much again: those who failed together do not return together.
  const int least = attempt == 1 ? 100 : 400;
  std::this_thread::sleep_for(
      std::chrono::milliseconds(std::uniform_int_distribution(least, 2 * least)(random)));
}

}  // namespace

// A libcurl handle for one request, with the connection that it may have kept.
class S3Client::Turn {
 public:
  static Result<Turn> take(S3Client& client, bool at_once) {
    std::unique_lock lock(client.mutex_);
    // A probe counts, but does not queue: it must tell of a storage that is too busy.
    if (!at_once && client.running_ >= kMostRunning) {
      if (client.waiting_ >= kMostWaiting) {
        return fail(ServiceCode::store_unavailable,
                    "too many requests wait for the object store; try again");
      }
      ++client.waiting_;
      const bool free = client.freed_.wait_for(lock, client.location_.timeout,
                                               [&] { return client.running_ < kMostRunning; });
      --client.waiting_;
      if (!free) {
        return fail(ServiceCode::store_unavailable, "the object store is too slow; try again");
      }
    }
    CURL* handle = nullptr;
    if (!client.idle_.empty()) {
      handle = client.idle_.back();
      client.idle_.pop_back();
    } else {
      handle = curl_easy_init();
    }
    if (handle == nullptr) throw std::bad_alloc();
    ++client.running_;
    return Turn(client, handle);
  }
  Turn(Turn&& other) noexcept
      : client_(other.client_), handle_(std::exchange(other.handle_, nullptr)) {}
  Turn& operator=(Turn&&) = delete;
  ~Turn() {
    if (handle_ == nullptr) return;
    {
      const std::lock_guard lock(client_.mutex_);
      client_.idle_.push_back(handle_);
      --client_.running_;
    }
    client_.freed_.notify_one();
  }
  [[nodiscard]] CURL* handle() const { return handle_; }

 private:
  Turn(S3Client& client, CURL* handle) : client_(client), handle_(handle) {}
  S3Client& client_;
  CURL* handle_;
};

S3Client::S3Client(S3Location location) : location_(std::move(location)) {
  static const CURLcode started = curl_global_init(CURL_GLOBAL_DEFAULT);
  if (started != CURLE_OK) throw std::runtime_error("libcurl does not start");
}

S3Client::~S3Client() {
  for (CURL* handle : idle_) curl_easy_cleanup(handle);
}

Result<S3Reply> S3Client::send(const S3Request& request) {
  if (!request.is_probe) {
    if (const auto reason = why_resting()) return fail(ServiceCode::store_unavailable, *reason);
  }
  auto turn = Turn::take(*this, request.is_probe);
  if (!turn) return fail(std::move(turn.error()));
  return send_with(turn->handle(), request);
}

Result<S3Reply> S3Client::send_with(CURL* handle, const S3Request& request) {
  const Clock::time_point last_start = Clock::now() + location_.timeout;
  for (int attempt = 1;; ++attempt) {
    Attempt result = try_once(handle, request);
    const int status = result.reply.status;
    const bool is_once = request.is_probe || request.within.count() > 0;
    const bool again = attempt < kMostTries && !is_once && Clock::now() < last_start;
    if (result.curl_code == CURLE_ABORTED_BY_CALLBACK) {
      return fail(ErrorCode::cancelled, "stopped");
    }
    if (result.curl_code != CURLE_OK) {
      spdlog::warn("store: {} {}/{}: {}", request.method, location_.url, request.key,
                   result.reason);
      if (again) {
        pause_before(attempt);
        continue;
      }
      const std::string reason =
          "the object store cannot be reached: " +
          std::string(curl_easy_strerror(static_cast<CURLcode>(result.curl_code)));
      rest(reason);
      return fail(ServiceCode::store_unavailable, reason);
    }
    end_rest();
    if ((status >= 200 && status < 300) || status == 404) return std::move(result.reply);
    const std::string code = s3_code(result.reply.body);
    spdlog::warn("store: {} {}/{}: {} {}", request.method, location_.url, request.key, status,
                 code);
    if (is_later(status) && again) {
      pause_before(attempt);
      continue;
    }
    const std::string reason =
        fmt::format("the object store answered {}{}{}", status, code.empty() ? "" : " ", code);
    if (status == 507 || code == "QuotaExceeded" || code == "XMinioStorageFull") {
      return fail(ServiceCode::store_full, reason);
    }
    return fail(is_later(status) ? ServiceCode::store_unavailable : ServiceCode::store_failed,
                reason);
  }
}

S3Client::Attempt S3Client::try_once(CURL* handle, const S3Request& request) const {
  Attempt attempt;
  std::string url = location_.url + "/" + request.key;
  char separator = '?';
  for (const auto& [name, value] : request.query) {  // a map: sorted
    url += separator + escaped(name) + "=" + escaped(value);
    separator = '&';
  }

  Upload upload{request.body.value_or(std::string_view()), 0};
  Headers headers;
  // Signed with the rest, so that the server refuses bytes damaged on their way.
  add_header(headers, "x-amz-content-sha256: " + sha256_hex(upload.bytes));
  if (!location_.session_token.empty()) {
    add_header(headers, "x-amz-security-token: " + location_.session_token);
  }

  curl_easy_reset(handle);  // keeps the connection
  const auto set = [&](CURLoption option, auto value) {
    const CURLcode code = curl_easy_setopt(handle, option, value);
    if (code != CURLE_OK) throw std::runtime_error("libcurl lacks an option");
  };
  std::array<char, CURL_ERROR_SIZE> reason{};
  set(CURLOPT_ERRORBUFFER, reason.data());
  set(CURLOPT_NOSIGNAL, 1L);
  set(CURLOPT_PROTOCOLS_STR, "http,https");
  set(CURLOPT_URL, url.c_str());
  set(CURLOPT_USERAGENT, "geodesicd");
  set(CURLOPT_USERNAME, location_.access_key.c_str());
  set(CURLOPT_PASSWORD, location_.secret_key.c_str());
  const std::string signing = "aws:amz:" + location_.region + ":s3";
  set(CURLOPT_AWS_SIGV4, signing.c_str());
  set(CURLOPT_HTTPHEADER, headers.get());
  set(CURLOPT_FILETIME, 1L);

  if (request.method == "HEAD") {
    set(CURLOPT_NOBODY, 1L);
  } else if (request.method == "PUT") {
    set(CURLOPT_UPLOAD, 1L);
    set(CURLOPT_INFILESIZE_LARGE, static_cast<curl_off_t>(upload.bytes.size()));
    set(CURLOPT_READFUNCTION, &read_upload);
    set(CURLOPT_READDATA, static_cast<void*>(&upload));
    set(CURLOPT_SEEKFUNCTION, &seek_upload);
    set(CURLOPT_SEEKDATA, static_cast<void*>(&upload));
  } else if (request.method != "GET") {
    set(CURLOPT_CUSTOMREQUEST, request.method.c_str());
  }
  Download download{handle, attempt.reply, request.max_reply_bytes, request.file};
  if (request.file && ::ftruncate(*request.file, 0) != 0) {
    throw std::system_error(errno, std::generic_category());
  }
  set(CURLOPT_WRITEFUNCTION, &write_download);
  set(CURLOPT_WRITEDATA, static_cast<void*>(&download));

  // Silence ends a request, slowness does not; and nothing lasts for ever.
  const auto silence =
      request.is_probe ? std::min(kProbeTimeout, location_.timeout) : location_.timeout;
  const auto connect = std::min(request.is_probe ? kProbeTimeout : kConnectTimeout, silence);
  const std::uint64_t bytes = std::max<std::uint64_t>(upload.bytes.size(), request.max_reply_bytes);
  const auto longest = request.is_probe
                           ? silence
                           : silence + std::chrono::seconds(bytes / kSlowestBytesPerSecond + 1);
  set(CURLOPT_CONNECTTIMEOUT, static_cast<long>(connect.count()));
  set(CURLOPT_LOW_SPEED_LIMIT, 1L);
  set(CURLOPT_LOW_SPEED_TIME, static_cast<long>(silence.count()));
  set(CURLOPT_TIMEOUT, static_cast<long>(std::min<std::int64_t>(longest.count(), 1 << 20)));
  if (request.within.count() > 0) {
    set(CURLOPT_TIMEOUT_MS, static_cast<long>(request.within.count()));
  }

  CURLcode code = request.stop ? perform_until(handle, request.stop) : curl_easy_perform(handle);
  if (code == CURLE_WRITE_ERROR && attempt.reply.cut) code = CURLE_OK;
  attempt.curl_code = code;
  attempt.reason = reason[0] != '\0' ? reason.data() : curl_easy_strerror(code);
  long status = 0;
  curl_easy_getinfo(handle, CURLINFO_RESPONSE_CODE, &status);
  attempt.reply.status = static_cast<int>(status);
  curl_off_t length = -1;
  curl_easy_getinfo(handle, CURLINFO_CONTENT_LENGTH_DOWNLOAD_T, &length);
  if (length >= 0) attempt.reply.content_length = static_cast<std::uint64_t>(length);
  curl_header* tag = nullptr;
  if (curl_easy_header(handle, "ETag", 0, CURLH_HEADER, -1, &tag) == CURLHE_OK) {
    attempt.reply.entity_tag = strong_tag(tag->value);
  }
  curl_off_t changed = 0;
  curl_easy_getinfo(handle, CURLINFO_FILETIME_T, &changed);
  attempt.reply.last_modified = changed > 0 ? changed : 0;
  // They point to what is gone when this returns.
  curl_easy_reset(handle);
  return attempt;
}

std::optional<std::string> S3Client::why_resting() const {
  const std::lock_guard lock(mutex_);
  if (Clock::now() >= resting_until_) return std::nullopt;
  return resting_because_;
}

void S3Client::rest(const std::string& reason) {
  const std::lock_guard lock(mutex_);
  resting_until_ = Clock::now() + kRest;
  resting_because_ = reason;
}

void S3Client::end_rest() {
  const std::lock_guard lock(mutex_);
  resting_until_ = {};
}

}  // namespace geodesic::server
