// Faces by the labels of their corners in an attribute of the file: a query about a label is what
// it is about the numbers of its faces.
#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <future>
#include <map>
#include <random>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "server/base/process_usage.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/sanitizers.h"
#include "tests/fixtures/test_seed.h"
#include "tests/fixtures/wait_until.h"
#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using geodesic::fixtures::RandomMesh;
using geodesic::fixtures::test_seed;
using geodesic::fixtures::wait_until;

namespace {

constexpr const char* kAttribute = "_GEODESIC_SOURCE";

// A mesh whose file has for each vertex the number of the nearest of some vertices.
struct Labelled {
  std::string base;
  std::map<int, std::vector<std::uint32_t>> faces;  // by label
};

Labelled labelled(PlaneService& plane, const TriangleSoup& soup,
                  const std::vector<std::uint32_t>& sources) {
  json asked{{"from", json::array()}, {"labels", true}, {"method", "dijkstra"}};
  for (const std::uint32_t v : sources) asked["from"].push_back("v:" + std::to_string(v));
  const std::string bare = plane.add(soup);
  const json field = body_of(plane.service.ask("POST", bare + "/distance", asked.dump()));
  asked["format"] = "annotated";
  const HttpResponse file = plane.service.ask("POST", bare + "/distance", asked.dump());
  REQUIRE(file.status == 200);
  const json added = body_of(plane.service.ask("POST", "/v1/meshes", *file.body));
  Labelled made{"/v1/meshes/" + added["id"].get<std::string>(), {}};
  const auto label_of = [&](std::uint32_t v) {
    const json& label = field["labels"][v];
    return label.is_null() ? -1 : label.get<int>();
  };
  for (std::uint32_t f = 0; f < soup.faces.size(); ++f) {
    const Triangle& t = soup.faces[f];
    if (label_of(t[0]) != label_of(t[1]) || label_of(t[0]) != label_of(t[2])) continue;
    made.faces[label_of(t[0])].push_back(f);
  }
  return made;
}

json by_number(const std::vector<std::uint32_t>& faces) { return {{"faces", faces}}; }

}  // namespace

TEST_CASE("ALabelIsTheListOfItsFaces") {
  std::mt19937 seeds(test_seed());
  PlaneService plane;
  for (int round = 0; round < 6; ++round) {
    const auto number = static_cast<std::uint32_t>(seeds());
    CAPTURE(number);
    RandomMesh random(number);
    std::set<std::uint32_t> sources;
    for (int i = 0; i < 4; ++i) sources.insert(random.vertex());
    const Labelled mesh = labelled(plane, random.soup(), {sources.begin(), sources.end()});
    for (const auto& [label, faces] : mesh.faces) {
      CAPTURE(label);
      const json object{{"label", {{"attribute", kAttribute}, {"value", label}}}};
      const std::string text = std::string("label:") + kAttribute + "=" + std::to_string(label);
      const auto check = [&](const std::string& query, json asked, const json::json_pointer& at) {
        asked[at] = by_number(faces);
        const HttpResponse wanted = plane.service.ask("POST", mesh.base + query, asked.dump());
        CAPTURE(asked.dump());
        for (const json& region : {object, json(text), json(text + ".0")}) {
          asked[at] = region;
          const HttpResponse found = plane.service.ask("POST", mesh.base + query, asked.dump());
          REQUIRE(found.status == wanted.status);
          if (found.status == 200) CHECK(*found.body == *wanted.body);
        }
      };
      const std::string start = "v:" + std::to_string(random.soup().faces[faces[0]][0]);
      check("/distance", {{"from", start}}, json::json_pointer("/forbid"));
      check("/distance", {{"from", start}}, json::json_pointer("/within"));
      check("/distance", {{"from", nullptr}}, json::json_pointer("/from"));
      check("/table", {{"from", json::array({start, nullptr})}, {"to", start}},
            json::json_pointer("/from/1"));
      check("/voronoi", {{"sites", json::array({start, nullptr})}, {"method", "exact"}},
            json::json_pointer("/sites/1"));
      check("/distance",
            {{"from", start}, {"weights", json::array({{{"weight", 3}, {"region", nullptr}}})}},
            json::json_pointer("/weights/0/region"));
    }
  }
}

TEST_CASE("LabelsThatAreRefused") {
  PlaneService plane;
  const Labelled mesh = labelled(plane, shapes::plane(12, 10), {0, 119});
  REQUIRE(mesh.faces.size() == 2);
  const auto refused = [&](const std::string& base, const std::string& query, int status,
                           const std::string& code, const std::string& parameter) {
    CAPTURE(query);
    const HttpResponse reply = plane.service.get(base + "/distance?from=v:0&" + query);
    check_problem(reply, status, code, parameter);
    return body_of(reply)["detail"].get<std::string>();
  };
  const std::string label = std::string("label:") + kAttribute;
  // What there is, where this is not.
  const std::string values =
      refused(mesh.base, "within=" + label + "=2", 422, "value_out_of_range", "within.label");
  CHECK(values.find("there are: 0, 1") != std::string::npos);
  refused(mesh.base, "forbid=faces:0&forbid=" + label + "=0.5", 422, "value_out_of_range",
          "forbid[1].label");
  const std::string names =
      refused(mesh.base, "forbid=label:_SEG=1", 422, "value_out_of_range", "forbid.label");
  CHECK(names.find(kAttribute) != std::string::npos);
  refused(mesh.base, "within=" + label + "=1e300", 422, "value_out_of_range", "within.label");
  refused(mesh.base, "weights=2*label:_SEG=1", 422, "value_out_of_range", "weights[0].label");
  refused(mesh.base, "forbid=label:POSITION=1", 422, "value_out_of_range", "forbid.label");
  refused(mesh.base, "forbid=label:=1", 422, "value_out_of_range", "forbid.label");
  for (const std::string bad : {"label:_SEG", "label:_SEG=", "label:_SEG=x", "label:_SEG=1,2"}) {
    refused(mesh.base, "forbid=" + bad, 400, "bad_syntax", "forbid");
  }
  std::string many = "forbid=" + label + "=0";
  for (int i = 0; i < 10; ++i) many += "&forbid=label:_A" + std::to_string(i) + "=1";
  refused(mesh.base, many, 413, "too_large", "forbid[1].label");
  // A file that cannot have any.
  const std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  const json flat = body_of(plane.service.ask("POST", "/v1/meshes", obj));
  const std::string detail =
      refused("/v1/meshes/" + flat["id"].get<std::string>(), "forbid=" + label + "=1", 422,
              "value_out_of_range", "forbid.label");
  CHECK(detail.find(".obj") != std::string::npos);
}

TEST_CASE("LabelsAreKeptWithTheirMesh") {
  PlaneService plane;
  const Labelled mesh = labelled(plane, shapes::plane(12, 10), {0, 119});
  const auto kept = [&] {
    std::size_t count = 0;
    const json cached = body_of(plane.service.get("/debug/cache"));
    for (const json& entry : cached["adjacency"]) {
      count += entry["key"].get<std::string>().find("/labels/") != std::string::npos ? 1 : 0;
    }
    return count;
  };
  CHECK(kept() == 0);
  for (const int value : {0, 1}) {
    const std::string query = std::string("/distance?from=label:") + kAttribute + "=";
    CHECK(plane.service.get(mesh.base + query + std::to_string(value)).status == 200);
    CHECK(kept() == 1);
  }
  CHECK(plane.service.ask("DELETE", mesh.base).status == 204);
  CHECK(kept() == 0);
}

// Whoever has read the file waits for a slot to decode it.
TEST_CASE("FilesThatAreReadForLabelsAreNotAllInMemoryAtOnce") {
  PlaneService plane;
  const Labelled mesh = labelled(plane, shapes::terrain(300, 10, test_seed()), {0, 40'000});
  const std::size_t slots = plane.service.pool.slots();
  std::atomic<bool> is_open{false};
  std::vector<std::future<Result<int>>> held;
  for (std::size_t i = 0; i < slots; ++i) {
    held.push_back(std::async(std::launch::async, [&] {
      return plane.service.pool.run([&](Worker&) -> Result<int> {
        wait_until([&] { return is_open.load(); });
        return 1;
      });
    }));
  }
  wait_until([&] { return plane.service.pool.stats().running == slots; });
  const double before = process_usage().resident_bytes;
  std::vector<std::future<int>> asked;
  for (int i = 0; i < 50; ++i) {
    asked.push_back(std::async(std::launch::async, [&, i] {
      const std::string label = "label:_A" + std::to_string(i) + "=1";
      return plane.service.get(mesh.base + "/distance?from=v:0&within=" + label).status;
    }));
  }
  wait_until([&] { return plane.service.pool.stats().queued >= slots; });
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  // Of some 4 MB each; and threads. A sanitizer has memory of its own.
  const double taken = process_usage().resident_bytes - before;
  if (!geodesic::fixtures::kSanitized) CHECK(taken < 80e6);
  is_open = true;
  for (auto& each : held) CHECK(each.get() == 1);
  for (auto& each : asked) {
    const int status = each.get();
    CHECK((status == 422 || status == 503));
  }
}
