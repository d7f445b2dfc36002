// What a reload changes in a running service, what it leaves for a restart, and
// that one which fails changes nothing.
#include "server/program/reload.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <latch>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "server/base/service_codes.h"
#include "tests/fixtures/wait_until.h"
#include "tests/server/edge/fixture.h"
#include "tests/server/routes/service_fixture.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;

namespace {

using Names = std::vector<std::string>;

Environment nothing_set() {
  return [](const std::string&) -> std::optional<std::string> { return {}; };
}

// A service that was started with `written` as its file, and is told to read it again.
struct Reloadable {
  explicit Reloadable(const std::string& written,
                      std::vector<std::string> flags = {"--log-level=off"})
      : flags_(std::move(flags)) {
    flags_.insert(flags_.end(), {"--config", path("config")});
    write("config", written);
    const auto command = read_config(flags_, nothing_set());
    REQUIRE(command);
    service.emplace(folder.path() / "store", command->config);
    reload.emplace(
        command->config, [this] { return read_config(flags_, nothing_set()); }, nothing_set(),
        Reload::Parts{
            service->routes, service->catalog, service->queries, service->pool, {}, nullptr});
  }
  ~Reloadable() { spdlog::set_level(spdlog::level::off); }

  [[nodiscard]] std::string path(const std::string& name) const {
    return (folder.path() / name).string();
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(path(name)) << text;
  }
  Reload::Outcome with(const std::string& written) {
    write("config", written);
    auto outcome = reload->run();
    REQUIRE(outcome);
    return std::move(*outcome);
  }
  std::string refusal(const std::string& written) {
    write("config", written);
    const auto outcome = reload->run();
    REQUIRE_FALSE(outcome);
    return outcome.error().detail;
  }
  json status() { return body_of(service->get("/v1/status")); }

  TemporaryFolder folder;
  std::optional<Service> service;
  std::optional<Reload> reload;

 private:
  std::vector<std::string> flags_;
};

}  // namespace

TEST_CASE("limits, budgets and the log's level follow the file") {
  Reloadable process(R"({"field-cache-bytes": "3MiB", "log-level": "off"})", {});
  const auto same = process.with(R"({"log-level": "off", "field-cache-bytes": 3145728})");
  CHECK(same.changed.empty());  // the same bytes, written otherwise
  CHECK(same.waiting.empty());
  CHECK(same.warnings.empty());

  const auto outcome = process.with(R"({
    "field-cache-bytes": "1MiB", "mesh-cache-bytes": 5000, "adjacency-cache-bytes": 6000,
    "max-body-bytes": "7KiB", "max-json-bytes": 800, "max-vertices": 90, "max-faces": 1000,
    "queue": 11, "body-timeout-seconds": 12, "log-level": "error"})");
  CHECK(outcome.changed == Names{"queue", "max-body-bytes", "max-json-bytes", "max-vertices",
                                 "max-faces", "mesh-cache-bytes", "adjacency-cache-bytes",
                                 "field-cache-bytes", "body-timeout-seconds", "log-level"});
  CHECK(outcome.waiting.empty());
  const json status = process.status();
  CHECK(status["caches"]["meshes"]["budget"] == 5000);
  CHECK(status["caches"]["adjacency"]["budget"] == 6000);
  CHECK(status["caches"]["fields"]["budget"] == 1u << 20);
  CHECK(status["limits"]["max_body_bytes"] == 7168);
  CHECK(status["limits"]["max_json_bytes"] == 800);
  CHECK(status["limits"]["max_vertices"] == 90);
  CHECK(status["limits"]["queue"] == 11);
  CHECK(status["limits"]["body_timeout_seconds"] == 12);
  CHECK(process.service->routes.max_body("POST", "/v1/meshes") == 7168);
  CHECK(process.service->routes.max_body("POST", "/v1/meshes/x/path") == 800);
  CHECK(spdlog::get_level() == spdlog::level::err);
  CHECK(process.reload->config()->max_faces == 1000);

  // 10 x 10 vertices are over the new limit, and under it once the option is gone.
  const std::string glb = glb_of(shapes::plane(10, 10));
  CHECK(process.service->ask("POST", "/v1/meshes", glb).status == 422);
  CHECK(process.with(R"({"log-level": "off"})").changed.size() == 10);
  CHECK(process.service->ask("POST", "/v1/meshes", glb).status == 201);
}

TEST_CASE("a flag still beats the file when it is read again") {
  Reloadable process(R"({"queue": 10})", {"--max-json-bytes", "900", "--log-level=off"});
  const auto outcome = process.with(R"({"queue": 9, "max-json-bytes": 100})");
  CHECK(outcome.changed == Names{"queue"});
  CHECK(process.status()["limits"]["max_json_bytes"] == 900);
}

TEST_CASE("what cannot change while it runs waits for a restart, and is said each time") {
  Reloadable process(R"({"io-threads": 8, "queue": 20})");
  for (int i = 0; i < 2; ++i) {
    const auto outcome =
        process.with(R"({"io-threads": 9, "listen": "127.0.0.1:1", "samples": "x", "queue": 20})");
    CHECK(outcome.changed.empty());
    CHECK(outcome.waiting == Names{"listen", "samples", "io-threads"});
    CHECK(process.reload->config()->io_threads == 8);
  }
  // There are threads for as many as could wait at the start.
  auto outcome = process.with(R"({"io-threads": 8, "queue": 300})");
  CHECK(outcome.changed.empty());
  CHECK(outcome.waiting == Names{"queue"});
  CHECK(process.status()["limits"]["queue"] == 20);
  outcome = process.with(R"({"io-threads": 8, "queue": 5})");
  CHECK(outcome.changed == Names{"queue"});
  CHECK(outcome.waiting.empty());
  outcome = process.with(R"({"io-threads": 8, "queue": 300})");
  CHECK(outcome.changed == Names{"queue"});
  CHECK(outcome.waiting == Names{"queue"});
  CHECK(process.status()["limits"]["queue"] == 20);
}

TEST_CASE("a reload that fails changes nothing, and says why") {
  const std::string good = "ann read " + sha256_hex("geo_a") + "\n";
  Reloadable process("{}");
  process.write("tokens", good);
  const std::string tokens = R"("tokens": ")" + process.path("tokens") + "\"";
  CHECK(process.with("{" + tokens + R"(, "queue": 30})").changed == Names{"tokens", "queue"});
  const auto check_as_before = [&] {
    CHECK(process.service->get("/v1/status").status == 401);
    const auto reply =
        process.service->ask("GET", "/v1/status", "", {{"Authorization", "Bearer geo_a"}});
    REQUIRE(reply.status == 200);
    CHECK(body_of(reply)["limits"]["queue"] == 30);
    CHECK(process.reload->config()->queue == 30);
  };
  check_as_before();
  CHECK(process.refusal("{").find("is not a JSON object") != std::string::npos);
  check_as_before();
  CHECK(process.refusal(R"({"queue": 7, "max-vertices": 0})").find("max-vertices: at least 1") !=
        std::string::npos);
  check_as_before();
  CHECK(process.refusal(R"({"queue": 7, "store": "s3://"})").find("store: ") != std::string::npos);
  check_as_before();
  CHECK(process.refusal(R"({"queue": 7, "tls-cert": "none", "tls-key": "none"})").find("none") !=
        std::string::npos);
  check_as_before();
  process.write("tokens", good + "bob reads " + sha256_hex("geo_b") + "\n");
  CHECK(process.refusal("{" + tokens + R"(, "queue": 7})").find("tokens:2: the second field") !=
        std::string::npos);
  check_as_before();
}

TEST_CASE("tokens are switched on, replaced and switched off") {
  Reloadable process("{}");
  const auto status_of = [&](const std::string& token) {
    return process.service->ask("GET", "/v1/status", "", {{"Authorization", "Bearer " + token}})
        .status;
  };
  const std::string config = R"({"tokens": ")" + process.path("tokens") + "\"}";
  CHECK(status_of("geo_a") == 200);
  process.write("tokens", "ann read " + sha256_hex("geo_a"));
  process.with(config);
  CHECK(process.service->routes.access().is_on());
  CHECK(status_of("geo_a") == 200);
  CHECK(status_of("geo_b") == 401);
  process.write("tokens", "ann read " + sha256_hex("geo_b"));
  CHECK(process.with(config).changed.empty());  // the option has not; its file is read all the same
  CHECK(status_of("geo_a") == 401);
  CHECK(status_of("geo_b") == 200);
  const auto off = process.with("{}");
  CHECK(off.changed == Names{"tokens"});
  CHECK(off.warnings == Names{"no token is asked for any more"});
  CHECK(status_of("geo_a") == 200);
}

TEST_CASE("a shorter queue refuses the next, and keeps those that wait") {
  ComputePool pool(1, 8);
  std::latch running(1);
  std::latch go_on(1);
  std::atomic<int> done{0};
  const auto job = [&](Worker&) -> Result<int> {
    ++done;
    return 1;
  };
  std::thread first([&] {
    (void)pool.run([&](Worker& worker) {
      running.count_down();
      go_on.wait();
      return job(worker);
    });
  });
  running.wait();
  std::thread second([&] { (void)pool.run(job); });
  fixtures::wait_until([&] { return pool.stats().queued != 0; });
  pool.set_limits({0, 0, std::chrono::milliseconds(0)});
  const auto refused = pool.run(job);
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ServiceCode::overloaded);
  go_on.count_down();
  first.join();
  second.join();
  CHECK(done == 2);
}

TEST_CASE("a smaller cache lets go of what it no longer has room for") {
  Reloadable process("{}");
  const std::string mesh =
      "/v1/meshes/" + process.service->upload(glb_of(shapes::plane(20, 20))) + "/distance?from=v:0";
  CHECK(process.service->get(mesh).status == 200);
  CHECK(process.service->queries.field_cache().entries == 1);
  CHECK(process.service->catalog.adjacency_cache().entries == 1);
  process.with(R"({"field-cache-bytes": 0, "adjacency-cache-bytes": 0, "mesh-cache-bytes": 0})");
  CHECK(process.service->queries.field_cache().entries == 0);
  CHECK(process.service->catalog.adjacency_cache().entries == 0);
  CHECK(process.service->catalog.mesh_cache().entries == 0);
  CHECK(process.service->get(mesh).status == 200);  // what is gone comes back from the store
}

TEST_CASE("connections that idle from now on have the new patience") {
  Edge edge;  // a minute
  RawClient client(edge.port);
  client.send(get("/x"));
  CHECK(client.receive().status == 200);
  edge.server.set_patience({50ms, 60s, 0});
  client.send(get("/x"));
  CHECK(client.receive().status == 200);
  CHECK(client.ends());  // long before the minute is over
}

TEST_CASE("bodies from now on have the new patience") {
  Edge edge;
  edge.server.set_patience({60s, 50ms, 0});
  RawClient client(edge.port);
  client.send("POST /x HTTP/1.1\r\nHost: x\r\nContent-Length: 10\r\n\r\nhalf");
  CHECK(client.receive().status == 408);
}

TEST_CASE("requests go on while settings are replaced under them") {
  Reloadable process("{}");
  const std::string id = process.service->upload(glb_of(shapes::plane(6, 6)));
  std::atomic<bool> over{false};
  std::atomic<int> answered{0};
  std::atomic<int> wrong{0};
  std::vector<std::thread> clients;
  for (int i = 0; i < 3; ++i) {
    clients.emplace_back([&, i] {
      for (int k = 0; !over; ++k) {
        const std::string from = std::to_string((k + i) % 36);
        wrong +=
            process.service->get("/v1/meshes/" + id + "/distance?from=v:" + from).status != 200;
        wrong += process.service->get("/v1/status").status != 200;
        (void)process.service->routes.max_body("POST", "/v1/meshes");
        ++answered;
      }
    });
  }
  for (int i = 0; i < 30 || answered < 30; ++i) {
    process.with(i % 2 == 0 ? R"({"queue": 200, "mesh-cache-bytes": 0, "field-cache-bytes": 0})"
                            : R"({"queue": 100, "max-vertices": 1000})");
  }
  over = true;
  for (std::thread& client : clients) client.join();
  CHECK(wrong == 0);
}
