// Many queries in one request, each a line of JSON (NDJSON): answered in their order,
// line by line as they are done.
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "proto/wire/input_codes.h"
#include "proto/wire/parameters.h"
#include "server/http/problem.h"
#include "server/routes/call.h"
#include "server/routes/request_deadline.h"
#include "server/routes/routes.h"

namespace geodesic::server {
namespace {

constexpr const char* kMediaType = "application/x-ndjson";

// The next line of a body that is not blank, from `done` on; none at its end.
bool next_line(std::string_view body, std::size_t& done, std::string_view& line) {
  while (done < body.size()) {
    const std::size_t end = body.find('\n', done);
    line = body.substr(done, end == body.npos ? body.npos : end - done);
    done = end == body.npos ? body.size() : end + 1;
    if (line.find_first_not_of(" \t\r") != line.npos) return true;
  }
  return false;
}

// A batch under way: its lines, and how far it has come.
struct Batch {
  std::string mesh;
  std::string body;
  HttpRequest request;                   // for whom: without its body
  std::size_t done = 0;                  // bytes of the body
  bool is_over = false;                  // before its end
  std::shared_ptr<const void> reserved;  // for the reply of the last line, until it is sent

  [[nodiscard]] double part_done() const {
    return static_cast<double>(done) / static_cast<double>(body.size());
  }

  bool next(std::string_view& line) { return next_line(body, done, line); }
};

// {"id":…,"status":200,"reply":{…}} or {"id":…,"status":422,"problem":{…}}
std::string reply_line(const std::optional<std::string>& id, int status, const char* key,
                       std::string_view json) {
  std::string line = "{";
  if (id) line += "\"id\":" + *id + ",";
  line += "\"status\":" + std::to_string(status) + ",\"" + key + "\":";
  line += json;
  line += "}\n";
  return line;
}

std::string problem_line(const std::optional<std::string>& id, const Error& error,
                         const HttpRequest& request) {
  const int status = http_status(error.code);
  return reply_line(id, status, "problem", to_problem_json(error, request, status));
}

// Those that will be answered.
std::size_t lines_of(std::string_view body) {
  std::size_t lines = 0;
  std::string_view line;
  for (std::size_t done = 0; next_line(body, done, line);) ++lines;
  return lines;
}

}  // namespace

HttpResponse Routes::batch(Call& call) {
  auto parameters = proto::Parameters::from_query(call.request.query);
  auto hurried = with_deadline(call.request.caller, parameters);
  if (!hurried) return call.problem(hurried.error());
  if (const auto known = parameters.check_all_known(); !known) {
    return call.problem(Error{InputCode::unknown_parameter,
                              "parameters of a batch are in its lines, but for deadline_ms",
                              known.error().parameter,
                              {},
                              {}});
  }
  if (const std::size_t lines = lines_of(call.request.body); lines > kMaxBatchLines) {
    return call.problem(
        Error{ErrorCode::too_large, "too many lines in one batch", "body", kMaxBatchLines, lines});
  }
  // While the reply has not begun, an unknown mesh can still be told by its status.
  if (auto metadata = catalog_.metadata(call.id, call.request.caller); !metadata) {
    return call.problem(metadata.error());
  }
  auto batch = std::make_shared<Batch>();
  batch->mesh = call.id;
  batch->body = std::move(call.request.body);
  batch->request = call.request;
  batch->request.caller = std::move(*hurried);
  HttpResponse response;
  response.content_type = kMediaType;
  response.set_header("Cache-Control", "no-store");
  response.stream = [this, batch](std::string& chunk) {
    // Who asks for the next line has sent the last one.
    batch->reserved.reset();
    std::string_view text;
    const double begin = batch->part_done();
    if (batch->is_over || !batch->next(text)) return false;
    if (batch->request.caller()) {
      // The rest has no answers; why, is the last line.
      batch->is_over = true;
      chunk = problem_line(std::nullopt, batch->request.caller.why_stopped(), batch->request);
      return true;
    }
    const Caller caller = batch->request.caller.part(begin, batch->part_done());
    chunk = answer_line(batch->mesh, text, batch->request, caller, batch->reserved);
    return true;
  };
  return response;
}

// {"id":…, "query":"path", …}: the rest are the query's parameters.
std::string Routes::answer_line(const std::string& mesh, std::string_view text,
                                const HttpRequest& request, const Caller& caller,
                                std::shared_ptr<const void>& reserved) {
  std::optional<std::string> id;
  const auto answer = [&]() -> Result<HttpResponse> {
    const auto memory = memory_for_json(text.size(), caller);
    if (!memory) return fail(memory.error());
    auto parameters = proto::Parameters::from_json(text);
    if (!parameters) return fail(std::move(parameters.error()));
    auto given = parameters->scalar("id");
    if (!given) return fail(std::move(given.error()));
    id = std::move(*given);
    const auto action = parameters->text("query");
    if (!action) return fail(action.error());
    if (!*action || !is_query(**action)) {
      return fail(InputCode::bad_syntax, "each line names its query, such as \"path\"", "query");
    }
    return answer_any_query({mesh, **action, *parameters, nullptr, caller, nullptr, nullptr, true});
  };
  const auto found = answer();
  if (found) {
    reserved = found->reserved;
    return reply_line(id, found->status, "reply", *found->body);
  }
  return problem_line(id, found.error(), request);
}

}  // namespace geodesic::server
