#include "server/edge/reply_head.h"

#include <algorithm>
#include <ctime>

#include "server/http/head.h"

namespace geodesic::server {
namespace {

bool is_unfit_for_header(char c) {
  return (static_cast<unsigned char>(c) < 0x20 && c != '\t') || c == 0x7f;
}

}  // namespace

const std::string& without_controls(const std::string& text, std::string& spare) {
  if (std::none_of(text.begin(), text.end(), is_unfit_for_header)) return text;
  spare = text;
  std::erase_if(spare, is_unfit_for_header);
  return spare;
}

bool is_of_edge(std::string_view name) {
  for (const std::string_view ours : {"Content-Length", "Content-Type", "Transfer-Encoding",
                                      "Connection", "Keep-Alive", "Date", "X-Request-Id"}) {
    if (equals_ignoring_case(name, ours)) return true;
  }
  return false;
}

const std::string& http_date() {
  thread_local std::time_t known = 0;
  thread_local std::string date;
  const std::time_t now = std::time(nullptr);
  if (now != known || date.empty()) {
    std::tm utc{};
    ::gmtime_r(&now, &utc);
    char text[64];
    date.assign(text, std::strftime(text, sizeof text, "%a, %d %b %Y %H:%M:%S GMT", &utc));
    known = now;
  }
  return date;
}

std::string_view reason_of(int status) {
  constexpr int kClientClosedRequest = 499;  // nginx's
  return status == kClientClosedRequest ? " Client Closed Request\r\n" : kWordless;
}

}  // namespace geodesic::server
