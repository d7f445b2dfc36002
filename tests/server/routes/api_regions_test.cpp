// Every query about a part of a surface is what it is about the mesh that is left, uploaded alone.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "proto/encode/encode_mesh.h"
#include "tests/fixtures/random_meshes.h"
#include "tests/fixtures/test_seed.h"
#include "tests/server/routes/plane_service.h"

using namespace geodesic;
using namespace geodesic::server;
using namespace geodesic::server::test;
using fixtures::RandomMesh;
using fixtures::test_seed;

namespace {

// What is left of a mesh as a mesh of its own, and the numbers that it has in the whole.
struct Left {
  TriangleSoup soup;
  std::vector<std::uint32_t> vertices;
  std::vector<std::uint32_t> faces;

  template <class IsLeft>
  Left(const TriangleSoup& whole, IsLeft&& is_left) {
    std::vector<std::uint32_t> number(whole.positions.size(), kNone);
    for (std::uint32_t f = 0; f < whole.faces.size(); ++f) {
      if (!is_left(f)) continue;
      faces.push_back(f);
      for (const std::uint32_t v : whole.faces[f]) number[v] = 0;
    }
    for (std::uint32_t v = 0; v < number.size(); ++v) {
      if (number[v] == kNone) continue;
      number[v] = static_cast<std::uint32_t>(vertices.size());
      vertices.push_back(v);
      soup.positions.push_back(whole.positions[v]);
    }
    for (const std::uint32_t f : faces) {
      const auto& t = whole.faces[f];
      soup.faces.push_back({number[t[0]], number[t[1]], number[t[2]]});
    }
  }

  // A reply about the mesh of its own in the numbers of the whole.
  [[nodiscard]] json renumbered(const json& reply, const std::string& key = {}) const {
    const auto is = [&](std::initializer_list<const char*> names) {
      for (const char* name : names) {
        if (key == name) return true;
      }
      return false;
    };
    if (reply.is_number() && is({"vertex", "farthest"})) return vertices[reply.get<std::size_t>()];
    if (reply.is_number() && is({"face"})) return faces[reply.get<std::size_t>()];
    if (reply.is_array() && key == "vertices" && !reply.empty() && reply[0].is_number()) {
      json numbers = json::array();
      for (const json& v : reply) numbers.push_back(vertices[v.get<std::size_t>()]);
      return numbers;
    }
    if (!reply.is_structured()) return reply;
    json result = reply.is_array() ? json::array() : json::object();
    for (const auto& [name, value] : reply.items()) {
      if (reply.is_array()) {
        result.push_back(renumbered(value));
      } else if (name != "mesh") {
        result[name] = renumbered(value, name);
      }
    }
    return result;
  }

  // A number for each vertex of the whole.
  [[nodiscard]] json spread(const json& numbers, std::size_t count) const {
    json all = std::vector<std::nullptr_t>(count, nullptr);
    for (std::size_t i = 0; i < vertices.size(); ++i) all[vertices[i]] = numbers[i];
    return all;
  }
};

json without_mesh(json reply) {
  reply.erase("mesh");
  return reply;
}

// The same question about the part and about the mesh of its own.
struct Both {
  Service& service;
  const TriangleSoup& whole;
  const Left& left;
  std::string whole_base;
  std::string own_base;
  std::string region;  // parameters of the URL
  std::size_t asked = 0;
  std::size_t answered = 0;

  [[nodiscard]] std::string at(std::uint32_t own_vertex) const {
    return std::to_string(left.vertices[own_vertex]);
  }
  // `@v12` and `@f12` are vertex and face 12 of the mesh of its own.
  [[nodiscard]] std::string numbered(const std::string& question, bool in_whole) const {
    std::string text;
    for (std::size_t i = 0; i < question.size(); ++i) {
      if (question[i] != '@') {
        text += question[i];
        continue;
      }
      const char kind = question[i + 1];
      std::size_t digits = 0;
      const unsigned long number = std::stoul(question.substr(i + 2), &digits);
      text += kind == 'v' ? "v:" : "f:";
      text += std::to_string(!in_whole     ? number
                             : kind == 'v' ? left.vertices[number]
                                           : left.faces[number]);
      i += 1 + digits;
    }
    return text;
  }

  void ask(const std::string& question) {
    const std::string target = numbered(question, true) + "&" + region;
    CAPTURE(target);
    const HttpResponse part = service.get(whole_base + target);
    const HttpResponse own = service.get(own_base + numbered(question, false));
    CAPTURE(*part.body);
    CAPTURE(*own.body);
    ++asked;
    REQUIRE(part.status == own.status);
    if (part.status != 200) {
      CHECK(body_of(part)["code"] == body_of(own)["code"]);
      return;
    }
    ++answered;
    const json told = body_of(part);
    const json about_own = body_of(own);
    json expected = left.renumbered(about_own);
    if (question.starts_with("/distance") && question.find("&at=") == std::string::npos) {
      for (const char* name : {"distances", "labels"}) {
        if (expected.contains(name)) {
          expected[name] = left.spread(expected[name], whole.positions.size());
        }
      }
      expected["count"] = whole.positions.size();
    } else if (question.starts_with("/distance")) {
      expected["farthest"] = about_own["farthest"];  // a place among the points
    }
    CHECK(without_mesh(told) == expected);
  }
};

}  // namespace

TEST_CASE("QueriesOnAPartAreThoseOnAMeshOfItsOwn") {
  const TemporaryFolder folder;
  Service service(folder.path());
  const json methods = body_of(service.get("/v1/methods"))["methods"];
  // So many that something is left of.
  constexpr std::uint32_t kMeshes = 3;
  std::uint32_t meshes = 0;
  for (std::uint32_t i = 0; meshes < kMeshes; ++i) {
    REQUIRE(i < 20 * kMeshes);
    const std::uint32_t number = test_seed() + i;
    CAPTURE(number);
    RandomMesh random(number);
    const TriangleSoup& whole = random.soup();
    const std::uint32_t first = random.below(random.face_count());
    const std::uint32_t last = first + random.below(random.face_count() - first);
    const bool is_within = random.unit() < 0.3;
    const Left left(whole, [&](std::uint32_t f) {
      const bool is_named = first <= f && f <= last;
      return is_within ? is_named || f == 0 : !is_named && f != 0;
    });
    if (left.faces.size() < 2) continue;
    ++meshes;
    const std::string faces = "faces:0," + std::to_string(first) + "-" + std::to_string(last);
    Both both{service,
              whole,
              left,
              "/v1/meshes/" + service.upload(glb_of(whole)),
              "/v1/meshes/" + service.upload(glb_of(left.soup)),
              (is_within ? "within=" : "forbid=") + faces};
    const auto vertex = [&] {
      return "@v" + std::to_string(random.below(static_cast<std::uint32_t>(left.vertices.size())));
    };
    const auto inside = [&] {
      return "@f" + std::to_string(random.below(static_cast<std::uint32_t>(left.faces.size()))) +
             ",0.2,0.3";
    };
    const auto place = [&] {
      const Vec3 p =
          whole.positions[random.below(static_cast<std::uint32_t>(whole.positions.size()))];
      return "p:" + std::to_string(p.x) + "," + std::to_string(p.y) + "," + std::to_string(p.z);
    };
    for (const json& method : methods) {
      const std::string by = "&method=" + method["name"].get<std::string>();
      both.ask("/distance?from=" + vertex() + "&from=" + inside() + "&labels=1" + by);
      both.ask("/distance?from=" + vertex() + "&max=3" + by);
      both.ask("/distance?from=" + inside() + "&at=" + vertex() + "&at=" + inside() + by);
      both.ask("/path?from=" + vertex() + "&to=" + inside() + "&via=" + vertex() + by);
      both.ask("/table?from=" + vertex() + "&from=" + inside() + "&to=" + place() + by);
      both.ask("/isolines?from=" + inside() + "&count=4" + by);
      both.ask("/samples?count=5" + by);
      both.ask("/samples?count=3&from=" + vertex() + by);
      both.ask("/measure?from=" + vertex() + "&radii=1&radii=2.5" + by);
      both.ask("/extent?of=diameter&fields=6" + by);
      both.ask("/voronoi?from=" + vertex() + "&from=" + inside() + "&from=" + vertex() + by);
      both.ask("/loop?through=" + vertex() + "&through=" + inside() + by);
      both.ask("/logmap?from=" + vertex() + by);
    }
    both.ask("/trace?direction=1,0.3,0.2&length=4&from=" + inside());
    both.ask("/trace?angle=1.5&length=4&from=" + inside());
    both.ask("/nearest?point=" + place() + "&point=" + place() + "&point=" + vertex());
    both.ask("/nearest?point=ray:0.3,0.4,90,0,0,-1");
    CHECK(both.answered > both.asked / 2);
  }
}

// The paper's plane with a square hole, made of a whole plane.
TEST_CASE("AForbiddenSquareIsAHoleInThePlane") {
  PlaneService service;
  const TriangleSoup whole = shapes::plane(21, 21);
  const std::string base = service.add(whole);
  const auto is_in_square = [&](std::uint32_t f) {
    Vec3 p{0, 0, 0};
    for (const std::uint32_t v : whole.faces[f]) p = p + (1.0 / 3) * whole.positions[v];
    return 5 <= p.x && p.x <= 15 && 5 <= p.y && p.y <= 15;
  };
  const Left left(whole, [&](std::uint32_t f) { return !is_in_square(f); });
  const std::string own = service.add(left.soup);
  const auto distances = [&](std::string target, const char* by, const char* region) {
    target.append("/distance?from=v:0&method=").append(by).append(region);
    const HttpResponse reply = service.service.get(target);
    REQUIRE(reply.status == 200);
    return body_of(reply);
  };
  for (const char* by : {"auto", "exact", "chen_han", "wavefront"}) {
    CAPTURE(by);
    const json hole = distances(base, by, "&forbid=box:5,5,-1,15,15,1");
    const json told = distances(own, by, "");
    CHECK(hole["distances"] == left.spread(told["distances"], whole.positions.size()));
    CHECK(hole["reached"] == 441 - 81);
  }
  // From one corner to the other round the hole's corner (15, 5).
  const json way = body_of(
      service.service.get(base + "/path?from=v:0&to=v:440&method=exact&forbid=box:5,5,-1,15,15,1"));
  CHECK(way["length"] == doctest::Approx(2 * std::hypot(15, 5)));
  const json straight = body_of(service.service.get(base + "/path?from=v:0&to=v:440&method=exact"));
  CHECK(straight["length"] == doctest::Approx(20 * std::sqrt(2)));
}

TEST_CASE("PointsOutsideOfTheRegionAreRefusedAndPlacesFindWhatIsLeft") {
  PlaneService plane;  // 12 x 10, faces 2 k and 2 k + 1 in square k
  const std::string forbid = "&forbid=box:0,0,0,4,9,0";
  plane.check_refused("/distance?from=v:0" + forbid, 422, "outside_region", "from[0]");
  plane.check_refused("/distance?from=v:11&at=v:11&at=v:2" + forbid, 422, "outside_region",
                      "at[1]");
  plane.check_refused("/path?from=v:11&to=f:0,0.2,0.3" + forbid, 422, "outside_region", "to");
  plane.check_refused("/distance?from=v:120" + forbid, 422, "index_out_of_range", "from[0]");
  // On the border both sides have the vertex.
  CHECK(plane.ask("/distance?from=v:4" + forbid)["distances"][0].is_null());
  const json near = plane.ask("/nearest?point=p:1,3,0" + forbid)["points"][0];
  CHECK(near["xyz"][0] == doctest::Approx(4));
  CHECK(near["snap_distance"] == doctest::Approx(3));
  plane.check_refused("/nearest?point=ray:1.2,3.3,5,0,0,-1" + forbid, 422, "no_hit", "point[0]");
  CHECK(plane.ask("/nearest?point=ray:1.2,3.3,5,0,0,-1")["points"][0]["xyz"][0] ==
        doctest::Approx(1.2));
  check_problem(plane.service.ask("POST", plane.base + "/nearest",
                                  R"({"point":{"xyz":[0,0,0],"max_snap":1},"within":"faces:21"})"),
                422, "snap_too_far", "point[0]");
}

TEST_CASE("RegionsThatCannotBeAreRefused") {
  PlaneService plane;
  const auto refused = [&](const std::string& region, int status, const char* code,
                           const char* parameter) {
    plane.check_refused("/distance?from=v:0&" + region, status, code, parameter);
    plane.check_refused("/samples?count=2&" + region, status, code, parameter);
  };
  refused("forbid=faces:0-197", 422, "value_out_of_range", "forbid");
  refused("within=sphere:100,0,0,1", 422, "value_out_of_range", "within");
  refused("forbid=faces:198", 422, "index_out_of_range", "forbid.faces[0]");
  refused("within=part:1", 422, "index_out_of_range", "within.part");
  refused("forbid=faces:9-3", 422, "value_out_of_range", "forbid.faces[0]");
  refused("forbid=sphere:0,0,0,-1", 422, "value_out_of_range", "forbid.sphere.radius");
  refused("forbid=sphere:0,0,0,nan", 400, "bad_syntax", "forbid");
  refused("forbid=ball:0,0,0", 400, "bad_syntax", "forbid");
  plane.check_same("/samples?count=3&forbid=faces:0-9,20&forbid=sphere:3,4,0,2",
                   R"({"count":3,"forbid":[{"faces":[[0,9],20]},
                       {"sphere":{"center":[3,4,0],"radius":2}}]})");
}

TEST_CASE("PartsAreThoseOfTheMetadata") {
  PlaneService plane;
  const std::string base = plane.add(fixtures::two_components());
  const json parts = body_of(plane.service.get(base))["parts"];
  REQUIRE(parts.size() == 1);
  CHECK(body_of(plane.service.get(base + "/samples?count=99&within=part:0"))["samples"].size() ==
        50);
}

// Two primitives, a face each, that share the edge from (0, 0, 0) to (1, 0, 0).
TEST_CASE("EachPartOfAFileIsARegion") {
  PlaneService plane;
  const std::string gltf = R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
    "nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}},
      {"attributes":{"POSITION":1}}]}],
    "accessors":[
      {"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
      {"bufferView":0,"byteOffset":36,"componentType":5126,"count":3,"type":"VEC3",
       "min":[0,-3,0],"max":[1,0,0]}],
    "bufferViews":[{"buffer":0,"byteLength":72}],"buffers":[{"byteLength":72,"uri":"b.bin"}]})";
  const float xyz[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, -3, 0, 1, 0, 0};
  const auto file = [](const std::string& name, const std::string& bytes) {
    return "--x\r\nContent-Disposition: form-data; name=\"f\"; filename=\"" + name + "\"\r\n\r\n" +
           bytes + "\r\n";
  };
  const std::string form = file("a.gltf", gltf) +
                           file("b.bin", {reinterpret_cast<const char*>(xyz), sizeof xyz}) +
                           "--x--\r\n";
  const json told = body_of(plane.service.ask(
      "POST", "/v1/meshes", form, {{"Content-Type", "multipart/form-data; boundary=x"}}));
  REQUIRE(told["parts"].size() == 2);
  const std::string base = "/v1/meshes/" + told["id"].get<std::string>();
  const auto farthest = [&](const std::string& region) {
    return body_of(plane.service.get(base + "/measure?from=v:1&method=exact" + region))["max"];
  };
  CHECK(farthest("&within=part:0") == doctest::Approx(std::sqrt(2)));
  CHECK(farthest("&within=part:1") == doctest::Approx(std::sqrt(10)));
  CHECK(farthest("&forbid=part:1") == doctest::Approx(std::sqrt(2)));
  CHECK(farthest("&within=part:0&within=part:1") == doctest::Approx(std::sqrt(10)));
  check_problem(plane.service.get(base + "/measure?from=v:1&within=part:2"), 422,
                "index_out_of_range", "within.part");
}

TEST_CASE("APartIsPreparedOnceAndGoesWithItsMesh") {
  PlaneService plane;
  const auto made = [&] { return plane.service.catalog.adjacency_cache().makes; };
  const std::string target = "/distance?from=v:50&forbid=faces:0-9";
  const json of_part = plane.ask(target)["reached"];
  const std::uint64_t before = made();
  const json again = plane.ask("/distance?from=v:51&forbid=faces:0-9");
  CHECK(made() == before);
  plane.ask("/distance?from=v:50&forbid=faces:0-8");
  CHECK(made() == before + 1);
  // Fields and replies of the whole and of parts are told apart.
  CHECK(plane.ask("/distance?from=v:50")["reached"] == 120);
  CHECK(plane.ask(target)["reached"] == of_part);
  CHECK(again["reached"] < 120);
  const auto tag = [&](const std::string& question) {
    return header_of(plane.service.get(plane.base + question), "ETag");
  };
  CHECK(tag(target) != tag("/distance?from=v:50"));
  CHECK(tag(target) != tag("/distance?from=v:50&within=faces:0-9"));
  CHECK(plane.service.ask("DELETE", plane.base).status == 204);
  CHECK(plane.service.catalog.adjacency_cache().entries == 0);
  CHECK(plane.service.queries.field_cache().entries == 0);
  check_problem(plane.service.get(plane.base + target), 404, "mesh_unknown");
}

TEST_CASE("DrawingsAndArraysOfPartsHaveAllVertices") {
  PlaneService plane;
  const std::string target = "/distance?from=v:50&forbid=faces:0-59&format=";
  const auto values = numbers_of<double>(plane.service.get(plane.base + target + "f64"));
  REQUIRE(values.size() == 120);
  CHECK(values[0] == std::numeric_limits<double>::infinity());
  const HttpResponse glb = plane.service.get(plane.base + target + "glb");
  REQUIRE(glb.status == 200);
  std::uint32_t length = 0;
  std::memcpy(&length, glb.body->data() + 12, sizeof length);
  const json gltf = json::parse(glb.body->substr(20, length));
  const json& primitive = gltf["meshes"][0]["primitives"][0];
  CHECK(gltf["accessors"][primitive["attributes"]["POSITION"].get<int>()]["count"] == 120);
  CHECK(gltf["accessors"][primitive["indices"].get<int>()]["count"] == 3 * (198 - 60));
  CHECK(plane.service.get(plane.base + target + "png").status == 200);
  CHECK(plane.service.get(plane.base + target + "annotated").status == 200);
  CHECK(plane.service.get(plane.base + "/path?from=v:119&to=v:90&format=png&forbid=faces:0-59")
            .status == 200);
}

TEST_CASE("BatchesAndStatusKnowRegions") {
  PlaneService plane;
  HttpResponse batch =
      plane.service.ask("POST", plane.base + "/batch",
                        "{\"query\":\"samples\",\"count\":1,\"within\":\"faces:7\"}\n"
                        "{\"query\":\"nearest\",\"point\":\"v:0\",\"forbid\":{\"faces\":[[0,1]]}}\n"
                        "{\"query\":\"nearest\",\"point\":\"v:0\",\"forbid\":7}\n");
  REQUIRE(batch.stream);
  std::vector<std::string> told;
  std::string chunk;
  while (batch.stream(chunk)) {
    const json line = json::parse(chunk);
    told.push_back(line["status"] == 200 ? "" : line["problem"]["code"].get<std::string>());
    chunk.clear();
  }
  CHECK(told == std::vector<std::string>{"", "outside_region", "bad_syntax"});
  const json limits = body_of(plane.service.get("/v1/status"))["limits"];
  CHECK(limits["max_region_shapes"] == 1000);
  CHECK(limits["max_face_ranges"] == 100000);
}

TEST_CASE("APartIsCutOutForWhoIsThereAndWithinTheMemoryThereIs") {
  PlaneService plane;
  const std::string base = plane.add(shapes::plane(200, 200));
  const std::string target = base + "/samples?count=1&within=sphere:0,0,0,20";
  HttpRequest request;
  request.method = "GET";
  request.target = target;
  request.path = base + "/samples";
  request.query = {{"count", "1"}, {"within", "sphere:0,0,0,20"}};
  request.id = "test";
  request.caller = [] { return true; };
  check_problem(plane.service.routes.answer(request), 499, "cancelled");
  const auto limits = plane.service.pool.memory().limits;
  plane.service.pool.set_memory_limits({0, std::uint64_t{200} << 10});
  check_problem(plane.service.get(target), 422, "too_much_memory");
  // Nothing of it was kept, and with the memory for it there is an answer.
  plane.service.pool.set_memory_limits(limits);
  CHECK(plane.service.get(target).status == 200);
}
