// The whole service over HTTP with tokens on: every route with every scope, and
// with tokens that are missing, wrong or over.
#include <doctest/doctest.h>
#include <spdlog/sinks/base_sink.h>

#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "core/mesh/shapes.h"
#include "tests/server/edge/fixture.h"
#include "tests/server/routes/service_fixture.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

// Keeps what is logged, while it is told to. One of the log's sinks from the start: they
// may not change while others log.
class Recorder final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  std::string text() {
    const std::lock_guard lock(mutex_);
    return text_;
  }
  std::atomic<bool> on{false};

 private:
  void sink_it_(const spdlog::details::log_msg& message) override {
    if (on) text_.append(message.payload.data(), message.payload.size()).append("\n");
  }
  void flush_() override {}
  std::string text_;  // guarded by the base's mutex
};
const std::shared_ptr<Recorder> recorder = [] {
  auto sink = std::make_shared<Recorder>();
  spdlog::default_logger()->sinks().push_back(sink);
  return sink;
}();

struct Holder {
  const char* name;
  const char* scopes;  // null: not in the file
  const char* rest = "";
};
// The token of each is "geo_" and its name.
const std::vector<Holder> holders{
    {"reader", "read"},      {"uploader", "upload"},
    {"both", "read,upload"}, {"boss", "admin"},
    {"stranger", nullptr},   {"former", "admin", " expires=2020-01-01T00:00:00Z"}};

std::string bearer(std::string_view name) {
  return "Authorization: Bearer geo_" + std::string(name) + "\r\n";
}

struct Guarded {
  Guarded() : service(folder.path()), server(options(), handler()) {
    const Result<int> bound = server.start();
    REQUIRE(bound);
    port = *bound;
    id = service.upload(glb_of(shapes::icosphere(1)));
    std::string file;
    for (const Holder& holder : holders) {
      if (holder.scopes == nullptr) continue;
      file += std::string(holder.name) + " " + holder.scopes + " " +
              sha256_hex(std::string("geo_") + holder.name) + holder.rest + "\n";
    }
    auto tokens = Tokens::parse(file, "tokens");
    REQUIRE(tokens);
    service.routes.access().set_tokens(std::move(*tokens));
  }
  HttpOptions options() const {
    HttpOptions options = Edge::patient();
    options.max_body = [this](std::string_view method, std::string_view path) {
      return service.routes.max_body(method, path);
    };
    options.wants_body = [this](HttpRequest& request) {
      return service.routes.wants_body(request);
    };
    return options;
  }
  HttpHandler handler() {
    return [this](HttpRequest& request) { return service.routes.answer(request); };
  }
  RawReply ask(const std::string& method, const std::string& target, const std::string& headers,
               const std::string& body = "") const {
    RawClient client(port);
    client.send(method + " " + target + " HTTP/1.1\r\nHost: x\r\n" + headers +
                (body.empty() ? "" : with_length(body)) + "\r\n" + body);
    return client.receive(method == "HEAD");
  }

  TemporaryFolder folder;
  Service service;
  HttpServer server;
  int port = 0;
  std::string id;
};

struct RouteCase {
  std::string method;
  std::string target;
  Scopes needed;  // none: open
  std::string body;
};

std::vector<RouteCase> routes_of(const std::string& id) {
  const Scopes open;
  const Scopes read = Scope::read;
  const Scopes upload = Scope::upload;
  const Scopes admin = Scope::admin;
  const std::string mesh = "/v1/meshes/" + id;
  const std::string other = "/v1/meshes/" + std::string(64, '0');
  const std::string glb = glb_of(shapes::plane(3, 3));
  std::vector<RouteCase> cases{
      {"GET", "/", open, ""},
      {"GET", "/livez", open, ""},
      {"GET", "/readyz", open, ""},
      {"GET", "/openapi.yaml", open, ""},
      {"GET", "/openapi.json", open, ""},
      {"GET", "/docs/api/", open, ""},
      {"GET", "/v1/methods", open, ""},
      {"OPTIONS", "/v1/meshes", open, ""},
      {"OPTIONS", mesh, open, ""},
      {"GET", "/v1/status", read, ""},
      {"GET", "/v1/meshes", read, ""},
      {"GET", mesh, read, ""},
      {"HEAD", mesh, read, ""},
      {"HEAD", other, read, ""},
      {"GET", mesh + "/source", read, ""},
      {"GET", mesh + "/geometry", read, ""},
      {"POST", mesh + "/prepare", read, ""},
      {"POST", mesh + "/batch", read, "{\"query\":\"path\",\"from\":\"v:0\",\"to\":\"v:1\"}\n"},
      {"GET", "/v1/jobs/none", read | upload, ""},
      {"DELETE", "/v1/jobs/none", read | upload, ""},
      {"GET", "/nothing", read, ""},
      {"SEARCH", mesh, read, ""},
      {"PATCH", mesh, upload, R"({"name":"a"})"},
      {"POST", "/v1/meshes", upload, glb},
      {"PUT", "/v1/meshes/" + sha256_hex(glb), upload, glb},
      {"PUT", other, upload, "not a mesh"},
      {"DELETE", other, admin, ""},
      {"GET", "/metrics", admin, ""},
      {"GET", "/debug/cache", admin, ""},
      {"HEAD", "/debug/anything", admin, ""}};
  for (const auto& [query, parameters, body] : std::vector<std::array<std::string, 3>>{
           {"distance", "from=v:0", R"({"from":"v:0"})"},
           {"path", "from=v:0&to=v:1", R"({"from":"v:0","to":"v:1"})"},
           {"table", "from=v:0", R"({"from":"v:0"})"},
           {"isolines", "from=v:0&count=2", R"({"from":"v:0","count":2})"},
           {"samples", "count=2", R"({"count":2})"},
           {"trace", "from=v:0&direction=1,0,0&length=1",
            R"({"from":"v:0","direction":[1,0,0],"length":1})"},
           {"measure", "from=v:0&radii=1", R"({"from":"v:0","radii":1})"},
           {"extent", "of=mean&fields=1", R"({"of":"mean","fields":1})"},
           {"voronoi", "from=v:0&relax=1", R"({"from":"v:0","relax":1})"},
           {"loop", "through=v:0&through=v:5", R"({"through":["v:0","v:5"]})"},
           {"distance", "from=boundary", R"({"from":{"boundary":"all"}})"},
           {"samples", "count=1&forbid=faces:0", R"({"count":1,"forbid":"faces:0"})"},
           {"samples", "count=1&walls=v:0;v:5", R"({"count":1,"walls":"v:0;v:5"})"},
           {"path", "from=v:0&to=v:1&weights=2*faces:0",
            R"({"from":"v:0","to":"v:1","weights":"2*faces:0"})"},
           {"logmap", "from=v:0", R"({"from":"v:0"})"},
           {"nearest", "point=v:0", R"({"point":"v:0"})"}}) {
    cases.push_back({"GET", mesh + "/" + query + "?" + parameters, read, ""});
    cases.push_back({"POST", mesh + "/" + query, read, body});
  }
  return cases;
}

void check_refused(const RouteCase& route, const RawReply& reply, int status,
                   const std::string& challenge) {
  CHECK(reply.status == status);
  const auto header = reply.headers.find("www-authenticate");
  REQUIRE(header != reply.headers.end());
  CHECK(header->second == challenge);
  if (route.method == "HEAD") return;
  const json problem = json::parse(reply.body, nullptr, false);
  REQUIRE(problem.is_object());
  CHECK(problem.value("code", "") == (status == 401 ? "unauthorized" : "forbidden"));
  CHECK(reply.body.find("geo_") == std::string::npos);
}

}  // namespace

TEST_CASE("every route asks for its scope, and for nothing more") {
  const Guarded guarded;
  const std::string plain = R"(Bearer realm="geodesicd")";
  for (const RouteCase& route : routes_of(guarded.id)) {
    CAPTURE(route.method);
    CAPTURE(route.target);
    const RawReply without = guarded.ask(route.method, route.target, "", route.body);
    if (route.needed.empty()) {
      CHECK(without.status < 300);
    } else {
      check_refused(route, without, 401, plain);
    }
    for (const Holder& holder : holders) {
      CAPTURE(holder.name);
      const RawReply reply =
          guarded.ask(route.method, route.target, bearer(holder.name), route.body);
      const bool is_valid = holder.scopes != nullptr && *holder.rest == '\0';
      if (route.needed.empty()) {
        CHECK(reply.status < 300);  // whatever token comes with it
      } else if (!is_valid) {
        check_refused(route, reply, 401, plain + R"(, error="invalid_token")");
      } else if (parse_scopes(holder.scopes)->satisfy(route.needed)) {
        CHECK(reply.status != 401);
        CHECK(reply.status != 403);
        CHECK(reply.headers.count("www-authenticate") == 0);
      } else {
        const std::string scopes = format_scopes(route.needed);
        check_refused(route, reply, 403,
                      plain + R"(, error="insufficient_scope", scope=")" +
                          scopes.substr(0, scopes.find(',')) + "\"");
      }
    }
  }
}

TEST_CASE("what is refused has no effect, what is allowed has") {
  const Guarded guarded;
  const std::string glb = glb_of(shapes::plane(4, 3));
  const std::string target = "/v1/meshes/" + sha256_hex(glb);
  for (const char* name : {"reader", "stranger", "former"}) {
    CAPTURE(name);
    CHECK(guarded.ask("POST", "/v1/meshes", bearer(name), glb).status >= 401);
    CHECK(guarded.ask("PUT", target, bearer(name), glb).status >= 401);
    CHECK(guarded.service.store->size() == 1);
  }
  CHECK(guarded.ask("POST", "/v1/meshes", bearer("uploader"), glb).status == 201);
  CHECK(guarded.service.store->size() == 2);
  for (const char* name : {"reader", "uploader", "both", "stranger", "former"}) {
    CAPTURE(name);
    CHECK(guarded.ask("DELETE", target, bearer(name)).status >= 401);
    CHECK(guarded.service.store->size() == 2);
  }
  CHECK(guarded.ask("DELETE", target, bearer("boss")).status == 204);
  CHECK(guarded.service.store->size() == 1);
}

TEST_CASE("with tokens on, no shared cache may keep a reply") {
  Guarded guarded;
  const std::string mesh = "/v1/meshes/" + guarded.id;
  const std::vector<std::string> targets{mesh + "/source", mesh + "/geometry",
                                         mesh + "/distance?from=v:0",
                                         mesh + "/path?from=v:0&to=v:1&format=f32"};
  const auto policy = [&](const std::string& target) {
    const RawReply reply = guarded.ask("GET", target, bearer("reader"));
    CHECK(reply.status == 200);
    const std::string kept = reply.headers.at("cache-control");
    // What one token was shown is not what another is to be shown.
    const auto vary = reply.headers.find("vary");
    const bool by_token =
        vary != reply.headers.end() && vary->second.find("Authorization") != std::string::npos;
    CHECK(by_token == kept.starts_with("private"));
    return kept;
  };
  for (const std::string& target : targets) CHECK(policy(target).starts_with("private, max-age="));
  for (const std::string& target : targets) policy(target);  // kept replies too
  for (const char* target : {"/v1/meshes", "/v1/status"}) {
    CHECK(policy(target).find("public") == std::string::npos);
  }
  CHECK(guarded.ask("GET", mesh, "").headers.at("cache-control") == "no-store");
  guarded.service.routes.access().set_tokens(std::nullopt);
  for (const std::string& target : targets) CHECK(policy(target).starts_with("public, max-age="));
}

TEST_CASE("a token in the URL, in a cookie or in a body is none") {
  const Guarded guarded;
  for (const char* parameter : {"token", "access_token", "Authorization", "bearer"}) {
    CAPTURE(parameter);
    const std::string target = std::string("/v1/status?") + parameter + "=geo_boss";
    const RawReply reply = guarded.ask("GET", target, "");
    CHECK(reply.status == 401);
    CHECK(reply.headers.at("www-authenticate") == R"(Bearer realm="geodesicd")");
  }
  CHECK(guarded.ask("GET", "/v1/status", "Cookie: access_token=geo_boss\r\n").status == 401);
  CHECK(guarded
            .ask("POST", "/v1/meshes/" + guarded.id + "/distance",
                 "Content-Type: application/x-www-form-urlencoded\r\n", "access_token=geo_boss")
            .status == 401);
  CHECK(guarded.ask("GET", "/v1/status", bearer("boss") + bearer("boss")).status == 401);
}

TEST_CASE("a body that may not be sent is not waited for") {
  const Guarded guarded;
  // Only the head comes: an answer means that nobody waits for the rest.
  for (const std::string& head :
       {std::string("Content-Length: 100000000\r\n"), std::string("Transfer-Encoding: chunked\r\n"),
        "Content-Length: 100\r\nExpect: 100-continue\r\n" + bearer("reader")}) {
    CAPTURE(head);
    RawClient client(guarded.port);
    client.send("POST /v1/meshes HTTP/1.1\r\nHost: x\r\n" + head + "\r\n");
    const RawReply reply = client.receive();
    CHECK((reply.status == 401 || reply.status == 403));
    CHECK(reply.headers.at("connection") == "close");
    client.half_close();
    CHECK(client.ends());
  }
  CHECK(guarded.server.stats().body_bytes == 0);
}

TEST_CASE("the log names who was refused, and holds no token") {
  const Guarded guarded;
  const auto level = spdlog::get_level();
  recorder->on = true;
  spdlog::set_level(spdlog::level::trace);
  CHECK(guarded.ask("GET", "/v1/status", bearer("reader")).status == 200);
  CHECK(guarded.ask("GET", "/v1/status", bearer("stranger")).status == 401);
  CHECK(guarded.ask("GET", "/metrics?token=geo_boss", bearer("reader")).status == 403);
  CHECK(guarded.ask("GET", "/v1/status?token=geo_boss", "").status == 401);
  CHECK(guarded.ask("DELETE", "/v1/meshes/x%0aforged", bearer("uploader")).status == 403);
  // The line of a request is written after its reply is sent.
  const auto lines_of_requests = [] {
    const std::string text = recorder->text();
    int count = 0;
    for (std::size_t at = 0; (at = text.find(" bytes ", at)) != text.npos; ++at) ++count;
    return count;
  };
  for (int i = 0; i < 2000 && lines_of_requests() < 5; ++i) std::this_thread::sleep_for(5ms);
  CHECK(lines_of_requests() == 5);
  spdlog::set_level(level);
  recorder->on = false;
  const std::string log = recorder->text();
  CHECK(log.find("geo_") == std::string::npos);
  CHECK(log.find("Bearer TOKEN") != std::string::npos);
  CHECK(log.find("refused GET /metrics: the token lacks the scope 'admin' (token reader)") !=
        std::string::npos);
  CHECK(log.find("/v1/meshes/x\\x0aforged") != std::string::npos);
}

TEST_CASE("a listener of its own for operators asks for no token") {
  Guarded guarded;
  HttpServer admin(Edge::patient(), [&](HttpRequest& request) {
    return guarded.service.routes.answer_admin(request);
  });
  const Result<int> port = admin.start();
  REQUIRE(port);
  for (const char* path : {"/livez", "/readyz", "/metrics", "/debug/cache"}) {
    CAPTURE(path);
    RawClient client(*port);
    client.send(get(path));
    CHECK(client.receive().status == 200);
  }
  RawClient client(*port);
  client.send(get("/v1/meshes"));
  CHECK(client.receive().status == 404);  // and it has nothing of the API's
}

TEST_CASE("tokens that change while requests come are the old ones or the new ones") {
  Guarded guarded;
  const auto tokens = [](std::string_view name) {
    auto parsed = Tokens::parse(std::string(name) + " read " + sha256_hex("geo_same"), "tokens");
    REQUIRE(parsed);
    return std::move(*parsed);
  };
  guarded.service.routes.access().set_tokens(tokens("first"));
  std::atomic<bool> over{false};
  std::atomic<int> answered{0};
  std::vector<std::thread> clients;
  std::atomic<int> wrong{0};
  for (int i = 0; i < 3; ++i) {
    clients.emplace_back([&] {
      while (!over) {
        const HttpResponse reply =
            guarded.service.ask("GET", "/v1/meshes", "", {{"Authorization", "Bearer geo_same"}});
        wrong += reply.status != 200;
        ++answered;
      }
    });
  }
  for (int i = 0; i < 200 || answered < 50; ++i) {
    guarded.service.routes.access().set_tokens(tokens(i % 2 == 0 ? "second" : "first"));
    std::this_thread::yield();
  }
  over = true;
  for (std::thread& client : clients) client.join();
  CHECK(wrong == 0);
}
