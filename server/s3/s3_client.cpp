#include "server/s3/s3_client.h"

#include <curl/curl.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cctype>
#include <functional>
#include <pugixml.hpp>
#include <random>
#include <thread>
#include <utility>

#include "server/base/service_codes.h"

namespace geodesic::server {

namespace {

constexpr int kMostRunning = 32;
constexpr int kMostWaiting = 32;
constexpr int kMostTries = 3;
constexpr std::chrono::seconds kRest(6);
constexpr std::chrono::milliseconds kPoll(20);

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

// Returns false once `stop` says so.
bool pause_before(int attempt, const std::function<bool()>& stop) {
  thread_local std::minstd_rand random(std::random_device{}());
  // 0.1 s, then 0.4 s, up to as much again: those who failed together do not return together.
  const int least = attempt == 1 ? 100 : 400;
  const auto end =
      std::chrono::steady_clock::now() +
      std::chrono::milliseconds(std::uniform_int_distribution(least, 2 * least)(random));
  while (std::chrono::steady_clock::now() < end) {
    if (stop && stop()) return false;
    std::this_thread::sleep_for(kPoll);
  }
  return true;
}

}  // namespace

// The right to send one request, and a handle for it.
class S3Client::Turn {
 public:
  static Result<Turn> take(S3Client& client, const S3Request& request) {
    std::unique_lock lock(client.mutex_);
    // A probe counts, but does not queue: it must tell of a storage that is too busy.
    if (!request.is_probe && client.running_ >= kMostRunning) {
      if (client.waiting_ >= kMostWaiting) {
        return fail(ServiceCode::store_unavailable,
                    "too many requests wait for the object store; try again");
      }
      ++client.waiting_;
      const auto end = Clock::now() + client.location_.timeout;
      bool is_stopped = false;
      const auto is_free = [&] { return client.running_ < kMostRunning; };
      while (!is_free() && !is_stopped && Clock::now() < end) {
        client.freed_.wait_for(lock, kPoll, is_free);
        is_stopped = !is_free() && request.stop && request.stop();
      }
      --client.waiting_;
      if (is_stopped) return fail(ErrorCode::cancelled, "stopped");
      if (!is_free()) {
        return fail(ServiceCode::store_unavailable, "the object store is too slow; try again");
      }
    }
    std::unique_ptr<S3Transfer> transfer;
    if (client.idle_.empty()) {
      transfer = std::make_unique<S3Transfer>();
    } else {
      transfer = std::move(client.idle_.back());
      client.idle_.pop_back();
    }
    ++client.running_;
    return Turn(client, std::move(transfer));
  }
  Turn(Turn&& other) noexcept = default;
  Turn& operator=(Turn&&) = delete;
  ~Turn() {
    if (!transfer_) return;
    {
      const std::lock_guard lock(client_.mutex_);
      client_.idle_.push_back(std::move(transfer_));
      --client_.running_;
    }
    client_.freed_.notify_one();
  }
  [[nodiscard]] S3Transfer& transfer() const { return *transfer_; }

 private:
  Turn(S3Client& client, std::unique_ptr<S3Transfer> transfer)
      : client_(client), transfer_(std::move(transfer)) {}
  S3Client& client_;
  std::unique_ptr<S3Transfer> transfer_;
};

S3Client::S3Client(S3Location location, std::string label)
    : location_(std::move(location)), label_(std::move(label)) {}

S3Client::~S3Client() = default;

Result<S3Reply> S3Client::send(const S3Request& request) {
  if (!request.is_probe) {
    if (const auto reason = why_resting()) return fail(ServiceCode::store_unavailable, *reason);
  }
  auto turn = Turn::take(*this, request);
  if (!turn) return fail(std::move(turn.error()));
  return send_with(turn->transfer(), request);
}

Result<S3Reply> S3Client::send_with(S3Transfer& transfer, const S3Request& request) {
  const auto digest = digest_of_body(request);
  if (!digest) return fail(digest.error());
  const Clock::time_point last_start = Clock::now() + location_.timeout;
  const bool is_once = request.is_probe || request.within.count() > 0 || request.open_file;
  for (int attempt = 1;; ++attempt) {
    const Clock::time_point begun = Clock::now();
    S3Transfer::Outcome result = transfer.run(location_, request, *digest);
    if (result.own_error) return fail(std::move(*result.own_error));
    const int status = result.reply.status;
    const bool again = attempt < kMostTries && !is_once && Clock::now() < last_start;
    if (result.curl_code != CURLE_OK) {
      spdlog::warn("{}: {} {}/{}: {}", label_, request.method, location_.url, request.key,
                   result.reason);
      if (again) {
        if (!pause_before(attempt, request.stop)) return fail(ErrorCode::cancelled, "stopped");
        continue;
      }
      const std::string reason =
          "the object store cannot be reached: " +
          std::string(curl_easy_strerror(static_cast<CURLcode>(result.curl_code)));
      rest(reason);
      return fail(ServiceCode::store_unavailable, reason);
    }
    if ((status >= 200 && status < 300) || status == 404) {
      end_rest(begun);
      return std::move(result.reply);
    }
    const std::string code = s3_code(result.reply.body);
    spdlog::warn("{}: {} {}/{}: {} {}", label_, request.method, location_.url, request.key, status,
                 code);
    const std::string reason =
        fmt::format("the object store answered {}{}{}", status, code.empty() ? "" : " ", code);
    if (is_later(status)) {
      if (again) {
        if (!pause_before(attempt, request.stop)) return fail(ErrorCode::cancelled, "stopped");
        continue;
      }
      if (request.within.count() > 0) rest(reason);
      return fail(ServiceCode::store_unavailable, reason);
    }
    end_rest(begun);
    const bool is_full = status == 507 || code == "QuotaExceeded" || code == "XMinioStorageFull";
    return fail(is_full ? ServiceCode::store_full : ServiceCode::store_failed, reason);
  }
}

std::optional<std::string> S3Client::why_resting() const {
  const std::lock_guard lock(mutex_);
  if (Clock::now() >= resting_until_) return std::nullopt;
  return resting_because_;
}

void S3Client::rest(const std::string& reason) {
  const std::lock_guard lock(mutex_);
  resting_since_ = Clock::now();
  resting_until_ = resting_since_ + kRest;
  resting_because_ = reason;
}

void S3Client::end_rest(Clock::time_point begun) {
  const std::lock_guard lock(mutex_);
  if (begun >= resting_since_) resting_until_ = {};
}

}  // namespace geodesic::server
