// The whole service, attacked over raw sockets: hostile bytes in ids, in every
// parameter and in bodies. Each gets a 4xx that says what is wrong and nothing of
// the inside, and the service answers as before.
#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "core/mesh/shapes.h"
#include "tests/server/edge/fixture.h"
#include "tests/server/routes/service_fixture.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

constexpr std::string_view secret = "a secret beside the store";

struct Attacked {
  Attacked() : service(folder.path() / "store", config()), server(options(), handler()) {
    std::ofstream(folder.path() / "secret") << secret;
    const Result<int> bound = server.start();
    REQUIRE(bound);
    port = *bound;
    id = service.upload(glb_of(shapes::icosphere(1)));
  }
  static Config config() {
    Config config;
    config.max_body_bytes = 1u << 20;
    config.max_json_bytes = 1u << 16;
    return config;
  }
  HttpOptions options() const {
    HttpOptions options = Edge::patient();
    options.max_body = [this](std::string_view method, std::string_view path) {
      return service.routes.max_body(method, path);
    };
    return options;
  }
  HttpHandler handler() {
    return [this](HttpRequest& request) { return service.routes.answer(request); };
  }

  // Sends a request; its reply must be a 4xx problem that gives nothing away.
  json check_refused(const std::string& bytes) {
    CAPTURE(bytes.substr(0, 300));
    RawClient client(port);
    client.send(bytes);
    const RawReply reply = client.receive();
    CHECK(reply.status >= 400);
    CHECK(reply.status < 500);
    for (const char* name : {"set-cookie", "server", "x-evil"}) {
      CHECK(reply.headers.count(name) == 0);
    }
    const std::string inside = folder.path().string();
    for (const std::string_view leak :
         {std::string_view(inside), secret, std::string_view("std::"), std::string_view(".cpp"),
          std::string_view("terminate"), std::string_view("root:")}) {
      CHECK(reply.body.find(leak) == std::string::npos);
    }
    const auto type = reply.headers.find("content-type");
    REQUIRE(type != reply.headers.end());
    CHECK(type->second == "application/problem+json");
    json problem = json::parse(reply.body, nullptr, false);
    REQUIRE(problem.is_object());
    CHECK(problem.value("status", 0) == reply.status);
    return problem;
  }
  // Of the one mesh there is.
  void check_unharmed() {
    RawClient client(port);
    client.send(test::get("/v1/meshes/" + id + "/distance?from=v:0&at=v:1"));
    CHECK(client.receive().status == 200);
    client.send(test::get("/v1/meshes"));
    CHECK(json::parse(client.receive().body)["meshes"].size() == 1);
    std::ifstream file(folder.path() / "secret");
    CHECK(std::string(std::istreambuf_iterator<char>(file), {}) == secret);
  }

  TemporaryFolder folder;
  Service service;
  HttpServer server;
  int port = 0;
  std::string id;
};

// Each query with what it needs at least, and all parameters it takes.
struct Query {
  const char* path;
  const char* needed;
  std::vector<const char*> parameters;
};
const std::vector<Query> queries{
    {"distance",
     "from=v:0",
     {"from", "method", "max", "at", "labels", "precision", "format", "attribute"}},
    {"distance", "from=curve:v:0;v:1", {"from", "at"}},
    {"path", "from=boundary&to=v:1", {"from", "to"}},
    {"path", "from=v:0&to=v:1", {"from", "to", "via", "method", "refine", "precision", "format"}},
    {"table",
     "from=v:0",
     {"from", "to", "method", "max", "stream", "sparse", "rows", "precision", "format"}},
    {"isolines", "from=v:0&count=2", {"from", "levels", "step", "count", "method", "format"}},
    {"samples", "count=3", {"count", "from", "format"}},
    {"measure", "from=v:0&radii=2", {"from", "radii", "method", "max", "precision", "format"}},
    {"extent", "of=center&fields=3", {"of", "fields", "method", "precision", "format"}},
    {"voronoi", "from=v:0&from=v:1", {"from", "relax", "part", "method", "precision", "format"}},
    {"loop",
     "at=v:0&normal=0,0,1",
     {"through", "around", "at", "normal", "hull", "method", "precision", "format"}},
    {"logmap", "from=v:0", {"from", "radius", "angle", "method", "precision", "format"}},
    {"nearest", "point=p:1,0,0", {"point", "format"}},
};

// As they stand in a URL.
const std::vector<std::string> hostile_values{
    "%00",
    "v:0%00",
    "v:%001",
    "%ff%fe",
    "\xff\xfe",
    "v:\xe0\xa5\xa7",      // a digit, but not of ASCII
    "\xef\xbd\x96:1",      // a wide v
    "%E2%80%AEv:1",        // written from the right
    "%F0%9F%92%A9",        // beyond the basic plane
    "%ED%A0%80",           // half a surrogate pair
    "%C0%AE%C0%AE%C0%AF",  // an overlong ../
    "..%2f..%2f..%2fsecret",
    "%0d%0aSet-Cookie:%20a=1",
    "v:0%0d%0aX-Evil:%201",
    "v:-1",
    "v:99999999999999999999",
    "v:0x0",
    "v:1e0",
    "v:+1",
    "v:",
    "p:nan,0,0",
    "p:1e999,0,0",
    "p:1,0",
    "f:0,nan,0.5",
    "f:0,1e308,1e308",
    "ray:0,0,0,0,0,0",
    "faces:0-99999999999999999999",
    "faces:18446744073709551615",
    "sphere:0,0,0,1e999",
    "box:0,0,0,-1,0,0",
    "v:0;v:1e9",
    "v:0;;v:1",
    "inside:v:0;v:1",
    "p:1e61,0,0;v:0",
    "part:%00%ff%1b[2J",
    "material:%E2%80%AE%0d%0aX-Evil:1",
    "material:%3Cscript%3E",
    "material:99999999999999999999",
    "2*material:%F0%90",
    "1e999*faces:0",
    "-1*faces:0",
    "2*faces:99999999",
    "0:1,0:1",
    "0:nan",
    "%7B%22vertex%22%3A0%7D",
    "%27%3B+DROP+TABLE+meshes",
    "%25s%25n%25x",
    "%3Cscript%3E",
    std::string(7000, 'v'),
    "v:" + std::string(7000, '9'),
};

}  // namespace

TEST_CASE("hostile bytes in any parameter are refused, and nothing leaks") {
  Attacked attacked;
  const std::string base = "/v1/meshes/" + attacked.id + "/";
  for (const Query& query : queries) {
    std::vector<const char*> parameters = query.parameters;
    parameters.insert(parameters.end(), {"within", "forbid", "walls", "weights", "face_weights",
                                         "slope", "steepest", "up"});
    for (const char* parameter : parameters) {
      for (const std::string& value : hostile_values) {
        attacked.check_refused(
            get(base + query.path + "?" + query.needed + "&" + parameter + "=" + value));
      }
    }
    for (const char* name :
         {"%00", "fr%00om", "%E2%80%AE", "from%5B%5D", "From", "..", "%0d%0aa"}) {
      attacked.check_refused(get(base + query.path + "?" + query.needed + "&" + name + "=1"));
    }
  }
  for (const char* parameter : {"limit", "cursor", "other"}) {
    for (const std::string& value : hostile_values) {
      attacked.check_refused(get("/v1/meshes?" + std::string(parameter) + "=" + value));
    }
  }
  attacked.check_unharmed();
}

TEST_CASE("hostile values in a JSON body are refused, and nothing leaks") {
  Attacked attacked;
  const std::string target = "/v1/meshes/" + attacked.id + "/distance";
  const auto ask = [&](const std::string& body) {
    attacked.check_refused(post(target, with_length(body), body));
  };
  for (const char* value : {R"("\u0000")",
                            R"("v:0\u0000")",
                            R"("\ud800")",
                            R"("v:\u0967")",
                            R"("\r\nX-Evil: 1")",
                            R"({"vertex":-1})",
                            R"({"vertex":1.5})",
                            R"({"vertex":1e400})",
                            R"({"vertex":"0"})",
                            R"({"vertex":null})",
                            R"({"vertex":[0]})",
                            R"({"vertex":18446744073709551616})",
                            R"({"face":0,"bary":[1]})",
                            R"({"xyz":[1,2]})",
                            R"({"xyz":["a","b","c"]})",
                            R"({"\u0000":1})",
                            R"({"ray":{}})",
                            R"([[[[0]]]])",
                            "null",
                            "true",
                            "{}"}) {
    ask(R"({"from":[)" + std::string(value) + "]}");
    ask(R"({"from":["v:0"],"at":[)" + std::string(value) + "]}");
    ask(R"({"from":["v:0"],"method":)" + std::string(value) + "}");
    ask(R"({"from":["v:0"],"max":)" + (value[0] == 'n' ? "\"nan\"" : std::string(value)) + "}");
  }
  ask("");
  ask("{");
  ask("\xff\xfe");
  ask(std::string("{\0}", 3));
  ask("{\"from\":[\"v:0\"]} trailing");
  ask("{\"from\":[\"\xff\"]}");
  ask(std::string(60'000, '['));
  ask("{\"from\":" + std::string(30'000, '[') + std::string(30'000, ']') + "}");
  ask("{\"max\":1" + std::string(60'000, '0') + "}");
  attacked.check_unharmed();
}

TEST_CASE("no id leads out of the store") {
  Attacked attacked;
  const std::vector<std::string> ids{
      "..",
      "%2e%2e",
      "..%2fsecret",
      "%2e%2e%2fsecret",
      "..%2f..%2f..%2f..%2fetc%2fpasswd",
      "%2fetc%2fpasswd",
      "..%5c..%5csecret",
      "....%2f%2fsecret",
      "%C0%AE%C0%AE%C0%AFsecret",
      "secret",
      "%00",
      attacked.id + "%00",
      attacked.id.substr(0, 63) + "%00",
      attacked.id + "~",
      attacked.id + "~..%2f..%2fsecret",
      attacked.id.substr(0, 63),
      attacked.id + "0",
      "%E2%80%AE" + attacked.id,
      std::string(64, 'g'),
      std::string(64, 'A'),
      std::string(64, '.'),
      std::string(64, '/'),
      std::string(8000, 'a'),
      "*",
      "%7e",
      "%0d%0aX-Evil:%201",
  };
  for (const std::string& id : ids) {
    for (const std::string method : {"GET", "DELETE", "PUT", "POST"}) {
      for (const std::string action : {"", "/source", "/distance?from=v:0", "/prepare"}) {
        attacked.check_refused(method + " /v1/meshes/" + id + action +
                               " HTTP/1.1\r\nHost: x\r\nContent-Length: 0\r\n\r\n");
      }
    }
  }
  for (const std::string target :
       {"/../secret", "/v1/../../secret", "/%2e%2e/secret", "/v1/meshes/../../secret", "//secret",
        "/.git/config", "/etc/passwd", "/v1/meshes//source", "/v1//meshes"}) {
    attacked.check_refused(get(target));
  }
  attacked.check_unharmed();
}

TEST_CASE("bombs of bytes are refused before they go off") {
  Attacked attacked;
  // Announced, in chunks, compressed, and compressed without saying so.
  CHECK(attacked.check_refused(post("/v1/meshes", "Content-Length: 1048577\r\n", ""))["limit"] ==
        1u << 20);
  const std::string chunk = "10000\r\n" + std::string(65536, 'x') + "\r\n";
  std::string chunks;
  for (int i = 0; i < 17; ++i) chunks += chunk;
  CHECK(attacked.check_refused(
            post("/v1/meshes", "Transfer-Encoding: chunked\r\n", chunks))["code"] == "too_large");
  CHECK(attacked.check_refused(post("/v1/meshes", "Transfer-Encoding: chunked\r\n",
                                    "7fffffffffffffff\r\n"))["code"] == "too_large");
  for (const char* coding : {"gzip", "deflate", "br", "zstd", "gzip, gzip", "x-gzip"}) {
    const json problem = attacked.check_refused(post(
        "/v1/meshes", "Content-Encoding: " + std::string(coding) + "\r\nContent-Length: 20\r\n",
        std::string("\x1f\x8b\x08\0", 4) + std::string(16, 'x')));
    CHECK(problem["status"] == 415);
  }
  const std::string gzip = std::string("\x1f\x8b\x08\0\0\0\0\0\0\x03", 10) + std::string(1000, 'x');
  CHECK(attacked.check_refused(post("/v1/meshes", with_length(gzip), gzip))["code"] ==
        "format_unknown");
  const std::string json_bomb(70'000, ' ');
  CHECK(attacked.check_refused(post("/v1/meshes/" + attacked.id + "/distance",
                                    with_length(json_bomb), json_bomb))["limit"] == 1u << 16);
  attacked.check_unharmed();
}
