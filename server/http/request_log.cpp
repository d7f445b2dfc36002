#include "server/http/request_log.h"

#include <spdlog/spdlog.h>

#include <random>

namespace geodesic::server {

bool is_sane_request_id(std::string_view id) {
  constexpr std::string_view kAllowed =
      "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ._-";
  return !id.empty() && id.size() <= 64 && id.find_first_not_of(kAllowed) == std::string_view::npos;
}

std::string make_request_id() {
  thread_local std::mt19937_64 random = [] {
    std::random_device device;
    std::seed_seq seed{device(), device(), device(), device()};
    return std::mt19937_64(seed);
  }();
  return fmt::format("{:016x}", random());
}

std::string for_log(std::string_view text) {
  constexpr std::size_t kMaxBytes = 200;
  std::string out;
  for (const char c : text.substr(0, kMaxBytes)) {
    if (c > ' ' && c < 0x7f && c != '"' && c != '\\') {
      out += c;
    } else {
      out += fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
    }
  }
  if (text.size() > kMaxBytes) out += "...";
  return out.empty() ? "-" : out;
}

void log_request(const HttpRequest& request, std::string_view route, int status,
                 std::uint64_t bytes_sent, double milliseconds, bool all_sent) {
  if (!spdlog::should_log(spdlog::level::info)) return;
  spdlog::info("{} {} {} {} {} {} bytes {:.1f} ms{}", request.id, for_log(request.remote),
               for_log(request.method), for_log(route.empty() ? request.target : route), status,
               bytes_sent, milliseconds, all_sent ? "" : " (not all sent)");
}

}  // namespace geodesic::server
