#include "server/http/message.h"

#include "server/http/head.h"
#include "server/http/problem.h"

namespace geodesic::server {

const std::string* HttpRequest::header(std::string_view name) const {
  for (const auto& [key, value] : headers) {
    if (equals_ignoring_case(key, name)) return &value;
  }
  return nullptr;
}

const std::string* HttpRequest::parameter(std::string_view name) const {
  for (const auto& [key, value] : query) {
    if (key == name) return &value;
  }
  return nullptr;
}

void HttpRequest::set_base_path(std::string base) {
  base_path = std::move(base);
  if (base_path.empty() || !path.starts_with(base_path)) return;
  if (std::string rest = path.substr(base_path.size()); rest.starts_with('/')) {
    path = std::move(rest);
  }
}

void HttpResponse::set_header(std::string name, std::string value) {
  std::erase_if(headers, [&](const NameValue& h) { return equals_ignoring_case(h.first, name); });
  headers.emplace_back(std::move(name), std::move(value));
}

void HttpResponse::set_body(std::string bytes, std::string type) {
  body = std::make_shared<const std::string>(std::move(bytes));
  content_type = std::move(type);
}

HttpResponse HttpResponse::problem(const Error& error, const HttpRequest& request, int status) {
  HttpResponse response;
  response.status = status != 0 ? status : http_status(error.code);
  response.set_body(to_problem_json(error, request, response.status),
                    std::string(kProblemMediaType));
  if (const int seconds = retry_after_seconds(error.code); seconds != 0) {
    response.set_header("Retry-After", std::to_string(seconds));
  }
  return response;
}

}  // namespace geodesic::server
